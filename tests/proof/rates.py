"""Counts with the interval that so few cases leave."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from scipy.stats import beta


@dataclass(frozen=True)
class Rate:
    """So many of so many, with the two-sided 95 % interval of Clopper and Pearson, which holds for any count."""

    hits: int
    of: int

    @property
    def low(self) -> float:
        """Lower end; 0 where nothing was counted."""
        return float(beta.ppf(0.025, self.hits, self.of - self.hits + 1)) if self.hits else 0.0

    @property
    def high(self) -> float:
        """Upper end; 1 where nothing was counted."""
        return float(beta.ppf(0.975, self.hits + 1, self.of - self.hits)) if self.hits < self.of else 1.0

    @property
    def share(self) -> float | None:
        return self.hits / self.of if self.of else None

    def __str__(self) -> str:
        if not self.of:
            return "–"
        return f"{self.hits} of {self.of} ({percent(self.hits / self.of)}, 95 % {ends(self)})"

    def summary(self) -> dict[str, float | None]:
        return {"hits": self.hits, "of": self.of, "share": self.share, "low": self.low, "high": self.high}


def ends(rate: Rate) -> str:
    return f"{100 * rate.low:.0f}–{100 * rate.high:.0f} %"


def percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def rate(outcomes: Iterable[bool]) -> Rate:
    seen = list(outcomes)
    return Rate(sum(seen), len(seen))
