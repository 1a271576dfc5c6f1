"""What a diagnosis tried on its way."""

from __future__ import annotations

from dataclasses import dataclass

from network.analysis.calibration.null import Null
from network.analysis.diagnosis.forward_selection import Screening
from network.analysis.diagnosis.hypothesis import Case, Hypothesis
from network.analysis.diagnosis.intermittent.intermittent_fault import IntermittentFault
from network.analysis.diagnosis.result import UnknownHeat


@dataclass(frozen=True, eq=False)
class Search:
    """What a diagnosis tried on its way: the machine as written and calibrated, the best, of each step what stood
    before it (befores) and all its rivals, where it differed, the gain that chance reaches, what could be missing.

    given: the recordings as they were; fault: what was wrong with a channel of them, set right in those of the case.
    """

    given: Case
    case: Case
    fault: IntermittentFault | None
    written: Hypothesis
    calibrated: Null
    null: Hypothesis
    best: Hypothesis
    befores: tuple[Hypothesis, ...]
    steps: tuple[tuple[Hypothesis, ...], ...]
    gains: tuple[float, ...]
    located: tuple[UnknownHeat, ...]
    threshold: float
    screened: Screening
