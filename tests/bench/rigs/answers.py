"""What a diagnosis should say of a concealed effect, and how far it does: right, part or missed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

Found = Mapping[str, Any]
"""A finding of diagnosis.json, or one of its alternatives."""
GRADES = ("right", "part", "missed", "no answer")
SURE = 0.1
"""Least confidence with which the right thing counts as said; with less it is a part."""
WITHIN = 300.0
"""s by which a window may be off at either end."""


@dataclass(frozen=True)
class Answer:
    """kinds that are right at places (one of them, or all: `every`) and channels (all); alike: kinds that stand for a
    part of the truth there; drivers: inputs one of which it has to follow; window [s]: when it is to be; follows: least
    correlation of the heat found with the heat hidden."""

    words: str
    kinds: frozenset[str]
    places: frozenset[str] = frozenset()
    every: bool = False
    channels: frozenset[str] = frozenset()
    alike: frozenset[str] = frozenset()
    drivers: frozenset[str] = frozenset()
    window: tuple[float, float] | None = None
    follows: float | None = None

    def is_there(self, found: Found) -> bool:
        """Whether it sits where it should."""
        places, channels = {*found.get("places", ())}, {*found.get("channels", ())}
        placed = self.places <= places if self.every else bool(self.places & places)
        return (placed or not self.places) and self.channels <= channels

    def is_driven(self, found: Found) -> bool:
        return not self.drivers or bool(self.drivers & {*drivers_of(found.get("patch") or {})})

    def is_timed(self, found: Found) -> bool:
        if self.window is None:
            return True
        begin, end = self.window
        return any(abs(a - begin) <= WITHIN and abs(b - end) <= WITHIN for a, b in windows_of(found))

    def is_named(self, found: Found) -> bool:
        """Kind and place alone, as rivals have them."""
        return (found["kind"] in self.kinds or not self.kinds) and self.is_there(found)

    def is_right(self, found: Found, correlation: float | None) -> bool:
        is_followed = self.follows is None or (correlation is not None and correlation >= self.follows)
        is_said = (found.get("confidence") or 0.0) >= SURE
        return is_said and self.is_named(found) and self.is_driven(found) and self.is_timed(found) and is_followed

    def is_part(self, found: Found) -> bool:
        """The right thing unsure or not in its course, an alike or unnamed one there, or it among the rivals."""
        if self.window is not None:
            return any(overlap(w, self.window) > 0.5 for w in windows_of(found))
        rivals = (*found.get("alternatives", ()), *found.get("indistinguishable", ()))
        alike = found["kind"] in {*self.alike, "unknown"} and self.is_there(found) and bool(self.places | self.channels)
        return self.is_named(found) or alike or any(self.is_named(rival) for rival in rivals)


@dataclass(frozen=True)
class Score:
    """grade: one of GRADES; by: what it hangs on, with its confidence."""

    grade: str
    by: str = ""


def score(diagnosis: Mapping[str, Any] | None, answer: Answer, correlation: float | None = None) -> Score:
    """How far a diagnosis names what was concealed. correlation: of the heat found with the heat hidden."""
    if diagnosis is None:
        return Score("no answer")
    findings = diagnosis["findings"]
    for grade, holds in (("right", lambda f: answer.is_right(f, correlation)), ("part", answer.is_part)):
        for found in findings:
            if holds(found):
                return Score(grade, called(found))
    return Score("missed")


def named(found: Found) -> str:
    """`convection heater 1 – room (0.93), conductance 0.0034 ± 0.0005 W/K`."""
    return ", ".join([called(found), *(number(n, value) for n, value in (found.get("parameters") or {}).items())])


def called(found: Found) -> str:
    where = [*found.get("places", ()), *found.get("channels", ())]
    return f"{found['kind']} {' – '.join(where)} ({found.get('confidence') or 0:.2f})"


def number(name: str, of: Mapping[str, Any]) -> str:
    spread = f" ± {of['std']:.2g}" if of.get("std") else ""
    unit = "" if of.get("unit") in (None, "1") else f" {of['unit']}"
    return f"{name.replace('_', ' ')} {of['value']:.3g}{spread}{unit}"


def drivers_of(patch: Any) -> Iterator[str]:
    """Inputs that entries of a patch are said to follow."""
    if isinstance(patch, Mapping):
        for key, value in patch.items():
            if key in ("with", "input", "while"):
                yield str(value)
            yield from drivers_of(value)


def windows_of(found: Found) -> Iterator[tuple[float, float]]:
    """Stretches [s] that a finding names as those it is about."""
    for a, b in (found.get("evidence") or {}).get("windows", ()):
        yield float(a), float(b)


def overlap(a: tuple[float, float], b: tuple[float, float]) -> float:
    """What two stretches share, of what they span together."""
    shared = min(a[1], b[1]) - max(a[0], b[0])
    return max(shared, 0.0) / (max(a[1], b[1]) - min(a[0], b[0]))
