"""Points along a part that need not stand still: a share of its length, a length, or where an input says.

`at: 0.3`, `at: 350 mm`, `at: position` (an input in a unit of length, counted from the part's beginning),
`at: 220 mm + position`, `at: 900 mm - position`, `at: 0.2 + position` (an input that is a share of the length).
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from network.catalogue.declaration.field import word_of
from network.catalogue.declaration.number_fields import ParamField
from network.platform.quantities.units import (
    BadNumber,
    format_exactly,
    one_space,
    show,
    split_number,
    spread_parts,
    unit,
)
from network.platform.refusal import short
from network.platform.yaml.tree import Tree

_SUM = re.compile(r"^(.*\S)\s+([+-])\s+(\S.*)$")
_RIGHT = "give a share from 0 to 1, a length, an input, or both as in `220 mm + position`"
_SHARE, _LENGTH = (unit(text).dimension for text in ("1", "m"))


@dataclass(frozen=True)
class Along:
    """origin + sign · input, or the origin alone; [m], or a share of the length where `unit` is none of length."""

    origin: float
    unit: str
    input: str = ""
    sign: int = 1

    def __str__(self) -> str:
        if self.input and not self.origin and self.sign > 0 and not self.is_share:
            return self.input
        origin = format_exactly(self.origin, self.unit)
        return f"{origin} {'+' if self.sign > 0 else '-'} {self.input}" if self.input else origin

    @property
    def is_share(self) -> bool:
        return unit(self.unit).dimension == _SHARE

    @property
    def needs(self) -> Mapping[str, str]:
        """The input it follows, with a unit of the kind that must have."""
        return {self.input: "1" if self.is_share else "m"} if self.input else {}

    def metres(self, u: Mapping[str, Any], length: Any) -> Any:
        """Distance from the beginning of a part of that length [m]; not limited to the part."""
        where = self.origin + self.sign * u[self.input] if self.input else self.origin
        return where * length if self.is_share else where


class AlongField(ParamField):
    """A share of a part's length, which may be uncertain, or an `Along`."""

    def __init__(self, meaning: str, default: Any) -> None:
        super().__init__("1", 0, 1, meaning, default, typical=0.5)

    def parse(self, tree: Tree) -> Any:
        text = word_of(tree, self.meaning)
        if found := _SUM.match(one_space(text)):
            return Along(*self._origin(found[1], text), found[3], 1 if found[2] == "+" else -1)
        if text[0] not in "+-.0123456789" and not text.startswith("unknown"):
            if text.split()[0].lower() in ("nan", "inf", "infinity"):
                raise BadNumber(f"'{short(text)}' is not a number", _RIGHT)
            return Along(0.0, "m", text)
        bare, *spread = spread_parts(text)
        if text.startswith("unknown") or self._dimension(bare, text) == _SHARE:
            return super().parse(tree)
        if spread:
            raise BadNumber(f"'{short(text)}' is a length with a spread", "give an uncertain place as a share")
        return Along(*self._origin(text, text))

    @staticmethod
    def _dimension(number: str, text: str) -> str:
        try:
            return unit(split_number(number)[1]).dimension
        except BadNumber as error:
            raise BadNumber(f"'{short(text)}': {error.wrong}", _RIGHT) from None

    def _origin(self, origin: str, text: str) -> tuple[float, str]:
        if self._dimension(origin, text) not in (_SHARE, _LENGTH):
            raise BadNumber(f"'{short(text)}' is no place along a part", _RIGHT)
        number, unit_text = split_number(origin)
        return unit(unit_text).to_si(number), unit_text or "1"

    @property
    def range(self) -> str:
        return "0 to 1, or is a length, an input, or both as in `220 mm + position`"

    def write(self, value: Any) -> Any:
        return str(value) if isinstance(value, Along) else super().write(value)

    def tell(self, value: Any) -> str:
        return str(value) if isinstance(value, Along) else super().tell(value)

    def structure(self, value: Any) -> object:
        return value if isinstance(value, Along) else value is not None


def metres(where: Any, u: Mapping[str, Any], length: Any) -> NDArray[np.float64]:
    """Distance from the beginning of a part [m], of a share or an `Along`."""
    found = where.metres(u, length) if isinstance(where, Along) else where * length
    return cast(NDArray[np.float64], found)


def clip(x: Any, low: Any, high: Any) -> NDArray[np.float64]:
    """x, not below low and not above high; a complex step passes through."""
    below, above = np.real(x) < np.real(low), np.real(x) > np.real(high)
    return cast(NDArray[np.float64], np.where(below, low, np.where(above, high, x)))


def list_inputs(*places: Any) -> dict[str, str]:
    """The inputs that such places follow."""
    return {name: wanted for where in places if isinstance(where, Along) for name, wanted in where.needs.items()}


def beyond(where: Any, u: Mapping[str, Any], length: Any) -> Iterator[str]:
    """Says so where a place leaves a part of that length [m]: one that follows an input; with no u one that stands."""
    if not isinstance(where, Along) or bool(where.input) != bool(u):
        return
    x, slack = np.atleast_1d(where.metres(u, float(length))), 1e-9 * float(length)
    if x.min() < -slack or x.max() > float(length) + slack:
        low, high = (show(float(end), "mm") for end in (x.min(), x.max()))
        reach = f"goes from {low} to {high}" if where.input else f"is {low}"
        yield f"`{where}` {reach} along the {show(float(length), 'mm')}"
