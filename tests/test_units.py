"""Numbers with units: every way of writing them, what is refused, and that what is written reads back the same."""

from __future__ import annotations

import math

import pint
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from network.catalogue.declaration.discovery import kinds
from network.catalogue.declaration.number_fields import ParamField
from network.platform.quantities.number_format import format_amount, per_kelvin
from network.platform.quantities.units import (
    BadNumber,
    Number,
    difference,
    format_exactly,
    in_unit,
    parse_number,
    show,
    unit,
)
from network.platform.refusal import Spot
from network.platform.yaml.tree import Leaf

BOUNDS = (0.0, 1e6)
SPOT = Spot("test")
OTHERS = pint.UnitRegistry()


def read(text: str, wanted: str, negative: bool = False, bounds: tuple[float, float] = BOUNDS) -> Number:
    return parse_number(text, wanted, negative, bounds)


def refused(text: str, wanted: str, negative: bool = False) -> str:
    with pytest.raises(BadNumber) as caught:
        read(text, wanted, negative)
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "wanted", "value"),
    [
        ("520 N mm", "N m", 0.52),
        ("0.52 N m", "N m", 0.52),
        ("520 N·mm", "N m", 0.52),
        ("520 Nmm", "N m", 0.52),
        ("1.2 kJ/K", "J/K", 1200),
        ("7.85 g/cm^3", "kg/m^3", 7850),
        ("7.85 g/cm3", "kg/m^3", 7850),
        ("7.85 kg/dm³", "kg/m^3", 7850),
        ("185 cm^2", "m^2", 0.0185),
        ("80 %", "1", 0.8),
        ("0.25 um", "m", 0.25e-6),
        ("0.25 µm", "m", 0.25e-6),
        ("0.25 μm", "m", 0.25e-6),  # the Greek letter, not the micro sign
        ("10.8 um/(m K)", "1/K", 10.8e-6),
        ("10.8e-6 1/K", "1/K", 10.8e-6),
        ("10.8e-6 K⁻¹", "1/K", 10.8e-6),
        ("10.8 ppm/K", "1/K", 10.8e-6),
        ("5 W/(m^2 K)", "W/(m^2 K)", 5),
        ("5 W/(m²·K)", "W/(m^2 K)", 5),
        ("5 W m⁻² K⁻¹", "W/(m^2 K)", 5),
        ("5 W/(m**2*K)", "W/(m^2 K)", 5),
        ("5 W/m^2/K", "W/(m^2 K)", 5),
        ("5 W/(m^2 °C)", "W/(m^2 K)", 5),
        ("500 J/(kg K)", "J/(kg K)", 500),
        ("8000 rpm", "rpm", 8000 * 2 * math.pi / 60),
        ("8000 rev/min", "rpm", 8000 * 2 * math.pi / 60),
        ("50 Hz", "rpm", 100 * math.pi),
        ("15 m/min", "m/min", 0.25),
        ("12 W/(m/min)", "W/(m/s)", 720),
        ("30 min", "s", 1800),
        ("2 h", "s", 7200),
        ("5 arcsec", "rad", math.radians(5 / 3600)),
        ("3 l/min", "m^3/s", 5e-5),
        ("1e3 W/K", "W/K", 1000),
        ("5W/K", "W/K", 5),
        ("+.5 W/K", "W/K", 0.5),
    ],
)
def test_a_number_with_its_unit(text: str, wanted: str, value: float) -> None:
    assert read(text, wanted) == Number(pytest.approx(value, rel=1e-15))


@pytest.mark.parametrize(
    ("text", "celsius"),
    [("22 degC", 22), ("22 °C", 22), ("22 ℃", 22), ("71.6 degF", 22), ("295 K", 21.85), ("295000 mK", 21.85)],
)
def test_a_temperature_is_read_in_degrees_celsius(text: str, celsius: float) -> None:
    assert in_unit(text, "degC") == pytest.approx(celsius, abs=1e-12)


@pytest.mark.parametrize(("text", "kelvin"), [("2 K", 2), ("2 degC", 2), ("3.6 degF", 2), ("50 mK", 0.05)])
def test_a_difference_has_no_zero_of_its_own(text: str, kelvin: float) -> None:
    assert in_unit(text, "K") == pytest.approx(kelvin, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("28 W/K ± 30 %", Number(28, "log", 0.3)),
        ("28 W/K±30%", Number(28, "log", 0.3)),
        ("28 W/K +/- 30 %", Number(28, "log", 0.3)),
        ("28 W/K ± 7 W/K", Number(28, "log", 0.25)),
        ("28 W/K ± 7000 mW/K", Number(28, "log", 0.25)),
        ("unknown", Number(1e3, "unknown", 0, 1, 1e6)),
        ("unknown 4..25 W/K", Number(10, "unknown", 0, 4, 25)),
        ("unknown 4 .. 25 W/K", Number(10, "unknown", 0, 4, 25)),
        ("unknown 0..25 W/K", Number(0.025, "unknown", 0, 2.5e-5, 25)),
    ],
)
def test_what_is_uncertain(text: str, number: Number) -> None:
    got = read(text, "W/K")
    assert got.prior == number.prior
    assert (got.value, got.spread) == pytest.approx((number.value, number.spread), rel=1e-12)
    if got.prior == "unknown":
        assert (got.low, got.high) == pytest.approx((number.low, number.high), rel=1e-12)


@pytest.mark.parametrize(
    ("text", "wanted", "number"),
    [
        ("0.03 1/K ± 20 %", "1/K", Number(0.03, "normal", 0.006)),
        ("-0.01 1/K ± 0.02 1/K", "1/K", Number(-0.01, "normal", 0.02)),
        ("0 W ± 5 W", "W", Number(0, "normal", 5)),
        ("22 degC ± 2 K", "degC", Number(22, "normal", 2)),
        ("295 K ± 0.9 degF", "degC", Number(21.85, "normal", 0.5)),
        ("unknown -2..4 K", "K", Number(1, "unknown", 0, -2, 4)),
    ],
)
def test_what_may_be_negative_is_uncertain_in_itself(text: str, wanted: str, number: Number) -> None:
    got = read(text, wanted, negative=True, bounds=(-10, 10))
    assert got.prior == number.prior
    assert (got.value, got.spread) == pytest.approx((number.value, number.spread), rel=1e-12)


@pytest.mark.parametrize(
    ("text", "wanted", "message"),
    [
        ("5", "W/K", "'5' has no unit; a unit like W/K is needed, as in `5 W/K`"),
        ("5 W", "W/K", "'5 W' is in W; a unit like W/K is needed"),
        ("8000 1/min", "rpm", "'8000 1/min' is in 1/min; a unit like rpm is needed"),
        ("8000 1/s", "rpm", "'8000 1/s' is in 1/s; a unit like rpm is needed"),
        ("5 rmp", "rpm", "'5 rmp' has an unknown unit 'rmp'; did you mean 'rpm'?"),
        ("5 W/C", "W/K", "'5 W/C' has an unknown unit 'C'; did you mean 'degC'?"),
        ("5 KW", "W", "'5 KW' has an unknown unit 'KW'; did you mean 'kW'?"),
        ("5 furlong", "m", "'5 furlong' has an unknown unit 'furlong'; a unit like m is needed"),
        ("5 m;m", "m", "'5 m;m' has an unreadable unit 'm;m'; a unit like m is needed"),
        ("5 W/", "W/K", "'5 W/' has an unreadable unit 'W/'; a unit like W/K is needed"),
        ("5 m^x", "m", "'5 m^x' has an unknown unit 'x'; a unit like m is needed"),
        ("5 m^99", "m", "'5 m^99' has an unreadable unit 'm^99'; a unit like m is needed"),
        ("5 cd", "s", "'5 cd' has an unknown unit 'cd'; a unit like s is needed"),
        ("5 m**9**9**9", "m", "'5 m**9**9**9' has an unreadable unit 'm**9**9**9'; a unit like m is needed"),
        ("30 ± 3 W/K", "W/K", "'30 ± 3 W/K' has its unit behind the spread only; write `30 W/K ± 3 W/K`"),
        ("5 (m", "m", "'5 (m' has an unreadable unit '(m'; a unit like m is needed"),
        ("0.5 mm", "1", "'0.5 mm' has a unit; a bare number is needed"),
        ("a", "1", "'a' is not a number; write a bare number, like `0.5`"),
        (
            "22 degC ± 5 %",
            "degC",
            "'22 degC ± 5 %' has a spread that is a share of a temperature; write it in K, as in ± 2 K",
        ),
        ("22 degC ± 5", "degC", "'22 degC ± 5' has a spread without unit; write `± 5 K`"),
        ("5 W/K ± 3 kg", "W/K", "'3 kg' is in kg; a unit like W/K is needed"),
        ("5 W/K ± 0 W/K", "W/K", "'5 W/K ± 0 W/K' has a spread that is not above zero; drop the ± for a known number"),
        ("0 W/K ± 1 W/K", "W/K", "'0 W/K ± 1 W/K' is zero with a spread; give a value above zero, or drop the ±"),
        ("unknown 5..5 W/K", "W/K", "'unknown 5..5 W/K' has its bounds the wrong way round; write the lower one first"),
        ("1_000 W/K", "W/K", "'1_000 W/K' is not a number; write it with its unit, like `5 W/K`"),
        ("٣ W/K", "W/K", "'٣ W/K' is not a number; write it with its unit, like `5 W/K`"),
        ("1.2.3 W/K", "W/K", "'1.2.3 W/K' is not a number; write it with its unit, like `5 W/K`"),
        ("-007 W/K", "W/K", "'-007 W/K' starts with a zero; write `-7 W/K`"),
    ],
)
def test_refused_numbers(text: str, wanted: str, message: str) -> None:
    assert refused(text, wanted) == message


def test_long_texts_are_cut_and_quick() -> None:
    assert len(refused("5 " + "(" * 100_000, "W/K")) < 200
    assert len(refused("9" * 100_000, "W/K")) < 200


@pytest.mark.parametrize("unit_text", ["W/(m^2 K^1.25)", "W/(m^2 K^1.33)", "W/(m² K^(1.33))", "mW/(mm^2 K^1.25)"])
def test_coefficients_of_natural_convection_come_per_any_power_of_kelvin(unit_text: str) -> None:
    field = kinds("links")["natural_convection"].params()["coefficient"]
    scale = unit(unit_text).scale
    assert field.parse(Leaf(f"0.0015 {unit_text}", SPOT)).value == pytest.approx(0.0015 * scale)
    assert field.parse(Leaf(f"0.0015 {unit_text} ± 20 %", SPOT)).spread == pytest.approx(0.2)
    assert field.parse(Leaf(f"unknown 0.001..0.004 {unit_text}", SPOT)).value == pytest.approx(0.002 * scale)


@pytest.mark.parametrize("text", ["1.5 W/m^2", "1.5 W/K^1.25", "1.5"])
def test_other_units_of_that_coefficient_are_refused(text: str) -> None:
    field = kinds("links")["natural_convection"].params()["coefficient"]
    with pytest.raises(BadNumber, match=r"a unit like W/\(m\^2 K\^1.25\) is needed"):
        field.parse(Leaf(text, SPOT))


COMPARED = (
    *("m", "mm", "um", "nm", "km", "cm", "dm", "inch", "g", "kg", "mg", "s", "ms", "min", "h", "day", "K", "W", "kW"),
    *("mW", "MW", "J", "kJ", "MJ", "Wh", "kWh", "N", "kN", "Pa", "MPa", "bar", "mbar", "l", "ml", "V", "mV", "A"),
    "ohm",
    *("m/min", "mm/s", "W/K", "W/(m^2*K)", "J/(kg*K)", "N*m", "N*mm", "g/cm^3", "1/K", "um/(m*K)", "W/(m*K)", "l/min"),
    *("kJ/K", "N/mm^2", "m^2/s", "W*s", "m^3", "kg/m^3"),
)


@pytest.mark.parametrize("text", COMPARED)
def test_factors_agree_with_pints_own_table(text: str) -> None:
    theirs = OTHERS.Quantity(1.0, text).to_base_units()
    assert unit(text).scale == pytest.approx(theirs.magnitude, rel=1e-14)


def test_turns_agree_with_pints_own_table() -> None:
    for ours, theirs in (("rpm", "rpm"), ("deg", "degree"), ("arcsec", "arcsecond"), ("rev/min", "rpm")):
        factor = OTHERS.Quantity(1.0, theirs).to_base_units().magnitude
        assert unit(ours).scale == pytest.approx(factor, rel=1e-14)


@pytest.mark.parametrize(
    ("one", "other"),
    [("N m", "J"), ("W", "kg m^2/s^3"), ("W/(m K)", "K^-1 m^-1 W"), ("Pa", "N/m^2"), ("%", "1"), ("ohm", "W/A^2")],
)
def test_a_dimension_has_one_spelling(one: str, other: str) -> None:
    assert unit(one).dimension == unit(other).dimension


def test_a_speed_is_not_a_rate() -> None:
    assert unit("rpm").dimension != unit("1/min").dimension
    assert unit("Hz").dimension == unit("rpm").dimension


def test_exact_where_decimals_are() -> None:
    assert in_unit("700 N mm", "N m") == 0.7
    assert in_unit("580 mm", "m") == 0.58
    assert unit("g/cm^3").scale == 1000.0


UNITS = st.sampled_from(["W/K", "kJ/K", "Nmm", "rpm", "um", "mm", "1/K", "degC", "degF", "K", "1", "g/cm^3", "%"])
NUMBERS = st.floats(-1e9, 1e9, allow_nan=False).filter(lambda x: x == 0 or abs(x) > 1e-12)


@given(NUMBERS, UNITS)
def test_a_value_written_reads_back_the_same(number: float, text: str) -> None:
    value = (difference(unit(text)) if text == "K" else unit(text)).to_si(number)
    again = in_unit(format_exactly(value, text), text)
    assert again == pytest.approx(value, rel=4e-16, abs=1e-13)
    assert len(format_exactly(value, text)) <= len(repr(number)) + 20
    assert in_unit(show(value, text), text) == pytest.approx(value, rel=1e-3, abs=0.15 if text == "degC" else 1e-13)


def numbers(field: ParamField) -> st.SearchStrategy[Number]:
    """Every kind of number that a field could hold, inside its bounds."""
    inside = st.floats(max(field.low, 1e-6), field.high, exclude_min=True).map(lambda x: float(f"{x:.6g}"))
    spread = st.floats(0.01, 3)
    negative = field.may_be_negative
    known, both = inside.map(Number), st.tuples(inside, inside).filter(lambda ends: ends[0] < ends[1])
    uncertain = st.tuples(inside, spread).map(lambda n: Number(n[0], "normal" if negative else "log", n[1]))
    middle = (lambda low, high: (low + high) / 2) if negative else (lambda low, high: math.sqrt(low * high))
    return known | uncertain | both.map(lambda ends: Number(middle(*ends), "unknown", 0.0, *ends))


FIELDS = {
    f"{kind}.{name}": field
    for section in ("links", "sources", "tcp", "effects")
    for kind, cls in kinds(section).items()
    for name, field in cls.params().items()
}


@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.data())
@pytest.mark.parametrize("name", FIELDS)
def test_a_parameter_written_reads_back_the_same(name: str, data: st.DataObject) -> None:
    field = FIELDS[name]
    number = data.draw(numbers(field))
    again = field.parse(Leaf(str(field.write(number)), SPOT))
    assert again.prior == number.prior
    for one, other in zip(vars(again).values(), vars(number).values(), strict=True):
        assert one == other or one == pytest.approx(other, rel=1e-10, abs=1e-13)


@pytest.mark.parametrize(("value", "unit_text", "told"), [
    (5.5691, "W/K", "5.57 W/K"), (1000 * 2 * math.pi / 6, "rpm", "10\u00a0000 rpm"), (21.618, "degC", "21.62 °C"),
    (-0.00012, "1/K", "−0.00012 1/K"), (0.0, "W", "0 W"), (562.7, "s", "563 s"), (207908.0, "J/K", "207\u00a0900 J/K"),
])  # fmt: skip
def test_a_number_of_a_sentence_is_short(value: float, unit_text: str, told: str) -> None:
    assert format_amount(value, unit_text) == told


def test_a_relative_slope_is_told_in_percent() -> None:
    assert (per_kelvin(0.0408), per_kelvin(-0.012)) == ("4.1 % per K", "−1.2 % per K")
