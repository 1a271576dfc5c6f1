"""Answered development cases as conformal sets see them: what was told of each truth, and with which belief."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from bench.conformal_before import explanations_before
from proof.findings import UNKNOWN, Concealed, Member, concealed_in
from proof.judgement import VISIBLE
from proof.judging import INNOCENT, LUMPING, MOST, SENSORS, group_of
from proof.score import SCORED, answer, is_kept_back
from proof.sealed import opened

from network.analysis.diagnosis.findings.conformal import (
    CLASSES,
    EFFECT,
    NOTHING,
    NULL,
    OUTSIDE,
    SENSOR,
    Calibration,
    Explanation,
    choose,
)
from network.analysis.diagnosis.settings import SETTINGS


class Refused(Exception):
    """A folder that sets may not be calibrated on."""


@dataclass(frozen=True)
class Told:
    """What a finding could be, and whether that is the truth."""

    explanations: tuple[Explanation, ...]
    hits: tuple[bool, ...]

    @property
    def belief(self) -> float:
        """In the truth; 0 where that is not among them."""
        return max((e.belief for e, hit in zip(self.explanations, self.hits, strict=True) if hit), default=0.0)


@dataclass(frozen=True)
class Truth:
    """One truth of a case: its class, and the finding of the answer that believes most in it."""

    case: str
    kind: str
    told: Told

    @property
    def score(self) -> float:
        return min(max(1 - self.told.belief, 0.0), 1.0)

    def names(self, by: Calibration) -> list[str]:
        """The set."""
        return choose(self.told.explanations, by)

    def is_covered(self, by: Calibration) -> bool:
        names = {*self.names(by)}
        return any(hit and e.name in names for e, hit in zip(self.told.explanations, self.told.hits, strict=True))


@dataclass
class Collected:
    """All truths of some folders, the seeds that they are of, and how many were left out for which reason."""

    truths: list[Truth] = field(default_factory=list)
    seeds: set[int] = field(default_factory=set)
    left_out: Counter[str] = field(default_factory=Counter)
    cases: set[str] = field(default_factory=set)

    def add(self, folder: Path, answers: str = "out") -> None:
        """The answered cases of a folder. Raises Refused where it is no development proof."""
        seed, names = read_proof(folder)
        self.seeds.add(seed)
        for name in names:
            told, case = answer(folder / name / answers), f"{seed}/{name}"
            if (why := self._why_not(told, case)) or told is None:
                self.left_out[why] += 1
                continue
            key = opened(folder, name)
            if group_of(key) != "innocent" and float(key["in_noise"]["after_calibration"]) < VISIBLE:
                self.left_out["too faint to be asked for"] += 1
                continue
            self.cases.add(case)
            self.truths += truths_of(case, key, told)

    def _why_not(self, told: Mapping[str, Any] | None, case: str) -> str:
        if told is None:
            return "not answered"
        if case in self.cases:
            return "there twice"
        return "" if is_of_now(told) else "answered under other settings"

    def scores(self, but: str = "") -> dict[str, list[float]]:
        """By class; but: a case that is left out."""
        return {kind: [t.score for t in self.truths if t.kind == kind and t.case != but] for kind in CLASSES}


def read_proof(folder: Path) -> tuple[int, list[str]]:
    """Seed and cases."""
    try:
        about = json.loads((folder / "cases.json").read_text(encoding="utf-8"))
        seed, names = int(about["seed"]), sorted(about["cases"])
    except (OSError, ValueError, KeyError, TypeError):
        raise Refused(f"{folder} holds no proof: there is no cases.json with a seed and cases") from None
    if is_kept_back(seed):
        raise Refused(f"{folder} is of seed {seed}: from {SCORED} on cases are for the score, not for calibration")
    return seed, names


def is_of_now(told: Mapping[str, Any]) -> bool:
    """Whether an answer was given under the present settings, as far as it has them."""
    now, then = SETTINGS.summary(), told.get("settings") or {}
    return all(now[name]["value"] == each["value"] for name, each in then.items() if name in now)


def truths_of(case: str, key: Mapping[str, Any], told: Mapping[str, Any]) -> Iterator[Truth]:
    """Of every effect that is concealed, or that nothing is."""
    sets = [*sets_told(told)]
    if not (effects := concealed_in(key)):
        yield Truth(case, NULL, looked_for(sets, is_nothing))
    for effect in effects:
        yield Truth(case, class_of(key, effect), looked_for(sets, partial(is_it, effect)))


def class_of(key: Mapping[str, Any], effect: Concealed) -> str:
    """By the group of the case; of one of two by its kind."""
    if (group := group_of(key)) in (SENSOR, OUTSIDE):
        return group
    return SENSOR if group == "two" and effect.kinds[0].startswith(SENSORS) else EFFECT


def looked_for(sets: Sequence[tuple[Explanation, ...]], fits: Callable[[str], bool]) -> Told:
    found = [Told(some, tuple(fits(e.name) for e in some)) for some in sets]
    return max(found, key=lambda told: (any(told.hits), told.belief))


def is_nothing(name: str) -> bool:
    return name == NOTHING


def is_it(effect: Concealed, name: str) -> bool:
    member = Member.read(name)
    return member.kind in effect.kinds and member.is_at(effect.places)


def sets_told(told: Mapping[str, Any]) -> Iterator[tuple[Explanation, ...]]:
    """What each finding could be, lumps aside; nothing, or what has no name, where the verdict stands alone."""
    physics = [each for each in told.get("findings") or () if each["kind"] != LUMPING][:MOST]
    yield from (explanations_of(told, each) for each in physics)
    if not physics:
        alone = (NOTHING, NULL) if told["verdict"] in INNOCENT else (UNKNOWN, OUTSIDE)
        yield (Explanation(*alone, 1.0, 1.0),)


def explanations_of(told: Mapping[str, Any], finding: Mapping[str, Any]) -> tuple[Explanation, ...]:
    if "beliefs" not in finding:
        return explanations_before(told, finding)
    return tuple(map(Explanation.read, finding["beliefs"]))
