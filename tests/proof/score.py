"""The scorer: opens the keys and counts what was named, placed, accused and mended.

`python -m proof.score FOLDER` from the folder tests/; a diagnosis lies in FOLDER/case-…/out/diagnosis.json.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import sqrt
from pathlib import Path
from statistics import median
from typing import Any

from proof.judging import Judgement, judge
from proof.sealed import opened

ANSWER = Path("out") / "diagnosis.json"


@dataclass(frozen=True)
class Rate:
    """So many of so many, with Wilson's 95 % interval."""

    hits: int
    of: int

    def bound(self, sign: int, z: float = 1.959964) -> float:
        """The upper (+1) or lower (−1) end of the interval; 0 or 1 where nothing was counted."""
        if not self.of:
            return float(sign > 0)
        p, n = self.hits / self.of, self.of
        end = (p + z * z / (2 * n) + sign * z * sqrt(p * (1 - p) / n + z * z / (4 * n * n))) / (1 + z * z / n)
        return min(max(end, 0.0), 1.0)

    def __str__(self) -> str:
        share = f"{100 * self.hits / self.of:.0f} %" if self.of else "–"
        return f"{self.hits} of {self.of} ({share}, 95 % {100 * self.bound(-1):.0f}–{100 * self.bound(1):.0f} %)"


@dataclass(frozen=True)
class Score:
    """All judgements of a proof and what they add up to."""

    judgements: tuple[Judgement, ...]

    @cached_property
    def effects(self) -> list[Judgement]:
        """Cases that conceal effects of the catalogue."""
        return [each for each in self.judgements if not each.innocent and not each.outside]

    @cached_property
    def nulls(self) -> list[Judgement]:
        return [each for each in self.judgements if each.innocent]

    @cached_property
    def outsiders(self) -> list[Judgement]:
        return [each for each in self.judgements if each.outside]

    @property
    def rates(self) -> dict[str, Rate]:
        """Counts by what they mean; false alarms are counted among the innocents that were answered."""
        answered = [each for each in self.nulls if each.answered]
        confident = [each for each in self.judgements if (each.confidence or 0) > 0.9]
        fitted = [each for each in self.judgements if each.after is not None]
        return {
            "right name": rate(each.named for each in self.effects),
            "right place": rate(each.placed for each in self.effects),
            "right name at the right place": rate(each.both for each in self.effects),
            "first name right": rate(each.first for each in self.effects),
            "something else named besides": rate(each.spurious > 0 for each in self.effects),
            "innocents accused": rate(each.accused for each in answered),
            "outside called unknown": rate(each.named for each in self.outsiders),
            "outside placed right": rate(each.placed for each in self.outsiders),
            "confident (> 0.9) and wrong": rate(each.sure_and_wrong for each in confident),
            "held out worse than before": rate(each.worse for each in fitted),
            "no answer": rate(not each.answered for each in self.judgements),
        }

    @property
    def removed(self) -> float | None:
        """Median share of the held-out excess that went away, over effects of the catalogue."""
        shares = [each.removed for each in self.effects if each.removed is not None]
        return median(shares) if shares else None

    @property
    def seconds(self) -> float | None:
        """Median time of a diagnosis [s]."""
        times = [each.seconds for each in self.judgements if each.seconds is not None]
        return median(times) if times else None

    @property
    def calibration_error(self) -> float | None:
        """Expected calibration error of the first finding's confidence, in five bins, over effects of the catalogue."""
        sure = [(each.confidence, each.first) for each in self.effects if each.confidence is not None]
        bins = [[pair for pair in sure if min(int(5 * pair[0]), 4) == i] for i in range(5)]
        gaps = (abs(sum(c for c, _ in some) - sum(right for _, right in some)) for some in bins)
        return sum(gaps) / len(sure) if sure else None

    @property
    def confusion(self) -> Counter[tuple[str, str]]:
        """How often what was concealed (or the class of an innocent) was answered by what."""
        return Counter((each.expected or each.what, each.answer) for each in self.judgements)

    def __str__(self) -> str:
        from proof.telling import tell

        return tell(self)


def rate(outcomes: Iterable[bool]) -> Rate:
    seen = list(outcomes)
    return Rate(sum(seen), len(seen))


def score(folder: Path | str, seconds: Mapping[str, float] | None = None, cases: Sequence[str] | None = None) -> Score:
    """Opens the keys of a folder of cases (or of some of them) and judges what lies in each out/.

    `seconds` are wall times measured outside; a case with no readable diagnosis.json counts as missed.
    Raises Broken where a key is not the one that was sealed.
    """
    folder = Path(folder)
    names = cases or sorted(json.loads((folder / "cases.json").read_text(encoding="utf-8"))["cases"])
    times = seconds or {}
    return Score(tuple(judge(name, opened(folder, name), answer(folder / name), times.get(name)) for name in names))


def answer(case: Path) -> dict[str, Any] | None:
    """The diagnosis of a case, if there is one that can be read."""
    try:
        told: dict[str, Any] = json.loads((case / ANSWER).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return told if isinstance(told, dict) and "verdict" in told else None


if __name__ == "__main__":
    print(score(sys.argv[1]))
