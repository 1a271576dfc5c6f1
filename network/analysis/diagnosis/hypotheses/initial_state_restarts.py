"""Relays fitted about other starts: what switches depends on where a part began, and not along a straight line.

A part that comes with a relay, like a tank, has no sensor; where it began and where it switches may both be off by the
same few tenths of a kelvin without much of a trace, so both are tried warmer and colder together.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from network.analysis.calibration.measured_means import RunPoint
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.compact_fit import compact
from network.analysis.diagnosis.hypotheses.few_runs import on_few_runs
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import (
    fit_by_continuation,
    fit_findings,
    lead_into_step,
    start_from,
)
from network.analysis.diagnosis.switching.prior_samples import Space
from network.platform.parallel import run_all
from network.platform.refusal import Failed

SHIFTS = (-0.6, -0.3, 0.3, 0.6)
"""K by which starts and switching temperatures are moved together."""
TRIED, REST = (0.25, 0.4, 0.6), (0.8,)
"""Shares of the runs over which other starts are tried, and over which the best of them is led on."""


def restart_from_starts(best: Hypothesis, jobs: int = 1) -> Hypothesis:
    """The hypothesis fitted about the starts that it finds, and about others, where relays switch and that helps; these
    are tried on the runs that are told worst."""
    if not best.fit.problem.model.switches:
        return best
    best = _better(best, fit_findings(start_from(best.case, best), best.root, best.found, best.values))
    loose = {n for c in best.found if c.switches for n in Space(c).parts}
    if not loose:
        return best
    shifts = (0.0, *SHIFTS)
    tried = run_all(partial(_shift_start, on_few_runs(best), loose), shifts, jobs)
    evidence = [-np.inf if h is None else h.evidence for h in tried]
    first = int(np.argmax(evidence))
    chosen = tried[first]
    if not first or chosen is None:
        return best
    about = _move_starts(best, loose, shifts[first])
    return _better(best, lead_into_step(about, chosen, chosen.values, REST))


def _better(best: Hypothesis, other: Hypothesis | None) -> Hypothesis:
    return other if other is not None and other.evidence > best.evidence else best


def _shift_start(best: Hypothesis, loose: set[str], shift: float) -> Hypothesis | None:
    """The hypothesis from starts and temperatures of its findings moved by a few tenths of a kelvin, over some of the
    runs."""
    degrees = {p.path for p in best.own if p.field.unit == "degC"}
    values = {path: x + shift if path in degrees else x for path, x in best.values.items()}
    try:
        moved = _move_starts(best, loose, shift)
        return compact(fit_by_continuation(moved, best.machine, best.found, best.own, values, TRIED))
    except (Failed, np.linalg.LinAlgError):
        return None


def _move_starts(best: Hypothesis, loose: set[str], shift: float) -> Case:
    """The case about the starts that a hypothesis finds, those of some parts moved."""
    case = start_from(best.case, best)
    return replace(case, began=tuple(_move_start(point, loose, shift) for point in case.began))


def _move_start(point: RunPoint, loose: set[str], shift: float) -> RunPoint:
    return replace(point, start={n: T + shift if n in loose else T for n, T in point.start.items()})
