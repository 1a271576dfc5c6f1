"""The fields that hold numbers with units."""

from __future__ import annotations

import math
from copy import copy
from dataclasses import dataclass
from typing import Any, Self

from network.catalogue.declaration.field import Field, word_of
from network.platform.quantities.number_format import format_amount
from network.platform.quantities.units import (
    NUMBER,
    BadNumber,
    Number,
    Unit,
    format_exactly,
    parse_number,
    show,
    split_number,
    unit,
)
from network.platform.refusal import short
from network.platform.yaml.tree import Tree


class ParamField(Field):
    """A number with a unit, bounds and a meaning. Inside it is SI, absolute temperatures °C."""

    def __init__(
        self,
        unit_text: str,
        low: float,
        high: float,
        meaning: str,
        default: Any,
        positive: bool = False,
        typical: float | None = None,
        any_power_of: str = "",
        is_instant: bool = False,
    ) -> None:
        super().__init__(meaning, default)
        self.unit, self.positive, self.any_power_of = unit_text, positive, any_power_of
        self.is_instant = is_instant
        self._low, self._high, self._typical = low, high, typical

    @property
    def example(self) -> str:
        return f", in {self.unit}" if self.unit != "1" else ""

    @property
    def initial(self) -> Any:
        return self._si(self.default) if isinstance(self.default, int | float) else None

    def _si(self, number: float) -> float:
        given = unit(self.unit)
        return number * given.scale + (0.0 if self.unit == "K" else given.offset)

    @property
    def low(self) -> float:
        return self._si(self._low)

    @property
    def high(self) -> float:
        return self._si(self._high)

    @property
    def may_be_negative(self) -> bool:
        return self._low < 0 or self.unit == "degC"

    def parse(self, tree: Tree) -> Number:
        text = word_of(tree, f"a number{self.example}")
        number = parse_number(text, self._choose_unit(text), self.may_be_negative, (self.low, self.high))
        ends = (number.low, number.high) if number.prior == "unknown" else (number.value,)
        for value in ends:
            self._check_bounds(value, text)
        return number

    def _choose_unit(self, text: str) -> str:
        """The unit asked for; some coefficients come per any power of one dimension (W/(m² K^1.25), W/(m² K^1.33))."""
        if not self.any_power_of:
            return self.unit
        given = text.removeprefix("unknown").rpartition("..")[2].split("±")[0].strip()
        try:
            of = unit(split_number(given)[1]).dimension
        except BadNumber:
            return self.unit
        same = _without(of, self.any_power_of) == _without(unit(self.unit).dimension, self.any_power_of)
        return split_number(given)[1] if same and self.any_power_of in of else self.unit

    def in_unit(self, unit_text: str) -> Self:
        """The same field with its numbers in another unit, its bounds alike. What is typical is told of its own
        dimension only."""
        other = copy(self)
        other.unit = unit_text
        if unit(unit_text).dimension != unit(self.unit).dimension:
            other._typical = 0.0
        return other

    def _check_bounds(self, value: float, text: str) -> None:
        slack = 1e-12 * max(abs(self.low), abs(self.high))
        if self.positive and not value > 0:
            in_unit = f", in {self.unit}" if self.unit != "1" else ""
            raise BadNumber(f"'{short(text)}' is not above zero", f"give a {self.key} above zero{in_unit}")
        if not self.low - slack <= value <= self.high + slack:
            side = "below" if value < self.low else "above"
            raise BadNumber(f"'{short(text)}' is {side} what is possible", f"{self.key} goes from {self.range}")

    @property
    def range(self) -> str:
        """Its bounds in words."""
        return f"{show(self.low, self.unit)} to {show(self.high, self.unit)}"

    def proposal(self) -> float:
        """A typical value in SI: where a search for it may start."""
        if self._typical is not None:
            return self._si(self._typical)
        if self.may_be_negative:
            return (self.low + self.high) / 2
        return math.sqrt(max(self.low, self.high * 1e-6) * self.high)

    def write(self, value: Any) -> Any:
        number = value if isinstance(value, Number) else Number(float(value))
        if number.prior == "unknown":
            low = format_exactly(number.low, self.unit).partition(" ")[0]
            return f"unknown {low}..{format_exactly(number.high, self.unit)}"
        text = format_exactly(number.value, self.unit)
        if number.prior == "log":
            return f"{text} ± {number.spread * 100:.12g} %"
        if number.prior == "normal":
            return f"{text} ± {show(number.spread, 'K' if self.unit == 'degC' else self.unit, 12)}"
        return text

    def tell(self, value: Any) -> str:
        return format_amount(float(value), self.unit)

    @property
    def sample(self) -> Any:
        """Typical, to four digits."""
        text = show(self.proposal(), self.unit, 4)
        return self.write(self._si(float(text))) if self.unit == "1" else text

    def schema(self) -> dict[str, Any]:
        """A number with its unit; heirs of this class may read words as well."""
        bare = self.unit == "1"
        unit_part = ".*" if bare else r"(\s+\S|[^\s0-9.]).*"
        pattern = rf"^\s*(unknown\b.*|{NUMBER}{unit_part})$" if type(self) is ParamField else "."
        return {"type": ["string", "number"] if bare else "string", "pattern": pattern, "examples": [self.sample]}

    def structure(self, value: Any) -> object:
        return value is not None


def _without(dimension: str, name: str) -> str:
    """A dimension less one of its bases: '[mass] [temperature]^-1 [time]^-3' → '[mass] [time]^-3'."""
    return " ".join(term for term in dimension.split() if not term.startswith(name))


@dataclass(frozen=True)
class Amount:
    """A number in a unit of the user's own choice, kept with that unit; `value` is SI."""

    value: float
    unit: str

    def __str__(self) -> str:
        return format_exactly(self.value, self.unit)


class AmountField(Field):
    """A number whose unit is decided elsewhere, like the value of an input channel."""

    def parse(self, tree: Tree) -> Amount:
        text = word_of(tree, self.meaning)
        if "±" in text:
            raise BadNumber(f"'{short(text)}' has a spread", "give the number without ±")
        number, unit_text = split_number(text)
        return self._amount(text, number, self._check_unit(text, unit_text))

    def _check_unit(self, text: str, unit_text: str) -> Unit:
        try:
            return unit(unit_text)
        except BadNumber as error:
            raise BadNumber(f"'{short(text)}' has an {error.wrong}", error.right) from None

    def _amount(self, text: str, number: float, given: Unit) -> Amount:
        value = given.to_si(number)
        if value == 0:
            raise BadNumber(f"'{short(text)}' is zero", "give another value")
        return Amount(value, given.text)

    @property
    def sample(self) -> Any:
        return "1 m/min"

    def structure(self, value: Any) -> object:
        return value is not None
