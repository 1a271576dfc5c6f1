"""The units that occur here, as definitions for pint, and the likely one for an unknown name.

A table of its own starts faster than pint's thousand units and leaves out what would surprise (h is an hour, cd is
nothing). Turns are a dimension (angle), so a speed in rpm is never mistaken for a rate in 1/min.
"""

from __future__ import annotations

import math
import re
from difflib import get_close_matches
from fractions import Fraction
from functools import lru_cache
from typing import Any

NAME = r"[A-Za-zµΩ_]+"
DEFINITIONS = f"""
nano- = 1e-9 = n-
micro- = 1e-6 = µ- = u-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
deci- = 1e-1 = d-
hecto- = 1e2 = h-
kilo- = 1e3 = k-
mega- = 1e6 = M-
giga- = 1e9 = G-
meter = [length] = m = metre
second = [time] = s = sec
kilogram = [mass] = kg
gram = 1e-3 * kilogram = g
kelvin = [temperature] = K
rankine = 5 / 9 * kelvin
ampere = [current] = A
radian = [angle] = rad
turn = {2 * math.pi!r} * radian = rev = revolution
degree = turn / 360 = deg
arcsecond = turn / 1296000 = arcsec
percent = 0.01
ppm = 1e-6
minute = 60 * second = min
hour = 3600 * second = h = hr
day = 86400 * second = d
hertz = turn / second = Hz
rpm = turn / minute
inch = 0.0254 * meter = in
liter = 1e-3 * meter ** 3 = l = L = litre
newton = kilogram * meter / second ** 2 = N
newton_meter = newton * meter = Nm
newton_millimeter = 1e-3 * newton * meter = Nmm
joule = newton * meter = J
watt = joule / second = W
watt_hour = 3600 * joule = Wh
pascal = newton / meter ** 2 = Pa
bar = 1e5 * pascal
volt = watt / ampere = V
ohm = volt / ampere = Ω
stokes = 1e-4 * meter ** 2 / second = St
"""
UNPREFIXED = {
    "turn", "degree", "arcsecond", "percent", "ppm", "minute", "hour", "day", "rpm", "inch", "kilogram", "rankine",
}  # fmt: skip
_HINTS = {"C": "degC", "F": "degF", "U": "rev", "RPM": "rpm", "KW": "kW", "KJ": "kJ", "Km": "km", "MM": "mm"}


@lru_cache(maxsize=1)
def registry() -> Any:
    """pint's registry of these units; factors are fractions, so that 700 mm are exactly 0.7 m."""
    from pint import UnitRegistry

    units: Any = UnitRegistry(None, on_redefinition="ignore", non_int_type=Fraction)
    units.load_definitions(DEFINITIONS.strip().splitlines())
    return units


@lru_cache(maxsize=256)
def find_spelling(name: str) -> str | None:
    """The name as the registry spells it (a capital is forgiven: Kelvin), None where it has none."""
    for spelling in (name, name.lower() if name.istitle() and len(name) > 3 else name):
        found = [(prefix, base) for prefix, base, _ in registry().parse_unit_name(spelling)]
        if any(not prefix or base not in UNPREFIXED for prefix, base in found):
            return spelling
    return None


def likely_unit(text: str) -> str | None:
    """The name that was probably meant by the first unknown one in it."""
    for name in re.findall(NAME, text):
        if find_spelling(name) is None:
            names = [n for n in re.findall(NAME, DEFINITIONS) if len(n) > 1 and find_spelling(n)]
            return _HINTS.get(name) or next(iter(get_close_matches(name.lower(), names, n=1, cutoff=0.66)), None)
    return None
