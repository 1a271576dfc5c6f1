"""A hypothesis on as many lumps as it takes with what was found in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.compact_fit import expand
from network.analysis.diagnosis.hypotheses.few_runs import on_few_runs
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import theta_of
from network.analysis.diagnosis.lumps.coarse_surrogate import fit_on_finer_lumps, fit_on_finer_lumps_afresh
from network.analysis.diagnosis.lumps.lump_refinement import LEVELS, choose_lumps
from network.analysis.diagnosis.settings import SETTINGS
from network.machine.machine import Machine


def never_late(best: Hypothesis) -> bool:
    """What takes the time that it takes."""
    return False


def refine_until_converged(
    case: Case, best: Hypothesis, jobs: int = 1, is_late: Callable[[Hypothesis], bool] = never_late
) -> Hypothesis:  # fmt: skip
    """The hypothesis on the lumps that it takes at its numbers; relays are led back into step there. What numbers of
    the file are bent for is not converged, however little is left: then lumps are doubled, until they are not. is_late:
    asked whether there is no time for finer ones."""
    for _ in range(LEVELS):
        best = expand(best)
        if is_late(best) or (root := _choose_next(best, jobs)) is None:
            break
        begun = _begin_on_few(best, root)
        other = begun and fit_on_finer_lumps_afresh(case, begun, root, best.evidence)
        if other is None or other.evidence < best.evidence + _least_gain(best, other):
            break
        best = other
    return best


def refine_once(h: Hypothesis, least: float, jobs: int = 1) -> Hypothesis:
    """A hypothesis on the lumps that it takes at its numbers, however little is left, where they explain more by some
    evidence [nats]; else itself."""
    root = choose_lumps(h, jobs)
    finer = None if root is None else fit_on_finer_lumps(h.case, h, root)
    return h if finer is None or finer.evidence <= h.evidence + least else finer


def _choose_next(best: Hypothesis, jobs: int) -> Machine | None:
    """The machine with the lumps that it takes; None where it has them, or nothing is left to tell which."""
    if best.chi >= SETTINGS.noise:
        return choose_lumps(best, jobs)
    return choose_lumps(best, jobs, rounds=1, growth=2) if best.is_bent else None


def _begin_on_few(best: Hypothesis, root: Machine) -> Hypothesis | None:
    """The hypothesis at the numbers that finer lumps take on the runs that it tells worst; None where they explain less
    of these."""
    few = on_few_runs(best)
    if few is best or best.fit.problem.model.switches:
        return best
    begun = fit_on_finer_lumps(few.case, few, root, needed=few.evidence)
    if begun is None or begun.evidence < few.evidence:
        return None
    return replace(
        best, fit=replace(best.linearised.estimate, theta=theta_of(best.fit.problem.parameters, begun.values))
    )


def _least_gain(best: Hypothesis, other: Hypothesis) -> float:
    """Evidence [nats] that finer lumps must add: none where numbers of the file come back to it by them."""
    return 0.0 if best.is_bent and not other.is_bent else SETTINGS.structure
