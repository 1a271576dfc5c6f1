"""Numbers with units: `28 W/K ± 30 %` ↔ a value with a prior. At the rim only; inside everything is SI and °C."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

from network.platform.quantities.unit_names import LONGEST, BadNumber, Unit, difference, unit
from network.platform.quantities.unit_table import likely_unit
from network.platform.refusal import short

__all__ = [
    "BadNumber",
    "Number",
    "Prior",
    "Unit",
    "difference",
    "format_exactly",
    "in_unit",
    "one_space",
    "parse_number",
    "show",
    "split_number",
    "spread_parts",
    "unit",
]  # fmt: skip

Prior = Literal["known", "log", "normal", "unknown"]


@dataclass(frozen=True)
class Number:
    """A number of a file in SI (temperatures in °C) with its prior.

    prior: known (never touched), log (normal in the logarithm, σ = spread), normal (σ = spread), unknown (log-uniform
    or uniform over low..high; `value` is the start of a calibration, not something to simulate with); unit: the one it
    was given in, where its field takes several.
    """

    value: float
    prior: Prior = "known"
    spread: float = 0.0
    low: float = -math.inf
    high: float = math.inf
    unit: str = ""


NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_QUANTITY = re.compile(rf"^({NUMBER})\s*(.*)$")
_RANGE = re.compile(rf"^({NUMBER})\s*\.\.\s*({NUMBER})\s*(.*)$")
_PLUS_MINUS = re.compile(r"\s*(?:±|\+/-|\+-)\s*")


def split_number(text: str, wanted: str = "W/K") -> tuple[float, str]:
    """'28 W/K' → (28.0, 'W/K'). Raises BadNumber where there is no finite number in front; `wanted` is for its hint."""
    match = _QUANTITY.match(one_space(text))
    if not match or match[2][:1] in tuple(".:_;'"):
        hint = "write a bare number, like `0.5`" if wanted == "1" else f"write it with its unit, like `5 {wanted}`"
        raise BadNumber(f"'{short(text)}' is not a number", hint)
    if match[2][:1] == ",":
        raise BadNumber(f"'{short(text)}' has a comma in it", "write the decimals with a point, like `0.5`")
    if re.match(r"[+-]?0[0-9]", match[1]):
        plain = re.sub("0+(?=[0-9])", "", match[1], count=1)
        raise BadNumber(f"'{short(text)}' starts with a zero", f"write `{short(f'{plain} {match[2]}')}`")
    value = float(match[1])
    if not math.isfinite(value):
        raise BadNumber(f"'{short(text)}' is not finite", "write a finite number")
    return value, match[2]


def in_unit(text: str, wanted: str) -> float:
    """'580 mm' wanted in 'm' → 0.58 in SI. `wanted` 'degC' means an absolute temperature, 'K' a difference."""
    number, unit_text = split_number(text, wanted)
    target = unit(wanted)
    if unit_text == "" and target.dimension != "dimensionless":
        raise _no_unit(text, wanted)
    given = _check_unit(text, unit_text, wanted)
    if given.dimension != target.dimension:
        if wanted == "1":
            raise BadNumber(f"'{short(text)}' has a unit", "a bare number is needed")
        raise BadNumber(f"'{short(text)}' is in {short(unit_text)}", f"a unit like {wanted} is needed")
    return (difference(given) if wanted == "K" else given).to_si(number)


def _no_unit(text: str, wanted: str) -> BadNumber:
    read = short(text)
    return BadNumber(f"'{read}' has no unit", f"a unit like {wanted} is needed, as in `{read} {wanted}`")


def _check_unit(text: str, unit_text: str, wanted: str) -> Unit:
    try:
        return unit(unit_text)
    except BadNumber as error:
        meant = likely_unit(unit_text[:LONGEST])
        right = f"did you mean '{meant}'?" if meant else f"a unit like {wanted} is needed"
        raise BadNumber(f"'{short(text)}' has an {error.wrong}", right) from None


@lru_cache(maxsize=4096)
def parse_number(text: str, wanted: str, may_be_negative: bool, bounds: tuple[float, float]) -> Number:
    """One number of a file: `v unit`, `v unit ± p %`, `v unit ± u unit`, `unknown`, `unknown 1..50 W/K`.

    bounds: in SI, for an `unknown` without a range. A quantity that may be negative has a prior in itself, others in
    their logarithm.
    """
    text = one_space(text)
    if text.startswith("unknown"):
        return _parse_unknown(text, wanted, may_be_negative, bounds)
    centre, *rest = spread_parts(text)
    if len(rest) > 1:
        raise BadNumber(f"'{short(text)}' has more than one ±", f"write `value {wanted} ± spread`")
    if rest and _is_bare(centre) and not _is_bare(rest[0]) and not rest[0].endswith("%"):
        right = f"write `{centre} {split_number(rest[0])[1]} ± {rest[0]}`"
        raise BadNumber(f"'{short(text)}' has its unit behind the spread only", right)
    value = in_unit(centre, wanted)
    return _with_spread(text, value, rest[0], wanted, may_be_negative) if rest else Number(value)


def spread_parts(text: str) -> list[str]:
    """What stands before and behind every ±."""
    return _PLUS_MINUS.split(one_space(text))


def has_spread(text: str) -> bool:
    """Whether there is a ± in it."""
    return _PLUS_MINUS.search(one_space(text)) is not None


def one_space(text: str) -> str:
    """One space wherever there are some, so that no pattern has to try them all."""
    return " ".join(text.split())


def _is_bare(text: str) -> bool:
    return re.fullmatch(NUMBER, text) is not None


def _with_spread(text: str, value: float, spread: str, wanted: str, may_be_negative: bool) -> Number:
    absolute = _spread(text, value, spread, wanted)
    if not absolute > 0:
        raise BadNumber(f"'{short(text)}' has a spread that is not above zero", "drop the ± for a known number")
    if may_be_negative:
        return Number(value, "normal", absolute)
    if value == 0:
        raise BadNumber(f"'{short(text)}' is zero with a spread", "give a value above zero, or drop the ±")
    return Number(value, "log", absolute / abs(value))


def _spread(text: str, value: float, spread: str, wanted: str) -> float:
    """What stands behind ±, in SI."""
    read, scale = short(text), "K" if wanted == "degC" else wanted
    if not spread:
        raise BadNumber(f"'{read}' has nothing behind the ±", "write the spread, as in ± 30 %")
    number, unit_text = split_number(spread, scale)
    if unit_text == "" and wanted != "1":
        either = f"`± {spread} {scale}`" if wanted == "degC" else f"`± {spread} %` or `± {spread} {scale}`"
        raise BadNumber(f"'{read}' has a spread without unit", f"write {either}")
    if unit_text != "%":
        return in_unit(spread, scale)
    if wanted == "degC":
        raise BadNumber(f"'{read}' has a spread that is a share of a temperature", "write it in K, as in ± 2 K")
    if value == 0 and number != 0:
        raise BadNumber(f"'{read}' has a spread that is a share of zero", "write it with its unit, or drop the ±")
    return abs(value) * number / 100


def _parse_unknown(text: str, wanted: str, may_be_negative: bool, bounds: tuple[float, float]) -> Number:
    low, high = _unknown_range(text, wanted) if text != "unknown" else bounds
    if not low < high:
        raise BadNumber(f"'{short(text)}' has its bounds the wrong way round", "write the lower one first")
    if may_be_negative:
        return Number((low + high) / 2, "unknown", 0.0, low, high)
    low = low or high * 1e-6
    return Number(math.sqrt(max(low, 0.0) * high), "unknown", 0.0, low, high)


def _unknown_range(text: str, wanted: str) -> tuple[float, float]:
    match = _RANGE.match(text.removeprefix("unknown").strip())
    if not match:
        raise BadNumber(f"'{short(text)}' is not a range", f"write `unknown 1..50 {wanted}`, or `unknown` alone")
    if not match[3] and wanted != "1":
        raise _no_unit(text, wanted)
    return in_unit(f"{match[1]} {match[3]}", wanted), in_unit(f"{match[2]} {match[3]}", wanted)


def show(value: float, unit_text: str, digits: int = 4) -> str:
    """A value inside (SI, °C) as text in the given unit: show(0.58, 'mm') → '580 mm'. 'K' is a difference.

    With 16 digits or more it reads back as the same value.
    """
    if digits >= 16:
        return format_exactly(value, unit_text)
    return _with_unit(f"{unit_of_output(unit_text).from_si(value):.{digits}g}", unit_text)


def format_exactly(value: float, unit_text: str) -> str:
    """A value as text in the given unit, with as many digits as it takes to read back as the same value."""
    given = unit_of_output(unit_text)
    number = given.from_si(value)
    rounded = (float(f"{number:.{digits}g}") for digits in range(4, 17))
    exact = next((short for short in rounded if given.to_si(short) == value), number)
    return _with_unit(repr(float(exact)).removesuffix(".0"), unit_text)


def _with_unit(number: str, unit_text: str) -> str:
    return number if unit_text in ("", "1") else f"{number} {unit_text}"


def unit_of_output(unit_text: str) -> Unit:
    """The unit that a value inside is written in; K is one of differences."""
    return difference(unit(unit_text)) if unit_text == "K" else unit(unit_text)
