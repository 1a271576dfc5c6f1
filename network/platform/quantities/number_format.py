"""Numbers as a sentence tells them."""

from __future__ import annotations

import math
import re

from network.platform.quantities.units import unit_of_output

FEWEST, LARGEST = 1e-3, 1e9
"""Sizes between which no exponent is written."""
GROUPED = 1e4
"""Size from which thousands stand apart."""
_SIGN = re.compile(r"(?<![^\s(\[,;:±…])-(?=\.?\d)")
_PRETTY = {"degC": "°C", "degF": "°F", "um": "µm", "urad": "µrad", "1": "–"}


def pretty(unit_text: str) -> str:
    """A unit as it is printed."""
    return _PRETTY.get(unit_text, unit_text)


def format_amount(value: float, unit_text: str, most: int = 3) -> str:
    """A value inside (SI, °C) in a unit, of so many digits (three: one more for temperatures and thousands), without
    exponent where it reads so: 5.57 W/K, 21.62 °C, 10 000 rpm."""
    given = unit_of_output(unit_text).from_si(value)
    is_long = most > 2 and (abs(given) >= 1e3 or unit_text == "degC")
    number = float(f"{given:.{most + is_long}g}")
    if number and not FEWEST <= abs(number) < LARGEST:
        text = f"{number:.3g}"
    elif abs(number) < GROUPED:
        text = f"{number:.4g}"
    else:
        text = f"{number:,.0f}".replace(",", "\u00a0")
    told = f"−{text[1:]}" if text.startswith("-") else text
    return told if unit_text in ("", "1") else f"{told} {pretty(unit_text)}"


def write_minus(text: str) -> str:
    """Signs of numbers as true minus; hyphens in words, names, dates and exponents stay."""
    return _SIGN.sub("−", text)


def per_kelvin(value: float) -> str:
    """A relative slope [1/K]: 4.1 % per K."""
    return write_minus(f"{100 * value:.2g} % per K")


def number(value: float, unit_text: str, digits: int = 4, sign: bool = False) -> str:
    """A value to so many digits, with its unit; 0 for what is nothing but rounding."""
    if not math.isfinite(value):
        return "no value"
    plus = "+" if sign else ""
    text = f"{value:{plus}#.{digits}g}".rstrip(".") if abs(value) < 10**digits else f"{value:{plus}.0f}"
    return f"{text if abs(value) > 1e-9 else '0'} {pretty(unit_text)}".replace("-", "−").replace(" –", "")
