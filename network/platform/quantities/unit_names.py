"""A unit by its name: `W/(m^2 K)` → its factor to SI and its dimension, by pint. Written as engineers write units."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

from network.platform.quantities.unit_products import read_product
from network.platform.quantities.unit_table import NAME, find_spelling, registry
from network.platform.refusal import Spot

LONGEST = 60
MOST_POWER = 12
AS_IN = "write it like W/K, kJ/K, N mm, rpm, degC, um"
_ZEROS = {
    **dict.fromkeys(("degC", "°C", "℃", "celsius"), 0.0),
    **dict.fromkeys(("degF", "°F", "℉", "fahrenheit"), -160 / 9),
}
ABSOLUTE_ZERO = -273.15
_SPELLINGS = (
    ("μ", "µ"), ("℃", "kelvin"), ("°C", "kelvin"), ("degC", "kelvin"), ("celsius", "kelvin"),
    ("℉", "rankine"), ("°F", "rankine"), ("degF", "rankine"), ("fahrenheit", "rankine"),
    ("°", "degree"), ("%", " percent "), ("·", " "), ("⋅", " "), ("×", " "), ("**", "^"), ("*", " "),
)  # fmt: skip
_RAISED = str.maketrans("⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "+-0123456789")


class BadNumber(ValueError):
    """What is wrong with a value and what would be right; the caller knows the place, unless `spot` says it closer."""

    def __init__(self, wrong: str, right: str, spot: Spot | None = None) -> None:
        super().__init__(f"{wrong}; {right}")
        self.wrong, self.right, self.spot = wrong, right, spot


@dataclass(frozen=True)
class Unit:
    """A unit: SI value = scale · number (+ offset for an absolute temperature, giving °C)."""

    text: str
    scale: float
    offset: float
    dimension: str
    inverse: float

    def to_si(self, number: float) -> float:
        """Divides where that is exact: 700 mm are 0.7 m and not 0.7000000000000001 m."""
        return (number * self.scale if self.scale >= 1 else number / self.inverse) + self.offset

    def from_si(self, value: float) -> float:
        return (value - self.offset) / self.scale if self.scale >= 1 else (value - self.offset) * self.inverse

    @property
    def is_temperature(self) -> bool:
        return self.dimension == "[temperature]"


@lru_cache(maxsize=1024)
def unit(text: str) -> Unit:
    """The unit of that name. Raises BadNumber for an unknown one.

    Temperatures (degC, degF, K, mK alone) carry an offset to °C; in a product (W/degC, K/%) they count as differences.
    """
    if text in ("", "1", "-"):
        return Unit("1", 1.0, 0.0, "dimensionless", 1.0)
    factor, dimension = _factor_and_dimension(text)
    is_absolute = dimension == "[temperature]" and "/" not in text and "%" not in text
    offset = _ZEROS.get(text, ABSOLUTE_ZERO) if is_absolute else 0.0
    return Unit(text, float(factor), offset, dimension, float(1 / factor))


def difference(of: Unit) -> Unit:
    """The unit for a difference of such quantities: K for temperatures."""
    return replace(of, offset=0.0)


def _factor_and_dimension(text: str) -> tuple[Fraction, str]:
    """'g/cm^3' → (1000, '[length]^-3 [mass]'). Raises BadNumber for what is not a unit."""
    if len(text) > LONGEST:
        raise BadNumber(f"unreadable unit '{text[:20]}…' ({len(text)} characters)", AS_IN)
    product = read_product(_respell(text))
    if product is not None:
        return product[0], _name_dimension(product[1])
    spelled = _spell(text)
    units = registry()
    try:
        parsed = units.parse_units(spelled)
        factor = Fraction(units.Quantity(Fraction(1), parsed).to_base_units().magnitude)
        powers = dict(units.get_dimensionality(parsed))
    except Exception as error:  # pint answers a malformed expression with whatever its tokenizer met
        raise BadNumber(f"unreadable unit '{text}'", AS_IN) from error
    if any(abs(power) > MOST_POWER for power in powers.values()):
        raise BadNumber(f"unreadable unit '{text}'", AS_IN)
    return factor, _name_dimension(powers)


def _name_dimension(powers: Mapping[str, float]) -> str:
    terms = (base if p == 1 else f"{base}^{float(p):g}" for base, p in sorted(powers.items()) if p)
    return " ".join(terms) or "dimensionless"


def _spell(text: str) -> str:
    """The expression as pint reads it: one way to write products, powers and temperatures, only known names."""
    spelled = _respell(text)
    odd = re.search(rf"[^\s()/^.+\-\d{NAME[1:-2]}]", spelled)
    if odd or re.search(r"\^\s*\(?\s*[+-]?\d{3}|[\^/]\s*$|\^[^A-Za-z(]*\^|\)\s*\^.*\^", spelled):
        raise BadNumber(f"unreadable unit '{text}'", AS_IN)
    return re.sub(NAME, lambda match: _check_name(match[0]), spelled)


def _respell(text: str) -> str:
    for theirs, ours in _SPELLINGS:
        text = text.replace(theirs, ours)
    text = re.sub(r"[⁺⁻]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+", lambda match: "^" + match[0].translate(_RAISED), text)
    return re.sub(rf"({NAME})(\d+)", r"\1^\2", text)


def _check_name(name: str) -> str:
    spelling = find_spelling(name)
    if spelling is None:
        raise BadNumber(f"unknown unit '{name}'", AS_IN)
    return spelling
