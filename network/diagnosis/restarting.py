"""Relays fitted about other starts: what switches depends on where a part began, and not along a straight line.

A part that comes with a relay, like a tank, has no sensor; where it began and where it switches may both be off by the
same few tenths of a kelvin without much of a trace, so both are tried warmer and colder together.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from network.diagnosis.case import Hypothesis, begun, relaid
from network.diagnosis.drawing import Space
from network.diagnosis.together import spread

SHIFTS = (-0.6, -0.3, 0.3, 0.6)
"""K by which starts and switching temperatures are moved together."""


def restarted(best: Hypothesis, jobs: int = 1) -> Hypothesis:
    """The hypothesis fitted about the starts that it finds, and about others, where relays switch and that helps."""
    if not any(c.switches for c in best.found):
        return best
    best = _better(best, relaid(begun(best.case, best), best.root, best.found, best.values))
    loose = {n for c in best.found if c.switches for n in Space(c).parts}
    if not loose:
        return best
    for other in spread(partial(_shifted, best, loose), SHIFTS, jobs, None):
        best = _better(best, other)
    return best


def _better(best: Hypothesis, other: Hypothesis | None) -> Hypothesis:
    return other if other is not None and other.evidence > best.evidence else best


def _shifted(best: Hypothesis, loose: set[str], shift: float) -> Hypothesis | None:
    """The hypothesis from starts and temperatures of its findings moved by a few tenths of a kelvin."""
    case = begun(best.case, best)
    degrees = {p.path for p in best.own if p.field.unit == "degC"}
    values = {path: x + shift if path in degrees else x for path, x in best.values.items()}
    moved = tuple(_moved(start, loose, shift) for start in case.began)
    return relaid(replace(case, began=moved), best.root, best.found, values, in_step=False)


def _moved(start: Mapping[str, float], loose: set[str], shift: float) -> dict[str, float]:
    return {n: T + shift if n in loose else T for n, T in start.items()}
