"""What a finding does to the tool centre point: the better machine along a recording, with it and without."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from network.catalogue.declaration.patch import Patch
from network.engine.simulation import simulate
from network.engine.trajectory import Trajectory, axis_unit
from network.machine.machine import Machine
from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import digits
from network.platform.quantities.units import unit
from network.platform.refusal import Failed, Refused
from network.platform.wording import join_names
from network.recordings.inputs import Start
from network.report.words.recording_names import name_recording

if TYPE_CHECKING:
    from network.analysis.diagnosis.findings.finding import Finding
    from network.analysis.diagnosis.findings.result import Diagnosis

SECTIONS = ("nodes", "links", "sources", "tcp")
"""Where what moves the tool stands; a sensor's fault moves nothing."""
NOTICED = 0.01
"""Share of the largest movement from which one along another axis is told."""
KEPT = 32
"""Findings whose effect is remembered, for words, page and JSON ask for it in turn."""


@lru_cache(maxsize=KEPT)
def movements(d: Diagnosis, number: int) -> Mapping[str, float]:
    """Axis → the movement [m, rad] that finding `number` (from 0) makes at most, on the first recording. Empty where
    there is none, and where the machine cannot run without the finding."""
    finding, run = d.findings[number], d.fits.train_after.recordings[0].trajectory
    try:
        there, gone = (_along(machine, run) for machine in (d.after, _without(d, finding)))
    except (Refused, Failed, KeyError, ArithmeticError):
        return {}
    apart = {axis: there.tcp[axis] - gone.tcp[axis] for axis in there.tcp if axis in gone.tcp}
    return {axis: float(x[np.argmax(np.abs(x))]) for axis, x in apart.items() if len(x)}


def _without(d: Diagnosis, finding: Finding) -> Machine:
    """The better machine with the entries of the finding as they were; its numbers stay."""
    before = dict(Patch.difference(d.after.tree, d.before.tree).by_name())
    ours = [path for path, _ in finding.patch.by_name() if path.section in SECTIONS and path in before]
    if not ours:
        raise KeyError(finding.kind)
    return d.after.patched(Patch.of((path, before[path]) for path in ours))


def _along(machine: Machine, run: Trajectory) -> Trajectory:
    """From where that run began, along its inputs."""
    run = max(run.pieces, key=lambda piece: len(piece.t), default=run)
    begun = {name: float(run.T_start[part].mean()) for name, part in run.network.bodies.items()
             if name in machine.nodes and machine.nodes[name].is_part}  # fmt: skip
    return simulate(machine, replace(run.schedule, start=Start(nodes=begun)), parts=False)


def effect_words(d: Diagnosis, finding: Finding) -> str:
    """It moves the tool by so much; nothing where it moves nothing that is told."""
    moved = movements(d, d.findings.index(finding)) if finding in d.findings else {}
    most = max((abs(x) for axis, x in moved.items()), default=0.0)
    told = [f"{_tell(x, axis)} along {axis}" for axis, x in moved.items() if most and abs(x) >= NOTICED * most]
    if not told:
        return ""
    name = name_recording(d, d.fits.train_after.recordings[0])
    return f"It moves the tool centre point by up to {join_names(told)} on {name}."


def _tell(x: float, axis: str) -> str:
    of = unit(axis_unit(axis))
    return f"{'−' if x < 0 else '+'}{digits(abs(of.from_si(x)), 2)} {pretty(of.text)}"


def effect_summary(d: Diagnosis, number: int) -> dict[str, Any]:
    """The same for machines."""
    return {axis: {"value": unit(axis_unit(axis)).from_si(x), "unit": axis_unit(axis)}
            for axis, x in movements(d, number).items()}  # fmt: skip
