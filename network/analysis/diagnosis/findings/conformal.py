"""Which explanations are told together: split conformal sets by class of truth, calibrated on development cases.

The score of a case is 1 − b, b the belief in its truth (0 where that is not among what was told); q of a class is the
⌈(n + 1)(1 − α)⌉-th smallest of its n scores. Told is every explanation with b ≥ 1 − q of its class: of further cases
like them, 1 − α have their truth in the set, unless q is 1, where all that was told may still lack it. Needs
n ≥ 1/α − 1; real recordings are not exchangeable with the bench. Source: Vovk, Gammerman & Shafer, Algorithmic Learning
in a Random World (2005), section 4.5 (by classes).
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from typing import Any

from network.analysis.diagnosis.settings import SETTINGS, Settings

NULL, EFFECT, SENSOR, OUTSIDE = CLASSES = ("null", "effect", "sensor", "outside")
"""Of truths: nothing or lumps alone, an effect of the catalogue, readings that are not true, what has no name."""
NOTHING = "nothing"
"""The explanation that nothing is missing."""
FILE = "conformal.json"
TINY = 1e-9


@dataclass(frozen=True)
class Explanation:
    """What a finding could be. belief: its share, not capped by doubts; confidence: the one it is told with, None where
    it has none; is_tied: it cannot be told from the first one."""

    name: str
    truth: str
    belief: float
    confidence: float | None = None
    is_tied: bool = False

    @classmethod
    def read(cls, told: Mapping[str, Any]) -> Explanation:
        return cls(told["name"], told["class"], told["belief"], told["confidence"], told["tied"])

    def summary(self) -> dict[str, Any]:
        return {"name": self.name, "class": self.truth, "belief": self.belief, "confidence": self.confidence,
                "tied": self.is_tied}  # fmt: skip


def quantile(scores: Sequence[float], alpha: float) -> float:
    """The ⌈(n + 1)(1 − α)⌉-th smallest of n scores in 0 to 1; 1 where there are too few."""
    rank = math.ceil((len(scores) + 1) * (1 - alpha) - TINY)
    return float(sorted(scores)[rank - 1]) if rank <= len(scores) else 1.0


def fingerprint(settings: Settings) -> str:
    """Of the values of all settings: what was calibrated under others does not hold."""
    values = {name: float(each["value"]) for name, each in settings.summary().items()}
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:12]


@dataclass(frozen=True)
class Calibration:
    """Cases and quantile of each class; settings: their fingerprint; seeds: of the cases."""

    counts: Mapping[str, int] = field(default_factory=dict)
    quantiles: Mapping[str, float] = field(default_factory=dict)
    settings: str = ""
    seeds: tuple[int, ...] = ()

    @classmethod
    def of(cls, scores: Mapping[str, Sequence[float]], seeds: Sequence[int] = ()) -> Calibration:
        """From the scores of cases by their class."""
        quantiles = {name: quantile(some, 1 - SETTINGS.covered) for name, some in scores.items()}
        return cls({n: len(s) for n, s in scores.items()}, quantiles, fingerprint(SETTINGS), tuple(sorted({*seeds})))

    @classmethod
    def read(cls, told: Mapping[str, Any]) -> Calibration:
        each = told["classes"]
        counts, quantiles = ({name: one[key] for name, one in each.items()} for key in ("n", "q"))
        return cls(counts, quantiles, told["settings"], tuple(told["seeds"]))

    def count(self, truth: str) -> int:
        """Cases of a class."""
        return self.counts.get(truth, 0)

    def least(self, truth: str) -> float | None:
        """The belief from which an explanation is told; None where a class has too few cases."""
        is_enough = self.count(truth) >= math.ceil(1 / (1 - SETTINGS.covered) - TINY) - 1
        return 1 - self.quantiles[truth] if is_enough else None

    def summary(self) -> dict[str, Any]:
        """As it is shipped."""
        each = {name: {"n": self.count(name), "q": self.quantiles.get(name, 1.0)} for name in CLASSES}
        return {"alpha": round(1 - SETTINGS.covered, 9), "settings": self.settings, "seeds": list(self.seeds),
                "classes": each}  # fmt: skip


@cache
def shipped() -> Calibration:
    """What is shipped; of no cases where it was made under other settings."""
    told = json.loads((files("network.analysis.diagnosis.findings") / FILE).read_text(encoding="utf-8"))
    found = Calibration.read(told)
    return found if found.settings == fingerprint(SETTINGS) else Calibration()


def choose(explanations: Sequence[Explanation], by: Calibration) -> list[str]:
    """The names that are told, in their order: the first, what cannot be told from it, and of a class with enough cases
    all from its least belief on, of another one while less than SETTINGS.covered of the belief lies before. How sure it
    is to be whole takes nothing from that: a doubt speaks for none of the others."""
    told: list[str] = []
    total = 0.0
    for e in explanations:
        least = by.least(e.truth)
        is_in = e.confidence is not None and total < SETTINGS.covered if least is None else e.belief >= least - TINY
        if not told or e.is_tied or is_in:
            told.append(e.name)
        total += e.belief
    return told
