"""Machines for the tests of fits, one of each kind that is computed in another way."""

from __future__ import annotations

import numpy as np
from fits import USUAL, speeds, two_blocks

from network import Machine
from network.recordings.inputs import Schedule, linear

STEEL = {"material": "steel", "length": "400 mm", "area": "60 cm^2", "lumps": 10}
BAR = {"kind": "stretching", "of": "body@0..0.5", "direction": 1}
VISCOUS = {
    "kind": "viscous_friction", "into": {"motor": 0.5, "body": 0.5}, "torque": "250 N mm ± 30 %",
    "thinning": "0.03 1/K ± 30 %", "reads": "motor",
}  # fmt: skip
RADIATES = {"kind": "radiation", "between": ["motor", "air"], "emissivity_area": "0.5 m^2 ± 30 %"}
FAN = {
    "kind": "forced_convection", "between": ["motor", "air"], "conductance": "3 W/K ± 30 %", "gain": "1.5 ± 30 %",
    "exponent": 0.8, "reference_speed": "8000 rpm",
}  # fmt: skip
LAGS = {"measures": "motor", "noise": "0.05 K", "effects": [{"kind": "sensor_lag", "lag": "150 s ± 30 %"}]}


def cooler(delay: str) -> dict[str, object]:
    return {
        "kind": "thermostat_cooling", "into": {"body": 1}, "watches": "body", "set": "26 degC ± 0.5 K",
        "hysteresis": "0.6 K ± 20 %", "power": "260 W ± 20 %", "delay": delay,
    }  # fmt: skip


def machines() -> dict[str, Machine]:
    """By what is special about each."""
    seat = {
        "flange": {"kind": "conduction", "between": ["motor", "seat"], "conductance": "20 W/K ± 30 %"},
        "seat": {"kind": "conduction", "between": ["seat", "body"], "conductance": "30 W/K ± 30 %"},
        "seat skin": {"kind": "convection", "between": ["seat", "air"], "conductance": "2 W/K ± 30 %"},
    }
    stream = {
        "hose": {"kind": "advection", "through": ["supply", "body"], "capacity_flow": "15 W/K ± 20 %", "delay": "60 s"}
    }
    return {
        "linear": two_blocks(),
        "bar": two_blocks(nodes={"body": STEEL}, tcp={"z": {"grows": BAR}},
                          links={"flange": {"kind": "conduction", "between": ["motor", "body@0..0.2"],
                                            "conductance": "12 W/K ± 30 %"}}),
        "massless": two_blocks(nodes={"seat": {}}, links=seat,
                               sensors={"T_seat": {"measures": "seat", "noise": "0.05 K"}},
                               sources={"rub": {"kind": "heat_source", "into": {"seat": 1}, "power": "30 W ± 20 %",
                                                "with": "running"}}),
        "stream": two_blocks(nodes={"supply": {"temperature": "18 degC"}}, links=stream),
        "lag": two_blocks(sensors={"T_motor": LAGS}),
        "fan": two_blocks(links={"fins": FAN}),
        "bent": two_blocks(sources={"rub": VISCOUS}, links={"glow": RADIATES}),
        "relay": two_blocks(sources={"cooler": cooler("0 s")}),
        "delayed relay": two_blocks(sources={"cooler": cooler("25 s ± 20 %")}),
        "zeroed": two_blocks(sensors={"dz": {"measures": "tcp.z", "noise": "0.25 um", "zero": "start"}}),
    }  # fmt: skip


def ramped() -> Schedule:
    """A room that warms, then cools."""
    t = np.array([0.0, 1.7, 4.0]) * 3600
    return speeds(*USUAL, ambient=linear("ambient", "degC", t, np.array([20.0, 23.0, 21.0])))
