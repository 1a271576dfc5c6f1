"""Relays that readings show: what a sensor reads goes up and down between two levels and turns nowhere else.

Where it turns, it switched (hysteresis_swing): so the levels and instants are read, the relay's heat is fitted as that
of a source that follows them, which is no matter of chance, and only then it has to keep in step by itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from network.analysis.calibration.expansion_point import move_points
from network.analysis.calibration.hysteresis_swing import find_levels
from network.analysis.calibration.measured_means import RunPoint
from network.analysis.calibration.recorded_modes import CLEAR, read_modes
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.compact_fit import compact, fit_with
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.steps.ranking import best_of
from network.catalogue.declaration.patch import Patch
from network.catalogue.mechanisms.mechanism import Relay
from network.engine.response.followed_relays import list_readers
from network.platform.parallel import run_all
from network.recordings.recording import Recording

STEPS = 12
"""Of a fit beside what was read."""


@dataclass(frozen=True, eq=False)
class ShownRelay:
    """A candidate; followed: the same with its levels as they were read for certain; levels: these, by path;
    recordings: with when it was on."""

    candidate: Candidate
    followed: Candidate
    levels: Mapping[str, float]
    recordings: tuple[Recording, ...]


@dataclass(frozen=True)
class RelayStart:
    """A candidate to be fitted from some numbers, about some starts of its parts."""

    candidate: Candidate
    values: Mapping[str, float]
    began: tuple[RunPoint, ...]


def read_relays(case: Case, switched: Sequence[Candidate]) -> list[ShownRelay]:
    """Those of some candidates whose levels and instants the recordings show."""
    shown = (_read_relay(case.recordings, c) for c in switched)
    return [s for s in shown if s is not None]


def follow_shown(case: Case, null: Hypothesis, shown: Sequence[ShownRelay], jobs: int) -> list[RelayStart]:
    """Numbers that each takes as a heat that follows what was read, the best first: of those that explain more than the
    null, fitted from its numbers and from those of the file, which are not bent to what is missing."""
    told = [each for each in run_all(partial(_follow, case, null), shown, jobs) if each is not None]
    return [start for h, start in sorted(told, key=lambda each: each[0].chi) if h.chi < null.chi]


def _follow(case: Case, null: Hypothesis, shown: ShownRelay) -> tuple[Hypothesis, RelayStart] | None:
    beside = replace(case, recordings=shown.recordings, began=())
    best = best_of(*(fit_with(beside, null, shown.followed, start, STEPS) for start in (null.values, null.own_values)))
    if best is None:
        return None
    return compact(best), RelayStart(shown.candidate, {**best.values, **shown.levels}, move_points(best.fit))


def _read_relay(recordings: Sequence[Recording], c: Candidate) -> ShownRelay | None:
    """None where no sensor reads what it watches, or what is read does not go between two levels."""
    relays = [(p, e) for p, _ in c.patch.entries() if isinstance(e := c.machine.by_path.get(p), Relay)]
    if len(relays) != 1:
        return None
    ((path, relay),) = relays
    sensor = next((n for n in list_readers(c.machine, relay) if all(n in r.columns for r in recordings)), "")
    least = 2 * CLEAR * c.machine.sensors[sensor].sigma if sensor else np.inf
    levels = find_levels([(r.t, r.columns[sensor].values) for r in recordings], least) if sensor else None
    keys = relay.keep_between(*levels) if levels else {}
    if not keys:
        return None
    machine = c.machine.patched(Patch.of([(path, keys)]))
    told = read_modes(machine, recordings)
    if not told[0].modes:
        return None
    own = [p for p in c.own if p.entry == path and p.field.key in keys]
    kept = {p.path: float(machine.by_path[path].__dict__[p.attribute]) for p in own}
    return ShownRelay(c, replace(c, machine=machine, own=tuple(p for p in c.own if p not in own)), kept, told)
