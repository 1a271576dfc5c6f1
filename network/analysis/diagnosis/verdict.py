"""From what a search found to what is said: verdict, confidence, rivals, the machine with its findings, the gain."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from network.analysis.calibration.estimated_constants import Numbers, compare_estimated
from network.analysis.calibration.gauss_newton import chi_of
from network.analysis.calibration.generalisation import with_numbers
from network.analysis.calibration.misfit import channel_misfits
from network.analysis.calibration.recorded_modes import forget_modes
from network.analysis.calibration.uncertainty import uncertainty_by_curvature
from network.analysis.comparison.compare import Comparison, RecordingResidual
from network.analysis.diagnosis.compact_fit import expand
from network.analysis.diagnosis.experiments.advice import experiments
from network.analysis.diagnosis.faced_relays import face_relays
from network.analysis.diagnosis.findings import find_unknown, is_shadow, list_findings, list_rivals
from network.analysis.diagnosis.hypothesis import Hypothesis, fit_findings, reweight, state
from network.analysis.diagnosis.invariants import doubt_unseen, list_refutations
from network.analysis.diagnosis.isolability import isolability
from network.analysis.diagnosis.locate import trace
from network.analysis.diagnosis.lumping_finding import find_lumping
from network.analysis.diagnosis.refit import linearise_at_priors
from network.analysis.diagnosis.result import UNKNOWN, Diagnosis, Finding, Fits, UnknownHeat
from network.analysis.diagnosis.screened_gain import list_screened
from network.analysis.diagnosis.selection import Selection
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.strategies import list_unsearched
from network.analysis.diagnosis.time_budget import TimeBudget
from network.machine.machine import Machine
from network.platform.parallel import run_all
from network.platform.refusal import Failed
from network.platform.wording import sentence
from network.recordings.recording import Recording

if TYPE_CHECKING:
    from network.analysis.diagnosis.reading_fault import ReadingFault
    from network.analysis.diagnosis.search_record import Search


def conclude(search: Search, holdout: Sequence[Recording], warnings: Sequence[str], seed: int, jobs: int) -> Diagnosis:
    """The diagnosis that a search amounts to."""
    search = replace(search, case=replace(search.case, budget=TimeBudget()))
    before = search.calibrated.fitted
    search, after, fits, refuted = _withdraw_refuted(search, before, holdout, jobs)
    finer_gain = search.null.evidence - search.written.evidence
    is_told = _is_finer(search) and finer_gain > search.threshold
    coarse = find_lumping(search.written, search.best.root, finer_gain, search.threshold) if is_told else None
    findings, verdict = _decide_verdict(search, list_findings(search, after), coarse, bool(refuted))
    doubt = doubt_unseen(fits)
    findings = [_doubt_finding(f, doubt) for f in findings]
    if search.ended:  # nothing is sure
        findings = [replace(f, confidence=min(f.confidence, SETTINGS.half)) for f in findings]
    known = isolability(search.screened.scores, search.screened.proposed)
    advice = () if search.ended else tuple(experiments(search, known.unseen))
    is_looked = search.null.chi > SETTINGS.noise
    unsearched = list_unsearched(search.screened, not search.ended) if is_looked else []
    told = [*map(_as_sentence, refuted), *_notes(search), *(u.sentence for u in unsearched)]
    told += list(_tell_unseen(fits)) if doubt and not findings else []
    notes = (*warnings, *told, *([known.sentence] if known.sentence else ()))
    if after is before:
        before = after = search.calibrated.machine
    after = _leave_fault(search, after, holdout, fits)
    return Diagnosis(
        search.given.machine, before, after, verdict, tuple(findings), _channels(fits), _trace_first(search), fits,
        tuple(list_rivals(search.steps[0], search.befores[0]) if search.steps else ()), notes, advice,
        _shifts(search.best), seed, explained=search.selection.explained, ended=search.ended, refuted=tuple(refuted),
        unsearched=tuple(unsearched), screened=list_screened(search.screened.scores),
    )  # fmt: skip


def _tell_unseen(fits: Fits) -> Iterator[str]:
    """That runs held out are told much worse than those fitted."""
    if fits.holdout_after is not None:
        seen, unseen = fits.train_after.rmse_in_noise, fits.holdout_after.rmse_in_noise
        yield (
            f"What was held out is left at {unseen:.2g} σ, what was fitted at {seen:.2g} σ: something differs between "
            "these runs that the file does not know – a room, a start, or what acts in some of them only."
        )


def _doubt_finding(finding: Finding, doubt: str) -> Finding:
    """A finding with a further doubt, where there is one."""
    if not doubt:
        return finding
    sure = min(finding.confidence, SETTINGS.barred)
    return replace(finding, confidence=sure, doubts=(*finding.doubts, doubt))


def _trace_first(search: Search) -> tuple[UnknownHeat, ...]:
    """Where unknown heat would explain most, with the course of the most probable one where something is missing."""
    places = search.located[:8]
    first = next((u for u in places if not u.is_offset), None)
    if first is None or search.null.chi <= SETTINGS.noise:
        return places
    return tuple(trace(search.null.linearised, u) if u is first else u for u in places)


def _as_sentence(told: str) -> str:
    return f"{sentence(told)}: it is not added."


def _withdraw_refuted(
    search: Search, before: Machine, holdout: Sequence[Recording], jobs: int
) -> tuple[Search, Machine, Fits, list[str]]:
    """The search without the last findings, then without finer lumps, while simulated runs speak against them, and what
    did."""
    told = _test_simulated(search, before, holdout, jobs)
    refuted = told[2]
    for rest in _list_retreats(search):
        if not told[2]:
            break
        search, told = rest, _test_simulated(rest, before, holdout, jobs)
    after, fits, left = told
    if fits is None:
        raise Failed(left[0])
    return search, after, fits, refuted


def _test_simulated(
    search: Search, before: Machine, holdout: Sequence[Recording], jobs: int
) -> tuple[Machine, Fits | None, list[str]]:
    """What a search comes to, simulated, and what speaks against it; runs that break down do."""
    try:
        after, fits = _simulate_both(search, before, holdout, jobs)
    except (Failed, np.linalg.LinAlgError) as broken:
        return before, None, [f"with it a run breaks down: {broken}"]
    return after, fits, list_refutations(search.selection, fits) if after is not before else []


def _list_retreats(search: Search) -> Iterator[Search]:
    """The search with ever less of what it found, to the machine as written; at once where the time is up."""
    best, chosen = search.best, search.selection
    case = replace(best.case, budget=search.case.budget)
    for count in range(0 if search.ended else len(best.found) - 1, 0, -1):
        fewer = fit_findings(case, best.root, best.found[:count], best.values)
        if fewer is not None:
            yield replace(search, selection=replace(chosen, best=fewer, gains=chosen.gains[:count]))
    for rest in (search.null, search.written):
        if rest is not best:
            yield replace(search, selection=Selection(reweight(best.case, rest)))
    if search.fault is not None:
        bare = _bare_of(search)
        yield replace(search, fault=None, case=search.given, written=bare, selection=Selection(bare))


def _bare_of(search: Search) -> Hypothesis:
    """The machine as given on the recordings as they were, where a fault of readings is taken back."""
    if search.fault is None or not search.fault.patch:
        return reweight(search.given, search.written)
    return state(search.given, search.given.machine, search.calibrated.values)


def _simulate_both(search: Search, before: Machine, holdout: Sequence[Recording], jobs: int) -> tuple[Machine, Fits]:
    """The machine with what was found and its numbers, and how it tells the recordings, simulated."""
    if not (search.fault or search.best.found or _is_finer(search)):
        return before, _fits(search, search.best, before, before, holdout, jobs)
    best = face_relays(search.best)
    after = numbers_in(best)
    return after, _fits(search, best, before, after, holdout, jobs)


def _is_finer(search: Search) -> bool:
    return search.best.root.to_plain() != search.written.machine.to_plain()


def numbers_in(h: Hypothesis) -> Machine:
    """The machine of a hypothesis with its numbers ± their standard errors, and how far it holds."""
    return with_numbers(h.machine, uncertainty_by_curvature(expand(h).linearised))


def _decide_verdict(
    search: Search, findings: list[Finding], coarse: Finding | None, is_refuted: bool
) -> tuple[list[Finding], str]:
    """Findings and verdict. What holds on unseen runs is told, as a part of the truth where much is left; before it,
    what has no name, where that is more, the names are less likely than not, or heat at one place alone explains more
    than they do."""
    best, cut = search.best, [coarse] if coarse else []
    is_left = best.chi > SETTINGS.doubtful and bool(search.located)
    if findings:
        holds = search.selection.explained if search.selection.is_checked else 1.0
        is_more = is_left and min(holds, max(f.confidence for f in findings)) < SETTINGS.half
        is_bent = is_left and search.fault is None and is_shadow(search)
        only_sensors = not (is_more or is_bent) and all(f.channels for f in findings)
        told = [*([find_unknown(search, is_bent)] if is_more or is_bent else []), *findings, *cut]
        return told, "sensor_fault" if only_sensors else "missing_physics"
    if is_left or (is_refuted and best.chi > SETTINGS.adequate and _stands_out(search)):
        unknown = find_unknown(search)
        return [*cut, unknown], "unexplained" if unknown.kind == UNKNOWN else "missing_physics"
    if coarse:
        return cut, "too_coarse"
    wrong = any(abs(x) > SETTINGS.shift for x in _shifts(best).values()) or _was_off(search)
    return [], "parameters_only" if wrong else "adequate"


def _stands_out(search: Search) -> bool:
    """Whether unknown heat at one place explains more than chance would."""
    return bool(search.located) and search.located[0].gain > search.threshold


def _was_off(search: Search) -> bool:
    """Whether the numbers of the file, as they stand, leave more than noise."""
    at = linearise_at_priors(search.null.linearised)
    return at is None or chi_of(at) > SETTINGS.doubtful


def _fits(
    search: Search, best: Hypothesis, before: Machine, after: Machine, holdout: Sequence[Recording], jobs: int
) -> Fits:
    given = search.calibrated.numbers(search.given.start)
    found = given if after is before else _numbers(best, after)
    held = _correct_readings(search, found, holdout)
    bare = tuple(forget_modes(search.case.recordings))
    sets = [(given, search.given.recordings), (found, bare), (given, holdout), (found, held)]
    items = [(i, i > 1, run) for i, (_, runs) in enumerate(sets) for run in runs]
    told = iter(run_all(partial(_compare_run, [numbers for numbers, _ in sets]), items, jobs))
    train, fitted, *rest = (Comparison(of.machine, tuple(next(told) for _ in runs)) for of, runs in sets)
    return Fits(train, fitted, *(rest if holdout else (None, None)))


def _numbers(h: Hypothesis, machine: Machine) -> Numbers:
    """A machine with the numbers of a hypothesis."""
    misfit = channel_misfits(h.fit)
    return Numbers(machine, h.machine, h.fit.problem.parameters, h.fit.theta, h.case.start, misfit)


def _correct_readings(search: Search, found: Numbers, holdout: Sequence[Recording]) -> Sequence[Recording]:
    """Held-out recordings without the fault that was found in the others."""
    fault = search.fault
    if fault is None:
        return holdout
    return [_correct_run(fault, found, run) for run in holdout]


def _leave_fault(search: Search, after: Machine, holdout: Sequence[Recording], fits: Fits) -> Machine:
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
    raw = compare_estimated(found, run, held_out=True)
    if not {*fault.channels} <= {*raw.channels}:
        return run
    ways = fault.list_corrections(raw)
    if len(ways) == 1:
        return ways[0]
    return min(ways, key=lambda way: compare_estimated(found, way, held_out=True).rmse_in_noise)


def _compare_run(of: Sequence[Numbers], item: tuple[int, bool, Recording]) -> RecordingResidual:
    """Residuals of a run, held out or not, of one of some machines, its constants estimated."""
    i, held_out, run = item
    return compare_estimated(of[i], run, held_out)


def _channels(fits: Fits) -> Mapping[str, float]:
    """Channels by how far they were off before, the worst first."""
    told: dict[str, float] = fits.summary()["train"]["before"]["channels"]
    return dict(sorted(told.items(), key=lambda pair: -pair[1]))


def _shifts(h: Hypothesis) -> dict[str, float]:
    """How far the numbers of the file moved, in prior σ, the farthest first."""
    own = {p.path for p in h.own}
    names = [p.path for p in h.fit.problem.parameters if p.path not in own]
    return dict(sorted(zip(names, h.shift.tolist(), strict=True), key=lambda pair: -abs(pair[1])))


def _notes(search: Search) -> Iterator[str]:
    """What the recordings are worth, as sentences."""
    for data in search.best.fit.problem.data:
        for name, channel in data.channels.items():
            if channel.apart.any():
                count = int(channel.apart.sum())
                yield f"{data.recording.name}: {count} readings of {name} are outliers and were excluded."
    tinted = [n for n, (s, _) in search.best.case.noise.coloured.items() if s]
    if tinted:
        yield f"The noise of {', '.join(tinted)} is coloured; evidence counts it as such."
