"""A machine of two blocks for tests of fits, and recordings of it that a seed draws."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import build as small
import numpy as np

from network import Machine
from network.analysis.calibration.gauss_newton import Problem, make_problem
from network.analysis.calibration.measured_means import weigh_recording
from network.engine.response.parameters import free_parameters
from network.engine.simulation import simulate
from network.recordings.columns import Column
from network.recordings.inputs import Schedule, Signal, Start, constant, hold
from network.recordings.recording import Recording

GROWS = {"kind": "stretching", "of": "body", "length": "300 mm", "expansion": "1.1e-5 1/K", "direction": 1}


def two_blocks(**sections: Mapping[str, Any]) -> Machine:
    """A motor block on a body, both in air; six uncertain numbers. `sections`: entries on top."""
    given: dict[str, dict[str, Any]] = {
        "nodes": {
            "motor": {"heat_capacity": "4 kJ/K ± 20 %"}, "body": {"heat_capacity": "15 kJ/K"},
            "air": {"temperature": "ambient"},
        },
        "links": {
            "flange": {"kind": "conduction", "between": ["motor", "body"], "conductance": "12 W/K ± 30 %"},
            "fins": {"kind": "convection", "between": ["motor", "air"], "conductance": "4 W/K ± 30 %"},
            "skin": {"kind": "convection", "between": ["body", "air"], "conductance": "7 W/K ± 30 %"},
        },
        "sources": {
            "loss": {
                "kind": "motor_loss", "into": {"motor": 1}, "copper": "60 W ± 40 %", "iron": "200 W ± 40 %",
                "iron_exponent": 1.5, "reference_speed": "8000 rpm",
            },
        },
        "tcp": {"z": {"grows": GROWS}},
        "sensors": {
            "T_motor": {"measures": "motor", "noise": "0.05 K"}, "T_body": {"measures": "body", "noise": "0.05 K"},
            "dz": {"measures": "tcp.z", "noise": "0.25 um"},
        },
    }  # fmt: skip
    for name, entries in sections.items():
        own = given.setdefault(name, {})
        own |= {k: {**own.get(k, {}), **v} if name == "tcp" else v for k, v in entries.items()}
    return small.machine(given.pop("nodes"), **given)


def speeds(*steps: tuple[float, float], hours: float = 4, every: float = 10.0, **more: Signal) -> Schedule:
    """Held speeds [h, rpm], 20 °C of air unless `ambient` is among `more`."""
    t, rpm = np.array(steps).T
    signals = [hold("speed", "rpm", t * 3600, rpm * small.RPM), *more.values()]
    if "ambient" not in more:
        signals.append(constant("ambient", "degC", 20.0))
    return small.schedule(np.arange(0.0, hours * 3600 + 1, every), *signals)


USUAL = ((0.0, 6000), (0.8, 2000), (1.6, 8000), (2.7, 0))
ANOTHER = ((0.0, 3000), (0.5, 8000), (1.9, 5000), (3.1, 1000))


def recorded(
    machine: Machine, schedule: Schedule, seed: int | None, more: Mapping[str, np.ndarray] | None = None
) -> Recording:
    """What the sensors read: the run, white noise by a seed, and what `more` adds to channels."""
    run = simulate(machine, schedule, parts=False)
    draw, t = np.random.default_rng(seed), schedule.t
    columns = {}
    for name, values in run.sensors.items():
        noise = machine.sensors[name].sigma * draw.standard_normal(len(t)) if seed is not None else 0.0
        columns[name] = Column(name, machine.sensors[name].unit, values + noise + (more or {}).get(name, 0.0))
    inputs = {n: Column(n, s.unit, s.at(t)) for n, s in schedule.signals.items()}
    return Recording("run", "test", t, columns | inputs, start=Start(others=20.0))


def problem_of(machine: Machine, *recordings: Recording) -> Problem:
    return make_problem(machine, free_parameters(machine), [weigh_recording(machine, r) for r in recordings])


def ou_series(t: np.ndarray, size: float, tau: float, seed: int) -> np.ndarray:
    """A draw of an OU process at even instants."""
    draw = np.random.default_rng(seed).standard_normal(len(t))
    keep = np.exp(-(t[1] - t[0]) / tau)
    x = np.empty(len(t))
    x[0] = draw[0]
    for k in range(1, len(t)):
        x[k] = keep * x[k - 1] + np.sqrt(1 - keep**2) * draw[k]
    return size * x
