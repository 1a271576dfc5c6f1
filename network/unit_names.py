"""Names of units: `W/(m^2 K)` → its factor to SI and its dimension, exactly.

A reader of our own: a library's took 0.13 s at every start, read `m;m` as an area and `cd` as a hundredth of a day.
Turns are a dimension (angle), so a speed in rpm is never mistaken for a rate in 1/min.
"""

from __future__ import annotations

import math
import re
from difflib import get_close_matches
from fractions import Fraction
from functools import lru_cache
from typing import TypeAlias

from network.refusal import Spot

LONGEST = 60
SMALLEST = Fraction(1, 10**100)
AS_IN = "write it like W/K, kJ/K, N mm, rpm, degC, um"
_TURN = Fraction(2 * math.pi)
_BASES = {"m": "length", "kg": "mass", "s": "time", "K": "temperature", "A": "current", "rad": "angle"}
_SHORT = {"n": -9, "µ": -6, "u": -6, "m": -3, "c": -2, "d": -1, "h": 2, "k": 3, "M": 6, "G": 9}
_LONG = {"nano": -9, "micro": -6, "milli": -3, "centi": -2, "deci": -1, "hecto": 2, "kilo": 3, "mega": 6, "giga": 9}

Meaning: TypeAlias = tuple[Fraction, str]
"""So many times that product of bases."""


def _table(rows: dict[str, tuple[str | int | Fraction, str]]) -> dict[str, Meaning]:
    return {name: (Fraction(factor), bases) for names, (factor, bases) in rows.items() for name in names.split()}


_PREFIXED = _table(
    {
        "g gram": ("1e-3", "kg"),
        "m meter metre": (1, "m"),
        "s second": (1, "s"),
        "K kelvin": (1, "K"),
        "A ampere": (1, "A"),
        "rad radian": (1, "rad"),
        "N newton": (1, "kg m/s^2"),
        "Nm": (1, "kg m^2/s^2"),
        "J joule": (1, "kg m^2/s^2"),
        "W watt": (1, "kg m^2/s^3"),
        "Wh": (3600, "kg m^2/s^2"),
        "Pa pascal": (1, "kg/(m s^2)"),
        "bar": ("1e5", "kg/(m s^2)"),
        "V volt": (1, "kg m^2/(s^3 A)"),
        "Ω ohm": (1, "kg m^2/(s^3 A^2)"),
        "l L liter litre": ("1e-3", "m^3"),
        "St stokes": ("1e-4", "m^2/s"),
        "Hz hertz": (_TURN, "rad/s"),
    }
)
_WHOLE = _table(
    {
        "Nmm": ("1e-3", "kg m^2/s^2"),
        "min minute": (60, "s"),
        "h hr hour": (3600, "s"),
        "d day days": (86400, "s"),
        "sec": (1, "s"),
        "rev turn revolution": (_TURN, "rad"),
        "rpm": (_TURN / 60, "rad/s"),
        "deg degree °": (_TURN / 360, "rad"),
        "arcsec arcsecond": (_TURN / 1_296_000, "rad"),
        "in inch": ("0.0254", "m"),
        "degC °C ℃ celsius": (1, "K"),
        "degF °F ℉ fahrenheit": ("5/9", "K"),
        "% percent": ("1e-2", ""),
        "ppm": ("1e-6", ""),
    }
)
_HINTS = {"C": "degC", "F": "degF", "U": "rev", "RPM": "rpm", "KW": "kW", "KJ": "kJ", "Km": "km", "MM": "mm"}


class BadNumber(ValueError):
    """What is wrong with a value and what would be right; the caller knows the place, unless `spot` says it closer."""

    def __init__(self, wrong: str, right: str, spot: Spot | None = None) -> None:
        super().__init__(f"{wrong}; {right}")
        self.wrong, self.right, self.spot = wrong, right, spot


@lru_cache(maxsize=1024)
def factor_and_dimension(text: str) -> tuple[Fraction, str]:
    """'g/cm^3' → (1000, '[length]^-3 [mass]'). Raises BadNumber for what is not a unit."""
    expression = _Expression(text)
    factor, powers = expression.read()
    terms = (f"[{base}]" if p == 1 else f"[{base}]^{float(p):g}" for base, p in sorted(powers.items()) if p)
    if not SMALLEST < factor < 1 / SMALLEST:
        raise expression.unreadable("it is beyond all numbers")
    return factor, " ".join(terms) or "dimensionless"


def _meaning(name: str) -> Meaning | None:
    """A name as it stands, else with a prefix, in the plural, or with a capital (Kelvin)."""
    known = _WHOLE.get(name) or _PREFIXED.get(name)
    if known or len(name) < 2:
        return known
    for prefixes, long in ((_SHORT, False), (_LONG, True)):
        for prefix, power in prefixes.items():
            rest = name.removeprefix(prefix)
            if rest != name and rest in _PREFIXED and (len(rest) > 3) == long:
                return _PREFIXED[rest][0] * Fraction(10) ** power, _PREFIXED[rest][1]
    if len(name) > 4 and name.endswith("s"):
        return _meaning(name[:-1])
    return _meaning(name.lower()) if len(name) > 3 and name.istitle() else None


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
        if name in _BASES:
            return Fraction(1), {_BASES[name]: Fraction(1)}
        meaning = _meaning(name)
        if meaning is None:
            raise BadNumber(f"unknown unit '{name}'", AS_IN)
        inner, powers = _Expression(meaning[1]).read() if meaning[1] else (Fraction(1), {})
        return meaning[0] * inner, powers


def likely_unit(text: str) -> str | None:
    """The name that was probably meant by the first unknown one in it."""
    name = next((word for word in re.findall(r"[A-Za-zµΩ]+", text) if not (word in _BASES or _meaning(word))), "")
    names = [known for known in (*_WHOLE, *_PREFIXED) if len(known) > 1]
    return _HINTS.get(name) or next(iter(get_close_matches(name.lower(), names, n=1, cutoff=0.66)), None)
