"""The units that can be named: each a factor and a product of the bases, exactly.

Turns are a dimension (angle), so a speed in rpm is never mistaken for a rate in 1/min.
"""

from __future__ import annotations

import math
import re
from difflib import get_close_matches
from fractions import Fraction
from typing import TypeAlias

_TURN = Fraction(2 * math.pi)
BASES = {"m": "length", "kg": "mass", "s": "time", "K": "temperature", "A": "current", "rad": "angle"}
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


def meaning_of(name: str) -> Meaning | None:
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
        return meaning_of(name[:-1])
    return meaning_of(name.lower()) if len(name) > 3 and name.istitle() else None


def likely_unit(text: str) -> str | None:
    """The name that was probably meant by the first unknown one in it."""
    name = next((word for word in re.findall(r"[A-Za-zµΩ]+", text) if not (word in BASES or meaning_of(word))), "")
    names = [known for known in (*_WHOLE, *_PREFIXED) if len(known) > 1]
    return _HINTS.get(name) or next(iter(get_close_matches(name.lower(), names, n=1, cutoff=0.66)), None)
