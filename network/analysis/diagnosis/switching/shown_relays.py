"""Relays that readings show: what a sensor reads goes up and down between two levels.

Where it bends, it switched (hysteresis_swing): so levels and instants are read, the relay's heat is fitted as that of a
source that follows them, which is no matter of chance, and only then it has to keep in step by itself. Runs in which
it is not seen to switch are left out of that.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial

from network.analysis.calibration.expansion_point import move_edges, move_points
from network.analysis.calibration.hysteresis_swing import find_levels
from network.analysis.calibration.measured_means import RunPoint
from network.analysis.calibration.recorded_modes import clear_of, read_mode
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.compact_fit import fit_with
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.steps.ranking import best_of
from network.analysis.diagnosis.switching.certain_levels import Certain, find_relay, make_certain
from network.analysis.diagnosis.switching.relay_fits import RelayStart
from network.catalogue.declaration.entry_path import EntryPath
from network.catalogue.mechanisms.mechanism import Relay
from network.engine.response.followed_relays import list_readers
from network.platform.parallel import run_all
from network.recordings.recording import Recording
from network.recordings.relay_mode import RelayMode

STEPS = 12
"""Of a fit beside what was read."""
SLACK = 0.1
"""Share of χ by which a fit beside instants that were moved, which is straight there, may leave more."""

Levels = tuple[float, float] | None
LevelsOf = Callable[[Hypothesis, "ShownRelay"], Mapping[str, float]]


@dataclass(frozen=True, eq=False)
class ShownRelay:
    """A candidate; followed: the same with levels that are certain; levels: these as they were read, by path, or none
    where they are still to be; modes: of the runs that tell, when it was on; beside: numbers at which these were told,
    where they are not those of the null."""

    candidate: Candidate
    followed: Candidate
    levels: Mapping[str, float]
    modes: Mapping[int, RelayMode]
    beside: Mapping[str, float] = field(default_factory=dict)

    def onset(self, recordings: Sequence[Recording]) -> float:
        """Share of the runs until which it has not switched in any of them."""
        seen = ((mode, recordings[i].t) for i, mode in self.modes.items() if len(mode.t) > 1)
        return min(float((mode.t[1] - mode.t[0]) / (t[-1] - t[0])) for mode, t in seen)


def read_relays(case: Case, switched: Sequence[Candidate]) -> list[ShownRelay]:
    """Those of some candidates whose levels and instants the recordings show."""
    shown, find = list[ShownRelay | None](), cache(partial(_find_levels, case.recordings))
    for c in switched:
        case.budget.check()
        shown.append(_read_relay(case.recordings, c, find))
    return [s for s in shown if s is not None]


def follow_shown(
    case: Case, null: Hypothesis, shown: Sequence[ShownRelay], jobs: int, read_levels: LevelsOf | None = None
) -> list[RelayStart]:
    """Numbers that each takes as a heat that follows what was read, what leaves least first: fitted from the numbers of
    the null and from those of the file, which are not bent to what is missing. read_levels: off such a fit, where they
    are not known before."""
    told = [start for start in run_all(partial(_follow, case, null, read_levels), shown, jobs) if start is not None]
    return sorted(told, key=lambda start: start.followed)


def _follow(case: Case, null: Hypothesis, read_levels: LevelsOf | None, shown: ShownRelay) -> RelayStart | None:
    starts = (null.values, null.own_values, *([shown.beside] if shown.beside else ()))
    best = best_of(*(_fit_beside(case, null, shown, start) for start in starts))
    if best is not None and read_levels is not None:
        best, shown = follow_moved(best, shown, partial(_fit_beside, case, null))
    levels = shown.levels if best is None or read_levels is None else read_levels(best, shown)
    if best is None or not levels:
        return None
    there = dict(zip(shown.modes, move_points(best.fit), strict=True))
    began = case.began or (RunPoint(),) * len(case.recordings)
    points = tuple(there.get(i, point) for i, point in enumerate(began))
    return RelayStart(shown.candidate, {**best.values, **levels}, points, best.chi)


def _fit_beside(case: Case, null: Hypothesis, shown: ShownRelay, start: Mapping[str, float]) -> Hypothesis | None:
    recordings = (replace(r := case.recordings[i], modes={**r.modes, m.name: m}) for i, m in shown.modes.items())
    beside = replace(case.of([*shown.modes]), recordings=tuple(recordings), began=())
    return fit_with(beside, null, shown.followed, start, STEPS)


def follow_moved(
    followed: Hypothesis, shown: ShownRelay, fit: Callable[[ShownRelay, Mapping[str, float]], Hypothesis | None]
) -> tuple[Hypothesis, ShownRelay]:  # fmt: skip
    """A fit beside instants, or the one beside these where it finds them, unless that leaves more by far."""
    moved = replace(shown, modes=_shift_modes(followed, shown))
    again = fit(moved, followed.values)
    return (followed, shown) if again is None or again.chi > followed.chi * (1 + SLACK) else (again, moved)


def _shift_modes(followed: Hypothesis, shown: ShownRelay) -> dict[int, RelayMode]:
    """Modes with instants where a fit finds them."""
    runs = zip(shown.modes.items(), followed.case.recordings, move_edges(followed.fit), strict=True)
    return {i: mode.shift(later[len(later) - len(mode.spread) :], float(r.t[-1])) for (i, mode), r, later in runs}


def _read_relay(
    recordings: Sequence[Recording], c: Candidate, find: Callable[[str, float], Levels]
) -> ShownRelay | None:
    """None where nothing reads what it watches, or what is read does not go between two levels that it may have. find:
    the levels by sensor and its noise."""
    only = find_relay(c)
    readers = list_readers(c.machine, only[1]) if only else []
    sensor = next((n for n in readers if any(n in r.columns for r in recordings)), None)
    levels = find(sensor, c.machine.sensors[sensor].sigma) if sensor else None
    certain = make_certain(c, *levels) if levels else None
    return None if only is None or certain is None else _read_instants(recordings, c, only[0], certain)


def _find_levels(recordings: Sequence[Recording], sensor: str, sigma: float) -> Levels:
    read = [(r.t, r.columns[sensor].values) for r in recordings if sensor in r.columns]
    return find_levels(read, clear_of(sigma))


def _read_instants(
    recordings: Sequence[Recording], c: Candidate, path: EntryPath, certain: Certain
) -> ShownRelay | None:  # fmt: skip
    """certain: with the levels as they were read."""
    machine = certain.candidate.machine
    relay = machine.by_path[path]
    assert isinstance(relay, Relay)
    told = ((i, read_mode(machine, relay, path.name, r)) for i, r in enumerate(recordings))
    modes = {i: mode for i, mode in told if mode is not None}
    return ShownRelay(c, certain.candidate, certain.levels, modes) if modes else None
