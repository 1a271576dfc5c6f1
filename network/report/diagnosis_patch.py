"""machine.diagnosed.yaml: a patch of the user's file whose text is the finding, calibrated numbers below it."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from network.calibration.patching import difference_of
from network.patch import load_tree
from network.proposals import fresh
from network.refusal import Refused
from network.report.lumps_words import sentence_of
from network.report.naming import called
from network.residuals.amounts import joined
from network.yamlfile import Leaf, dump, load

if TYPE_CHECKING:
    from network.diagnosis.verdict import Diagnosis
    from network.machine import Machine

FILE = "machine.diagnosed.yaml"
WIDTH = 116
CALIBRATED = "# calibrated"


def patch_text(d: Diagnosis, where: Path) -> str:
    """The file as it stands in a folder: it extends the machine's own file, or is whole where that cannot be read."""
    head = "".join(f"{line}\n" for line in _remarks(d))
    try:
        base = load_tree(Path(d.machine.file))
    except Refused:
        return head + dump(d.after.to_plain())
    beside = os.path.relpath(Path(d.machine.file).resolve(), where.resolve())
    changed = difference_of(base, d.after.tree)
    return head + _lines({"extends": Path(beside).as_posix()}) + "".join(_sections(d, changed))


def _remarks(d: Diagnosis) -> Iterator[str]:
    """Comment lines: what was found, and on what."""
    names = joined([called(d, r) for r in d.fits.train_after.recordings])
    told = [sentence_of(f) for f in d.findings] or ["Nothing is missing that these recordings would show."]
    for sentence in (*told, f"Diagnosed by lptn on {names}: value ± standard error."):
        yield from commented(sentence)


def commented(sentence: str) -> list[str]:
    return textwrap.wrap(" ".join(sentence.split()), WIDTH, initial_indent="# ", subsequent_indent="#   ")


def _sections(d: Diagnosis, changed: Mapping[str, Any]) -> Iterator[str]:
    """Sections with a part of a finding first, and in each of them the finding's entries first."""
    ours = {key: _part(key, entries, [f.patch.get(key) for f in d.findings]) for key, entries in changed.items()}
    for key in (key for key in changed if ours[key]):
        rest = _without(changed[key], ours[key])
        yield f"{key}:\n{_lines(ours[key], '  ')}"
        yield f"  {CALIBRATED}\n{_lines(rest, '  ')}" if rest else ""
    others = {key: entries for key, entries in changed.items() if not ours[key]}
    yield f"{CALIBRATED}\n{_lines(others)}" if others else ""


def _lines(entries: Mapping[str, Any], indent: str = "") -> str:
    """Entries, one below the other whatever they are."""
    first = fresh("first", entries)
    return textwrap.indent(dump({first: {}, **entries}).split("\n", 1)[1], indent)


def _part(key: str, entries: Any, patches: Sequence[Any]) -> dict[str, Any]:
    """What findings name, of a section: entries by name; whole axes, what they name of them first."""
    named = [p for p in patches if isinstance(p, Mapping)]
    if key != "tcp":
        return {name: entry for name, entry in entries.items() if any(name in p for p in named)} if named else {}
    ours = {axis: _part(axis, own, [p.get(axis) for p in named]) for axis, own in entries.items()}
    return {axis: own | _without(entries[axis], own) for axis, own in ours.items() if own}


def _without(entries: Any, part: Mapping[str, Any]) -> Any:
    return {n: e for n, e in entries.items() if n not in part} if part else entries


def is_part_of(machine: Machine, target: Path) -> bool:
    """Whether a file is one that the machine is made of: its own, or one that it extends."""
    path = Path(machine.file)
    while path.is_file():
        if path.resolve() == target.resolve():
            return True
        above = load(path, "a machine file").items.get("extends")
        if not isinstance(above, Leaf):
            return False
        path = path.parent / above.text
    return False
