"""Numbers of a channel in words: a difference in its unit, a level of an input."""

from __future__ import annotations

from network.platform.quantities.number_format import number, pretty
from network.platform.quantities.text_table import digits
from network.platform.quantities.units import difference, unit


def amount(value: float, unit_text: str, most: int = 3) -> str:
    """A difference, given in SI: 0.41 K, 6.0 µm."""
    given = unit(unit_text)
    return f"{digits(abs(to_unit(value, unit_text)), most)} {'K' if given.is_temperature else pretty(unit_text)}"


def to_unit(value: float, unit_text: str) -> float:
    """A difference, given in SI, in the unit of the channel."""
    return value / difference(unit(unit_text)).scale


def level_words(value: float, unit_text: str) -> str:
    """A level of an input, given in SI: at 8000 rpm, at standstill."""
    given = unit("rpm") if unit(unit_text).dimension == unit("rpm").dimension else unit(unit_text)
    if value == 0 and given.text == "rpm":
        return "at standstill"
    return "at " + number(given.from_si(value), given.text)
