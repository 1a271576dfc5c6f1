"""Numbers that can be worked out by hand, entry by entry."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from catalogue import entry_in, machine, patch_of

from network.catalogue import convection_correlations
from network.catalogue.declaration.declare import Effect
from network.catalogue.declaration.discovery import kinds
from network.catalogue.mechanisms.bearing_friction import LEAST
from network.platform.refusal import Refused

RPM = 2 * math.pi / 60
REFERENCE = 22.0


def entry(section: str, kind: str, axis: str = "z", **body: Any) -> Any:
    """One entry on the machine of the tests (reference 22 °C)."""
    cls: type[Effect] = kinds(section)[kind]
    if section == "sources":
        body = {"into": {"shaft": 1}, **body}
    if section == "links":
        body = {"between": ["shaft", "air"], **body}
    body = {key.rstrip("_"): value for key, value in body.items()}
    return entry_in(cls, machine().patched(patch_of(cls, {"kind": kind, **body}, axis)), axis)


def at(rpm: float = 0.0, time: float = 0.0, feed: float = 0.0, cutting_power: float = 0.0) -> dict[str, Any]:
    """Inputs: speed in rpm, feed in m/min."""
    values = {"speed": rpm * RPM, "time": time, "feed": feed / 60, "cutting_power": cutting_power}
    return {name: np.array(value) for name, value in values.items()}


def flow(link: Any, T_a: float, T_b: float, rpm: float = 0.0) -> float:
    return float(link.heat_flow(np.array(T_a), np.array(T_b), at(rpm)))


def heat(source: Any, u: dict[str, Any], *T: float) -> float:
    return float(source.heat(u, *map(np.array, T)))


def moves(expansion: Any, *readings: float, rpm: float = 0.0) -> float:
    """In µm or µrad."""
    return 1e6 * float(expansion.movement(at(rpm), *map(np.array, readings)))


def test_conduction() -> None:
    joint = entry("links", "conduction", between=["shaft", "housing"], conductance="28 W/K")
    assert flow(joint, 25, 22) == pytest.approx(84)


def test_contact_closes_as_it_warms_and_never_pumps() -> None:
    joint = entry("links", "contact", between=["shaft", "housing"], conductance="40 W/K", slope="0.01 1/K")
    assert flow(joint, 42, 22) == pytest.approx(40 * 1.1 * 20)  # mean 32 °C: 10 K above the reference
    assert flow(joint, 22, 42) == pytest.approx(-40 * 1.1 * 20)
    assert flow(joint, -100, -120) == 0  # 132 K below: the joint is open
    opens = entry("links", "contact", between=["shaft", "housing"], conductance="40 W/K", slope="-0.05 1/K")
    assert flow(opens, 34, 30) == pytest.approx(40 * 0.5 * 4)
    assert flow(opens, 60, 50) == 0


def test_convection_in_its_three_forms() -> None:
    assert flow(entry("links", "convection", conductance="5 W/K"), 30, 20) == pytest.approx(50)
    assert flow(entry("links", "convection", coefficient="8 W/(m^2 K)", area="0.5 m^2"), 30, 20) == pytest.approx(40)
    wall = entry("links", "convection", geometry="vertical_plate", length="500 mm", area="2 m^2")
    h = float(convection_correlations.coefficient("vertical_plate", np.array(30.0), np.array(20.0), np.array(0.5)))
    assert flow(wall, 30, 20) == pytest.approx(h * 2 * 10)
    assert 3 < h < 4


def test_natural_convection() -> None:
    body = {"coefficient": "1.8 W/(m^2 K^1.25)", "area": "0.6 m^2"}
    assert flow(entry("links", "natural_convection", **body), 38, 22) == pytest.approx(1.8 * 0.6 * 2 * 16)  # 16^¼ = 2
    third = {"coefficient": "1.31 W/(m^2 K^1.33)", "area": "1 m^2", "exponent": "0.33"}
    assert flow(entry("links", "natural_convection", **third), 22, 30) == pytest.approx(-1.31 * 8**1.33)


def test_forced_convection() -> None:
    body = {"conductance": "4 W/K", "gain": "3", "exponent": "0.5", "reference_speed": "10000 rpm"}
    fan = entry("links", "forced_convection", **body)
    assert flow(fan, 32, 22) == pytest.approx(40)
    assert flow(fan, 32, 22, rpm=10_000) == pytest.approx(160)
    assert flow(fan, 32, 22, rpm=-2500) == pytest.approx(40 * (1 + 3 * 0.5))


def test_radiation() -> None:
    black = entry("links", "radiation", emissivity_area="1 m^2")
    assert flow(black, 26.85, -273.15) == pytest.approx(5.670374419e-8 * 300**4)  # 459.3 W/m²
    assert flow(black, 20.5, 19.5) == pytest.approx(4 * 5.670374419e-8 * 293.15**3, rel=1e-5)  # 5.71 W/(m² K)


def test_advection() -> None:
    stream = machine("coolant").links["stream"]
    assert float(stream.heat_flow(np.array(20.0), np.array(25.0), at())) == -1000


def test_bearing_friction_in_both_units() -> None:
    """The method's q = 1.047e-4 n M holds with M in N mm: 520 N mm at 6000 rpm are 326.7 W; 0.1047 n M with N m."""
    small, large = (entry("sources", "bearing_friction", torque=text) for text in ("520 N mm", "0.52 N m"))
    assert heat(small, at(6000)) == pytest.approx(1.047e-4 * 6000 * 520, rel=2e-4)
    assert heat(large, at(6000)) == pytest.approx(0.1047 * 6000 * 0.52, rel=2e-4)
    assert heat(small, at(6000)) == pytest.approx(heat(large, at(6000)), rel=1e-15)
    assert heat(small, at(6000)) == pytest.approx(2 * math.pi / 60 * 6000 * 0.52, rel=1e-15)


def test_bearing_friction_after_palmgren() -> None:
    """f₀ 2, 20 mm²/s, d_m 80 mm: at 6000 rpm M₀ = 1e-7 · 2 · 120000^(2/3) · 80³ = 249.1 N mm; below ν n = 2024 it is
    16.38 N mm, and 0.8 % of a step remain between that and the published branch at ν n = 2000."""
    body = {"lubrication_factor": "2", "viscosity": "20 mm^2/s", "mean_diameter": "80 mm"}
    bearing = entry("sources", "bearing_friction", **body)
    assert heat(bearing, at(6000)) == pytest.approx(1.047e-4 * 6000 * 249.14, rel=5e-4)
    assert heat(bearing, at(-100)) == heat(bearing, at(50)) * 2 == pytest.approx(1.047e-4 * 100 * 16.384, rel=5e-4)
    assert abs(1 - 2000 ** (2 / 3) / LEAST - 0.008) < 5e-4
    loaded = entry("sources", "bearing_friction", load_factor="0.001", load="1 kN", **body)
    assert heat(loaded, at(6000)) - heat(bearing, at(6000)) == pytest.approx(1.047e-4 * 6000 * 80, rel=5e-4)
    assert heat(bearing, at(0)) == 0


def test_a_load_beside_a_constant_torque_is_refused() -> None:
    with pytest.raises(Refused, match="says nothing beside a constant torque"):
        entry("sources", "bearing_friction", torque="520 N mm", load="1 kN")


def test_a_torque_that_was_meant_in_newton_millimetres_is_doubted() -> None:
    body = {"kind": "seal_friction", "into": {"shaft": 1}, "torque": "520 N m"}
    doubts = [str(w) for w in machine().patched({"sources": {"it": body}}).warnings]
    assert any("163 kW at 3000 rpm" in text and "N mm" in text for text in doubts)


def test_seal_friction() -> None:
    assert heat(entry("sources", "seal_friction", torque="50 N mm"), at(3000)) == pytest.approx(15.708, rel=1e-4)


def test_viscous_friction() -> None:
    oil = entry("sources", "viscous_friction", torque="520 N mm", thinning="0.03 1/K", reads="shaft@0.1")
    assert heat(oil, at(6000), REFERENCE) == pytest.approx(326.7256, rel=1e-6)
    assert heat(oil, at(6000), REFERENCE + 20) == pytest.approx(326.7256 * math.exp(-0.6), rel=1e-6)


def test_preload_friction_grows_and_stops_at_zero() -> None:
    rings = {"inner": "shaft", "outer": "housing"}
    bearing = entry("sources", "preload_friction", torque="520 N mm", growth="0.04 1/K", **rings)
    assert heat(bearing, at(6000), 30, 30) == pytest.approx(326.7256, rel=1e-6)
    assert heat(bearing, at(6000), 35, 25) == pytest.approx(326.7256 * 1.4, rel=1e-6)
    assert heat(bearing, at(6000), 25, 55) == 0


def test_motor_loss() -> None:
    motor = entry(
        "sources", "motor_loss", copper="100 W", iron="250 W", iron_exponent="1.5", reference_speed="10000 rpm"
    )
    assert heat(motor, at(0)) == 0
    assert heat(motor, at(-10_000)) == pytest.approx(350)
    assert heat(motor, at(2500)) == pytest.approx(100 + 250 / 8)


def test_copper_temperature_reads_its_own_place() -> None:
    copper = entry("sources", "copper_temperature", into={"housing@0.2..0.4": 0.7, "shaft": 0.3}, power="100 W",
                   slope="0.0039 1/K")  # fmt: skip
    assert copper.readings() == ("reads",)
    assert str(copper.reads) == "housing@0.2..0.4"
    assert heat(copper, at(1), REFERENCE) == pytest.approx(100)
    assert heat(copper, at(1), REFERENCE + 100) == pytest.approx(139)
    assert heat(copper, at(0), REFERENCE + 100) == 0


def test_windage() -> None:
    air = entry("sources", "windage", power="200 W", reference_speed="10000 rpm", exponent="3")
    assert heat(air, at(5000)) == pytest.approx(25)
    assert heat(air, at(-20_000)) == pytest.approx(1600)


def test_heat_source_always_running_and_by_an_input() -> None:
    assert heat(entry("sources", "heat_source", power="90 W"), at()) == 90
    running = entry("sources", "heat_source", power="90 W", with_="running")
    assert (heat(running, at(0)), heat(running, at(-1))) == (0, 90)
    by_feed = entry("sources", "heat_source", power="90 W", with_="feed", at="15 m/min")
    assert heat(by_feed, at(feed=5)) == pytest.approx(30)
    assert dict(by_feed.needs()) == {"feed": "m/min"}


@pytest.mark.parametrize(
    ("body", "wrong"), [({"with_": "feed"}, "lacks 'at'"), ({"at": "15 m/min"}, "has 'at' with `with: always`")]
)
def test_heat_source_refuses_half_an_input(body: dict[str, str], wrong: str) -> None:
    with pytest.raises(Refused, match=wrong):
        entry("sources", "heat_source", power="90 W", **body)


def test_timed_source_switches_at_its_edges() -> None:
    pump = entry("sources", "timed_source", power="400 W", period="30 min", duration="5 min", phase="-2 min")
    assert [heat(pump, at(time=60 * t)) for t in (0, 2.9, 3.1, 27.9, 28.1, 32.9, 33.1)] == [400, 400, 0, 0, 400, 400, 0]
    assert pump.edges(3600.0) / 60 == pytest.approx([3, 28, 33, 58])
    late = entry("sources", "timed_source", power="400 W", period="30 min", duration="5 min", phase="45 min")
    assert late.edges(3600.0) / 60 == pytest.approx([15, 20, 45, 50])
    assert heat(late, at(time=60 * 16)) == 400


def test_timed_sources_side_by_side_have_the_edges_of_all() -> None:
    one = entry("sources", "timed_source", power="400 W", period="30 min", duration="5 min")
    other = entry("sources", "timed_source", power="400 W", period="50 min", duration="10 min")
    assert type(one).stack([one, other]).edges(3600.0) / 60 == pytest.approx([5, 10, 30, 35, 50])


def test_a_pulse_longer_than_its_period_is_refused() -> None:
    with pytest.raises(Refused, match="longer than its period"):
        entry("sources", "timed_source", power="400 W", period="5 min", duration="6 min")


def test_sunlight() -> None:
    sun = entry("sources", "sunlight", power="120 W", rises="7 h", lasts="10 h")
    hours = {6.9: 0.0, 12: 120.0, 7 + 10 / 6: 60.0, 17.1: 0.0, 36: 120.0}
    for hour, expected in hours.items():
        assert heat(sun, at(time=3600 * hour)) == pytest.approx(expected)
    assert sun.edges(48 * 3600.0) / 3600 == pytest.approx([7, 17, 31, 41])
    day = np.linspace(0, 86_400, 86_401)
    assert float(sun.heat({"time": day}).sum()) == pytest.approx(120 * 36_000 * 2 / math.pi, rel=1e-6)


def test_screw_and_guide_friction() -> None:
    screw = entry("sources", "screw_friction", power_per_feed="12 W/(m/min)")
    assert heat(screw, at(feed=-15)) == pytest.approx(180)
    torque, lead = 2.0, 0.02  # N m, m: a screw at n turns 2π n M per minute
    assert heat(entry("sources", "screw_friction", power_per_feed=f"{2 * math.pi * torque / lead / 60} W/(m/min)"),
                at(feed=20)) == pytest.approx(0.12 * math.pi * 1000 * torque * 1000 / 3600)  # fmt: skip
    assert heat(entry("sources", "guide_friction", power_per_feed="1 W/(m/min)"), at(feed=60)) == pytest.approx(60)
    assert heat(entry("sources", "guide_friction", power_per_feed="60 N"), at(feed=60)) == pytest.approx(60)


def test_cutting_heat() -> None:
    assert heat(entry("sources", "cutting_heat", share="0.1"), at(cutting_power=3000)) == pytest.approx(300)


def test_the_period_of_a_thermostat() -> None:
    """One mass C = 50 kJ/K, 300 W, a cooler of 800 W, ± 0.5 K: on for 100 s, off for 166.7 s."""
    cooler = entry("sources", "thermostat_cooling", watches="shaft", set="22 degC", hysteresis="0.5 K", power="800 W")
    C, q, P, h = 50e3, 300.0, 800.0, 0.5
    T, mode, t, switches = 22.0, 0.0, 0.0, []
    while len(switches) < 6:
        T += (q + mode * heat(cooler, at(), T)) / C * 0.01
        t += 0.01
        if float(cooler.guard(np.array(mode), at(), np.array(T))) > 0:
            mode = 1 - mode
            switches.append(t)
    on, off = np.diff(switches)[0::2], np.diff(switches)[1::2]
    assert on == pytest.approx(2 * h * C / (P - q), abs=0.1)
    assert off == pytest.approx(2 * h * C / q, abs=0.1)


def test_a_thermostat_is_patient_inside_its_band() -> None:
    cooler = entry("sources", "thermostat_cooling", watches="shaft", set="22 degC", hysteresis="0.5 K", power="800 W")
    for mode in (0.0, 1.0):
        for T in (21.6, 22.0, 22.4):
            assert float(cooler.guard(np.array(mode), at(), np.array(T))) < 0
    assert float(cooler.guard(np.array(0.0), at(), np.array(22.6))) > 0
    assert float(cooler.guard(np.array(1.0), at(), np.array(21.4))) > 0


def test_stretching_from_temperature_and_from_heat() -> None:
    """α L ΔT: 1.13e-5 · 580 mm · 10 K = 65.5 µm; the specimen of the method, 360 kJ in a bar of Ø 100 mm: 138.33 µm."""
    grows = entry("tcp", "stretching", of="housing", direction=1)
    assert moves(grows, 10.0) == pytest.approx(1.13e-5 * 0.580 * 10 * 1e6)
    part = entry("tcp", "stretching", of="housing@0.1..0.6", direction=-1)
    assert moves(part, 10.0) == pytest.approx(-1.13e-5 * 0.290 * 10 * 1e6)
    given = entry("tcp", "stretching", of="column", length="1 m", expansion="1e-5 1/K", direction=1)
    assert moves(given, 1.0) == pytest.approx(10)
    bar = {"material": "steel", "length": "1 m", "area": "7853.98163 mm^2"}
    specimen = machine().patched(
        {"nodes": {"bar": bar},
         "links": {"it": {"kind": "conduction", "between": ["bar", "air"], "conductance": "0 W/K"}},
         "tcp": {"z": {"it": {"kind": "stretching", "of": "bar", "method": "heat", "direction": 1}}}}
    )  # fmt: skip
    assert moves(specimen.tcp["z"]["it"], 360e3) == pytest.approx(138.33, abs=0.01)


def test_bending_from_faces_gradient_and_heat() -> None:
    """θ = α L s/2 and (L/2) tan(θ/2): 2 m, 20 K over 200 mm, 1.13e-5: θ = 1.13 mrad, 565 µm."""
    faces = {"between": ["shaft", "housing"], "distance": "200 mm", "length": "2 m", "direction": 1}
    assert moves(entry("tcp", "bending", **faces), 30.0, 10.0) == pytest.approx(math.tan(1.13e-3 / 2) * 1e6)
    assert moves(entry("tcp", "bending", **faces), 10.0, 30.0) == pytest.approx(-math.tan(1.13e-3 / 2) * 1e6)
    assert moves(entry("tcp", "bending", "a", **faces), 30.0, 10.0) == pytest.approx(1130)
    bar = {"of": "housing", "length": "2 m", "direction": 1}
    assert moves(entry("tcp", "bending", **bar), 100.0) == pytest.approx(math.tan(1.13e-3 / 2) * 1e6)
    E = machine().nodes["housing"].capacity * 0.5 * 100 * 0.58  # linear from 0 to 58 K through 580 mm
    assert moves(entry("tcp", "bending", method="paper", **bar), E) == pytest.approx(math.tan(1.13e-3 / 2) * 1e6)


def test_tilt() -> None:
    """Supports of 300 mm, 300 mm apart, 2 K difference: 22.6 µrad; at an arm of 400 mm 9.04 µm."""
    supports = {"between": ["shaft", "housing"], "distance": "300 mm", "length": "300 mm", "direction": 1}
    assert moves(entry("tcp", "tilt", "a", **supports), 12.0, 10.0) == pytest.approx(22.6)
    assert moves(entry("tcp", "tilt", arm="400 mm", **supports), 12.0, 10.0) == pytest.approx(9.04)
    own = entry("tcp", "tilt", "a", between=["shaft", "housing"], distance="300 mm", direction=-1)
    assert moves(own, 10.0, 10.0) == pytest.approx(-1.13e-5 * 10 * 0.04 / 0.3 * 1e6)  # 620 against 580 mm


def test_an_arm_is_asked_for_on_z_and_refused_on_a() -> None:
    supports = {"between": ["shaft", "housing"], "distance": "300 mm", "direction": 1}
    with pytest.raises(Refused, match="lever arm is missing"):
        entry("tcp", "tilt", **supports)
    with pytest.raises(Refused, match="of no use"):
        entry("tcp", "tilt", "a", arm="400 mm", **supports)


def test_centrifugal_growth() -> None:
    shaft = entry("tcp", "centrifugal_growth", displacement="12 um", reference_speed="10000 rpm", direction=-1)
    assert shaft.readings() == ()
    assert moves(shaft, rpm=0) == 0
    assert moves(shaft, rpm=10_000) == pytest.approx(-12)
    assert moves(shaft, rpm=-5000) == pytest.approx(-3)
    assert machine().patched({"tcp": {"z": {"it": shaft.to_plain()}}}).uncertain.keys() == machine().uncertain.keys()


def test_sensor_lag_and_offset() -> None:
    lag = entry("effects", "sensor_lag", lag="20 s")
    assert float(lag.rate(np.array(30.0), np.array(22.0))) == pytest.approx(0.4)
    assert float(lag.reading(np.array(30.0), np.array(22.0), at())) == 22
    offset = entry("effects", "sensor_offset", offset="-0.1 K")
    assert float(offset.reading(np.array(30.0), np.array(0.0), at())) == 29.9


def test_conduction_through_a_wall() -> None:
    """48 W/(m K) · 100 cm² / 30 mm = 16 W/K; a contact in its place begins with that."""
    wall = {"conductivity": "48 W/(m K)", "area": "100 cm^2", "length": "30 mm"}
    through = entry("links", "conduction", **wall)
    assert float(through.heat_flow(np.array(30.0), np.array(20.0), at())) == pytest.approx(160)
    assert "conduction at 16 W/K" in through.said()
    between = {"kind": "conduction", "between": ["shaft", "column"], **wall}
    patches = kinds("links")["contact"].proposes(machine().patched({"links": {"wall": between}}))
    (body,) = (patch["links"]["wall"] for patch in patches if "wall" in patch["links"])
    assert body["conductance"] == "16 W/K"
    with pytest.raises(Refused, match="exactly one of"):
        entry("links", "conduction", conductance="16 W/K", area="1 m^2")


def test_a_pressed_joint() -> None:
    """Ground cast iron, 2 MPa at 2 GPa, σ = 3 µm, m = 0.2, k = 48: P/H = 1e-3, 1.25 · 48 · 0.2/3e-6 · 1e-3^0.95 = 5650;
    air over 1.53 · 3 µm · 1e-3^-0.097 = 8.97 µm: 0.0257/8.97e-6 = 2870 W/(m² K)."""
    faces = {"pressure": "2 MPa", "roughness": "3 um", "hardness": "2 GPa", "conductivity": "48 W/(m K)"}
    joint = entry("links", "pressed_joint", area="100 cm^2", asperity_slope="0.2", **faces)
    spots = 1.25 * 48 * 0.2 / 3e-6 * 1e-3**0.95
    gaps = 0.0257 / (1.53 * 3e-6 * 1e-3**-0.097)
    assert float(joint.heat_flow(np.array(30.0), np.array(20.0), at())) == pytest.approx((spots + gaps) * 0.1, rel=5e-3)
    usual = entry("links", "pressed_joint", area="100 cm^2", **faces)
    assert float(usual.coefficient - gaps) == pytest.approx(spots * 0.125 * 3**0.402 / 0.2, rel=0.02)
    oiled = entry("links", "pressed_joint", area="100 cm^2", fluid="oil_vg_32", **faces)
    assert float(oiled.coefficient) > 2 * float(usual.coefficient)
    body = {"kind": "pressed_joint", "between": ["shaft", "column"], "area": "1 m^2", **faces, "pressure": "2 Pa"}
    warned = machine().patched({"links": {"it": body}}).warnings
    assert any("is 1.0e-09 of the hardness" in str(w) for w in warned)
