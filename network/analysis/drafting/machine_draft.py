"""A first machine file from recordings alone: parts, links, sources, expansions and sensors, everything ±, and why."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path as File
from typing import Any

from network.analysis.drafting.channel_roles import FEWEST, Wishes, assign_roles
from network.analysis.drafting.displacement_paths import Path, find_paths
from network.analysis.drafting.draft_entries import Names, name_nodes, sections_of
from network.analysis.drafting.draft_sentences import (
    tell_inputs,
    tell_noise,
    tell_part,
    tell_path,
    tell_scale,
    tell_surroundings,
    tell_unused,
)
from network.analysis.drafting.heat_scale import Sizes, size_parts
from network.analysis.drafting.identification import Identified, identify
from network.analysis.drafting.part_models import Progress
from network.machine.machine import Machine
from network.platform.printing import Result
from network.platform.quantities.units import show
from network.platform.refusal import Complaints, Spot, refuse
from network.platform.wording import comment, join_names
from network.platform.yaml.document import Branch, dump, parse
from network.recordings.call_arguments import as_several
from network.recordings.recording import Recording

FILE = "machine.yaml"
DRAFTED = "# Draft from "
"""What a drafted file begins with, until somebody makes it his own."""


@dataclass(frozen=True, eq=False, repr=False)
class Draft(Result):
    """text: the file; machine: the same, read; found, sizes, paths, names: what it was made of; sentences: why;
    warnings: what of the recordings will not fit it."""

    text: str
    machine: Machine
    found: Identified
    sizes: tuple[Sizes, ...]
    paths: tuple[Path, ...]
    names: Names
    sentences: tuple[str, ...]
    warnings: tuple[str, ...]

    def __str__(self) -> str:
        return "\n".join(self.sentences)

    def summary(self) -> dict[str, Any]:
        """For machines; SI but for time constants, in s."""
        return {
            "surroundings": self.found.roles.ambient or None,
            "inputs": list(self.found.roles.inputs),
            "held": list(self.found.roles.held),
            "parts": [self._part(k) for k in range(len(self.names.parts))],
            "displacements": [_path(path, self.names) for path in self.paths],
            "unused": dict(self.found.roles.unused),
            "sentences": list(self.sentences),
        }

    def _part(self, k: int) -> dict[str, Any]:
        model = self.found.models[k]
        gains = {name.strip(): {"gain": w} for name, w in model.fit.weights.items()}
        follows = None if model.parent is None else self.names.parts[model.parent]
        return {
            "name": self.names.parts[k], "sensors": list(model.group.sensors), "time_constant": model.fit.tau,
            "drivers": gains, "follows": follows, "left": model.fit.rms,
        }  # fmt: skip


def _path(path: Path, names: Names) -> dict[str, Any]:
    slopes = {names.node(k): slope for k, slope in path.slopes.items()}
    return {"channel": path.channel, "axis": path.axis, "slopes": slopes, "left": path.left, "rms": path.moved}


NO_WISHES = Wishes()


def draft(
    recordings: Recording | Iterable[Recording], wishes: Wishes = NO_WISHES, progress: Progress = lambda _: None
) -> Draft:
    """A machine that these recordings could be of. Raises Refused where they have no temperature of a part, or inputs
    with gaps."""
    recordings = as_several(recordings)
    if not recordings:
        raise refuse(Spot("recordings"), "there is none", "give at least one")
    runs = [piece for recording in recordings for piece in recording.pieces]
    _check_lengths(runs)
    roles = assign_roles(runs, wishes)
    found = identify(runs, roles, progress)
    sizes, paths, names = size_parts(found), find_paths(runs, found), name_nodes(found)
    sections = sections_of(found, sizes, paths, names)
    sentences = tuple(_tell(found, sizes, paths, names, wishes))
    title = f"{DRAFTED[2:]}{join_names([File(recording.file).name for recording in recordings])}"
    text = _write(title, found, sections, names, sentences)
    tree = parse(text, Spot(FILE))
    assert isinstance(tree, Branch)
    warnings = tuple(_doubt_starts(recordings, names))
    return Draft(text, Machine.read(tree, FILE), found, sizes, paths, names, sentences, warnings)


def _doubt_starts(recordings: Sequence[Recording], names: Names) -> Iterator[str]:
    """Sentences on mappings that begin at nodes of another machine."""
    for recording in recordings:
        strange = [n for n in (recording.start.nodes if recording.start else None) or {} if n not in names.parts]
        if strange:
            named = join_names([f"'{n}'" for n in strange])
            right = f"take `start:` out of it, or name {join_names(list(names.parts))}"
            yield f"{recording.file}: its start names {named}, which the draft has not; {right}"


def _check_lengths(runs: Sequence[Recording]) -> None:
    complaints = Complaints()
    if all(len(run.t) < FEWEST for run in runs):
        for run in runs:
            right = f"give one of {FEWEST} samples at least"
            complaints.refuse(Spot(run.file), f"has {len(run.t)} samples, too few for a time constant", right)
    complaints.raise_if_any()


def _tell(
    found: Identified, sizes: Sequence[Sizes], paths: Sequence[Path], names: Names, wishes: Wishes
) -> Iterator[str]:
    yield from tell_surroundings(found, wishes)
    yield from tell_inputs(found)
    for k in range(len(names.parts)):
        yield from tell_part(found, k, names)
    for path in paths:
        yield tell_path(path, names)
    yield tell_noise(found)
    yield from tell_scale(sizes)
    yield from tell_unused(found)


def _write(
    title: str, found: Identified, sections: Mapping[str, Mapping[str, Any]], names: Names, sentences: Sequence[str]
) -> str:
    """The file: sentences above, those on a part again at its node."""
    lines = [line for sentence in (f"{title}. Nothing in it is calibrated.", *sentences) for line in comment(sentence)]
    head = {"machine": title, "reference": show(round(found.level, 1), "degC", 4)}
    lines += dump({**head, "nodes": {"": {}}}).splitlines()[: len(head)]
    at = {names.parts[k]: list(tell_part(found, k, names)) for k in range(len(names.parts))}
    for key, entries in sections.items():
        lines.append(f"{key}:")
        for name, body in entries.items():
            told = at.get(name, []) if key == "nodes" else []
            lines += [f"  {line}" for sentence in told for line in comment(sentence)]
            lines += textwrap.indent(dump({name: body}), "  ").splitlines()
    return "\n".join(lines) + "\n"
