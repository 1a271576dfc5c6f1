"""The scorer: opens the keys and counts what was named, placed, accused and mended.

`python -m proof.score FOLDER [ANSWERS]` from the folder tests/; a diagnosis lies in FOLDER/case-…/out/diagnosis.json,
or in another folder of each case where that is given.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from statistics import median
from typing import Any

from proof.counting import rates_of, shares_of
from proof.judgement import Judgement
from proof.judging import CLASSES, judge
from proof.rates import Rate
from proof.sealed import opened

OUT, ON_TWO = "out", "-two-cores"
"""Folder of a case with its answer, and what the one given by two processes is called besides."""
SCORED = 1000
"""Seeds below are for development: what was looked at while the search was made proves nothing."""
READ = frozenset(
    {
        1001,
        1007,
        1011,
        1013,
        1021,
        1031,
        1033,
        1035,
        1037,
        1039,
        1041,
        1043,
        1047,
        1049,
        1051,
        1053,
        1055,
        1057,
        1059,
        1061,
        1063,
        1065,
        1067,
        1069,
        1071,
        1073,
        1075,
    }
)
"""Of the others those that were scored, and their misses read since: now they are for development, too."""
BINS = 5


def is_kept_back(seed: int) -> bool:
    """Whether a seed is for the score."""
    return seed >= SCORED and seed not in READ


@dataclass(frozen=True)
class Score:
    """All judgements of a proof and what they add up to. answers: the folder of each case that was judged."""

    judgements: tuple[Judgement, ...]
    seed: int | None = None
    development: bool | None = None
    answers: str = OUT

    def of(self, *groups: str) -> list[Judgement]:
        return [each for each in self.judgements if each.group in groups]

    @cached_property
    def effects(self) -> list[Judgement]:
        """Cases that conceal effects of the catalogue large enough to be asked for by name."""
        return [each for each in self.of("effect", "sensor", "two") if each.seen]

    @cached_property
    def rates(self) -> dict[str, Rate]:
        """Counts by what they mean."""
        return rates_of(self.judgements)

    @property
    def shares(self) -> dict[str, dict[str, Rate]]:
        """Of each scored class: its rates."""
        return {group: shares_of(group, some) for group in CLASSES if (some := self.of(group))}

    @property
    def figures(self) -> dict[str, float | None]:
        """What is no count: medians [shares, members, s] and the error of the confidence."""
        sizes = [float(size) for each in self.effects for size in each.sizes]
        return {
            "held-out excess removed, median": middle([each.removed for each in self.effects]),
            "members of a set, median": middle(sizes),
            "calibration error": self.calibration_error,
            "seconds on one core, median": middle([each.seconds for each in self.judgements]),
            "seconds on one core, worst": max(
                (each.seconds for each in self.judgements if each.seconds is not None), default=None
            ),
            "seconds on two cores, median": middle([each.seconds_two for each in self.judgements]),
            "seconds on one core of the same, median": middle(
                [each.seconds for each in self.judgements if each.seconds_two is not None]
            ),
        }

    @property
    def calibration_error(self) -> float | None:
        """Expected calibration error of the first finding's confidence, in five bins, over all cases with a finding."""
        sure = [(each.confidence, each.right) for each in self.judgements if each.confidence is not None]
        bins = [[pair for pair in sure if min(int(BINS * pair[0]), BINS - 1) == i] for i in range(BINS)]
        gaps = (abs(sum(c for c, _ in some) - sum(right for _, right in some)) for some in bins)
        return sum(gaps) / len(sure) if sure else None

    @property
    def confusion(self) -> Counter[tuple[str, str]]:
        """How often what was concealed (or the sort of an innocent) was answered by what."""
        return Counter((each.expected or each.what, each.answer) for each in self.judgements)

    def summary(self) -> dict[str, Any]:
        """All of it as JSON takes it."""
        cases = [{**asdict(each), "right": each.right, "removed": each.removed} for each in self.judgements]
        shares = {group: {n: r.summary() for n, r in some.items()} for group, some in self.shares.items()}
        return {
            "seed": self.seed, "development": self.development, "answers": self.answers,
            "rates": {name: rate.summary() for name, rate in self.rates.items()}, "classes": shares,
            "figures": self.figures, "cases": cases,
        }  # fmt: skip

    def __str__(self) -> str:
        from proof.telling import tell

        return tell(self)


def middle(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return median(known) if known else None


def score(folder: Path | str, cases: Sequence[str] | None = None, answers: str = OUT) -> Score:
    """Opens the keys of a folder of cases (or of some of them) and judges what lies in each out/.

    A case with no readable diagnosis.json counts as missed. Raises Broken where a key is not the one that was sealed.
    """
    folder = Path(folder)
    about = json.loads((folder / "cases.json").read_text(encoding="utf-8"))
    names = cases or sorted(about["cases"])
    told, seed = tuple(judged_case(folder, name, answers) for name in names), about.get("seed")
    return Score(told, seed, about.get("development", None if seed is None else not is_kept_back(seed)), answers)


def judged_case(folder: Path, name: str, answers: str) -> Judgement:
    where = folder / name / answers
    told, run = answer(where), measured(where)
    if told is not None:
        run |= on_two(folder / name / f"{answers}{ON_TWO}", told)
    return judge(name, opened(folder, name), told, run)


def answer(where: Path) -> dict[str, Any] | None:
    """The diagnosis in a folder, if there is one that can be read."""
    told = read(where / "diagnosis.json")
    return told if "verdict" in told else None


def measured(where: Path) -> dict[str, Any]:
    """Seconds and how it ended, and the held-out misfit of the machine that was written, as far as they are known."""
    run, held = read(where / "run.json"), read(where / "held_out.json")
    known = {name: run[name] for name in ("seconds", "how") if name in run}
    return known | {"simulated": held.get("rmse_in_noise"), "does_not_run": run.get("file_runs") is False}


def on_two(where: Path, told: dict[str, Any]) -> dict[str, Any]:
    """Seconds on two cores, and whether the same was found there."""
    run, other = read(where / "run.json"), answer(where)
    if not run:
        return {}
    return {"seconds_two": run["seconds"], "same_on_two": other is not None and named(other) == named(told)}


def named(told: dict[str, Any]) -> list[Any]:
    return [told["verdict"], *((each["kind"], each.get("places")) for each in told.get("findings") or ())]


def read(path: Path) -> dict[str, Any]:
    """A mapping from a JSON file; empty where there is none."""
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return told if isinstance(told, dict) else {}


if __name__ == "__main__":
    print(score(sys.argv[1], None, *sys.argv[2:3]))
