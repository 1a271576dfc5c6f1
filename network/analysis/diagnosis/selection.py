"""What the steps of a search have chosen."""

from __future__ import annotations

from dataclasses import dataclass

from network.analysis.diagnosis.crossed_splits import UnseenTest
from network.analysis.diagnosis.hypothesis import Hypothesis
from network.analysis.diagnosis.settings import SETTINGS


@dataclass(frozen=True, eq=False)
class Selection:
    """Where the steps from one null led: the best, what stood before each step and its rivals, the evidence that each
    finding adds, and what chance reaches; is_checked: whether all findings were tested again beside each other and on
    runs that they were not fitted to, and what share of the misfit there they explain; added, share_of_rest: what they
    add to heat of any course beside them [nats], and by what share its variance falls; unseen: of each step, whether
    what half of the recordings picks out shows in the other half."""

    best: Hypothesis
    befores: tuple[Hypothesis, ...] = ()
    steps: tuple[tuple[Hypothesis, ...], ...] = ()
    gains: tuple[float, ...] = ()
    threshold: float = SETTINGS.least
    is_checked: bool = False
    explained: float = 0.0
    added: float = float("inf")
    share_of_rest: float = 1.0
    unseen: tuple[UnseenTest | None, ...] = ()
