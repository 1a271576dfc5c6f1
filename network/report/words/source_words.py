"""Where the movement of the tool centre point comes from, in a sentence for each axis, and as a mapping."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from network.catalogue.expansions.base import ANGULAR_AXES
from network.engine.superposition.superpose import ALONG, AT_ONCE, EXACTLY
from network.engine.superposition.superposition import Superposition
from network.engine.trajectory import ROUNDING, axis_unit
from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import span
from network.platform.quantities.units import unit
from network.platform.wording import name_of

MOST = 4
"""Sources that a sentence names; the others are added up."""
MOST_PARTS = 3
NEARLY = 0.95
"""Share of a source's movement from which one part is named alone."""
SAID = {EXACTLY: "exact superposition", ALONG: "conductances and heats as they were along this run"}


def tell_superposition(shares: Superposition) -> str:
    """A sentence for each axis that moves; below, what they leave out where that is worth a digit."""
    return "\n".join([*(tell_axis(shares, axis) for axis in shares.run.tcp), *_tell_remainder(shares)])


def tell_axis(shares: Superposition, axis: str) -> str:
    """Of so many µm at its furthest, how many come from which heat through which part."""
    at, moved = shares.furthest(axis), _moved(shares, axis)
    told = _Digits(axis, max(abs(moved), *(abs(v) for v in by_source(shares, axis).values()), 0.0))
    angular = axis in ANGULAR_AXES
    way = f"turning about {axis}" if angular else f"along {axis}"
    if unit(axis_unit(axis)).to_si(told.largest) < ROUNDING:
        moves = "turns the tool centre point about" if angular else "moves the tool centre point along"
        return f"Nothing {moves} {axis}."
    causes = sorted(by_source(shares, axis).items(), key=lambda item: -abs(item[1]))
    seen = [(name, value) for name, value in causes if told.shows(value)]
    first = [f"{told(value)} {_from(name)}{_through(shares, axis, name, told)}" for name, value in seen[:MOST]]
    if seen[MOST:]:
        first.append(f"{told(sum(v for _, v in seen[MOST:]))} from {len(seen) - MOST} more")
    after = span(float(shares.run.t[at] - shares.run.t[0]))
    words = f"Of {told(moved)} {pretty(axis_unit(axis))} {way} after {after}: {', '.join(first)}"
    return f"{words}.{_by_kind(shares, axis, told)}"


def by_source(shares: Superposition, axis: str) -> dict[str, float]:
    """What every cause moved the axis from the start to where it is furthest [m, rad]."""
    return {cause: value for (cause,), value in _at_furthest(shares, axis, "cause").items()}


def summarise_superposition(shares: Superposition) -> dict[str, Any]:
    """What summary.json holds under `from`, by axis."""
    return {axis: _summarise_axis(shares, axis) for axis in shares.run.tcp}


def _summarise_axis(shares: Superposition, axis: str) -> dict[str, Any]:
    given = unit(axis_unit(axis))

    def shown(values: Mapping[tuple[str, ...], float]) -> dict[str, float]:
        return {" / ".join(key): given.from_si(value) for key, value in values.items()}

    return {
        "unit": axis_unit(axis),
        "at": {"value": float(shares.run.t[shares.furthest(axis)]), "unit": "s"},
        "moved": given.from_si(_moved(shares, axis)),
        "by_source": shown(_at_furthest(shares, axis, "cause")),
        "by_part": shown(_at_furthest(shares, axis, "part")),
        "by_kind": shown(_at_furthest(shares, axis, "kind")),
        "by_source_and_part": shown(_at_furthest(shares, axis, "cause", "part")),
        "remainder": given.from_si(float(abs(shares.remainder[axis]).max())),
        "how": shares.how,
        "sentence": tell_axis(shares, axis),
    }


def _at_furthest(shares: Superposition, axis: str, *by: Any) -> dict[tuple[str, ...], float]:
    at = shares.furthest(axis)
    return {key: float(values[at] - values[0]) for key, values in shares.sum_by(axis, *by).items()}


def _moved(shares: Superposition, axis: str) -> float:
    values = shares.run.tcp[axis]
    return float(values[shares.furthest(axis)] - values[0])


class _Digits:
    """Writes movements of an axis in its unit, with a sign, all to the place of the third digit of the largest."""

    def __init__(self, axis: str, largest: float) -> None:
        self.unit = unit(axis_unit(axis))
        self.largest = abs(self.unit.from_si(largest))
        self.places = max(0, 2 - math.floor(math.log10(self.largest))) if self.largest > 0 else 0

    def __call__(self, value: float) -> str:
        return f"{self.unit.from_si(value):+.{self.places}f}".replace("-", "−")

    def shows(self, value: float) -> bool:
        """Whether any digit of it is told."""
        return bool(self(value).strip("+−0."))


def _from(cause: str) -> str:
    return {"start": "from the uneven start", AT_ONCE: AT_ONCE}.get(cause, f"from {cause}")


def _through(shares: Superposition, axis: str, cause: str, told: _Digits) -> str:
    """The parts that it moved the axis through: one that does nearly all by its name, else the largest and the rest."""
    parts = {p: v for (c, p), v in _at_furthest(shares, axis, "cause", "part").items() if c == cause and told.shows(v)}
    ordered = sorted(parts.items(), key=lambda item: -abs(item[1]))
    size = sum(abs(value) for value in parts.values())
    if not ordered:  # each less than a digit that is told, together more
        return ""
    if len(ordered) == 1 or abs(ordered[0][1]) >= NEARLY * size:
        return f" through {ordered[0][0]}"
    named = ordered if len(ordered) <= MOST_PARTS else ordered[: MOST_PARTS - 1]
    others = sum(value for _, value in ordered[len(named) :])
    told_parts = [f"{part} {told(value)}" for part, value in named] + [f"others {told(others)}"] * (named != ordered)
    return f" ({', '.join(told_parts)})"


def _by_kind(shares: Superposition, axis: str, told: _Digits) -> str:
    kinds = {kind: value for (kind,), value in _at_furthest(shares, axis, "kind").items() if told.shows(value)}
    if len(kinds) < 2:
        return ""
    words = (f"{name_of(kind)} {told(value)}" for kind, value in kinds.items())
    return f" By {', '.join(words)}."


def _tell_remainder(shares: Superposition) -> Iterator[str]:
    if shares.how != EXACTLY and shares.run.tcp:
        left = max(float(abs(values).max()) for values in shares.remainder.values())
        yield f"Told with {SAID[shares.how]}; {left * 1e6:.1g} µm are left out."
