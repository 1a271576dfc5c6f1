"""Heat pipes, and air in layers: against answers from outside, and concealed."""

from __future__ import annotations

from typing import Any

import build as small
import numpy as np
import pytest
from fits import two_blocks
from test_concealed_kinds import MORE, conceal, levels, own, proposed

from network import Machine, simulate, superpose
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.catalogue.mechanisms.heat_pipe import HeatPipe
from network.recordings.inputs import Start, constant, linear

HOUR = 3600.0
WARM, COLD = np.array(60.0), np.array(20.0)


# -- a heat pipe ----------------------------------------------------------------------------------------------------
def pipe(**own: float | None) -> HeatPipe:
    return HeatPipe("it", **{"conductance": 12.0, "limit": 150.0, "back": 1.0, "opens": None, "within": 5.0, **own})


def carried(entry: HeatPipe, T_a: float, T_b: float) -> float:
    return float(entry.heat_flow(np.array(T_a), np.array(T_b), {}))


@pytest.mark.parametrize(("dT", "heat"), [(0.01, 0.12), (12.5, 75.0), (1e5, 150.0)])
def test_a_pipe_conducts_little_heat_and_carries_no_more_than_its_limit(dT: float, heat: float) -> None:
    """G ΔT at first, half of the limit at ΔT = Q_max/G, the limit in the end; and as much back."""
    assert carried(pipe(), 20 + dT, 20) == pytest.approx(heat, rel=1e-3)
    assert carried(pipe(), 20, 20 + dT) == pytest.approx(-heat, rel=1e-3)


def test_a_thermosiphon_carries_one_way() -> None:
    one_way, half = pipe(back=0.0), pipe(back=0.5)
    assert carried(one_way, 60, 20) == carried(pipe(), 60, 20) > 0 == carried(one_way, 20, 60)
    assert carried(half, 20, 60) == carried(pipe(conductance=6.0), 20, 60)


@pytest.mark.parametrize(
    ("T", "share"), [(30.0, 0.5), (25.0, 1 / (1 + np.exp(4))), (35.0, 1 / (1 + np.exp(-4))), (-90, 0), (400, 1)]
)
def test_a_pipe_opens_with_its_warmer_end(T: float, share: float) -> None:
    """Half at `opens`, 2 and 98 % one `within` below and above, whichever end is the warmer; far off all or nothing."""
    opening = pipe(opens=30.0, limit=1e9)
    for there, way in (((T, T - 1), 1), ((T - 1, T), -1)):
        assert carried(opening, *there) == pytest.approx(way * share * 12, rel=1e-6, abs=1e-12)


def drive(link: dict[str, Any], power: float) -> Machine:
    return small.machine(
        {"drive": {"heat_capacity": "1 kJ/K"}, "sink": {"temperature": "sink"}},
        links={"pipe": {"between": ["drive", "sink"], "conductance": "12 W/K", **link}},
        sources={"loss": {"kind": "heat_source", "into": {"drive": 1}, "power": f"{power} W"}},
        sensors={"T": {"measures": "drive", "noise": "0.1 K"}},
    )  # fmt: skip


def test_a_run_settles_where_the_law_says() -> None:
    """100 W = 12 ΔT/(1 + 12 ΔT/150): ΔT = 25 K, three times what the conductance alone would take."""
    t = np.arange(0.0, 4 * HOUR + 1, 60.0)
    run = simulate(drive({"kind": "heat_pipe", "limit": "150 W"}, 100),
                   small.schedule(t, constant("sink", "degC", 20.0)))  # fmt: skip
    assert run.shown("T")[-1] == pytest.approx(45, abs=1e-3) and abs(run.energy.closure) < 1e-6


def test_a_diode_keeps_what_it_got() -> None:
    """The sink swings by ± 10 K: cooled through a thermosiphon the drive follows it down and not up again."""
    t = np.arange(0.0, 24 * HOUR + 1, 120.0)
    sink = linear("sink", "degC", t, 20 - 10 * np.sin(2 * np.pi * t / (12 * HOUR)))
    T = simulate(drive({"kind": "heat_pipe", "limit": "1 kW", "back": 0}, 0), small.schedule(t, sink)).shown("T")
    assert np.diff(T).max() < 1e-6 and T[-1] == pytest.approx(10, abs=0.1)


def test_a_pipe_that_opens_holds_its_end_steady() -> None:
    """Four times the heat: a conduction's rise is four times as high, that of a pipe opening about 40 °C grows by
    less than half of itself."""
    t = np.arange(0.0, 6 * HOUR + 1, 60.0)
    still = small.schedule(t, constant("sink", "degC", 20.0))
    opening = {"kind": "heat_pipe", "limit": "10 kW", "opens": "40 degC", "within": "10 K"}
    low, high = (simulate(drive(opening, power), still).shown("T")[-1] - 20 for power in (40, 160))
    assert 1 < high / low < 1.5


def test_a_pipe_that_the_file_does_not_know() -> None:
    """Beside a flange of any conductance: what bends is left over, and written down both numbers come back."""
    plain = two_blocks()
    it = {"kind": "heat_pipe", "between": ["motor", "body"], "back": 0}
    case = conceal(plain, plain.patched({"links": {"pipe": {**it, "conductance": "20 W/K", "limit": "40 W"}}}))
    known = plain.patched({"links": {"pipe": {**it, "conductance": "10 W/K ± 100 %", "limit": "80 W ± 100 %"}}})
    found = fit_hypothesis(case, known)
    assert fit_hypothesis(case, plain).chi > 1.3 and found.chi < 1.1
    assert found.values["links.pipe.limit"] == pytest.approx(40, rel=0.05)
    assert found.values["links.pipe.conductance"] == pytest.approx(20, rel=0.3)


# -- air in layers --------------------------------------------------------------------------------------------------
LAYERS = {"kind": "stratification", "into": {"body": 1}, "conductance": "9 W/K"}
SKIN = {"skin": {"kind": "convection", "between": ["body", "air"], "conductance": "9 W/K"}}


def in_layers(**body: str) -> Machine:
    return small.machine(
        {"body": {"heat_capacity": "40 kJ/K"}, "air": {"temperature": "ambient"}}, links=SKIN,
        sources={"layers": {**LAYERS, **body}},
        tcp={"z": {"grows": {"kind": "stretching", "of": "body", "length": "1 m", "expansion": "1.1e-5 1/K",
                             "direction": 1}}},
        sensors={"T": {"measures": "body", "noise": "0.1 K"}},
    )  # fmt: skip


def day() -> Any:
    t = np.arange(0.0, 24 * HOUR + 1, 300.0)
    return small.schedule(t, linear("ambient", "degC", t, 20 + 3 * np.sin(2 * np.pi * t / (24 * HOUR))))


@pytest.mark.parametrize(("gradient", "height"), [(0.6, 1.8), (0.6, -1.2), (-0.3, 2.0)])
def test_above_it_the_part_is_as_much_warmer_as_the_air_there(gradient: float, height: float) -> None:
    """C dT/dt = G (T_air + γ h − T): the course level with the thermometer, where nothing is added, and
    γ h (1 − e^(−G t/C)) on it."""
    level, there = (simulate(in_layers(gradient=f"{gradient} K/m", height=f"{h} m"), day(), start=Start(others=20.0))
                    for h in (0.0, height))  # fmt: skip
    more = gradient * height * (1 - np.exp(-9 * there.t / 40e3))
    assert there.shown("T") - level.shown("T") == pytest.approx(more, abs=1e-9)
    assert abs(there.energy.closure) < 1e-9


def test_its_micrometres_are_told_apart_from_the_rooms() -> None:
    run = simulate(in_layers(gradient="0.6 K/m", height="1.8 m"), day(), start=Start(others=20.0))
    shares = superpose(run).sum_by("z", "cause")
    expected = 0.6 * 1.8 * (1 - np.exp(-9 * run.t / 40e3)) * 11e-6
    assert shares["layers",] == pytest.approx(expected, abs=1e-12)


def test_a_head_that_climbs_gets_warmer_air() -> None:
    """Settled at the bottom, then lifted by 1.5 m: γ times that more, in the time constant of its film."""
    t = np.arange(0.0, 24 * HOUR + 1, 300.0)
    z = small.position((0.0, 0.0), (12 * HOUR, 1500.0))
    machine = in_layers(gradient="0.6 K/m", height="1 m", input="position")
    T = simulate(machine, small.schedule(t, z, constant("ambient", "degC", 20.0)), start=Start(others=20.6)).shown("T")
    after = np.where(t > 12 * HOUR, 0.9 * (1 - np.exp(-9 * (t - 12 * HOUR) / 40e3)), 0.0)
    assert pytest.approx(20.6 + after, abs=1e-6) == T


CLIMBS = levels("position", "mm", 0, 1500, 300, 1800, 0, 900, 1500, 0)


def test_layers_that_the_file_does_not_know(monkeypatch: pytest.MonkeyPatch) -> None:
    """A head that climbs in them: a convection of any size leaves more than noise, the gradient comes back. At a
    constant height heat that is always on tells as much: that is what a diagnosis finds."""
    monkeypatch.setitem(MORE, "position", CLIMBS)  # type: ignore[arg-type]
    plain = two_blocks()
    layers = {**LAYERS, "conductance": "7 W/K"}
    climbs = {**layers, "height": "0.5 m", "input": "position"}
    case = conceal(plain, plain.patched({"sources": {"layers": {**climbs, "gradient": "1 K/m"}}}))
    known = plain.patched({"sources": {"layers": {**climbs, "gradient": "0.3 K/m ± 1 K/m"}}})
    found = fit_hypothesis(case, known)
    assert fit_hypothesis(case, plain).chi > 1.1 > 1.05 > found.chi
    assert found.values["sources.layers.gradient"] == pytest.approx(1, rel=0.1)
    still = conceal(plain, plain.patched({"sources": {"layers": {**layers, "gradient": "2 K/m", "height": "2 m"}}}))
    c = proposed(still, "sources", "heat_source", "body", has="always")
    always = fit_hypothesis(still, c.machine, (c,), c.own)
    assert fit_hypothesis(still, plain).chi > 1.1 > 1.05 > always.chi
    assert own(always)["power"] == pytest.approx(7 * 2 * 2, rel=0.1)
