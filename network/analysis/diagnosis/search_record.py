"""What a diagnosis tried on its way."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from network.analysis.calibration.null import Null
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.latent_heat.latent_rest import Rest
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.latent_heat.mismatch import Mismatch, locate_beside, locate_mismatch
from network.analysis.diagnosis.reading_fault import ReadingFault
from network.analysis.diagnosis.screening.screening import Screening
from network.analysis.diagnosis.steps.backward_elimination import share_explained
from network.analysis.diagnosis.steps.selection import Selection

HURRIED = 0.9
"""Share of the time after which what is told is worked out briefly (budget)."""


@dataclass(frozen=True, eq=False)
class Search:
    """What a diagnosis tried on its way: the machine as written and calibrated, the null on its best lumps or, where
    runs on these are slow, on those of the file, the steps from there, and what could be missing.

    given: the recordings as they were; fault: what was wrong with a channel of them, set right in those of the case;
    ended: `budget`, `stopped` or, where runs broke down, `broken` where it did not come to its end; faced: what it came
    to at the numbers that keep its relays in step by themselves, where it stood on modes that were read; unrecorded:
    surroundings of any course beside the null, where nothing that was found explains as much.
    """

    given: Case
    case: Case
    fault: ReadingFault | None
    written: Hypothesis
    calibrated: Null
    null: Hypothesis
    selection: Selection
    screened: Screening
    ended: str = ""
    faced: Hypothesis | None = None
    unrecorded: Rest | None = None

    @property
    def best(self) -> Hypothesis:
        return self.selection.best

    def allot(self) -> Search:
        """The same with time of its own for what comes before all that is tried."""
        case, written = (replace(of, budget=self.case.budget.allot()) for of in (self.case, self.written.case))
        return replace(self, case=case, written=replace(self.written, case=written))

    @property
    def told(self) -> Hypothesis:
        """What it came to, at the numbers that are written."""
        return self.faced or self.best

    @property
    def befores(self) -> tuple[Hypothesis, ...]:
        """What stood before each step."""
        return self.selection.befores

    @property
    def steps(self) -> tuple[tuple[Hypothesis, ...], ...]:
        """Of each step all that was fitted, what was kept first."""
        return self.selection.steps

    @property
    def gains(self) -> tuple[float, ...]:
        return self.selection.gains

    @property
    def threshold(self) -> float:
        return self.selection.threshold

    @property
    def share_that_holds(self) -> float:
        """Of the misfit of runs that it has not seen what was found explains so much; where that was not tested, no
        more than of those that were fitted."""
        chosen = self.selection
        if chosen.is_checked:
            return chosen.explained
        return share_explained(self.null.chi, self.best.chi) if self.best.found else 1.0

    def is_hurried(self) -> bool:
        """Whether hardly any time is left for what is told."""
        return self.given.budget.is_past(HURRIED)

    @cached_property
    def mismatch(self) -> Mismatch:
        """Of the null."""
        if self.unrecorded is not None:
            return locate_beside(self.null, self.unrecorded)
        return locate_mismatch(self.null, self.is_hurried)

    @property
    def located(self) -> tuple[UnknownHeat, ...]:
        """Where unknown heat would explain most before anything was added."""
        return self.mismatch.places
