"""A floor as a half space, a stream that comes late, a Peltier module, sensors in steps and with outliers: against
answers from outside, and concealed; of what a diagnosis does not look for, what it tells in its stead."""

from __future__ import annotations

from pathlib import Path

import build as small
import numpy as np
import pytest
import yaml
from fits import recorded, speeds, two_blocks
from scipy.special import erfc
from scipy.stats import gamma
from test_concealed_kinds import MORE, conceal, levels, own, proposed

from network import Machine, simulate
from network.analysis.diagnosis.candidates.candidates import lay_over
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.catalogue.mechanisms.advection import Advection
from network.catalogue.mechanisms.half_space import LAYERS, RATES, HalfSpace
from network.catalogue.mechanisms.plug_flow import PlugFlow
from network.catalogue.mechanisms.thermoelectric import Thermoelectric
from network.catalogue.sensors.sensor_outliers import SensorOutliers
from network.catalogue.sensors.sensor_resolution import SensorResolution
from network.recordings.hygiene.judgement import judge
from network.recordings.inputs import Start, constant, hold, linear

ROOT = Path(__file__).parents[1]
DAY = 86400.0
AREA, CONDUCTIVITY, DIFFUSIVITY = 2.0, 1.4, 0.7e-6
FLOOR = {"kind": "half_space", "into": {"body": 1}, "surface": "body", "area": "2 m^2",
         "conductivity": "1.4 W/(m K)", "diffusivity": "0.7 mm^2/s", "temperature": "18 degC"}  # fmt: skip


# -- half space -----------------------------------------------------------------------------------------------------
def floor(area: float = AREA) -> HalfSpace:
    numbers = {"area": area, "conductivity": CONDUCTIVITY, "diffusivity": DIFFUSIVITY, "temperature": 18.0}
    return HalfSpace("floor", **numbers)


@pytest.mark.parametrize("area", [0.1, 2.0, 50.0])
@pytest.mark.parametrize("t", [10.0, 60.0, 3600.0, 8 * 3600.0, DAY, 10 * DAY])
def test_after_a_step_of_its_surface_it_takes_what_the_closed_form_says(area: float, t: float) -> None:
    """k S ΔT/√(π a t), and for good 4 k R ΔT; a layer of rate p has followed the step by 1 − e^(−p t)."""
    step = 10.0
    layers = [np.asarray(18 + step * (1 - np.exp(-rate * t))) for rate in RATES]
    found = -float(floor(area).heat({}, np.asarray(18 + step), *layers))
    passing = CONDUCTIVITY * area * step / np.sqrt(np.pi * DIFFUSIVITY * t)
    lasting = 4 * CONDUCTIVITY * np.sqrt(area / np.pi) * step
    assert abs(found - passing - lasting) < 0.006 * passing


def test_a_machine_on_it_warms_like_a_mass_on_a_half_space() -> None:
    """C dT/dt = q − b d^½T/dt^½ − G T with b = k S/√a: T = q Σ over the roots r of C r² + b r + G of
    (1/(C r (r₁ − r₂))) e^(r² t) erfc(−r √t), and q/G (Laplace transform in partial fractions)."""
    C, q, hours = 40e3, 300.0, 12
    machine = small.machine(
        {"body": {"heat_capacity": f"{C} J/K"}}, sources={
            "floor": FLOOR, "heat": {"kind": "heat_source", "into": {"body": 1}, "power": f"{q} W"}},
        sensors={"T": {"measures": "body", "noise": "0.1 K"}},
    )  # fmt: skip
    schedule = small.schedule(np.arange(0.0, hours * 3600 + 1, 300.0), constant("ambient", "degC", 20.0))
    run = simulate(machine, schedule, start=Start(others=18.0))
    b, G = CONDUCTIVITY * AREA / np.sqrt(DIFFUSIVITY), 4 * CONDUCTIVITY * np.sqrt(AREA / np.pi)
    first, second = np.roots([C, b, G])
    t = run.t[1:]
    T = sum(np.exp(r**2 * t) * erfc(-r * np.sqrt(t)) / (C * r * (r - other))
            for r, other in ((first, second), (second, first)))  # fmt: skip
    expected = 18 + q * (np.real(T) + 1 / G)
    assert np.iscomplexobj(np.roots([C, b, G])) is False and run.method in ("modal", "expm")
    assert np.abs(run.shown("T")[1:] - expected).max() < 0.006 * (expected[-1] - 18)
    assert abs(run.energy.closure) < 1e-9


def test_a_floor_begins_at_the_temperature_of_what_stands_on_it() -> None:
    """Nothing passes but what is lost for good; without conductivity nothing at all."""
    entry = floor()
    begun = entry.begin({}, np.asarray(25.0))
    assert len(begun) == LAYERS
    lasting = 4 * CONDUCTIVITY * np.sqrt(AREA / np.pi) * 7
    assert -float(entry.heat({}, np.asarray(25.0), *begun)) == pytest.approx(lasting, rel=0.03 * AREA**0.5)
    nothing = entry.replaced(conductivity=np.asarray(0.0))
    assert float(nothing.heat({}, np.asarray(25.0), *(z - 5 for z in begun))) == 0


def test_a_floor_that_the_file_does_not_know() -> None:
    """A loss to air of any size does not stand for it; written down, its numbers come back and noise is left."""
    plain = two_blocks()
    case = conceal(plain, plain.patched({"sources": {"floor": FLOOR}}))
    known = plain.patched({"sources": {"floor": {**FLOOR, "conductivity": "0.8 W/(m K) ± 50 %",
                                                 "temperature": "20 degC ± 3 K"}}})  # fmt: skip
    found = fit_hypothesis(case, known)
    assert fit_hypothesis(case, plain).chi > 1.3 and found.chi < 1.1
    assert found.values["sources.floor.conductivity"] == pytest.approx(CONDUCTIVITY, rel=0.1)


def test_a_hidden_mass_stands_for_a_floor_over_hours() -> None:
    """What a diagnosis tells of it: of more than ten times the noise less than half of the noise is left."""
    plain = two_blocks()
    case = conceal(plain, plain.patched({"sources": {"floor": FLOOR}}))
    c = proposed(case, "suspects", "hidden_mass", "body")
    assert fit_hypothesis(case, plain).chi > 10 > 1.5 > fit_hypothesis(case, c.machine, (c,), c.own).chi


# -- a stream that comes late ---------------------------------------------------------------------------------------
W, DELAY = 400.0, 120.0


def jacket(**body: str) -> Machine:
    stream = {"through": ["tank", "jacket"], "capacity_flow": f"{W} W/K", "delay": f"{DELAY} s", **body}
    return small.machine(
        {"tank": {"temperature": "supply"}, "jacket": {"heat_capacity": "0.01 J/K"}}, links={"loop": stream},
        sensors={"T": {"measures": "jacket", "noise": "0.1 K"}},
    )  # fmt: skip


@pytest.mark.parametrize("cells", [8, 64, 200])
def test_a_step_arrives_after_the_delay_spread_as_told(cells: int) -> None:
    """The distribution of tanks in series (Levenspiel): mean DELAY, standard deviation DELAY/√cells."""
    t = np.arange(0.0, 401.0, 2.0)
    step = hold("supply", "degC", np.array([0.0, 100.0]), np.array([20.0, 30.0]))
    T = simulate(jacket(kind="plug_flow", cells=str(cells)), small.schedule(t, step)).shown("T")
    assert pytest.approx(10 * gamma.cdf(t - 100, cells, scale=DELAY / cells), abs=1e-3) == T - 20
    rises = np.gradient(T, t)
    mean = (rises * (t - 100)).sum() / rises.sum()
    assert mean == pytest.approx(DELAY, rel=0.01)
    assert np.sqrt((rises * (t - 100 - mean) ** 2).sum() / rises.sum()) == pytest.approx(DELAY / cells**0.5, rel=0.03)


@pytest.mark.parametrize(("period", "lost"), [(10 * DELAY, 0.003), (DELAY, 0.27)])
def test_a_swing_arrives_late_and_hardly_lower(period: float, lost: float) -> None:
    t = np.arange(0.0, 20 * DELAY, 1.0)
    swing = linear("supply", "degC", t, 20 + 5 * np.sin(2 * np.pi * t / period))
    T = simulate(jacket(kind="plug_flow"), small.schedule(t, swing)).shown("T") - 20
    late = t > 5 * DELAY
    waves = np.column_stack([np.sin(2 * np.pi * (t - DELAY) / period), np.cos(2 * np.pi * (t - DELAY) / period)])[late]
    (height, beside), *_ = np.linalg.lstsq(waves, T[late], rcond=None)
    assert 1 - np.hypot(height, beside) / 5 == pytest.approx(lost, abs=0.1 * lost)
    assert abs(beside) < 0.06 * abs(height), "it comes after the delay"


def test_as_many_cells_as_advection_has_are_advection() -> None:
    t = np.arange(0.0, 401.0, 5.0)
    step = hold("supply", "degC", np.array([0.0, 100.0]), np.array([20.0, 30.0]))
    runs = [simulate(jacket(**body), small.schedule(t, step)).shown("T")
            for body in ({"kind": "advection"}, {"kind": "plug_flow", "cells": str(Advection.cells)})]  # fmt: skip
    assert np.abs(runs[0] - runs[1]).max() < 1e-12


def late_stream() -> Case:
    """Recordings of a stream that comes 240 s late, and a file whose stream comes at once."""
    supplied = levels("chiller", "degC", 20, 14, 25, 16, 22, 12, 24, 18)
    nodes = {"chilled": {"temperature": "chiller"}}
    stream = {"through": ["chilled", "body"], "capacity_flow": "30 W/K ± 20 %"}
    plain = two_blocks(nodes=nodes, links={"feed": {"kind": "advection", **stream}})
    truth = plain.patched({"links": {"feed": {"kind": "plug_flow", "delay": "240 s", **stream}}})
    more = {**MORE, "chiller": supplied}
    runs = tuple(recorded(truth, speeds((0.0, 6000), (1.5, 0), **more), seed) for seed in (1, 2))
    return Case(plain, runs)


def test_a_delay_that_the_file_does_not_know() -> None:
    """A stream without delay leaves more than noise; as it is proposed the delay comes back, and with as many cells as
    the stream has nothing is left."""
    case = late_stream()
    c = proposed(case, "links", "plug_flow", "chilled", "body")
    found = fit_hypothesis(case, c.machine, (c,), c.own)
    assert fit_hypothesis(case, case.machine).chi > 10 > 1.3 > found.chi
    assert own(found) == {"delay": pytest.approx(240, rel=0.05)}
    sharp = case.machine.patched({"links": {"feed": {**c.patch.to_plain()["links"]["feed"], "cells": 64,
                                                     "delay": "120 s ± 60 %"}}})  # fmt: skip
    known = fit_hypothesis(case, sharp)
    assert known.chi < 1.1 and known.values["links.feed.delay"] == pytest.approx(240, rel=0.03)


def test_a_delay_is_looked_for_in_streams_alone_and_once() -> None:
    """Where no stream is, nothing is tried; where one is late already, not either."""
    late = late_stream().machine.patched({"links.feed.delay": "30 s"})
    assert not [*PlugFlow.proposes(two_blocks())] and not [*PlugFlow.proposes(late)]
    assert len([*PlugFlow.proposes(late_stream().machine)]) == 1


# -- a Peltier module -----------------------------------------------------------------------------------------------
MODULE = {"couples": "127", "seebeck": "0.4 mV/K", "resistance": "15 mohm"}
COLD = {"kind": "thermoelectric", "side": "cold", "into": {"body": 1}, "junction": "body", **MODULE}


def side(name: str) -> Thermoelectric:
    return Thermoelectric("it", side=name, couples=127.0, seebeck=4e-4, resistance=0.015)


@pytest.mark.parametrize("current", [-3.0, 0.0, 2.0, 4.0])
def test_both_sides_bring_the_electric_power(current: float) -> None:
    """I² R + S I (T_h − T_c); without current nothing."""
    u = {"current": np.asarray(current)}
    cold, hot = (float(side(name).heat(u, np.asarray(T))) for name, T in (("cold", 10.0), ("hot", 45.0)))
    S, R = 127 * 4e-4, 127 * 0.015
    assert cold + hot == pytest.approx(current**2 * R + S * current * 35)
    assert cold == pytest.approx(current**2 * R / 2 - S * current * 283.15)


def test_its_best_current_and_its_largest_difference() -> None:
    """No load: it cools most at I = S T_c/R, and there the cold side comes to S² T_c²/(2 R K) below the hot one."""
    S, R, K = 127 * 4e-4, 127 * 0.015, 0.5
    machine = small.machine(
        {"body": {"heat_capacity": "20 J/K"}, "sink": {"temperature": "30 degC"}},
        links={"module": {"kind": "conduction", "between": ["body", "sink"], "conductance": f"{K} W/K"}},
        sources={"cold side": COLD}, sensors={"T": {"measures": "body", "noise": "0.1 K"}},
    )  # fmt: skip
    ends = {}
    for current in np.linspace(4.0, 9.0, 26):
        given = constant("current", "A", float(current))
        ends[float(current)] = simulate(machine, small.schedule(np.arange(0.0, 7201.0, 60.0), given)).shown("T")[-1]
    best = min(ends, key=ends.__getitem__)
    T = ends[best] + 273.15
    assert 30 - ends[best] == pytest.approx(S**2 * T**2 / (2 * R * K), rel=0.01)
    assert best == pytest.approx(S * T / R, abs=0.2)


def test_a_module_that_the_file_does_not_know() -> None:
    plain = two_blocks()
    case = conceal(plain, plain.patched({"sources": {"cold side": COLD}}))
    known = plain.patched({"sources": {"cold side": {**COLD, "seebeck": "0.3 mV/K ± 50 %", "couples": "127"}}})
    found = fit_hypothesis(case, known)
    assert fit_hypothesis(case, plain).chi > 1.3 and found.chi < 1.1
    assert found.values["sources.cold side.seebeck"] == pytest.approx(4e-4, rel=0.05)


def test_a_recorded_current_tells_of_a_module() -> None:
    """What a diagnosis finds in its stead: a cooling of N s T I, and a warming of N r/2 I², at 4 A."""
    plain = two_blocks()
    case = conceal(plain, plain.patched({"sources": {"cold side": COLD}}))
    tried = [proposed(case, "sources", "heat_source", "body", has=f"current{how} body") for how in ("", " squared")]
    laid = lay_over(plain, tried)
    assert laid is not None
    machine, found = laid
    h = fit_hypothesis(case, machine, found, tuple(p for c in found for p in c.own))
    assert fit_hypothesis(case, plain).chi > 10 > 1.1 > h.chi
    pumped, lost = (h.values[f"sources.heat source current{how} body.power"] for how in ("", " squared"))
    assert pumped == pytest.approx(-127 * 4e-4 * 302 * 4, rel=0.02)
    assert lost == pytest.approx(127 * 0.015 / 2 * 16, rel=0.05)


# -- readings in steps, readings far off ----------------------------------------------------------------------------
def test_readings_in_steps_are_off_by_a_step_over_root_twelve() -> None:
    truth = np.linspace(20, 60, 40_001)
    read = SensorResolution("it", steps=4).reading(truth, truth, {})
    assert set(np.round(4 * read) - 4 * read) == {0.0} and np.abs(read - truth).max() <= 0.125 + 1e-12
    assert np.std(read - truth) == pytest.approx(0.25 / 12**0.5, rel=1e-3)


def with_body(noise: str, *effects: dict[str, object]) -> Machine:
    return two_blocks(sensors={"T_body": {"measures": "body", "noise": noise, "effects": [*effects]}})


def test_steps_are_noise_to_a_fit() -> None:
    """A quarter of a kelvin is 0.072 K of noise: with that declared noise is left, and the numbers come back."""
    fine = with_body("0.05 K")
    case = conceal(fine, with_body("0.05 K", {"kind": "sensor_resolution", "steps": 4}))
    told = with_body(f"{(0.05**2 + 0.25**2 / 12) ** 0.5:.4f} K")
    unknown, known = fit_hypothesis(case, fine), fit_hypothesis(Case(told, case.recordings), told)
    assert unknown.chi > 1.1 > 1.05 > known.chi
    assert known.values["links.skin.conductance"] == pytest.approx(7, rel=0.05)


@pytest.mark.parametrize("share", [0.01, 0.1])
def test_outliers_hit_their_share_of_readings_without_order(share: float) -> None:
    effect = SensorOutliers("it", size=5.0, share=share, seed=3)
    t = np.arange(0.0, 200_000.0, 10.0)
    hit = effect.reading(np.zeros(len(t)), np.zeros(len(t)), {"time": t}) == 5
    sigma = np.sqrt(share * (1 - share) / len(t))
    assert abs(hit.mean() - share) < 5 * sigma
    assert abs((hit[1:] & hit[:-1]).mean() - share**2) < 6 * np.sqrt(share**2 / len(t))
    other = SensorOutliers("it", size=5.0, share=share, seed=4)
    assert (other.is_hit(t) & hit).mean() < 3 * share**2 + 1e-3


def test_outliers_that_the_file_does_not_know_are_set_aside() -> None:
    """Of a run through the ordinary reading of files: what is set aside is what was hit, and nothing else."""
    plain, sensor = with_body("0.05 K"), "T_body"
    truth = with_body("0.05 K", {"kind": "sensor_outliers", "size": "8 K", "share": "0.5 %"})
    recording = recorded(truth, speeds((0.0, 6000)), 1)
    effect = truth.sensors[sensor].effects[0]
    assert isinstance(effect, SensorOutliers)
    hit = effect.is_hit(recording.t)
    clean = judge(plain, recording)
    gone = np.isnan(clean.columns[sensor].values) & ~np.isnan(recording.columns[sensor].values)
    assert hit.sum() >= 3 and (gone == hit).all()


# -- as the README writes them --------------------------------------------------------------------------------------
def test_the_snippets_of_the_readme_run() -> None:
    """All of them on one machine: heat closes, the camera is cooled, the pump's heat leaves, the drive's goes through
    its pipe, and the column stands in warmer air than the room's."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    block = readme.partition("**Ground, hoses, Peltier modules, heat pipes, layered air**")[2]
    block = block.split("```")[1].removeprefix("yaml")
    line = next(line for line in readme.splitlines() if "sensor_resolution" in line and line.startswith("T5:"))
    given = {**yaml.safe_load(block), "sensors": yaml.safe_load(line)}
    nodes = {
        "tank": {"temperature": "16 degC"}, "air": {"temperature": "ambient"},
        **{name: {"heat_capacity": f"{C} kJ/K"} for name, C in
           (("jacket", 8), ("camera", 0.5), ("fins", 2), ("bed", 400), ("drive", 1), ("column", 5))},
    }  # fmt: skip
    skins = {f"{part} skin": {"kind": "convection", "between": [part, "air"], "conductance": "5 W/K"}
             for part in ("jacket", "fins", "bed")}  # fmt: skip
    skins["column skin"] = {"kind": "convection", "between": ["column", "air"], "conductance": "9 W/K"}
    given["sources"]["drive"] = {"kind": "heat_source", "into": {"drive": 1}, "power": "40 W"}
    machine = small.machine(nodes, **{**given, "links": {**given["links"], **skins}})
    t = np.arange(0.0, 4 * 3600 + 1, 30.0)
    on = constant("current", "A", 2.0)
    run = simulate(machine, small.schedule(t, on, constant("ambient", "degC", 22.0)))
    assert abs(run.energy.closure) < 1e-6
    parts = {name: float(T[-1]) for name, T in run.parts.items() if name in nodes}
    assert parts["camera"] < 5 < parts["jacket"] < 22 < parts["fins"]
    assert parts["column"] == pytest.approx(22 + 0.6 * 1.8 + 40 / 9, abs=0.02)
    assert parts["drive"] - parts["column"] == pytest.approx(40 / 12 / (1 - 40 / 90), abs=0.02)
    assert len(set(np.round(4 * (run.sensors["T5"] % 8) % 1, 9))) == 1, "quarters of a kelvin"
