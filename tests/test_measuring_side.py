"""What is wrong with how a machine is measured: recorded, hidden from its file, put back and fitted; by all solvers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from measured_side import UNCERTAIN, blocks, effect, record, schedule

from network import Machine, Recording, Refused, calibrate, compare, diagnose, simulate
from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.candidates.recorded_powers import gather_runs
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.catalogue.declaration.discovery import kinds

NOTHING = 1.1
"""σ: what noise leaves of a recording of 1623 readings; 99.9 % of such stay below 1.06."""


def drifts(**body: str) -> dict[str, Any]:
    return {"nodes": {"air": {"temperature": "ambient", "drifts": body}}}


def jump(size: str) -> dict[str, Any]:
    body = {"kind": "displacement_step", "size": size, "begins": "95 min", "direction": -1}
    return {"tcp": {"z": {"jump": body}}}


def fault(shape: str, size: str) -> dict[str, Any]:
    return effect("Ta", kind="sensor_fault", shape=shape, size=size, begins="65 min")


def shifted(channel: str, late: str) -> dict[str, Any]:
    return effect(channel, kind="clock_shift", late=late)


def crosstalk(share: str) -> dict[str, Any]:
    return effect("Ta", kind="sensor_crosstalk", share=share, **{"with": "Q1"})


HOUR = 3600.0
EFFECTS: dict[str, tuple[dict[str, Any], dict[str, Any], float]] = {
    "crosstalk": (crosstalk("0.03 K/%"), crosstalk("0.01 K/% ± 0.05 K/%"), 3.0),
    "offset": (fault("offset", "2 K"), fault("offset", "0.5 K ± 3 K"), 2.0),
    "drift": (fault("drift", "0.7 K/h"), fault("drift", "0.1 K/h ± 2 K/h"), 0.7 / HOUR),
    "drift told per hour": (fault("drift", "0.7 K"), fault("drift", "0.1 K ± 2 K"), 0.7),
    "late display": (shifted("dz", "150 s"), shifted("dz", "10 s ± 200 s"), 150.0),
    "early sensor": (shifted("Ta", "-100 s"), shifted("Ta", "10 s ± 200 s"), -100.0),
    "slow display": (effect("dz", kind="sensor_lag", lag="150 s"), effect("dz", kind="sensor_lag", lag="90 s ± 60 %"),
                     150.0),
    "step": (jump("6 um"), jump("2 um ± 100 %"), 6e-6),
    "room drifts": (drifts(rate="0.8 K/h"), drifts(rate="0 K/h ± 1 K/h"), 0.8 / HOUR),
    "room above": (drifts(offset="1.5 K"), drifts(offset="0 K ± 1 K"), 1.5),
    "room swings": (drifts(swing="1.5 K", period="2 h"), drifts(swing="1 K ± 60 %", period="2 h"), 1.5),
}  # fmt: skip
each = pytest.mark.parametrize("name", EFFECTS)


@each
def test_what_is_hidden_shows_and_is_fitted_when_it_is_put_back(name: str) -> None:
    real, unsure, value = EFFECTS[name]
    recording = record(blocks(real))
    assert compare(blocks(), recording).rmse_in_noise > 2 * compare(blocks(real), recording).rmse_in_noise
    assert compare(blocks(real), recording).rmse_in_noise < NOTHING
    found = calibrate(blocks(unsure), recording)
    (number,) = found.machine.uncertain.values()
    std = number.spread * (number.value if number.prior == "log" else 1.0)
    assert number.value == pytest.approx(value, rel=0.05) and std < 0.05 * abs(value)
    assert found.after.rmse_in_noise < NOTHING


@each
def test_every_solver_reads_the_same(name: str) -> None:
    machine = blocks(EFFECTS[name][0])
    methods = {"modal": None, "expm": None, "rosenbrock": 1e-9, "solve_ivp:LSODA": 1e-10}
    runs = [simulate(machine, schedule(), method=name, rtol=rtol) for name, rtol in methods.items()]
    for channel, scale in {"Ta": 1.0, "Tb": 1.0, "dz": 1e6}.items():
        for run in runs[1:]:
            np.testing.assert_allclose(scale * run.sensors[channel], scale * runs[0].sensors[channel], atol=2e-5)


@each
def test_it_reloads_as_it_is(name: str) -> None:
    for patch in EFFECTS[name][:2]:
        machine = blocks(patch)
        again = Machine.read(machine.tree, machine.file)
        assert dict(again.entries()) == dict(machine.entries()) and again.inputs == machine.inputs
        assert again.uncertain == machine.uncertain


# -- sensors exchanged ----------------------------------------------------------------------------------------------
def exchanged(*channels: str) -> dict[str, Any]:
    other = {"Ta": "Tb", "Tb": "Ta"}
    bodies = (effect(c, kind="sensor_swap", **{"with": other[c]})["sensors"] for c in channels)
    return {"sensors": {name: body for one in bodies for name, body in one.items()}}


@pytest.mark.parametrize("said_at", [("Ta",), ("Tb",), ("Ta", "Tb")])
def test_exchanged_sensors_read_each_others_places(said_at: tuple[str, ...]) -> None:
    right, wrong = (simulate(m, schedule()).sensors for m in (blocks(), blocks(exchanged(*said_at))))
    assert np.array_equal(wrong["Ta"], right["Tb"]) and np.array_equal(wrong["Tb"], right["Ta"])


def with_exchanged_columns(recording: Recording) -> Recording:
    columns = dict(recording.columns)
    columns["Ta"], columns["Tb"] = replace(columns["Tb"], name="Ta"), replace(columns["Ta"], name="Tb")
    return replace(recording, columns=columns)


def test_exchanged_columns_are_fitted_as_well_as_the_right_ones() -> None:
    recording = record(blocks())
    right = calibrate(blocks(UNCERTAIN), recording).after.rmse_in_noise
    found = calibrate(blocks({**UNCERTAIN, **exchanged("Ta")}), with_exchanged_columns(recording)).after
    assert found.rmse_in_noise == pytest.approx(right, rel=1e-3)
    assert compare(blocks(), with_exchanged_columns(recording)).rmse_in_noise > 20 * right


def test_a_proposal_exchanges_both_and_explains_it() -> None:
    recording = with_exchanged_columns(record(blocks()))
    (patch,) = kinds("effects")["sensor_swap"].proposes(blocks())
    assert {*patch["sensors"]} == {"Ta", "Tb"}
    assert compare(blocks(patch), recording).rmse_in_noise < NOTHING
    assert not [*kinds("effects")["sensor_swap"].proposes(blocks(patch))]


@pytest.mark.parametrize(("other", "fault"), [
    ("Tc", "exchanged with 'Tc', which is no other sensor"), ("Ta", "which is no other sensor"),
    ("dz", "measures a temperature and is exchanged with a displacement"),
])  # fmt: skip
def test_an_exchange_that_cannot_be_is_refused(other: str, fault: str) -> None:
    with pytest.raises(Refused, match=fault):
        blocks(effect("Ta", kind="sensor_swap", **{"with": other}))


def test_three_are_not_exchanged() -> None:
    third = {"sensors": {"Tc": {"measures": "b", "noise": "0.1 K", "effects": [{"kind": "sensor_swap", "with": "Tb"}]}}}
    with pytest.raises(Refused, match="exchange two at a time"):
        blocks(exchanged("Ta")).patched(third)


def test_the_channels_of_one_logger_share_a_number() -> None:
    late = {"late": "10 s ± 200 s"}
    shared = {"sensors": {
        **shifted("dz", late["late"])["sensors"],
        **{n: effect(n, kind="clock_shift", **{"with": "dz"})["sensors"][n] for n in ("Ta", "Tb")},
    }}  # fmt: skip
    each_late = [shifted(name, "150 s")["sensors"] for name in ("Ta", "Tb", "dz")]
    recording = record(blocks({"sensors": {k: v for one in each_late for k, v in one.items()}}))
    found = calibrate(blocks(shared), recording)
    ((path, number),) = found.machine.uncertain.items()
    assert path == "sensors.dz.effects.0.late" and number.value == pytest.approx(150, abs=4)
    assert found.after.rmse_in_noise < NOTHING < compare(blocks(), recording).rmse_in_noise / 2
    with pytest.raises(Refused, match="clock_shift with 'Tb', which has none of its own"):
        blocks(effect("Ta", kind="clock_shift", **{"with": "Tb"}))


# -- units ----------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(("share", "unit"), [("0.2 K/W", "W"), ("0.1 K/(m/min)", "m/min"), ("2 K", "1")])
def test_a_share_comes_per_unit_of_its_input(share: str, unit: str) -> None:
    machine = blocks(effect("Ta", kind="sensor_crosstalk", share=f"{share} ± 20 %", **{"with": "load"}))
    assert machine.inputs["load"] == unit
    assert machine.sensors["Ta"].effects[0].to_plain()["share"].startswith(share)
    with pytest.raises(Refused, match="one input has one kind of unit"):
        blocks(effect("Ta", kind="sensor_crosstalk", share=share, **{"with": "ambient"}))


@pytest.mark.parametrize("share", ["3", "3 W/K", "3 degC/", "K/%"])
def test_a_share_of_another_kind_is_refused(share: str) -> None:
    with pytest.raises(Refused, match="share '"):
        blocks(effect("Ta", kind="sensor_crosstalk", share=share, **{"with": "Q1"}))


@pytest.mark.parametrize(("body", "fault"), [
    ({"size": "2 K"}, "has a size, and a loose contact has a share"),
    ({"shape": "offset", "share": 0.2, "surroundings": "21 degC"}, "a fault of shape offset has a size"),
    ({"shape": "offset", "size": "2 K/h"}, "grows with time, and an offset stays"),
    ({"shape": "drift", "share": 0.2, "size": "2 K"}, "give exactly one of"),
    ({"shape": "drift", "size": "2 W"}, "size '2 W' is in W; a unit like K is needed"),
])  # fmt: skip
def test_a_fault_that_contradicts_itself_is_refused(body: Mapping[str, Any], fault: str) -> None:
    with pytest.raises(Refused, match=fault):
        blocks(effect("Ta", kind="sensor_fault", **body))


def test_only_what_is_held_drifts() -> None:
    with pytest.raises(Refused, match="drifts but its temperature is not held"):
        blocks({"nodes": {"a": {"heat_capacity": "3 kJ/K", "drifts": {"rate": "1 K/h"}}}})


# -- found ----------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(("name", "kind"), [("crosstalk", "sensor_crosstalk"), ("room drifts", "ambient_drift")])
def test_its_proposal_is_fitted_and_explains_it(name: str, kind: str) -> None:
    real, _, value = EFFECTS[name]
    case = Case(blocks(UNCERTAIN), (record(blocks(real)),))
    own = [c for c in candidates(case.machine, case.drivers) if c.kind.kind == kind]
    fits = [fit_hypothesis(case, c.machine, (c,), c.own) for c in own]
    best = min(fits, key=lambda h: h.chi)
    assert best.chi < NOTHING < fit_hypothesis(case, case.machine).chi / 2
    (found,) = best.own_values.values()
    assert found == pytest.approx(value, rel=0.1)


@pytest.mark.parametrize(("name", "kind", "where"), [
    ("crosstalk", "sensor_crosstalk", "Ta"), ("room drifts", "ambient_drift", "air"),
])  # fmt: skip
def test_a_diagnosis_names_it(name: str, kind: str, where: str) -> None:
    told = diagnose(blocks(UNCERTAIN), record(blocks(EFFECTS[name][0])))
    (finding,) = told.findings
    assert (finding.kind, *finding.places, *finding.channels) == (kind, where)


def test_crosstalk_is_proposed_of_every_input_that_is_no_temperature() -> None:
    bodies = [p["sensors"] for p in kinds("effects")["sensor_crosstalk"].proposes(blocks())]
    tried = {(name, e["with"], e["share"]) for body in bodies for name, s in body.items() for e in s["effects"]}
    assert tried == {(name, "Q1", share) for name in ("Ta", "Tb") for share in ("0.01 K/%", "-0.01 K/%")}


def test_along_an_input_that_never_changes_crosstalk_is_a_constant_error() -> None:
    """In runs of one value each it is one, in runs of several values it is not."""
    machine, run = blocks(), record(blocks())
    drives = run.columns["Q1"]
    held = [replace(run, columns={**run.columns, "Q1": replace(drives, values=0 * run.t + x)}) for x in (5, 9)]
    for runs, tried in (((run,), True), (held[:1], False), (held, True)):
        told = gather_runs(machine, runs, machine.inputs)
        assert bool([*kinds("effects")["sensor_crosstalk"].proposes_on(machine, told)]) is tried
