"""When what is tried is given up: a fit that will not come to some evidence by what its last steps gained, one that
leaves too much, or what shows too little."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

from network.analysis.calibration.linearised import Linearised
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.settings import SETTINGS

BEFORE = 3
"""Steps that tell how fast a fit gains."""
HOPE = 2.0
"""How many times as fast as by the better of the last steps it may come to go on."""


@dataclass
class FallsShort:
    """Asked after every step of a fit. needed: evidence [nats]; steps: that the fit may take; told: evidence so far."""

    needed: float
    steps: int
    told: list[float] = field(default_factory=list)

    def __call__(self, at: Linearised) -> bool:
        self.told.append(at.temper(1.0, at.problem.firm_eta).log_evidence)
        last = self.told[-BEFORE:]
        gain = max((b - a for a, b in pairwise(last)), default=0.0)
        left = HOPE * (self.steps - len(self.told)) * max(gain, 0.0)
        return len(last) == BEFORE and self.told[-1] + left < self.needed


def leaves_too_much(before: Hypothesis, after: Hypothesis) -> bool:
    """Whether so much is left beside what is tried that it will not come to hardly anything."""
    return after.chi > max(SETTINGS.hopeless, SETTINGS.half * before.chi)


def explains_half(before: Hypothesis, after: Hypothesis) -> bool:
    """Whether half of the excess χ² − 1 before is gone."""
    return after.chi**2 - 1 < SETTINGS.half * (before.chi**2 - 1)


def explains_most(before: Hypothesis, after: Hypothesis) -> bool:
    """Whether all but a quarter of the excess χ² − 1 before is gone."""
    return leaves_little_of(before, after.chi**2)


def leaves_little_of(before: Hypothesis, left: float) -> bool:
    """The same of a misfit χ² that is left."""
    return left - 1 < SETTINGS.half**2 * (before.chi**2 - 1)


def share_shown(h: Hypothesis, gain: float) -> float:
    """What of the excess χ² − 1 about a fit would go by a linear score [nats, in squares of the misfit]."""
    misfit = max(1.0, h.chi**2)
    return 2 * gain * misfit / len(h.fit.left) / max(misfit - 1, 1e-9)
