"""What moves in a test, from when to when, and which test of ISO 230-3 that makes it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from network.catalogue.declaration.declare import Array
from network.machine.machine import Machine
from network.platform.quantities.units import unit
from network.platform.refusal import Spot, refuse
from network.recordings.inputs import Schedule, Signal, constant

TITLES = {
    "etve": "environmental temperature variation error (ETVE) test",
    "spindle_constant": "test for thermal distortion caused by rotating spindles, constant speed",
    "spindle_spectrum": "test for thermal distortion caused by rotating spindles, variable-speed spectrum",
    "linear_axis": "test for thermal distortion caused by moving linear axes",
    "rotary_axis": "test for thermal distortion caused by rotary motion of components",
}
"""As ISO 230-3:2020 calls them."""
SPINDLE = ("speed", "spindle")
"""How the inputs begin that turn a spindle; what else turns is a rotary axis."""
MOTIONS = ("rpm", "m/min", "m")
"""Units of inputs that a program may leave out: they rest."""


@dataclass(frozen=True)
class Motion:
    """test: one of TITLES; begin, end: when something moves [s], the whole run where nothing does; moving: inputs that
    move; position: of a linear axis, the input that says where it is."""

    test: str
    begin: float
    end: float
    moving: tuple[str, ...]
    position: str = ""

    @property
    def title(self) -> str:
        return TITLES[self.test]


def rest(machine: Machine, schedule: Schedule) -> Schedule:
    """The schedule with every speed, feed and position at zero that the machine reads and the program does not name."""
    missing = {name: text for name, text in machine.inputs.items() if name not in schedule.signals and text in MOTIONS}
    resting = {name: constant(name, text, 0.0) for name, text in missing.items()}
    return replace(schedule, signals={**schedule.signals, **resting})


def find_motion(machine: Machine, schedule: Schedule) -> Motion:
    """Raises Refused where a program moves something, and nothing that this machine reads."""
    moved = {name: s for name, s in schedule.signals.items() if _is_motion(s) and _moves(s, schedule.t)}
    read = {name: signal for name, signal in moved.items() if name in machine.inputs}
    if moved and not read:
        wrong = f"the program moves {', '.join(moved)}, which this machine does not read"
        raise refuse(Spot(schedule.file), wrong, _advise(machine, next(iter(moved.values()))))
    if not read:
        return Motion("etve", float(schedule.t[0]), float(schedule.t[-1]), ())
    begin, end = _span(read, schedule.t)
    return Motion(_name_test(read, schedule.t), begin, end, tuple(read), _find_position(machine, schedule))


def _advise(machine: Machine, moved: Signal) -> str:
    """What to do about a motion that a machine does not read: call it by another name, or take another program."""
    own = [name for name, text in machine.inputs.items() if text in ("rpm", "m/min")]
    alike = [name for name in own if unit(machine.inputs[name]).dimension == moved.dimension
             and _is_spindle(name) is _is_spindle(moved.name)]  # fmt: skip
    right = f"give a program that moves {' or '.join(own)}" if own else "give a program of an idle machine (ETVE)"
    named = f"say which one it is, as in `--input {moved.name}={alike[0]}`, " if alike else ""
    return f"{named}{right}, or let an entry read it, as in `input: {moved.name}`"


def _is_motion(signal: Signal) -> bool:
    return signal.dimension in {unit("rpm").dimension, unit("m/min").dimension}


def _moves(signal: Signal, t: Array) -> bool:
    return bool(np.any(signal.at(t[:-1]) != 0))


def _span(moving: Mapping[str, Signal], t: Array) -> tuple[float, float]:
    """From the first instant at which something moves to the one at which all rests for good."""
    on = np.any([signal.at(t) != 0 for signal in moving.values()], axis=0)
    at = np.flatnonzero(on)
    return float(t[at[0]]), float(t[min(at[-1] + 1, len(t) - 1)])


def _name_test(moving: Mapping[str, Signal], t: Array) -> str:
    turning = {n: s for n, s in moving.items() if s.dimension == unit("rpm").dimension}
    spindles = [signal for name, signal in turning.items() if _is_spindle(name)]
    if spindles:
        levels = [np.unique(np.round(np.abs(speed.at(t)), 6)) for speed in spindles]
        return "spindle_spectrum" if any(np.sum(level > 0) > 1 for level in levels) else "spindle_constant"
    return "rotary_axis" if turning else "linear_axis"


def _is_spindle(name: str) -> bool:
    return name.lower().startswith(SPINDLE)


def _find_position(machine: Machine, schedule: Schedule) -> str:
    """The input that says where an axis is, if it changes."""
    lengths = (name for name, text in machine.inputs.items() if text == "m")
    return next((n for n in lengths if n in schedule.signals and np.ptp(schedule.signals[n].at(schedule.t)) > 0), "")
