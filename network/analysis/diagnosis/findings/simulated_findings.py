"""What a search comes to, simulated: beside the calibrated machine, and with ever less of it while runs speak against
it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from network.analysis.calibration.estimated_constants import Numbers, compare_estimated
from network.analysis.calibration.expansion_point import points_by_file
from network.analysis.calibration.generalisation import with_numbers, with_standard_errors
from network.analysis.calibration.misfit import channel_misfits
from network.analysis.calibration.recorded_modes import forget_modes
from network.analysis.calibration.uncertainty import Uncertainty, uncertainty_by_curvature
from network.analysis.diagnosis.findings.invariants import list_refutations
from network.analysis.diagnosis.findings.result import Fits
from network.analysis.diagnosis.findings.simulated_runs import SimulatedRuns, simulate_runs
from network.analysis.diagnosis.hypotheses.case_noise import use_file_noise
from network.analysis.diagnosis.hypotheses.compact_fit import expand
from network.analysis.diagnosis.hypotheses.faced_relays import face_relays
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_findings, fit_lasting, reweight, state
from network.analysis.diagnosis.steps.selection import Selection
from network.machine.machine import Machine
from network.platform.refusal import Failed, Refused
from network.recordings.recording import Recording

if TYPE_CHECKING:
    from network.analysis.diagnosis.reading_fault import ReadingFault
    from network.analysis.diagnosis.search_record import Search


def withdraw_refuted(
    search: Search, before: SimulatedRuns, jobs: int
) -> tuple[Search, Machine | None, Fits, list[str]]:
    """The search without the last findings, then without finer lumps, while simulated runs speak against them (before:
    as calibrated); the machine that this comes to (None: as calibrated), how both tell the recordings, and what spoke
    against it. Raises Failed where a run breaks down with whatever is left."""
    search, after, fits, against = _test_simulated(search, before, jobs)
    refuted = against
    for rest in list_retreats(search):
        if not against:
            break
        search, after, fits, against = _test_simulated(rest, before, jobs)
    if fits is None:
        raise Failed(against[0])
    return search, after, fits, refuted


def _test_simulated(
    search: Search, before: SimulatedRuns, jobs: int
) -> tuple[Search, Machine | None, Fits | None, list[str]]:  # fmt: skip
    """A search at the numbers that its relays keep step with, the machine that it comes to, how it tells the
    recordings, and what speaks against it; None and why where a run breaks down, or its numbers make no machine."""
    try:
        search, after, fits = _simulate_both(search, before, jobs)
    except (Failed, np.linalg.LinAlgError) as broken:
        return search, None, None, [f"with it a run breaks down: {broken}"]
    except Refused as refused:
        return search, None, None, [f"its numbers make no machine: {refused}"]
    return search, after, fits, [] if after is None else list_refutations(search.selection, fits)


def list_retreats(search: Search) -> Iterator[Search]:
    """The search with ever less of what it found, to the machine as written, where the time is up at once, and to a
    fault of readings that stands alone."""
    best, chosen = search.best, search.selection
    case = replace(best.case, budget=search.case.budget)
    for count in range(0 if search.ended else len(best.found) - 1, 0, -1):
        fewer = fit_findings(case, best.root, best.found[:count], best.values)
        if fewer is not None:
            yield replace(search, selection=replace(chosen, best=fewer, gains=chosen.gains[:count]))
    for rest in (search.null, search.written):
        if rest is not best:
            yield replace(search, selection=Selection(reweight(best.case, rest)))
    if search.fault is not None and search.fault.stands_alone:
        yield from _list_alone(search)
    if search.fault is not None:
        bare = _bare_of(search)
        yield replace(search, fault=None, case=search.given, written=bare, null=bare, selection=Selection(bare))


def _list_alone(search: Search) -> Iterator[Search]:
    """Its fault of readings alone, at numbers to which each channel counts by how far it is off and how long that
    lasts: neither coloured noise nor constant errors of sensors take up what is left. From the numbers as calibrated,
    then from those as fitted; where readings show it by themselves as calibrated, which takes no fit."""
    case = replace(use_file_noise(search.written.case), budget=search.case.budget)
    calibrated, fitted = search.calibrated.values, search.written.values
    is_shown = search.fault is not None and search.fault.shows_itself
    for values in (calibrated,) if is_shown else (calibrated, fitted):
        try:
            alone = state(case, case.machine, values)
            alone = alone if is_shown else reweight(case, fit_lasting(alone))
        except (Failed, np.linalg.LinAlgError):
            continue
        yield replace(search, case=case, written=alone, null=alone, selection=Selection(alone))


def _bare_of(search: Search) -> Hypothesis:
    """The machine as given on the recordings as they were, where a fault of readings is taken back."""
    if search.fault is None or not search.fault.changes_machine:
        return reweight(search.given, search.written)
    return state(search.given, search.given.machine, search.calibrated.values)


def _simulate_both(search: Search, before: SimulatedRuns, jobs: int) -> tuple[Search, Machine | None, Fits]:
    """A search at the numbers that its relays keep step with, the machine with what was found at these (None: as
    calibrated), and how both tell the recordings, simulated."""
    if not (search.best.found or is_finer(search)) and (search.fault is None or _is_as_calibrated(search)):
        return replace(search, faced=None), None, _fits(search, before, before.numbers, jobs)
    search = replace(search, faced=face_relays(search.best, bool(search.ended)))
    after = with_standard_errors(search.told.machine, _known(search.told))
    return search, after, _fits(search, before, _numbers(search.told, after), jobs)


def _is_as_calibrated(search: Search) -> bool:
    """Whether nothing but readings is other than calibrated: then every run is told by the same numbers."""
    then, now = search.calibrated.values, search.best.values
    is_same = then.keys() == now.keys() and all(np.isclose(now[path], x, rtol=1e-9) for path, x in then.items())
    return is_same and search.fault is not None and not search.fault.changes_machine


def is_finer(search: Search) -> bool:
    return search.best.root.to_plain() != search.written.machine.to_plain()


def numbers_in(h: Hypothesis, is_late: Callable[[], bool]) -> Machine:
    """The machine of a hypothesis with its numbers ± their standard errors, and how far it holds; briefly found once it
    is late."""
    return with_numbers(h.machine, _known(h), is_late)


def _known(h: Hypothesis) -> Uncertainty:
    return uncertainty_by_curvature(expand(h).linearised)


def _fits(search: Search, before: SimulatedRuns, found: Numbers, jobs: int) -> Fits:
    """How the calibrated machine and the one that was found tell the recordings, the second without the fault in
    them."""
    shown = search.given.recordings if search.fault is None else search.fault.show(search.case)
    held = _correct_readings(search, found, before.held)
    after = simulate_runs(found, forget_modes(shown), held, jobs, before)
    return Fits(before.train, after.train, before.holdout, after.holdout)


def _numbers(h: Hypothesis, machine: Machine) -> Numbers:
    """A machine with the numbers of a hypothesis."""
    misfit = channel_misfits(h.fit)
    points = points_by_file(h.fit)
    return Numbers(machine, h.machine, h.fit.problem.parameters, h.fit.theta, h.case.start, misfit, points)


def _correct_readings(search: Search, found: Numbers, holdout: Sequence[Recording]) -> Sequence[Recording]:
    """Held-out recordings without the fault that was found in the others."""
    fault = search.fault
    if fault is None:
        return holdout
    return [_correct_run(fault, found, run) for run in holdout]


def leave_fault(search: Search, after: Machine, holdout: Sequence[Recording], fits: Fits) -> Machine:
    """The machine with a sensor's fault that lasts, where what was held out has it, too: it tells what comes next."""
    fault = search.fault
    if fault is None:
        return after
    told = fits.holdout_after.recordings if fits.holdout_after is not None else ()
    pairs = [(t.recording.columns[n], run.columns[n]) for t, run in zip(told, holdout, strict=True)
             for n in fault.channels if n in run.columns]  # fmt: skip
    is_whole = any(np.array_equal(a.values, b.values, equal_nan=True) for a, b in pairs)
    return after if is_whole else fault.leave_in(after)


def _correct_run(fault: ReadingFault, found: Numbers, run: Recording) -> Recording:
    """The run set right in the way that leaves least."""
    run = fault.complete(run)
    raw = compare_estimated(found, run, held_out=True)
    if not {*fault.needed} <= {*raw.channels}:
        return run
    ways = fault.list_corrections(raw, found)
    if len(ways) == 1:
        return ways[0]
    return min(ways, key=lambda way: compare_estimated(found, way, held_out=True).rmse_in_noise)
