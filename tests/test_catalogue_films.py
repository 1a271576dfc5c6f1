"""Film coefficients against worked examples and tables of textbooks."""

from __future__ import annotations

import numpy as np
import pytest
from catalogue import machine

from network.catalogue import convection_correlations, fluids
from network.platform.refusal import Refused

AIR = np.array(0.71)


def test_churchill_and_chu_at_a_textbook_point() -> None:
    """Bergman et al., Introduction to Heat Transfer, example 9.2: Pr 0.69, Gr 2.63e9, vertical plate: Nu 147."""
    Ra, Pr = np.array(0.69 * 2.63e9), np.array(0.69)
    films = convection_correlations.FILMS
    assert float(films["vertical_plate"].nusselt(Ra, Pr)) == pytest.approx(147.16185, rel=1e-7)
    assert float(films["horizontal_cylinder"].nusselt(Ra, Pr)) == pytest.approx(139.13494, rel=1e-7)


def test_films_of_whole_examples() -> None:
    """The same example from its temperatures: a 0.71 m screen at 232 °C in air of 23 °C, h = 7.0 W/(m² K); and the
    point of a cylinder worked with tabulated air: 60 mm at 70 °C in 30 °C, Pr 0.7228, ν 1.798e-5, k 0.02735 (tables of
    the conductivity of air differ by 3 %)."""
    assert coefficient("vertical_plate", 232, 23, 0.71) == pytest.approx(7.0, rel=0.03)
    Ra = 9.81 / 323.15 * 40 * 0.06**3 / 1.798e-5**2 * 0.7228
    Nu = (0.60 + 0.387 * Ra ** (1 / 6) / (1 + (0.559 / 0.7228) ** (9 / 16)) ** (8 / 27)) ** 2
    assert coefficient("horizontal_cylinder", 70, 30, 0.06) == pytest.approx(Nu * 0.02735 / 0.06, rel=0.03)


def coefficient(geometry: str, T_a: float, T_b: float, length: float) -> float:
    T = (np.array(float(T_a)), np.array(float(T_b)))
    return float(convection_correlations.coefficient(geometry, *T, np.array(length)))


def test_air_agrees_with_tables() -> None:
    """Bergman et al. table A.4 at 300 K and 350 K; its density is that of 1 bar, ours of 1 atm: 1.3 % in viscosity."""
    for T, k, nu in ((300, 26.3e-3, 15.89e-6), (350, 30.0e-3, 20.92e-6)):
        air, at = fluids.FLUIDS["air"], np.array(T - 273.15)
        assert float(air.conductivity(at)) == pytest.approx(k, rel=0.01)
        assert float(air.viscosity(at)) * fluids.PRESSURE / 1e5 == pytest.approx(nu, rel=0.005)


def test_horizontal_plates() -> None:
    """McAdams: 0.54 Ra^¼ and 0.15 Ra^⅓ facing up, 0.27 Ra^¼ facing down; the other way round if colder than the air."""
    up, down = convection_correlations.FILMS["plate_facing_up"], convection_correlations.FILMS["plate_facing_down"]
    assert float(up.nusselt(np.array(1e6), AIR)) == pytest.approx(0.54 * 1e6**0.25)
    assert float(up.nusselt(np.array(1e9), AIR)) == pytest.approx(150)
    assert float(down.nusselt(np.array(1e8), AIR)) == pytest.approx(27)
    assert coefficient("plate_facing_up", 20, 40, 0.2) == pytest.approx(coefficient("plate_facing_down", 40, 20, 0.2))
    assert coefficient("plate_facing_down", 20, 40, 0.2) == pytest.approx(coefficient("plate_facing_up", 40, 20, 0.2))


def test_the_power_law_for_air_lies_near_the_correlation() -> None:
    for dT in (5.0, 10.0, 20.0, 40.0):
        assert 0.8 < 1.42 * (dT / 0.5) ** 0.25 / coefficient("vertical_plate", 20 + dT, 20, 0.5) < 1
        assert 0.9 < 1.31 * dT ** (1 / 3) / coefficient("vertical_plate", 20 + dT, 20, 2.0) < 1


def test_a_correlation_outside_its_range_is_doubted() -> None:
    body = {"kind": "convection", "between": ["shaft", "air"], "geometry": "plate_facing_down", "length": "5 mm"}
    doubtful = machine().patched({"links": {"it": {**body, "area": "1 m^2"}}})
    assert any("outside the correlation" in str(warning) for warning in doubtful.warnings)


def film(**body: str) -> tuple[float, list[str]]:
    """Heat of 1 m² at 40 °C in 20 °C, and what is doubted."""
    it = {"kind": "convection", "between": ["shaft", "air"], "length": "0.4 m", "area": "1 m^2", **body}
    found = machine().patched({"links": {"it": it}})
    T = np.array(40.0), np.array(20.0)
    return float(found.links["it"].heat_flow(*T, {})), [str(w) for w in found.warnings if "links.it" in str(w)]


def test_shape_and_orientation_say_what_one_word_says() -> None:
    for shape, way, word in (
        ("plate", "vertical", "vertical_plate"), ("plate", "up", "plate_facing_up"),
        ("plate", "down", "plate_facing_down"),
        ("cylinder", "horizontal", "horizontal_cylinder"), ("cylinder", "vertical", "vertical_plate"),
    ):  # fmt: skip
        assert film(geometry=shape, orientation=way)[0] == film(geometry=word)[0]


@pytest.mark.parametrize(
    ("body", "wrong"),
    [
        ({"geometry": "plate"}, "does not say how the plate lies; give `orientation: vertical` or `up` or `down`"),
        ({"geometry": "cylinder", "orientation": "up"}, "does not say how the cylinder lies"),
        ({"geometry": "vertical_plate", "orientation": "up"}, "says nothing without a plate or a cylinder"),
    ],
)
def test_half_an_orientation_is_refused(body: dict[str, str], wrong: str) -> None:
    with pytest.raises(Refused, match=wrong):
        film(**body)


def test_water_carries_more_than_oil_and_oil_more_than_air() -> None:
    """Still water around a vertical plate of 0.4 m, 20 K: Ra = g β ΔT L³ Pr/ν² with tabulated water at 30 °C (β
    3.03e-4, ν 0.801e-6, Pr 5.42, k 0.615)."""
    Ra = 9.81 * 3.03e-4 * 20 * 0.4**3 / 0.801e-6**2 * 5.42
    Nu = (0.825 + 0.387 * Ra ** (1 / 6) / (1 + (0.492 / 5.42) ** (9 / 16)) ** (8 / 27)) ** 2
    water, oil, air = (film(geometry="vertical_plate", fluid=name)[0] for name in ("water", "oil_vg_32", "air"))
    assert water == pytest.approx(Nu * 0.615 / 0.4 * 20, rel=0.03)
    assert water > 5 * oil > 10 * air
