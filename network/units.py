"""Numbers with units: `28 W/K ± 30 %` ↔ a value with a prior. At the rim only; inside everything is SI and °C."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

from pint import UnitRegistry
from pint.errors import DefinitionSyntaxError, UndefinedUnitError

_DEFINITIONS = """
nano- = 1e-9 = n-
micro- = 1e-6 = µ- = μ- = u-
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
ampere = [current] = A
radian = [angle] = rad
percent = 0.01 = %
ppm = 1e-6
rankine = 5 / 9 * kelvin
turn = 6.283185307179586 * radian = rev = revolution
degree = 0.017453292519943295 * radian = deg
arcsecond = 4.84813681109536e-06 * radian = arcsec
minute = 60 * second = min
hour = 60 * minute = h = hr
day = 24 * hour = d
hertz = turn / second = Hz
rpm = turn / minute
inch = 25.4 * millimeter = in
liter = 1e-3 * meter ** 3 = l = L = litre
newton = kilogram * meter / second ** 2 = N
joule = newton * meter = J
watt = joule / second = W
watt_hour = watt * hour = Wh
pascal = newton / meter ** 2 = Pa
bar = 1e5 * pascal
volt = watt / ampere = V
ohm = volt / ampere = Ω
stokes = 1e-4 * meter ** 2 / second = St
"""

Prior = Literal["known", "log", "normal", "unknown"]


@dataclass(frozen=True)
class Unit:
    """A unit: SI value = scale · number (+ offset for an absolute temperature, giving °C)."""

    text: str
    scale: float
    offset: float
    dimension: str

    def to_si(self, number: float) -> float:
        return number * self.scale + self.offset

    def from_si(self, value: float) -> float:
        return (value - self.offset) / self.scale

    @property
    def is_temperature(self) -> bool:
        return self.dimension == "[temperature]"


@dataclass(frozen=True)
class Number:
    """A number of a file in SI (temperatures in °C) with its prior.

    prior: known (never touched), log (normal in the logarithm, σ = spread), normal (σ = spread), unknown (log-uniform
    or uniform over low..high; `value` is the start of a calibration, not something to simulate with).
    """

    value: float
    prior: Prior = "known"
    spread: float = 0.0
    low: float = -math.inf
    high: float = math.inf


class BadNumber(ValueError):
    """What is wrong with a number and what would be right; the caller knows the place."""

    def __init__(self, wrong: str, right: str) -> None:
        super().__init__(f"{wrong}; {right}")
        self.wrong, self.right = wrong, right


@lru_cache(maxsize=1)
def _registry() -> UnitRegistry:
    registry: UnitRegistry = UnitRegistry(None, on_redefinition="ignore")
    registry.load_definitions(_DEFINITIONS.strip().splitlines())
    return registry


@lru_cache(maxsize=1024)
def unit(text: str) -> Unit:
    """The unit of that name. Raises BadNumber for an unknown one.

    Absolute temperatures (degC, degF, K alone) carry an offset to °C; in a product (W/degC) they count as differences.
    """
    if text in ("", "1", "-"):
        return Unit("1", 1.0, 0.0, "dimensionless")
    absolute = {"degC": (1.0, 0.0), "°C": (1.0, 0.0), "celsius": (1.0, 0.0), "K": (1.0, -273.15), "kelvin": (1.0, -273.15)}
    if text in absolute:
        return Unit(text, *absolute[text], "[temperature]")
    if text in ("degF", "°F", "fahrenheit"):
        return Unit(text, 5 / 9, -160 / 9, "[temperature]")
    registry = _registry()
    spelled = re.sub(r"degC|°C|celsius", "kelvin", re.sub(r"degF|°F|fahrenheit", "rankine", text))
    try:
        base = registry.Quantity(1.0, registry.parse_units(spelled.replace("%", "percent"))).to_base_units()
    except (UndefinedUnitError, DefinitionSyntaxError, ValueError, TypeError, AttributeError, KeyError, SyntaxError):
        raise BadNumber(f"unknown unit '{text}'", "write it like W/K, kJ/K, N mm, rpm, degC, um") from None
    except Exception as error:
        raise BadNumber(f"unit '{text}' is not understood ({error})", "write it like W/(m^2 K)") from None
    return Unit(text, float(base.magnitude), 0.0, str(base.dimensionality))


def difference(of: Unit) -> Unit:
    """The unit for a difference of such quantities: K for temperatures."""
    return Unit(of.text, of.scale, 0.0, of.dimension)


_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_QUANTITY = re.compile(rf"^\s*({_NUMBER})\s*(.*?)\s*$")
_RANGE = re.compile(rf"^\s*({_NUMBER})\s*\.\.\s*({_NUMBER})\s*(.*?)\s*$")
_PLUS_MINUS = re.compile(r"\s*(?:±|\+/-|\+-)\s*")


def split_number(text: str) -> tuple[float, str]:
    """'28 W/K' → (28.0, 'W/K'). Raises BadNumber where there is no finite number in front."""
    match = _QUANTITY.match(text)
    if not match:
        raise BadNumber(f"'{text}' is not a number", "write a number with its unit, like `5 W/K`")
    if re.match(r"[+-]?0\d", match[1]):
        raise BadNumber(f"'{text}' starts with a zero", f"write {match[1].lstrip('+-0') or '0'}")
    value = float(match[1])
    if not math.isfinite(value):
        raise BadNumber(f"'{text}' is not finite", "write a finite number")
    return value, match[2]


def in_unit(text: str, wanted: str) -> float:
    """'580 mm' wanted in 'm' → 0.58 in SI. `wanted` 'degC' means an absolute temperature, 'K' a difference."""
    number, unit_text = split_number(text)
    target = unit(wanted)
    if unit_text == "" and target.dimension != "dimensionless":
        raise BadNumber(f"'{text}' has no unit", f"a unit like {wanted} is needed, as in `{text.strip()} {wanted}`")
    given = unit(unit_text)
    if given.dimension != target.dimension:
        if unit_text == "" or wanted == "1":
            raise BadNumber(f"'{text}' has a unit", "a bare number is needed")
        raise BadNumber(f"'{text}' is in {unit_text}", f"a unit like {wanted} is needed")
    if target.is_temperature and wanted == "K":
        given = difference(given)
    return given.to_si(number)


def parse_number(text: str, wanted: str, may_be_negative: bool, bounds: tuple[float, float]) -> Number:
    """One number of a file: `v unit`, `v unit ± p %`, `v unit ± u unit`, `unknown`, `unknown 1..50 W/K`."""
    text = text.strip()
    if text.startswith("unknown"):
        return _parse_unknown(text[len("unknown") :].strip(), wanted, may_be_negative, bounds)
    centre, *rest = _PLUS_MINUS.split(text)
    value = in_unit(centre, wanted)
    if not rest:
        return Number(value)
    if len(rest) > 1:
        raise BadNumber(f"'{text}' has more than one ±", "write `value unit ± spread`")
    return _with_spread(value, rest[0], centre, wanted, may_be_negative)


def _with_spread(value: float, spread_text: str, centre: str, wanted: str, may_be_negative: bool) -> Number:
    number, unit_text = split_number(spread_text)
    if number <= 0:
        raise BadNumber(f"the spread '{spread_text}' is not above zero", "drop the ± for a known number")
    if unit_text == "%":
        relative, absolute = number / 100, abs(value) * number / 100
        if wanted == "degC":
            raise BadNumber(f"'{centre} ± {spread_text}' is a share of a temperature", "write the spread in K")
    else:
        absolute = in_unit(spread_text, "K" if wanted == "degC" else wanted)
        relative = absolute / abs(value) if value else math.inf
    if may_be_negative:
        if absolute == 0:
            raise BadNumber("a spread of zero times a share", "write the spread with its unit")
        return Number(value, "normal", absolute)
    if value == 0:
        raise BadNumber("zero with a spread", "give a value above zero, or drop the ±")
    return Number(value, "log", relative)


def _parse_unknown(rest: str, wanted: str, may_be_negative: bool, bounds: tuple[float, float]) -> Number:
    low, high = bounds
    if rest:
        match = _RANGE.match(rest)
        if not match:
            raise BadNumber(f"'unknown {rest}' is not a range", f"write `unknown 1..50 {wanted}`, or `unknown` alone")
        low, high = in_unit(f"{match[1]} {match[3]}", wanted), in_unit(f"{match[2]} {match[3]}", wanted)
    if not low < high:
        raise BadNumber(f"'unknown {rest}' has its bounds the wrong way round", "write the lower one first")
    if may_be_negative:
        return Number((low + high) / 2, "unknown", 0.0, low, high)
    if low <= 0:
        low = high * 1e-6
    return Number(math.sqrt(low * high), "unknown", 0.0, low, high)


def show(value: float, unit_text: str, digits: int = 4) -> str:
    """A value inside (SI, °C) as text in the given unit: show(0.58, 'mm') → '580 mm'."""
    given = unit(unit_text)
    if unit_text == "K":
        given = difference(given)
    number = f"{given.from_si(value):.{digits}g}"
    return number if unit_text in ("", "1") else f"{number} {unit_text}"
