"""A sensor that fails from an instant of one run on: scored about a fit, confirmed by fits.

A reading that jumps where no input does and no other channel does has failed, whatever else is missing: it counts where
hardly anything of that channel's own excess in that run is left. A drift, or a jump that noise covers, could be heat,
too: it counts where hardly anything is left at all, and neither the catalogue nor unknown heat anywhere explains as
much, its beginning is told, and no input steps there. What should be seen to jump and does not is none.

Coarse lumps leave much, and lumps are not refined as far as they should be where a reading is wrong: what takes most of
that away is looked at again beside finer ones, where it has to hold (search).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from network.analysis.calibration.linearised import linearise
from network.analysis.diagnosis.hypotheses.falling_short import leaves_too_much, share_shown
from network.analysis.diagnosis.hypotheses.few_runs import FEW, SEARCHED, list_worst_runs, on_runs
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.intermittent.channel_fault import LEFT, PER_WINDOW
from network.analysis.diagnosis.intermittent.corrected_onset import Corrected, correct_onset
from network.analysis.diagnosis.intermittent.fault_shapes import list_shapes
from network.analysis.diagnosis.intermittent.onset_fault import OnsetFault
from network.analysis.diagnosis.intermittent.onset_jump import (
    ResidualSteps,
    begin_with_jump,
    list_lone_jumps,
    may_be_driven,
    watch_jump,
)
from network.analysis.diagnosis.intermittent.onset_scan import Onset, OnsetScan
from network.analysis.diagnosis.latent_heat.locate import locate
from network.analysis.diagnosis.settings import SETTINGS

CONFIRMED = 2
"""Clear jumps of the best scores of which all that they could be is confirmed by fits, and one score of those that are
not clear (budget)."""
ROUNDS = 6
"""Times at most that instant and size are found again about the better fit."""
SETTLED = 1.0
"""Nats by which that has to gain to go on, in squares of the misfit."""
NEARLY = 1.5
"""Times LEFT that a linear score may leave of the excess, for fits to be tried."""


def find_onset_fault(h: Hypothesis, rival_gain: Callable[[], float]) -> tuple[OnsetFault, Hypothesis] | None:
    """The fault that explains most, and the hypothesis fitted to the readings set right; None where there is none. One
    that leaves much beside it, for finer lumps to tell, is open, and told where there is no other. rival_gain: what the
    best of the catalogue scores about the same fit [nats]."""
    recordings = h.case.recordings
    scan, steps = OnsetScan(h.linearised, tuple(list_shapes(h)), recordings), ResidualSteps(h, recordings)
    faults = _list_faults(scan, steps)
    clear = [f for f in faults if f.is_clear]
    open_to = [f for f in faults if not f.is_clear and f.onset.since > PER_WINDOW and _may_mend(h, f.onset)]
    other = [f for f in open_to[:1] if not may_be_driven(steps, f.onset)]
    groups = (_at_first_jumps(clear), (f for f in other if _beats_unknown(h, f) and rival_gain() < f.gain))
    open_one = None
    for pair in (_confirm_best(h, group) for group in groups):
        if pair is not None and not pair[0].is_open:
            return pair
        open_one = open_one or pair
    return open_one


def _beats_unknown(h: Hypothesis, fault: OnsetFault) -> bool:
    """Whether an error of its channel over time explains more than any other, and than heat anywhere; or it alone does,
    with the few numbers that it has."""
    first, *_ = locate(h.linearised, h.machine)
    return first.at.channel == fault.channel or first.gain < fault.gain


def _list_faults(scan: OnsetScan, steps: ResidualSteps) -> list[OnsetFault]:
    """All that can have failed, the best scores first; clear jumps of which no linear score agrees with what is read
    stand last."""
    lone = [(jump[2], o) for jump in list_lone_jumps(steps) for o in scan.begun_at(*jump)]
    jumps = [
        OnsetFault(tuple(steps.recordings), o.gain, begin_with_jump(steps, o, at), is_clear=True) for at, o in lone
    ]
    seen = [_make_fault(steps, o) for o in scan.best() if o.gain > PER_WINDOW and o.shape.allows(o.size)]
    agreed = {f.jump for f in (*seen, *(_make_fault(steps, o) for _, o in lone)) if f.is_clear}
    return sorted(_list_best([*jumps, *seen]), key=lambda f: f.is_clear and f.jump not in agreed)


def _list_best(faults: Sequence[OnsetFault]) -> list[OnsetFault]:
    """Faults that can be, each once, the best scores first."""
    each = {(f.onset.shape, f.onset.run, f.onset.t0, f.onset.stays): f for f in reversed(faults)}
    return sorted((f for f in each.values() if f.onset.shape.allows(f.onset.size)), key=lambda f: -f.gain)


def _at_first_jumps(clear: Sequence[OnsetFault]) -> list[OnsetFault]:
    """Those of clear faults that share the jumps of the first of them: what a jump is, fits have to tell, for about
    numbers that are bent by it no linear score can be believed."""
    jumps = [*dict.fromkeys(f.jump for f in clear)][:CONFIRMED]
    return [f for f in clear if f.jump in jumps]


def _make_fault(steps: ResidualSteps, o: Onset) -> OnsetFault:
    """A fault as it scores; where a clear jump shows it, with the jump's own instant and size."""
    jump = watch_jump(steps, o)
    if jump.is_clear and o.shape.allows(jump.size):
        o = replace(o, t0=jump.at, size=jump.size, std=jump.std)
    return OnsetFault(tuple(steps.recordings), o.gain, o, jump.is_clear)


def _confirm_best(h: Hypothesis, faults: Iterable[OnsetFault]) -> tuple[OnsetFault, Hypothesis] | None:
    """The fault that explains most, settled, or what else its jump could be where that does not hold; None where none
    does."""
    pairs = [(f, tried) for f in faults if (tried := _try_first(h, f)) is not None]
    ranked = sorted(pairs, key=lambda pair: -pair[1].fault.gain)
    for fault, tried in (pair for pair in ranked if pair[0].jump == ranked[0][0].jump):
        whole = tried if tried.is_of(fault) else correct_onset(h, fault)
        settled = _settle(h, whole) if whole is not None and whole.fault.gain > 0 else None
        if settled is not None and settled.holds:
            return replace(settled.fault, is_open=not settled.is_alone), settled.after
    return None


def _try_first(h: Hypothesis, fault: OnsetFault) -> Corrected | None:
    """Fits that tell whether a fault explains anything: of a clear jump, where there are many runs, in its own and the
    worst of the others, for what numbers that are free to follow these alone do not mend does not hold on all. None
    where it does not. What is not clear is tried on all: its instant is still open."""
    own = fault.onset.run
    if not fault.is_clear or len(h.case.recordings) <= SEARCHED:
        whole = correct_onset(h, fault)
        return whole if whole is not None and whole.fault.gain > 0 else None
    other = next(run for run in (*list_worst_runs(h, 1), *list_worst_runs(h, FEW)) if run != own)
    runs = sorted([own, other])
    few = on_runs(h, runs)
    begun = replace(fault, recordings=few.case.recordings, onset=replace(fault.onset, run=runs.index(own)))
    tried = correct_onset(few, begun)
    return tried if tried is not None and tried.fault.gain > 0 and tried.holds else None


def _settle(h: Hypothesis, best: Corrected) -> Corrected:
    """The fault with its instant and size found again in the readings as they were, about the numbers that a fit finds
    once it is set right. Where these still leave much, a clear jump tells more than they do."""
    first = best
    if first.fault.is_clear and leaves_too_much(h, first.after):
        return first
    for _ in range(ROUNDS):
        known, after = best.fault.onset, best.after
        about = linearise(h.case.problem(h.machine, after.fit.problem.parameters), after.fit.theta)
        onset = OnsetScan(about, (known.shape,), h.case.recordings, after.chi).again(known)
        if onset is None or not onset.shape.allows(onset.size):
            break
        again = correct_onset(h, replace(best.fault, onset=onset), after)
        if again is None:
            break
        least = SETTLED * max(1.0, best.after.chi) ** 2
        is_better, is_settled = again.fault.gain > best.fault.gain, again.fault.gain < best.fault.gain + least
        best = again if is_better else best
        if is_settled:
            break
    return first if first.fault.is_clear and best.after.chi > SETTINGS.adequate else best


def _may_mend(h: Hypothesis, o: Onset) -> bool:
    """Whether by the linear score little enough is left for fits to be tried."""
    return 1 - share_shown(h, o.gain) <= NEARLY * LEFT
