"""A schedule for a machine where none is given: everything that heats on for a warm-up, then off for as long."""

from __future__ import annotations

import numpy as np

from network.engine.assembly import build
from network.engine.time_constants import time_constants
from network.machine.machine import Machine
from network.platform.quantities.units import unit
from network.recordings.inputs import Schedule, Signal, constant, hold
from network.recordings.scenario import Scenario

USUAL = {"rpm": 6000.0, "m/min": 10.0, "W": 1000.0, "W/m^2": 500.0}
"""What inputs of these units are on at; all others at 1, or at 100 %."""
SETTLED = 3.0
"""Time constants of the slowest part that a warm-up lasts: 95 % of its rise."""
SHORTEST, LONGEST = 2 * 3600.0, 12 * 3600.0
"""s: of a warm-up."""
INSTANTS = 2880
"""30 s or less apart, so that what a relay does is seen."""


def usual_program(machine: Machine) -> Scenario:
    """Temperatures stay at the reference; axes stand at 0. It lasts 4 to 24 h, half of it off."""
    taus = time_constants(build(machine))
    slowest = max((tau for tau in taus if np.isfinite(tau)), default=SHORTEST)
    half = float(np.clip(SETTLED * slowest, SHORTEST, LONGEST))
    signals = {name: _signal(machine, name, text, half) for name, text in machine.inputs.items()}
    t = np.linspace(0.0, 2 * half, INSTANTS + 1)
    return Scenario(Schedule("a warm-up and rest", "a usual program", t, signals), float(t[1]))


def _signal(machine: Machine, name: str, text: str, half: float) -> Signal:
    of = unit(text)
    if of.is_temperature:
        return constant(name, text, machine.reference)
    if of.dimension == unit("m").dimension:
        return constant(name, text, 0.0)
    usual = next((u for u in USUAL if unit(u).dimension == of.dimension), None)
    high = unit(usual).to_si(USUAL[usual]) if usual is not None else of.to_si(100.0 if text == "%" else 1.0)
    return hold(name, text, np.array([0.0, half]), np.array([high, 0.0]))
