"""Structure before physics: as many lumps in every bar as the recordings can tell apart, and no more.

With n lumps in a bar and all others as they are, let d be what the channels have more with 2 n: whitened and with
what the numbers take up of it projected out, e(n) = |M W d| [σ]. The error of n lumps falls with n², so that 4/3 e(n)
is what is left to the limit of a continuous bar. Lumps suffice where these, summed over the B bars, stay within √(2 E)
times the factor that noise counts with where a misfit lasts (misfit.py), E the evidence within which two explanations
cannot be told apart: no lump decides then between them. Where there are many runs, those told worst stand for all.
Where a better fit leaves less, lumps are looked at again.
Range: bars whose profiles their lumps begin to resolve; from coarser ones at most GROWTH times as many are taken at
once, and it is looked again. Source of the order: Richardson's extrapolation, Phil. Trans. R. Soc. A 210 (1911) 307.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import ceil

import numpy as np

from network.analysis.calibration.growing_horizon import begin_in_step
from network.analysis.calibration.linearised import Linearised
from network.analysis.calibration.misfit import lasting_misfit
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.falling_short import FallsShort
from network.analysis.diagnosis.hypotheses.few_runs import on_few_runs
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis, parameters_of, settle_hypothesis
from network.analysis.diagnosis.screening.screen import whiten
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.ranking import best_of
from network.analysis.diagnosis.time_budget import BudgetReached
from network.analysis.sweep.finer_lumps import bars_of, cut_bars
from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.patch import Patch
from network.engine.response.model import Model
from network.engine.response.parameters import values_at
from network.machine.machine import Machine
from network.platform.parallel import run_all
from network.platform.refusal import Failed

STEPS = 15
"""Of a fit on finer lumps to a few runs."""
LEVELS = 3
"""Times that lumps are refined."""
FINEST, MANY = 400, 120
"""Lumps beyond which a machine is not refined, and beyond which it is not worked out what would not have shown where
little is left and what comes before the search has had its time, nor looked once more for readings at fault
(budget)."""
ROUNDS, GROWTH = 4, 4
"""Times that lumps are looked at again, and how many times as many a bar gets at once."""
LOOK, FURTHER, SLOWER = 0.1, 0.01, 1.5
"""Shares of the whole time beyond which a look at the next lumps tells that fits on them would take too long, and
beyond which they are taken without one (budget); the power of their number that it grows with (measured: 1 to 1.8)."""
TO_THE_LIMIT = 4 / 3
NEARLY = 0.9
"""Misfit χ over that on coarser lumps from which finer ones hardly matter, and are not refined further, while there is
time for them (budget)."""
NOTHING = 1e-6
"""σ below which cutting a bar changes nothing, however others are cut: it has one temperature."""


def list_finer_machines(machine: Machine, most: int | None = None) -> Iterator[Machine]:
    """The machine with all structural proposals laid over it, and again over that, to so many lumps."""
    for _ in range(LEVELS):
        patch = Patch.of(entry for c in list_structural(machine) for entry in c.patch.by_name())
        if not patch:
            return
        machine = machine.patched(patch)
        if most is not None and machine.lumps > most:
            return
        yield machine


def list_structural(machine: Machine) -> list[Candidate]:
    return list(candidates(machine, machine.inputs, structural=True))


def refine_lumps(case: Case, written: Hypothesis, jobs: int = 1) -> list[Hypothesis]:
    """The machine as written, then on the lumps that it takes at its numbers, and again at those that it has there,
    while that helps and there is time for it. Raises BudgetReached where none finer were fitted until then."""
    levels = [written]
    for _ in range(LEVELS):
        best = max(levels, key=lambda h: h.evidence)
        if levels[-1].chi < SETTINGS.noise or is_late(levels[-1]):
            break
        try:
            fitted = _fit_first_that_matters(case, levels, best, jobs)
        except BudgetReached:
            if len(levels) == 1:
                raise
            break
        if fitted is None:
            break
        levels.append(fitted)
        if fitted.evidence < best.evidence + SETTINGS.structure or _is_no_matter_of_lumps(fitted, best):
            break
    return levels


def _fit_first_that_matters(
    case: Case, levels: Sequence[Hypothesis], best: Hypothesis, jobs: int
) -> Hypothesis | None:  # fmt: skip
    """The first of the finer machines by which it is a matter of lumps, fitted; else the best of them, none where none
    fits. What it would come to is not told from the coarse one before: its numbers are bent to its lumps."""
    fitted: Hypothesis | None = None
    for machine in _list_finer(levels, jobs):
        try:
            fitted = best_of(fitted, _try_finer(case, machine, best, levels[0]))
        except BudgetReached:
            if fitted is None:
                raise
            break
        if fitted is not None and not _is_no_matter_of_lumps(fitted, best):
            break
    return fitted


def is_late(h: Hypothesis) -> bool:
    """Whether there is no time for finer lumps than those of a hypothesis: what leaves little takes what it takes."""
    return h.chi > SETTINGS.doubtful and h.case.budget.is_prepared()


def _list_finer(levels: Sequence[Hypothesis], jobs: int) -> Iterator[Machine]:
    """The last machine on the lumps that it takes at its numbers. The one that was written, where much is left of it,
    also with every bar cut: numbers that are bent by its lumps do not tell which it takes."""
    last = levels[-1]
    if (chosen := choose_lumps(last, jobs)) is not None:
        yield chosen
    few = {name: GROWTH for name, n in bars_of(last.root).items() if n < GROWTH}
    if few and len(levels) == 1 and last.chi > SETTINGS.doubtful and not last.fit.problem.model.switches:
        yield cut_bars(last.root, few)


def _is_no_matter_of_lumps(finer: Hypothesis, before: Hypothesis, share: float = SETTINGS.half) -> bool:
    """Whether much is left, and not by far less than on the lumps before: something else is missing."""
    return finer.chi > SETTINGS.doubtful and finer.chi > share * before.chi


def hardly_matter(finer: Hypothesis, written: Hypothesis) -> bool:
    """Whether finer lumps leave much, and nearly as much as those of the machine as written; once the time for them is
    up, more than half of it: what is missing is found sooner on few."""
    return _is_no_matter_of_lumps(finer, written, SETTINGS.half if is_late(finer) else NEARLY)


def _try_finer(case: Case, machine: Machine, before: Hypothesis, written: Hypothesis) -> Hypothesis | None:
    """The machine fitted on finer lumps; None where its runs break down, which is none of those on fewer."""
    try:
        return _fit_finer(case, machine, before, written)
    except (Failed, np.linalg.LinAlgError):
        return None


def _fit_finer(case: Case, machine: Machine, before: Hypothesis, written: Hypothesis) -> Hypothesis | None:
    """The machine fitted on finer lumps, from the numbers of the file where nothing finer was fitted before; None where
    they explain less of a few runs or, once there is no time for them, leave more than half. Relays that fall out of
    step there begin anew in step, unless the numbers at hand explain more as they are."""
    few, start = on_few_runs(before), None if before is written else before.values
    if few is not before and not before.fit.problem.model.switches:
        until = FallsShort(few.evidence, STEPS)
        begun = fit_hypothesis(few.case, machine, start=start, steps=STEPS, until=until)
        if begun.evidence < few.evidence or _is_in_vain(begun, few):
            return None
        start = begun.values
    direct = fit_hypothesis(case, machine, start=start, until=lambda at: is_late(before))
    if is_late(before):
        return None if _is_in_vain(direct, before) else fit_hypothesis(case, machine, start=direct.values)
    is_in_step = start is not None and direct.evidence > before.evidence
    if is_in_step or direct.chi < SETTINGS.doubtful or not direct.fit.problem.model.switches:
        return direct
    return _begin_anew_in_step(case, direct, before)


def _is_in_vain(finer: Hypothesis, before: Hypothesis) -> bool:
    """Whether there is no time for finer lumps that leave more than half."""
    return is_late(before) and _is_no_matter_of_lumps(finer, before)


def _begin_anew_in_step(case: Case, direct: Hypothesis, before: Hypothesis) -> Hypothesis:
    """A fit whose relays fell out of step on finer lumps, or another one that begins in step, where that explains more
    and there is time for it."""
    parameters = parameters_of(direct.machine, ())
    begin = begin_in_step(
        direct.machine, parameters, case.lay_out(direct.machine), case.start,
        lambda: is_late(before) or case.budget.is_searched(),
    )  # fmt: skip
    if begin is None or is_late(before):
        return direct
    about = replace(case, began=begin.points)
    led = settle_hypothesis(fit_hypothesis(about, direct.machine, start=values_at(parameters, begin.theta)))
    return max(direct, led, key=lambda h: h.evidence)


def choose_lumps(h: Hypothesis, jobs: int = 1, rounds: int = ROUNDS, growth: int = GROWTH) -> Machine | None:
    """The machine of a hypothesis without what was found, with the lumps that it takes, as far as they are no more than
    FINEST and a look at them does not take long, for then fits would, too; None where it has them. rounds: times that
    they are looked at, for what one bar takes shows the more the finer the others are, unless that is slow; growth: how
    many times as many a bar gets in each."""
    own = bars_of(h.root)
    written = counts = {name: n for name, n in bars_of(h.machine).items() if name in own}
    few = on_few_runs(h)
    part = len(few.fit.left) / max(len(h.fit.left), 1)
    allowed = float(np.sqrt(2 * SETTINGS.alike * part)) * lasting_misfit(h.linearised) / max(len(counts), 1)
    bars, others = [*counts], h.machine.lumps - sum(counts.values())
    for _ in range(rounds):
        began = h.case.budget.spent
        left = leave_each(few, counts, bars, jobs)
        more = counts | {name: _count(counts[name], TO_THE_LIMIT * off / allowed, growth) for name, off in left.items()}
        took = h.case.budget.spent - began
        growing = (others + sum(more.values())) / (others + sum(counts.values()))
        next_one = took * growing**SLOWER
        if more == counts or sum(more.values()) > FINEST or next_one > LOOK * h.case.budget.seconds:
            break
        counts, bars = more, [name for name in bars if left.get(name, np.inf) > NOTHING]
        if next_one > FURTHER * h.case.budget.seconds:
            break
    return None if counts == written else cut_bars(h.root, counts)


def _count(now: int, off: float, growth: int) -> int:
    """Lumps with which an error that is so many times what is allowed is within it, as far as they do not grow by
    more."""
    return now if off <= 1 else min(ceil(now * np.sqrt(off)), growth * now)


def leave_each(h: Hypothesis, counts: Mapping[str, int], bars: Sequence[str], jobs: int) -> dict[str, float]:
    """|M W d| of some bars [σ], of those with which no run breaks down."""
    is_own = counts.items() <= bars_of(h.machine).items()
    here = np.concatenate([p.cells for p in h.predictions]) if is_own else means_of(h, cut_bars(h.machine, counts))
    finer = [cut_bars(h.machine, {**counts, name: 2 * counts[name]}) for name in bars]
    there = zip(bars, run_all(partial(means_of, h), finer, jobs), strict=True)
    told = {name: means - here for name, means in there if here is not None and means is not None}
    return {name: _size(h.linearised, lack) for name, lack in told.items()}


def means_of(h: Hypothesis, machine: Machine) -> Array | None:
    """Cells' means of all runs at the numbers of a hypothesis; None where they break down."""
    fit, parameters = h.fit, parameters_of(machine, h.own)
    if [p.path for p in parameters] != [p.path for p in fit.problem.parameters]:
        return None
    try:
        told = Model(machine, parameters, [d.run for d in fit.problem.data]).predict(fit.theta)
        return np.concatenate([p.cells for p in told])
    except (Failed, np.linalg.LinAlgError):
        return None


def _size(fit: Linearised, lack: Array) -> float:
    d = whiten(fit, lack)
    return float(np.sqrt(max(d @ fit.project(d[None])[0], 0.0)))
