"""`while` on a sensor: readings count only while an input is not zero, wherever a recording meets a machine."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from measured_side import SENSORS, UNCERTAIN, blocks, record, schedule

from network import Recording, Refused, calibrate, compare, diagnose, simulate
from network.engine.assembly import build
from network.engine.start import start_temperatures
from network.recordings.columns import Column
from network.recordings.counted_readings import drop_uncounted
from network.recordings.inputs import Signal, constant

COLD = 12.0
"""°C of a pipe that stands."""


def counts(channel: str, switch: str) -> dict[str, Any]:
    return {"sensors": {channel: {**SENSORS[channel], "while": switch}}}


def in_a_pipe(seed: int = 1, **patch: Any) -> Recording:
    """The second thermometer hangs in a pipe that is cold while the pump stands: every other half hour."""
    recording = record(blocks(patch), seed)
    pump = (recording.t // 1800 % 2 == 1).astype(float)
    true = recording.columns["Tb"]
    seen = replace(true, values=np.where(pump > 0, true.values, COLD))
    return replace(recording, columns={**recording.columns, "Tb": seen, "pump": Column("pump", "1", pump)})


def test_readings_count_only_while_the_input_runs() -> None:
    recording = in_a_pipe()
    plain, gated = (compare(blocks(p), recording).recordings[0] for p in ({}, counts("Tb", "pump")))
    assert plain.channels["Tb"].rmse_in_noise > 30
    assert gated.channels["Tb"].rmse_in_noise == pytest.approx(1, abs=0.15)
    on = recording.columns["pump"].values > 0
    assert np.array_equal(gated.channels["Tb"].finite, on) and gated.channels["Ta"].n == len(recording.t)
    assert np.array_equal(gated.trajectory.sensors["Tb"], plain.trajectory.sensors["Tb"])


def test_a_fit_is_not_drawn_by_what_does_not_count() -> None:
    recording, held_out = in_a_pipe(1), in_a_pipe(2)
    found = calibrate(blocks({**UNCERTAIN, **counts("Tb", "pump")}), recording, held_out)
    assert found.after.rmse_in_noise < 1.2 and found.after_holdout is not None
    assert found.after_holdout.rmse_in_noise < 1.2
    assert found.machine.nodes["b"].capacity == pytest.approx(8000, rel=0.02)
    assert calibrate(blocks(UNCERTAIN), recording).after.rmse_in_noise > 12


def test_a_diagnosis_finds_nothing_behind_readings_that_do_not_count() -> None:
    told = diagnose(blocks({**UNCERTAIN, **counts("Tb", "pump")}), in_a_pipe(1), [in_a_pipe(2)])
    assert told.verdict in ("adequate", "parameters_only") and not told.findings


def test_a_display_that_freezes_at_standstill() -> None:
    recording = record(blocks())
    runs = recording.columns["Q1"].values != 0
    last = np.maximum.accumulate(np.where(runs, np.arange(len(runs)), 0))
    dz = recording.columns["dz"]
    frozen = replace(recording, columns={**recording.columns, "dz": replace(dz, values=dz.values[last])})
    plain, gated = (compare(blocks(p), frozen).recordings[0].channels["dz"] for p in ({}, counts("dz", "Q1")))
    assert plain.n < len(runs) and gated.rmse_in_noise < 1.2 and gated.n == runs.sum()


def test_a_run_does_not_start_at_a_reading_that_does_not_count() -> None:
    recording = replace(in_a_pipe(), start=None)
    machine, gated = blocks(), blocks(counts("Tb", "pump"))
    warm = replace(recording, columns={**recording.columns, "Ta": Column("Ta", "degC", np.full(541, 30.0))})
    inputs = schedule()
    starts = [start_temperatures(build(m), replace(inputs, start=None), warm) for m in (machine, gated)]
    b = build(machine).parts["b"]
    assert starts[0][b] == COLD and 21 < starts[1][b] < 30


def test_a_recording_without_gated_channels_stays_itself() -> None:
    recording = in_a_pipe()
    assert drop_uncounted(blocks(), recording) is recording
    once = drop_uncounted(blocks(counts("Tb", "pump")), recording)
    assert once is not recording and drop_uncounted(blocks(counts("Tb", "pump")), once) is once


def test_the_input_is_needed_to_compare_and_not_to_simulate() -> None:
    gated = blocks(counts("Tb", "pump"))
    assert gated.inputs["pump"] == "" and "pump" not in gated.drives
    assert simulate(gated, schedule()).sensors["Tb"].max() > 25
    with pytest.raises(Refused, match="the machine needs the input `pump`, which the recording lacks"):
        compare(gated, record(blocks()))


def test_a_switch_may_be_a_constant_of_the_recording() -> None:
    recording = record(blocks())
    switches: dict[str, Signal] = {"pump": constant("pump", "1", 1.0)}
    assert drop_uncounted(blocks(counts("Tb", "pump")), replace(recording, constants=switches)) is not None
    on = compare(blocks(counts("Tb", "pump")), replace(recording, constants=switches)).recordings[0]
    assert on.channels["Tb"].n == len(recording.t)
    off = {"pump": constant("pump", "1", 0.0)}
    assert compare(blocks(counts("Tb", "pump")), replace(recording, constants=off)).recordings[0].channels["Tb"].n == 0


def test_it_reads_back_and_is_told() -> None:
    from network.report.words.describe import describe

    gated = blocks(counts("Tb", "pump"))
    assert gated.sensors["Tb"].to_plain()["while"] == "pump"
    assert "while pump is not zero" in str(describe(gated))
