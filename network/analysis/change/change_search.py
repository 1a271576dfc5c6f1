"""Then and now: which numbers of a machine, and which sensors, differ between two sets of recordings.

All numbers are fitted on both sets together, parts cut into more lumps while that fits the first set better. The entry
whose difference explains most is split, if it lies further from zero than one in 1/RARE machines that have not changed
would show in any of its entries (Bonferroni), and so on until none does; the limit is Student's for as many independent
values as tell what the machine leaves beyond noise. Of entries that explain nearly as much each is fitted in full, and
those that stay as likely are told.
Where something switches, what it does hangs on where its parts began, and not along a straight line: each set stands
about the starts with which it stays in step.
Range: changes that hold over all runs of a set; numbers without ± do not change.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from scipy.special import stdtrit

from network.analysis.calibration.calibrated_patch import with_fitted_numbers
from network.analysis.calibration.expansion_point import move_points
from network.analysis.calibration.gauss_newton import Linearised, Problem, chi_of, make_problem, minimise
from network.analysis.calibration.growing_horizon import InStep, begin_in_step, has_relays, settle_starts
from network.analysis.calibration.measured_means import Measured, RunPoint
from network.analysis.calibration.null import estimate_null
from network.analysis.calibration.robust_fit import fit_robustly
from network.analysis.change.change_screening import Difference, list_testable, measure_difference, test_entries
from network.analysis.change.paired_fit import PairedFit, Sets, fit_sets, weigh_again
from network.analysis.change.paired_starts import settle_sets
from network.analysis.change.run_information import find_scale
from network.analysis.diagnosis.lumps.lump_refinement import FINEST, list_finer_machines
from network.analysis.diagnosis.settings import SETTINGS
from network.engine.response.parameters import free_parameters
from network.machine.machine import Machine
from network.recordings.inputs import Start

RARE = 1e-3
"""Share of unchanged machines of which a change may be told."""
MOST = 6
"""Changes that are looked for, at most."""
NEAR, TRIED = 0.5, 4
"""Of the square of the largest σ: from there on rivals are fitted in full, so many at most."""
ALIKE = 6.0
"""J that a rival may lose more and is still told: e⁻³ as likely."""
REACHED = 0.5
"""Of the difference that slopes promise: what a fit has to have gone, for the slopes to be believed."""
ALL_FREE = 2.0
"""Prior σ that a number may differ by while all may differ at once, for the noise that is left then."""


@dataclass(frozen=True, eq=False)
class Split:
    """What was found. at: the fit with all changes split; differences: of these, in the order found; alike: entry →
    others that explain it as well; tested: entries that could have differed, each alone beside what was found; limit:
    σ beyond which one counts."""

    at: PairedFit
    differences: tuple[Difference, ...]
    alike: dict[int, tuple[int, ...]]
    tested: tuple[Difference, ...]
    limit: float


def split_changes(
    machine: Machine, then: Sequence[Measured], now: Sequence[Measured], start: Start | None = None, seed: int = 0,
    tell: Callable[[float], None] = lambda share: None,
) -> Split:  # fmt: skip
    """What differs between two sets of recordings that are laid out for a machine. Raises Failed where every run
    breaks down."""
    sets = _make_sets(machine, then, now, start, seed, lambda share: tell(0.5 * share))
    sets, freedom = _with_noise(sets)
    unchanged = fit_sets(sets)
    tell(0.7)
    candidates = tuple(_list_candidates(unchanged))
    limit = float(-stdtrit(freedom, RARE / 2 / max(len(candidates), 1)))
    at, alike = unchanged, dict[int, tuple[int, ...]]()
    while len(at.split) < MOST:
        best, rivals = _split_one(at, tuple(j for j in candidates if j not in at.split), limit)
        if best is None:
            break
        alike[best.split[-1]] = rivals
        at = _drop_faint(best, limit)
        if at.split == best.split[:-1]:
            break
        tell(0.7 + 0.3 * len(at.split) / MOST)
    tested = {j: measure_difference(at, j) for j in candidates}
    return Split(at, tuple(tested[j] for j in at.split), alike, tuple(tested.values()), limit)


def _make_sets(
    machine: Machine, then: Sequence[Measured], now: Sequence[Measured], start: Start | None, seed: int,
    tell: Callable[[float], None],
) -> Sets:  # fmt: skip
    """Both problems with the lumps that the first set asks for and the noise that it shows, about the numbers that fit
    it."""
    null = estimate_null(machine, free_parameters(machine), then, start, seed, lambda share: tell(0.8 * share))
    at, noise = _refine(null.fit.at, then, start), null.fit.noise
    fine = at.problem.model.machine
    if fine is not machine:
        noise = fit_robustly(make_problem(fine, at.problem.parameters, then).offsets, at).noise
    if has_relays(machine):
        alike = with_fitted_numbers(fine, at.problem.parameters, at.theta, [p.spread for p in at.problem.parameters])
        then, now = _stand_at(then, move_points(at)), _stand_at(now, _begin(at, alike, now, start).points)
    problems = [replace(make_problem(fine, at.problem.parameters, data, noise), offsets=()) for data in (then, now)]
    return Sets(fine, (problems[0], problems[1]), begin=at.theta)


def _refine(null: Linearised, data: Sequence[Measured], start: Start | None) -> Linearised:
    """The fit of the machine on as many lumps as it takes: on finer ones while they take a share of the misfit away."""
    machine = null.problem.model.machine
    best = _fit_about(machine, data, InStep.of(null))
    for finer in list_finer_machines(machine, FINEST):
        if chi_of(best) < SETTINGS.noise:
            break
        other = _fit_about(finer, data, _begin(best, finer, data, start))
        if chi_of(other) > (1 - SETTINGS.worth) * chi_of(best):
            break
        best = other
    return best


def _begin(near: Linearised, machine: Machine, data: Sequence[Measured], start: Start | None) -> InStep:
    """Where a fit begins: where what switches stays in step, else where another ended."""
    found = begin_in_step(machine, free_parameters(machine), data, start, lambda: False)
    return found or InStep(near.theta, tuple(d.point for d in data))


def _fit_about(machine: Machine, data: Sequence[Measured], begin: InStep) -> Linearised:
    """The minimum, where something switches about the starts that it finds."""
    given = _stand_at(data, begin.points) if has_relays(machine) else data
    return settle_starts(minimise(_problem_of(machine, given), begin.theta))


def _stand_at(data: Sequence[Measured], points: Sequence[RunPoint]) -> Sequence[Measured]:
    return [d.about(point) for d, point in zip(data, points, strict=True)]


def _problem_of(machine: Machine, data: Sequence[Measured]) -> Problem:
    return replace(make_problem(machine, free_parameters(machine), data), offsets=())


def _with_noise(sets: Sets) -> tuple[Sets, float]:
    """The sets, what switches about the starts found where all may differ, weighed by what they leave there, and how
    many independent values tell that."""
    at, freedom = settle_sets(fit_sets(replace(sets, loose=ALL_FREE), range(len(sets.prior[0])))), 0.0
    for _ in range(2):
        (then, n), (now, m) = (find_scale(runs, scale) for runs, scale in zip(at.runs, at.sets.scales, strict=True))
        at, freedom = weigh_again(at, (then, now)), min(n, m)
    return replace(at.sets, loose=sets.loose, begin=at.p[: len(sets.parameters)]), freedom


def _list_candidates(at: PairedFit) -> Iterator[int]:
    """What may have changed: numbers that both sets tell, and sensors, but for probes that are zeroed at every start
    and sensors whose constant error is a number of the machine."""
    n, sensors = len(at.sets.parameters), at.sets.machine.sensors
    stated = {p.entry.name for p in at.sets.parameters if p.entry.section == "sensors"}
    for j in list_testable(at):
        name = at.sets.channels[j - n] if j >= n else ""
        if not name or not (sensors[name].zero or name in stated):
            yield j


def _split_one(at: PairedFit, candidates: tuple[int, ...], limit: float) -> tuple[PairedFit | None, tuple[int, ...]]:
    """The fit with one more entry split, of those that explain most, and its equals; None where none counts."""
    tested = test_entries(at, candidates)
    if not tested or tested[0].sigma < limit:
        return None, ()
    near = [each.entry for each in tested if each.sigma**2 > NEAR * tested[0].sigma ** 2][:TRIED]
    fits = sorted((fit_sets(at.sets, (*at.split, j), at) for j in near), key=lambda fit: fit.cost)
    equals = tuple(fit.split[-1] for fit in fits[1:] if fit.cost - fits[0].cost < ALIKE)
    return fits[0], equals


def _drop_faint(at: PairedFit, limit: float) -> PairedFit:
    """Without entries that the last one has made needless, and those that the fit did not follow."""
    kept = tuple(j for j in at.split if measure_difference(at, j).sigma >= limit and is_reached(at, j))
    return at if kept == at.split else fit_sets(at.sets, kept, at)


def is_reached(at: PairedFit, entry: int) -> bool:
    """Whether the simulation has confirmed at least half of the difference that slopes promise. Where a thermostat
    switches they may promise what no simulation does; a constant error of a sensor is linear."""
    if entry >= len(at.sets.parameters):
        return True
    return abs(float(at.d[entry])) >= REACHED * abs(measure_difference(at, entry).value)
