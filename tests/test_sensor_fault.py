"""A loose contact reads between its part and the air: by hand, in a run, in its window, beside other effects."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from catalogue import machine

from network.analysis.comparison.compare import compare
from network.catalogue.sensors.sensor_fault import SensorFault
from network.catalogue.sensors.sensor_lag import SensorLag
from network.engine.simulation import simulate
from network.engine.trajectory import Trajectory
from network.machine.machine import Machine
from network.platform.refusal import Refused
from network.recordings.columns import Column
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario

HOUR = 3600.0
INPUTS = {"speed": "6000 rpm", "position": "200 mm"}
AIR = {"ambient": {"ramp": {"from": "18 degC", "to": "26 degC", "for": "4 h"}}}


def loose(*effects: dict[str, Any]) -> Machine:
    sensor = {"measures": "housing", "noise": "0.05 K"}
    return machine().patched({"sensors": {"T": {**sensor, "effects": list(effects)}, "true": sensor}})


def fault(share: float = 0.3, **more: str) -> dict[str, Any]:
    return {"kind": "sensor_fault", "share": share, "surroundings": "ambient", **more}


def run(on: Machine, start: str = "22 degC") -> Trajectory:
    return simulate(on, Scenario.of("warm", "4 h", INPUTS | AIR, output="1 min", start=start))


def test_it_reads_between_its_part_and_the_air() -> None:
    result = run(loose(fault()))
    true, air = result.sensors["true"], np.linspace(18, 26, len(result.t))
    assert result.sensors["T"] == pytest.approx(true + 0.3 * (air - true), abs=1e-9)
    assert true.max() > 30


def test_it_reads_the_truth_outside_its_window() -> None:
    result = run(loose(fault(begins="1 h", ends="150 min")))
    off = np.abs(result.sensors["T"] - result.sensors["true"])
    inside = (result.t >= HOUR) & (result.t < 2.5 * HOUR)
    assert off[~inside].max() == 0 and off[inside].min() > 0.1


def test_a_constant_air_needs_no_input() -> None:
    on = loose(fault(surroundings="20 degC"))
    assert run(on).sensors["T"] == pytest.approx(0.7 * run(on).sensors["true"] + 0.3 * 20, abs=1e-9)
    assert "ambient" not in SensorFault(share=0.3, surroundings=20.0).needs()


def test_its_air_is_an_input_of_the_machine() -> None:
    faulty = loose(fault() | {"surroundings": "shop"})
    assert faulty.inputs["shop"] == "degC" and "shop" not in machine().inputs


def test_it_goes_behind_a_lag_and_not_before() -> None:
    lag = {"kind": "sensor_lag", "lag": "5 min"}
    result, slow = run(loose(lag, fault())), run(loose(lag)).sensors["T"]
    air = np.linspace(18, 26, len(result.t))
    assert result.sensors["T"] == pytest.approx(0.7 * slow + 0.3 * air, abs=1e-9)
    with pytest.raises(Refused, match="sensor_lag stands behind sensor_fault; list sensor_lag first"):
        loose(fault(), lag)


@pytest.mark.parametrize("kind", [fault(), {"kind": "sensor_offset", "offset": "0.1 K"}])
def test_what_a_thermometer_does_is_refused_on_a_displacement(kind: dict[str, Any]) -> None:
    body = {"measures": "tcp.z", "noise": "0.3 um", "effects": [kind]}
    with pytest.raises(Refused, match=f"{kind['kind']} does not act on what measures tcp.z; it acts on a temperature"):
        machine().patched({"sensors": {"dz": body}})


def test_a_window_that_ends_before_it_begins_is_refused() -> None:
    with pytest.raises(Refused, match="ends before it begins; give a time after `begins`"):
        loose(fault(begins="2 h", ends="1 h"))


def test_a_proposal_reads_the_air_of_the_machine() -> None:
    patch, _ = SensorFault.proposes(machine())
    (effect,) = patch["sensors"]["T"]["effects"]
    assert effect["surroundings"] == "ambient"
    (alone,) = SensorFault.proposes(machine("one mass").patched({"nodes": {"air": {"temperature": "19 degC"}}}))
    assert alone["sensors"]["T"]["effects"][0]["surroundings"] == "19 degC"
    told = SensorFault.told(machine().patched(patch), patch)
    assert told == "T sits loose and reads 0.2 of the way from its part to ambient"


def test_a_lag_is_proposed_before_a_fault() -> None:
    patch, _ = SensorLag.proposes(machine().patched({"sensors": {"T": {
        "measures": "housing", "noise": "0.05 K", "effects": [fault()]}}}))  # fmt: skip
    assert [effect["kind"] for effect in patch["sensors"]["T"]["effects"]] == ["sensor_lag", "sensor_fault"]


def test_a_comparison_sees_the_fault_on_its_channel_alone() -> None:
    result = run(loose(fault()))
    named = {"T": result.sensors["T"], "true": result.sensors["true"]}
    columns = {name: Column(name, "degC", values) for name, values in named.items()}
    columns["ambient"] = Column("ambient", "degC", np.linspace(18, 26, len(result.t)))
    columns["speed"] = Column("speed", "rpm", np.full(len(result.t), 6000 * 2 * np.pi / 60))
    columns["position"] = Column("position", "m", np.full(len(result.t), 0.2))
    recording = Recording("loose", "loose.csv", result.t, columns, start=Start(others=22.0))
    (right,) = compare(loose(fault()), [recording]).recordings
    (wrong,) = compare(loose(), [recording]).recordings
    assert right.rmse_in_noise < 1e-4
    assert wrong.channels["T"].rmse_in_noise > 20 and wrong.channels["true"].rmse_in_noise < 1e-4
