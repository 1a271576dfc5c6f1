"""Which way things go in a run, for kinds whose sign no single evaluation tells: streams, what switches or keeps a
state, films that something drives, both sides of a Peltier module, and what sensors do to readings over time.

Each group is complete: a kind that is new has to be given a body here.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from build import machine, schedule
from catalogue import FLOWS, LAWS

from network import Start, simulate
from network.catalogue.mechanisms.base import Source, Stream
from network.catalogue.mechanisms.film import MovingFilm
from network.catalogue.mechanisms.mechanism import Relay
from network.catalogue.sensors.base import SensorEffect
from network.engine.trajectory import Trajectory
from network.recordings.inputs import Signal, constant

T = np.linspace(0, 3600, 61)
ROOM = constant("ambient", "degC", 20.0)
STRENGTHS = 0.5, 1.0, 2.0
SENSED = {"noise": "0.1 K"}


def run(*signals: Signal, effects: Any = (), links: Any = None, **sources: Any) -> Trajectory:
    """An hour of two parts of 5 kJ/K from 20 °C, each with a film of 2 W/K to a room of 20 °C, joined by 1 W/K."""
    nodes = {"a": {"heat_capacity": "5 kJ/K"}, "b": {"heat_capacity": "5 kJ/K"}, "air": {"temperature": "ambient"}}
    films = {n: {"kind": "convection", "between": [n, "air"], "conductance": "2 W/K"} for n in "ab"}
    joint = {"joint": {"kind": "conduction", "between": ["a", "b"], "conductance": "1 W/K"}}
    sensors = {"true": {"measures": "a", **SENSED}, "T": {"measures": "a", **SENSED, "effects": list(effects)}}
    found = machine(nodes, links=films | joint | (links or {}), sources=sources, sensors=sensors)
    return simulate(found, schedule(T, ROOM, *signals, start=Start(others=20.0)))


def end_of(result: Trajectory, name: str = "a") -> float:
    return float(result.parts[name][-1])


def heater(power: float) -> dict[str, Any]:
    return {"kind": "heat_source", "into": {"a": 1}, "power": f"{power} W"}


# -- streams ----------------------------------------------------------------------------------------------------------
STREAMS = {"advection": {}, "plug_flow": {"delay": "30 s", "cells": 8}}


def test_each_kind_of_a_group_is_here() -> None:
    kept = {cls.kind for cls in FLOWS if issubclass(cls, Relay) or (issubclass(cls, Source) and cls.states)}
    driven = {cls.kind for cls in FLOWS if issubclass(cls, MovingFilm)}
    assert {*STREAMS} == {cls.kind for cls in FLOWS if issubclass(cls, Stream)}
    assert {*KEPT, "switched_convection"} == kept and {*DRIVEN} >= driven
    unlike = {"sensor_offset", "sensor_crosstalk", "sensor_fault"}  # which test_catalogue_signs evaluates
    assert {*READ} | unlike == {cls.kind for cls in LAWS if issubclass(cls, SensorEffect)}


@pytest.mark.parametrize("kind", STREAMS)
def test_more_of_a_cold_stream_is_colder_and_what_it_meets_last_is_warmed_by_what_it_met_first(kind: str) -> None:
    def ends(flow: float, *through: str) -> tuple[float, float]:
        stream = {"kind": kind, "through": ["air", *through], "capacity_flow": f"{flow} W/K", **STREAMS[kind]}
        result = run(links={"stream": stream}, heater=heater(100))
        return end_of(result, "a"), end_of(result, "b")

    there = [ends(flow, "a", "b") for flow in (0.5, 2.0, 8.0)]
    assert there[0][0] > there[1][0] > there[2][0] > 20
    assert all(ends(flow, "a", "b")[1] > ends(flow, "b", "a")[1] + 0.1 for flow in (2.0, 8.0))


# -- what switches, what keeps a state --------------------------------------------------------------------------------
WATCH = {"into": {"a": 1}, "watches": "a"}
KEPT: dict[str, tuple[str, float, str, int, dict[str, Any]]] = {
    "thermostat_cooling": ("power", 20, "W", -1, {**WATCH, "set": "22 degC", "hysteresis": "0.5 K"}),
    "thermostat_heating": ("power", 20, "W", +1, {**WATCH, "set": "200 degC", "hysteresis": "0.5 K"}),
    "pi_cooling": ("gain", 5, "W/K", -1, {**WATCH, "set": "22 degC", "reset_time": "300 s", "limit": "1 kW"}),
    "half_space": ("conductivity", 1.4, "W/(m K)", -1, {"into": {"a": 1}, "surface": "a", "area": "1 m^2",
                                                        "diffusivity": "0.7 mm^2/s", "temperature": "15 degC"}),
}  # fmt: skip
"""Strength, what half of it and twice of it are taken of, the sign of its heat in a part that is heated, what else."""


@pytest.mark.parametrize("kind", KEPT)
def test_more_of_what_cools_is_colder_and_of_what_warms_warmer(kind: str) -> None:
    strength, size, unit, sign, body = KEPT[kind]
    each = [{"kind": kind, strength: f"{size * share} {unit}", **body} for share in (0, *STRENGTHS)]
    means = [float(run(heater=heater(100), it=one).parts["a"].mean()) for one in each]
    assert (np.diff(means) * sign > 0.01).all(), means


def test_ground_that_is_warm_below_warms() -> None:
    def on(temperature: float) -> float:
        *_, body = KEPT["half_space"]
        it = {"kind": "half_space", "conductivity": "1.4 W/(m K)", **body, "temperature": f"{temperature} degC"}
        return end_of(run(it=it))

    assert on(10) < on(15) < 20 < on(30)


def test_a_current_cools_one_side_of_a_peltier_module_and_warms_the_other_and_the_other_way_round() -> None:
    def ends(current: float) -> tuple[float, float, float]:
        sides = {side: {"kind": "thermoelectric", "into": {node: 1}, "side": side, "junction": node}
                 for side, node in (("cold", "a"), ("hot", "b"))}  # fmt: skip
        usual = {"couples": 30, "seebeck": "0.4 mV/K", "resistance": "15 mohm"}
        result = run(constant("current", "A", current), **{side: body | usual for side, body in sides.items()})
        brought = result.energy.by_mechanism
        return end_of(result), end_of(result, "b"), brought["sources.cold"] + brought["sources.hot"]

    none, some, more, back = (ends(current) for current in (0.0, 1.0, 2.0, -1.0))
    assert none == pytest.approx((20, 20, 0), abs=1e-9)
    assert more[0] < some[0] < 20 < some[1] < more[1]
    assert back[0] == pytest.approx(some[1], abs=0.05) and back[1] == pytest.approx(some[0], abs=0.05)
    assert 0 < some[2] < more[2] and back[2] > 0, "electric power is spent, whichever way it pumps"


# -- films ------------------------------------------------------------------------------------------------------------
SPEEDS = (0, 300, 1000, 3000, 10_000)
DRIVEN: dict[str, tuple[str, str, float, dict[str, Any]]] = {
    "rotating_cylinder": ("speed", "rpm", 1, {"diameter": "80 mm", "area": "0.1 m^2"}),
    "rotating_disc": ("speed", "rpm", 1, {"diameter": "250 mm", "area": "0.1 m^2"}),
    "annular_gap": ("speed", "rpm", 1, {"diameter": "100 mm", "gap": "0.5 mm", "area": "0.05 m^2"}),
    "forced_convection": ("speed", "rpm", 1, {"conductance": "1 W/K", "gain": "3", "reference_speed": "3000 rpm"}),
    "pipe_flow": ("flow", "l/min", 2e-3, {"diameter": "12 mm", "length": "2 m", "area": "0.07 m^2", "input": "flow"}),
    "plate_flow": ("feed", "m/min", 1e-2, {"length": "0.5 m", "area": "0.3 m^2", "moves": "feed"}),
}
"""Input, its unit, that many of it to a revolution, what else."""


@pytest.mark.parametrize("kind", DRIVEN)
def test_a_heated_part_is_the_colder_the_faster_it_is_driven(kind: str) -> None:
    """Over laminar and turbulent flow, whichever way it turns."""
    name, unit, each, body = DRIVEN[kind]
    film: dict[str, Any] = {"kind": kind, "between": ["a", "air"], **body}
    si = {"rpm": np.pi / 30, "l/min": 1e-3 / 60, "m/min": 1 / 60}[unit]

    def end(speed: float) -> float:
        return end_of(run(constant(name, unit, speed * each * si), links={"film": film}, heater=heater(60)))

    ends = [end(speed) for speed in SPEEDS]
    assert (np.diff(ends) <= 1e-9).all() and ends[-1] < ends[0] - 0.1, ends
    if unit != "l/min":  # a flow has one way
        assert end(-SPEEDS[2]) == pytest.approx(ends[2], abs=1e-6)


# -- sensors ----------------------------------------------------------------------------------------------------------
READ: dict[str, Any] = {
    "sensor_lag": [{"lag": f"{lag} s"} for lag in (1, 60, 300)],
    "clock_shift": [{"late": f"{late} s"} for late in (-120, 0, 120, 600)],
    "sensor_outliers": [{"size": f"{size} K", "share": 0.2} for size in (-5, 0, 5, 20)],
    "sensor_resolution": [{"steps": steps} for steps in (1, 10, 1000)],
    "sensor_swap": None,
}


def off_by(kind: str, body: dict[str, Any]) -> np.ndarray:
    """Reading less truth along a part that warms up steadily."""
    result = run(effects=[{"kind": kind, **body}], heater=heater(80))
    return np.asarray(result.sensors["T"] - result.sensors["true"])


def test_the_slower_or_later_a_sensor_is_the_less_it_reads_of_what_warms() -> None:
    for kind in ("sensor_lag", "clock_shift"):
        means = [float(off_by(kind, body).mean()) for body in READ[kind]]
        assert (np.diff(means) < -0.01).all(), (kind, means)
    early, exact, *_ = (float(off_by("clock_shift", body).mean()) for body in READ["clock_shift"])
    assert early > 0 == exact


def test_outliers_are_off_by_their_size_and_more_of_them_are_more() -> None:
    for body, size in zip(READ["sensor_outliers"], (-5.0, 0.0, 5.0, 20.0), strict=True):
        off = off_by("sensor_outliers", body)
        hit = np.abs(off) > 1e-9
        assert off[hit] == pytest.approx(size) and bool(hit.any()) is bool(size)
    counts = [int((off_by("sensor_outliers", {"size": "5 K", "share": share}) > 1).sum()) for share in (0, 0.1, 0.4, 1)]
    assert counts[0] == 0 < counts[1] < counts[2] < counts[3] == len(T)


def test_finer_steps_are_nearer_to_the_truth_and_never_turn_round() -> None:
    for body in READ["sensor_resolution"]:
        one, steps = run(effects=[{"kind": "sensor_resolution", **body}], heater=heater(80)), body["steps"]
        off = np.abs(one.sensors["T"] - one.sensors["true"]).max()
        assert 0.2 / steps < off <= 0.5 / steps + 1e-9
        assert (np.diff(one.sensors["T"]) >= 0).all() and (np.diff(one.sensors["true"]) > 0).all()


def test_sensors_that_are_exchanged_read_each_other() -> None:
    nodes = {"hot": {"heat_capacity": "5 kJ/K"}, "air": {"temperature": "ambient"}}
    film = {"kind": "convection", "between": ["hot", "air"], "conductance": "2 W/K"}
    swap = [{"kind": "sensor_swap", "with": "U"}]
    sensors = {"T": {"measures": "hot", **SENSED, "effects": swap}, "U": {"measures": "air", **SENSED}}
    sources = {"heater": {**heater(80), "into": {"hot": 1}}}
    found = machine(nodes, links={"film": film}, sources=sources, sensors=sensors)
    result = simulate(found, schedule(T, ROOM, start=Start(others=20.0)))
    assert result.sensors["U"][-1] > 25 > result.sensors["T"][-1] == pytest.approx(20)
