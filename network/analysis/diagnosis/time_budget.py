"""The time that a diagnosis may take: what is asked for first gets a share of it, so that there is always an answer."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace

from network.analysis.diagnosis.settings import SETTINGS

BEGINNINGS = 1 / 3
"""Share of the time of the null within which it is looked for from other beginnings: where something is missing it lies
at bounds and leaves much from wherever it is begun."""

PREPARED = 1 / 4
"""Share of what is left of the search when lumps are first looked at within which they are refined, where much is left,
before anything is tried on them: what is found is put on the lumps that it takes all the same, and what is not tried is
not found (budget)."""

RESERVED = 1 / 3
"""Share of the time that is kept for the end, at most."""

GROWTH = 0.56
"""Power of the lumps with which the time of a simulation grows (budget)."""


class BudgetReached(Exception):
    """The time for the search is over; what was found until then stands."""


@dataclass(frozen=True)
class TimeBudget:
    """seconds: of the whole; reserved: of these for what comes after the search; prepared: after which lumps are left
    as they are; began: instant on the machine's clock [s], the same in all its processes."""

    seconds: float = float("inf")
    reserved: float = 0.0
    prepared: float = float("inf")
    began: float = field(default_factory=time.monotonic)

    @property
    def spent(self) -> float:
        return time.monotonic() - self.began

    def is_past(self, share: float) -> bool:
        return self.spent > share * self.seconds

    def set_aside(self, took: float) -> TimeBudget:
        """The same without some time [s] that was taken, and with as much reserved, as far as RESERVED allows."""
        left = max(self.seconds - took, 0.0)
        return replace(self, seconds=left, reserved=min(took, RESERVED * left), began=self.began + took)

    def allot(self) -> TimeBudget:
        """The same with a share of what is left of the search for what comes before all that is tried."""
        began = self.spent
        return replace(self, prepared=began + PREPARED * max(self._searched - began, 0.0))

    def is_ended(self, larger: float) -> bool:
        """Whether what is left is needed for what comes after the search, of a machine of so many times the lumps that
        it was reserved for: 12 times as many take 4 times as long (measured)."""
        needed: float = self.reserved * max(larger, 1.0) ** GROWTH
        return self.spent > self.seconds - needed

    def is_searched(self) -> bool:
        """Whether the search has had its share."""
        return self.spent > self._searched

    @property
    def _searched(self) -> float:
        """Seconds after which nothing more is looked for."""
        return min(SETTINGS.searched * self.seconds, self.seconds - self.reserved)

    def is_prepared(self) -> bool:
        """Whether what comes before all that is tried has had its share."""
        return self.spent > self.prepared

    def is_calibrated(self) -> bool:
        """Whether the null has had its share."""
        return self.is_past(SETTINGS.calibrated)

    def is_begun(self) -> bool:
        """Whether other beginnings of the null have had their share."""
        return self.is_past(BEGINNINGS * SETTINGS.calibrated)

    def check(self, _: float = 0.0) -> None:
        """Raises BudgetReached where the search has had its share; takes the share done of some work, as `tell`."""
        if self.is_searched():
            raise BudgetReached
