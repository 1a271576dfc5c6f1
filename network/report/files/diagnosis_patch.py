"""machine.diagnosed.yaml: a patch of the user's file whose text is the finding, calibrated numbers below it."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from network.catalogue.declaration.patch import Patch
from network.catalogue.declaration.proposals import fresh
from network.catalogue.declaration.sections import depth
from network.machine.file_layers import patch_from
from network.platform.wording import comment, join_names
from network.platform.yaml.document import dump
from network.report.words.recording_names import name_recording

if TYPE_CHECKING:
    from network.analysis.diagnosis.findings.result import Diagnosis

FILE = "machine.diagnosed.yaml"
CALIBRATED = "# calibrated"


def patch_text(d: Diagnosis, where: Path) -> str:
    """The file as it stands in a folder: it extends the machine's own file, or is whole where that cannot be read."""
    head = "".join(f"{line}\n" for line in _remarks(d))
    over = patch_from(d.machine.file, d.after.tree, where)
    if over is None:
        return head + dump(d.after.to_plain())
    return head + _lines({"extends": over[0]}) + "".join(_sections(d, over[1]))


def _remarks(d: Diagnosis) -> Iterator[str]:
    """Comment lines: what was found, and on what."""
    names = join_names([name_recording(d, r) for r in d.fits.train_after.recordings])
    told = [f.whole_sentence for f in d.findings] or ["Nothing is missing that these recordings would show."]
    for sentence in (*told, f"Diagnosed by lptn on {names}: value ± standard error."):
        yield from comment(sentence)


def _sections(d: Diagnosis, changed: Patch) -> Iterator[str]:
    """Sections with a part of a finding first, and in each of them the finding's entries first."""
    found = {path for f in d.findings for path, _ in f.patch.by_name()}
    part = Patch.of((path, body) for path, body in changed.by_name() if path in found)
    ours = {key: _whole_axes(part.get(key, {}), entries, depth(key)) for key, entries in changed.items()}
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


def _whole_axes(part: Mapping[str, Any], entries: Any, below: int) -> Mapping[str, Any]:
    """A part of a section; where its entries lie below axes, whole axes, with the part first."""
    return part if below < 2 else {axis: own | _without(entries[axis], own) for axis, own in part.items()}


def _without(entries: Any, part: Mapping[str, Any]) -> Any:
    return {n: e for n, e in entries.items() if n not in part} if part else entries
