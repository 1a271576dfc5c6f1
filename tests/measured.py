"""Recordings made by simulation: every sensor's noise, and whatever else a test does to the readings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from network import Machine, Recording, Scenario, simulate
from network.recordings.recording import Column

ROOT = Path(__file__).parents[1]
STEPS = {"ambient": "22 degC", "level": [{"for": "40 min", "at": "1"}, {"for": "40 min", "at": "0"}]}
BLOCKS = {
    "machine": "Two blocks",
    "reference": "22 degC",
    "nodes": {
        "hot": {"heat_capacity": "400 J/K"},
        "cold": {"heat_capacity": "400 J/K"},
        "room": {"temperature": "ambient"},
    },
    "links": {
        "joint": {"kind": "conduction", "between": ["hot", "cold"], "conductance": "3 W/K ± 30 %"},
        "hot skin": {"kind": "convection", "between": ["hot", "room"], "conductance": "0.5 W/K ± 30 %"},
        "cold skin": {"kind": "convection", "between": ["cold", "room"], "conductance": "0.5 W/K ± 30 %"},
    },
    "sources": {"heater": {"kind": "heat_source", "into": {"hot": 1}, "power": "12 W", "with": "level", "at": "1"}},
    "tcp": {"z": {"grows": {"kind": "stretching", "of": "hot", "length": "200 mm", "expansion": "1.1e-5 1/K",
                            "direction": 1}}},
    "sensors": {
        "T_hot": {"measures": "hot", "noise": "0.05 K"},
        "T_cold": {"measures": "cold", "noise": "0.05 K"},
        "dz": {"measures": "tcp.z", "noise": "0.25 um"},
    },
}  # fmt: skip


def blocks(**patch: Any) -> Machine:
    from network.platform.refusal import Spot
    from network.platform.yaml.document import Branch, tree_of

    tree = tree_of(BLOCKS, Spot("blocks"))
    assert isinstance(tree, Branch)
    machine = Machine.read(tree, "blocks")
    return machine.patched(patch) if patch else machine


def steps(duration: str = "80 min", inputs: Mapping[str, Any] = STEPS, output: str = "5 s") -> Scenario:
    return Scenario.of("steps", duration, dict(inputs), output=output)


def recorded(machine: Machine, scenario: Scenario, seed: int = 0, name: str = "readings") -> Recording:
    """A noisy simulation as a recording: inputs and sensors."""
    run = simulate(machine, scenario, noise_seed=seed)
    columns = {n: Column(n, s.unit, s.at(run.t)) for n, s in scenario.schedule.signals.items()}
    columns |= {n: Column(n, machine.sensors[n].unit, values) for n, values in run.sensors.items()}
    return Recording(name, f"{name}.csv", run.t, columns)


def changed(recording: Recording, **columns: Any) -> Recording:
    """The recording with the values of some columns exchanged by functions of (t, values)."""
    new = {n: replace(c, values=np.asarray(columns[n](recording.t, c.values.copy()))) if n in columns else c
           for n, c in recording.columns.items()}  # fmt: skip
    return replace(recording, columns=new)
