"""Loggers whose clock is off against the inputs: found with the channels and the seconds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from test_diagnosis import CONCEALED, HELD_OUT, plant, recorded
from test_swapped_sensors import GROWS, runs_of

from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.diagnose import diagnose
from network.machine.machine import Machine
from network.recordings.recording import Recording

TEMPERATURES = ("T_housing", "T_column")


def late(run: Recording, seconds: float, names: Sequence[str]) -> Recording:
    """The run with channels that a clock stamps so many seconds late."""
    columns = {n: replace(c, values=np.interp(run.t - seconds, run.t, c.values)) if n in names else c
               for n, c in run.columns.items()}  # fmt: skip
    return replace(run, columns=columns)


def probed() -> Machine:
    probe = {"sensors": {"dz": {"measures": "tcp.z", "noise": "0.3 um"}}}
    return plant().patched({"tcp": {"z": {"grows": {**GROWS, "of": "housing"}}}, **probe}, "test")


def test_all_channels_and_those_of_one_quantity_are_proposed() -> None:
    machine = probed()
    found = [c for c in candidates(machine, machine.inputs) if c.kind.kind == "clock_shift"]
    assert {frozenset(c.channels) for c in found} == {
        frozenset(machine.sensors), frozenset(n for n in machine.sensors if n != "dz"), frozenset({"dz"}),
    }  # fmt: skip
    assert all([p.field.key for p in c.own] == ["late"] for c in found)


@pytest.mark.parametrize("seconds", [30.0, 90.0, pytest.param(400.0, marks=pytest.mark.proof)])
def test_a_diagnosis_tells_by_how_much_a_clock_is_late(seconds: float) -> None:
    names = [*plant().sensors]
    runs = [late(r, seconds, names) for r in runs_of(plant())]
    d = diagnose(plant(), runs, [late(recorded(plant(), HELD_OUT, 9), seconds, names)], seed=1)
    assert d.verdict == "sensor_fault" and [f.kind for f in d.findings] == ["clock_shift"]
    (value,) = d.findings[0].parameters.values()
    assert value.value == pytest.approx(seconds, abs=max(3 * value.std, 5.0))
    assert {*d.findings[0].channels} == {*names}


def test_what_warms_late_is_no_clock() -> None:
    d = diagnose(plant(), runs_of(plant(**CONCEALED["source"])), seed=1)
    assert not any(f.kind == "clock_shift" for f in d.findings)
