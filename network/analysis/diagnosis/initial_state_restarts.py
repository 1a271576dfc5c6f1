"""Relays fitted about other starts: what switches depends on where a part began, and not along a straight line.

A part that comes with a relay, like a tank, has no sensor; where it began and where it switches may both be off by the
same few tenths of a kelvin without much of a trace, so both are tried warmer and colder together.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from network.analysis.calibration.measured_means import RunPoint
from network.analysis.diagnosis.compact_fit import compact
from network.analysis.diagnosis.hypothesis import (
    Case,
    Hypothesis,
    fit_by_continuation,
    fit_findings,
    fit_hypothesis,
    start_from,
)
from network.analysis.diagnosis.ranking import best_first
from network.analysis.diagnosis.switching.prior_samples import Space
from network.platform.parallel import run_all
from network.platform.refusal import Failed

SHIFTS = (-0.6, -0.3, 0.3, 0.6)
"""K by which starts and switching temperatures are moved together."""
TRIED, REST = (0.25, 0.4, 0.6), (0.8,)
"""Shares of the runs over which other starts are tried, and over which the best of them is led on."""


def restart_from_starts(best: Hypothesis, jobs: int = 1) -> Hypothesis:
    """The hypothesis fitted about the starts that it finds, and about others, where relays switch and that helps."""
    if not best.fit.problem.model.switches:
        return best
    best = _better(best, fit_findings(start_from(best.case, best), best.root, best.found, best.values))
    loose = {n for c in best.found if c.switches for n in Space(c).parts}
    if not loose:
        return best
    tried = run_all(partial(_shift_start, best, loose), (0.0, *SHIFTS), jobs)
    ranked = best_first(*(h for h in tried if h is not None))
    is_other = ranked and tried[0] is not ranked[0]
    return _better(best, _to_the_end(best.case, ranked[0])) if is_other else best


def _better(best: Hypothesis, other: Hypothesis | None) -> Hypothesis:
    return other if other is not None and other.evidence > best.evidence else best


def _shift_start(best: Hypothesis, loose: set[str], shift: float) -> Hypothesis | None:
    """The hypothesis from starts and temperatures of its findings moved by a few tenths of a kelvin, over some of the
    runs."""
    case = start_from(best.case, best)
    degrees = {p.path for p in best.own if p.field.unit == "degC"}
    values = {path: x + shift if path in degrees else x for path, x in best.values.items()}
    moved = replace(case, began=tuple(_move_start(point, loose, shift) for point in case.began))
    try:
        return compact(fit_by_continuation(moved, best.machine, best.found, best.own, values, TRIED))
    except (Failed, np.linalg.LinAlgError):
        return None


def _to_the_end(case: Case, h: Hypothesis) -> Hypothesis | None:
    """A hypothesis over some of the runs, led over the rest of them."""
    about = replace(case, began=h.case.began)
    try:
        further = fit_by_continuation(about, h.machine, h.found, h.own, h.values, REST)
        return fit_hypothesis(about, h.machine, h.found, h.own, further.values)
    except (Failed, np.linalg.LinAlgError):
        return None


def _move_start(point: RunPoint, loose: set[str], shift: float) -> RunPoint:
    return replace(point, start={n: T + shift if n in loose else T for n, T in point.start.items()})
