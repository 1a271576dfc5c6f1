"""Two blocks, a heater that is switched, and what may be wrong with how they are measured."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from catalogue import read_text

from network import Machine, Recording, simulate
from network.recordings.columns import Column
from network.recordings.inputs import Schedule, Start, constant, hold

HEAD = "machine: blocks\nreference: 20 degC\n"
BLOCKS = (
    HEAD
    + """
nodes:
  a: {heat_capacity: 3 kJ/K}
  b: {heat_capacity: 8 kJ/K}
  air: {temperature: ambient}
links:
  ab: {kind: conduction, between: [a, b], conductance: 4 W/K}
  skin: {kind: convection, between: [b, air], conductance: 3 W/K}
sources:
  heater: {kind: heat_source, into: {a: 1}, power: 60 W, with: Q1, at: 100 %}
tcp:
  z: {grows: {kind: stretching, of: b, length: 300 mm, expansion: 1.1e-5 1/K, direction: 1}}
sensors:
  Ta: {measures: a, noise: 0.05 K}
  Tb: {measures: b, noise: 0.05 K}
  dz: {measures: tcp.z, noise: 0.3 um}
"""
)
SENSORS: dict[str, dict[str, Any]] = {
    "Ta": {"measures": "a", "noise": "0.05 K"},
    "Tb": {"measures": "b", "noise": "0.05 K"},
    "dz": {"measures": "tcp.z", "noise": "0.3 um"},
}
MINUTES = np.array([0.0, 40, 70, 120])
LEVELS = np.array([1.0, 0.0, 0.6, 0.0])
UNITS = {"ambient": "degC", "Q1": "%", "Ta": "degC", "Tb": "degC", "dz": "um"}
UNCERTAIN = {
    "nodes": {"a": {"heat_capacity": "3 kJ/K ± 20 %"}, "b": {"heat_capacity": "8 kJ/K ± 20 %"}},
    "links": {
        "ab": {"kind": "conduction", "between": ["a", "b"], "conductance": "4 W/K ± 30 %"},
        "skin": {"kind": "convection", "between": ["b", "air"], "conductance": "3 W/K ± 30 %"},
    },
}


def blocks(patch: Mapping[str, Any] | None = None) -> Machine:
    return Machine.read(read_text(BLOCKS), "blocks").patched(patch or {})


def effect(channel: str, **body: Any) -> dict[str, Any]:
    """The patch that puts an effect on a channel."""
    return {"sensors": {channel: {**SENSORS[channel], "effects": [body]}}}


def schedule() -> Schedule:
    """Three hours, the heater on, off, on at 60 % and off."""
    signals = {"ambient": constant("ambient", "degC", 21.0), "Q1": hold("Q1", "%", 60 * MINUTES, LEVELS)}
    return Schedule("blocks", "blocks", np.arange(541) * 20.0, signals, Start(others=20.0))


def record(machine: Machine, seed: int = 1) -> Recording:
    """What it really did, with noise."""
    run = simulate(machine, schedule(), noise_seed=seed)
    found = {**run.sensors, **run.inputs}
    columns = {name: Column(name, UNITS[name], values) for name, values in found.items()}
    return Recording("blocks", "blocks.csv", run.t, columns, start=Start(others=20.0))
