"""Names of units: `W/(m^2 K)` → its factor to SI and its dimension, exactly.

A reader of our own: a library's took 0.13 s at every start, read `m;m` as an area and `cd` as a hundredth of a day.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

from network.refusal import Spot
from network.unit_table import BASES, meaning_of

LONGEST = 60
SMALLEST = Fraction(1, 10**100)
AS_IN = "write it like W/K, kJ/K, N mm, rpm, degC, um"
_ZEROS = {
    **dict.fromkeys(("degC", "°C", "℃", "celsius"), 0.0),
    **dict.fromkeys(("degF", "°F", "℉", "fahrenheit"), -160 / 9),
}
ABSOLUTE_ZERO = -273.15


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

    Temperatures (degC, degF, K, mK alone) carry an offset to °C; in a product (W/degC) they count as differences.
    """
    if text in ("", "1", "-"):
        return Unit("1", 1.0, 0.0, "dimensionless", 1.0)
    factor, dimension = factor_and_dimension(text)
    offset = _ZEROS.get(text, ABSOLUTE_ZERO) if dimension == "[temperature]" else 0.0
    return Unit(text, float(factor), offset, dimension, float(1 / factor))


def difference(of: Unit) -> Unit:
    """The unit for a difference of such quantities: K for temperatures."""
    return replace(of, offset=0.0)


@lru_cache(maxsize=1024)
def factor_and_dimension(text: str) -> tuple[Fraction, str]:
    """'g/cm^3' → (1000, '[length]^-3 [mass]'). Raises BadNumber for what is not a unit."""
    expression = _Expression(text)
    factor, powers = expression.read()
    terms = (f"[{base}]" if p == 1 else f"[{base}]^{float(p):g}" for base, p in sorted(powers.items()) if p)
    if not SMALLEST < factor < 1 / SMALLEST:
        raise expression.unreadable("it is beyond all numbers")
    return factor, " ".join(terms) or "dimensionless"


class _Expression:
    """Products, quotients and powers of names, read from the left; a space or a dot multiplies."""

    _TOKEN = re.compile(
        r"(?P<sign>\*\*|[\^*·⋅×/()])|(?P<name>[A-Za-zµΩ]+|°[CF]?|[℃℉%])(?P<digits>[0-9]*)"
        r"|(?P<number>[+-]?[0-9]+(?:\.[0-9]+)?)|(?P<raised>[⁺⁻]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+)|\s+"
    )
    _LOWERED = str.maketrans("⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "+-0123456789")

    def __init__(self, text: str) -> None:
        self.text = text
        if len(text) > LONGEST:
            raise BadNumber(f"unreadable unit '{text[:20]}…' ({len(text)} characters)", AS_IN)
        self.tokens = self._split(text.replace("μ", "µ"))

    def _split(self, text: str) -> list[str]:
        tokens, at = [], 0
        while at < len(text):
            match = self._TOKEN.match(text, at)
            if match is None:
                raise self.unreadable(f"{text[at]!r} does not belong in a unit")
            at, found = match.end(), match.groupdict()
            tokens += [part for part in (found["sign"], found["name"], found["number"]) if part]
            power = found["digits"] or (found["raised"] or "").translate(self._LOWERED)
            tokens += ["^", power] if power else []
        return ["^" if token == "**" else token for token in tokens]

    def unreadable(self, why: str) -> BadNumber:
        return BadNumber(f"unreadable unit '{self.text}' ({why})", AS_IN)

    def _next(self) -> str:
        return self.tokens[0] if self.tokens else ""

    def _take(self) -> str:
        return self.tokens.pop(0) if self.tokens else ""

    def read(self) -> tuple[Fraction, dict[str, Fraction]]:
        """The factor to SI and the exponent of every base."""
        result = self._product()
        if self.tokens:
            raise self.unreadable(f"'{self._next()}' is left over")
        return result

    def _product(self) -> tuple[Fraction, dict[str, Fraction]]:
        factor, powers = self._power()
        while self._next() not in ("", ")"):
            sign = -1 if self._next() == "/" else 1
            if self._next() in "*·⋅×/":
                self._take()
            other, more = self._power()
            factor *= other**sign
            powers = {base: powers.get(base, 0) + sign * more.get(base, Fraction()) for base in {**powers, **more}}
        return factor, powers

    def _power(self) -> tuple[Fraction, dict[str, Fraction]]:
        factor, powers = self._atom()
        if self._next() != "^":
            return factor, powers
        self._take()
        bracket = self._next() == "("
        exponent = self._exponent([self._take() for _ in range(1 + bracket)][-1])
        if bracket and self._take() != ")":
            raise self.unreadable("a bracket is not closed")
        raised = factor**exponent if exponent.denominator == 1 else Fraction(float(factor) ** float(exponent))
        return Fraction(raised), {base: power * exponent for base, power in powers.items()}

    def _exponent(self, token: str) -> Fraction:
        if not re.fullmatch(r"[+-]?[0-9]+(\.[0-9]+)?", token) or abs(float(token)) > 12:
            raise self.unreadable(f"'{token}' is no exponent")
        return Fraction(token)

    def _atom(self) -> tuple[Fraction, dict[str, Fraction]]:
        token = self._take()
        if token == "(":
            inside = self._product()
            if self._take() != ")":
                raise self.unreadable("a bracket is not closed")
            return inside
        if token == "1":
            return Fraction(1), {}
        if not token or token in "^*·⋅×/)" or token[0] in "+-0123456789":
            raise self.unreadable(f"'{token}' where a name is needed" if token else "it ends too early")
        return self._named(token)

    def _named(self, name: str) -> tuple[Fraction, dict[str, Fraction]]:
        if name in BASES:
            return Fraction(1), {BASES[name]: Fraction(1)}
        meaning = meaning_of(name)
        if meaning is None:
            raise BadNumber(f"unknown unit '{name}'", AS_IN)
        inner, powers = _Expression(meaning[1]).read() if meaning[1] else (Fraction(1), {})
        return meaning[0] * inner, powers
