"""Machines and schedules of the benchmark: built in code, so that size and steps are free."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from network import Machine
from network.platform.refusal import Spot
from network.platform.yaml.document import Branch, tree_of
from network.recordings.inputs import Schedule, constant, hold

GROWS = {"length": "400 mm", "expansion": "1.1e-5 1/K", "direction": 1}
RPM = 2 * np.pi / 60
HOURS = 8


def chain_machine(nodes: int, seed: int = 0) -> Machine:
    """A spindle-like chain with cross links and losses: `nodes` heat capacities, seven outputs."""
    draw = np.random.default_rng(seed)
    names = [f"n{i}" for i in range(nodes)]
    links = {
        f"l{i}": {
            "kind": "conduction",
            "between": [names[i], names[i + 1]],
            "conductance": f"{draw.uniform(5, 80):.3f} W/K",
        }
        for i in range(nodes - 1)
    }
    links |= {
        f"skin{i}": {
            "kind": "convection",
            "between": [name, "ambient"],
            "conductance": f"{draw.uniform(0.5, 6):.3f} W/K",
        }
        for i, name in enumerate(names)
    }
    links |= {
        f"x{i}": {
            "kind": "conduction",
            "between": [names[i], names[i + 3]],
            "conductance": f"{draw.uniform(1, 9):.3f} W/K",
        }
        for i in range(0, nodes - 3, 4)
    }
    machine = {
        "machine": f"chain of {nodes}",
        "reference": "22 degC",
        "nodes": {n: {"heat_capacity": f"{draw.uniform(3, 40):.3f} kJ/K"} for n in names}
        | {"ambient": {"temperature": "ambient"}},
        "links": links,
        "sources": {
            "bearing": {"kind": "bearing_friction", "into": {names[0]: 0.5, names[1]: 0.5}, "torque": "520 N mm"},
            "motor": {
                "kind": "motor_loss", "into": {names[2]: 1}, "copper": "90 W", "iron": "240 W",
                "iron_exponent": 1.5, "reference_speed": "10000 rpm",
            },
        },
        "tcp": {
            axis: {"grows": {"kind": "stretching", "of": names[i], **GROWS}}
            for i, axis in enumerate(("y", "z"))
        },
        "sensors": {f"T{i}": {"measures": names[i], "noise": "0.05 K"} for i in range(5)}
        | {f"d{axis}": {"measures": f"tcp.{axis}", "noise": "0.25 um"} for axis in ("y", "z")},
    }  # fmt: skip
    tree = tree_of(machine, Spot("bench"))
    assert isinstance(tree, Branch)
    return Machine.read(tree, "bench")


def speed_steps(steps: int = 60, hours: float = HOURS, output: float = 1.0, seed: int = 1) -> Schedule:
    """Unequal speed steps, a sample every `output` seconds."""
    draw = np.random.default_rng(seed)
    edges = np.sort(draw.uniform(0, hours * 3600, steps - 1))
    speeds = draw.choice([0, 2000, 4000, 6000, 8000, 10000], steps) * RPM
    t = np.arange(0.0, hours * 3600 + output / 2, output)
    signals = {
        "speed": hold("speed", "rpm", np.append(0.0, edges), speeds),
        "ambient": constant("ambient", "degC", 21.5),
    }
    return Schedule(f"{steps} speed steps", "bench", t, signals)


def bars_machine(lumps: int, bars: int = 5) -> Machine:
    """Bars end to end with skins, a bearing and a motor in the first: `lumps` in all."""
    names = [f"bar{i}" for i in range(bars)]
    each = {"material": "steel", "length": "900 mm", "area": "90 cm^2", "lumps": lumps // bars}
    links = {
        f"joint{i}": {"kind": "conduction", "between": [f"{a}@1", f"{b}@0"], "conductance": f"{30 + 5 * i} W/K"}
        for i, (a, b) in enumerate(pairwise(names))
    } | {f"skin{i}": {"kind": "convection", "between": [n, "ambient"], "conductance": f"{2 + i} W/K"}
         for i, n in enumerate(names)}  # fmt: skip
    machine = {
        "machine": f"bars of {lumps} lumps", "reference": "22 degC",
        "nodes": dict.fromkeys(names, each) | {"ambient": {"temperature": "ambient"}}, "links": links,
        "sources": {
            "bearing": {"kind": "bearing_friction", "into": {"bar0@0.1..0.2": 1}, "torque": "520 N mm"},
            "motor": {"kind": "heat_source", "into": {"bar0@0.5..0.8": 1}, "power": "120 W", "with": "speed",
                      "at": "6000 rpm"},
        },
        "tcp": {axis: {"grows": {"kind": "stretching", "of": name, **GROWS}}
                for axis, name in zip(("y", "z"), names, strict=False)},
        "sensors": {f"T{i}": {"measures": f"{names[0]}@{at}", "noise": "0.05 K"}
                    for i, at in enumerate((0.05, 0.3, 0.5, 0.7, 0.95))},
    }  # fmt: skip
    tree = tree_of(machine, Spot("bench"))
    assert isinstance(tree, Branch)
    return Machine.read(tree, "bench")
