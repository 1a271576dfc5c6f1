"""The shortest warm-up: so long at one of some speeds, so that the tool centre point then moves less than a tolerance.

What is left is the range (largest less smallest) of every axis over the scenario that follows. It need not fall with
every minute: a warm-up that is too fast or too long overshoots. So all lengths are looked at, in steps of a grid, dips
between them too, and the first that serves is then narrowed down to a minute.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from network.analysis.sweep.lumping_error import LumpingError, estimate_lumping
from network.analysis.sweep.tolerance import Tolerance, parse_tolerance
from network.catalogue.declaration.declare import Array
from network.engine.simulation import check_length, schedule_for, simulate
from network.machine.machine import Machine
from network.platform.printing import Brief, Result
from network.platform.quantities.units import BadNumber, in_unit, split_number, unit
from network.platform.refusal import Spot, likely, refuse
from network.recordings.call_arguments import expect
from network.recordings.inputs import Schedule, Signal
from network.recordings.scenario import Scenario

STEP, FINEST = 600.0, 60.0
"""s: of the grid of lengths, and to what a length is narrowed down."""
GOLDEN = (5**0.5 - 1) / 2
STANDS = 1.0
"""s: the machine stands so long before, so that `start: steady` means a machine at rest."""
SHARES = (0.5, 0.75, 1.0)
"""Of the largest speed of the scenario: what is tried unless speeds are given."""
DRIVEN = ("rpm", "m/min")


@dataclass(frozen=True, eq=False, repr=False)
class Attempt(Brief):
    """One speed (SI). lengths: of the warm-ups tried [s]; left: what moves after each [m]; shortest: the first that
    serves [s], None where none does; leaves: what moves after it, else after the best [m]; best: that length [s]."""

    value: float
    lengths: Array
    left: Array
    shortest: float | None
    leaves: float
    best: float


@dataclass(frozen=True, eq=False, repr=False)
class WarmUp(Result):
    """input: what is driven; attempts: by speed; none: what moves without a warm-up [m]; chosen: the attempt that is
    shortest, where none serves the one that leaves least; lumping: what finer lumps would change over it and what
    follows."""

    machine: Machine
    scenario: Scenario
    input: str
    tolerance: Tolerance
    none: float
    attempts: tuple[Attempt, ...]
    lumping: LumpingError | None = None

    @property
    def is_needed(self) -> bool:
        return self.none > self.tolerance.value

    @property
    def chosen(self) -> Attempt:
        serve = [a for a in self.attempts if a.shortest is not None]
        return min(serve, key=lambda a: (a.shortest, a.leaves)) if serve else min(self.attempts, key=lambda a: a.leaves)

    @property
    def unit(self) -> str:
        """Of the input."""
        return self.machine.inputs[self.input]

    def summary(self) -> dict[str, Any]:
        """What `--json` prints. minutes: null where no warm-up serves; left is then that of the best tried."""
        chosen, shown = self.chosen, self.tolerance.unit
        minutes = 0.0 if not self.is_needed else None if chosen.shortest is None else chosen.shortest / 60
        length = chosen.best if chosen.shortest is None else chosen.shortest
        speed = {"value": chosen.value / unit(self.unit).scale, "unit": self.unit}
        steps = [{"for": {"value": length / 60, "unit": "min"}, self.input: speed}] if self.is_needed else []
        left = chosen.leaves if self.is_needed else self.none
        return {
            "minutes": minutes, "schedule": steps, "left": {"value": shown.from_si(left), "unit": shown.text},
            "without": {"value": shown.from_si(self.none), "unit": shown.text}, "tolerance": self.tolerance.summary(),
            "lumping": None if self.lumping is None else self.lumping.summary(),
            "tried": [{self.input: a.value / unit(self.unit).scale, "minutes": (a.lengths / 60).tolist(),
                       "left": [shown.from_si(v) for v in a.left.tolist()]} for a in self.attempts],
        }  # fmt: skip


def find_warm_up(
    machine: Machine, scenario: Scenario, tolerance: str, *, speeds: str | None = None, longest: float = 4 * 3600.0,
    driven: str | None = None, progress: Callable[[float], None] | None = None,
) -> WarmUp:  # fmt: skip
    """The shortest warm-up before a scenario. tolerance: like '2 um'; speeds: like '4000, 8000 rpm'; longest: [s];
    driven: the input, by default the speed; progress: told the share that is done. Raises Refused."""
    expect("machine", machine, Machine)
    expect("scenario", scenario, Scenario)
    wanted = parse_tolerance(tolerance, machine)
    schedule = schedule_for(machine, scenario)
    check_length(machine, schedule)
    name = _find_driven(machine, driven)
    values = _read_speeds(speeds, schedule.signals[name], machine.inputs[name])
    lengths = np.append(np.arange(STEP, longest, STEP), longest)
    none, attempts = _left(machine, schedule, wanted, 0.0), []
    for k, value in enumerate(values):
        if progress is not None:
            progress(k / len(values))
        attempts.append(_attempt(_Trial(machine, schedule, name, value, wanted), lengths, none))
    found = WarmUp(machine, scenario, name, wanted, none, tuple(attempts))
    warmed = _warmed(schedule, name, found.chosen.value, found.chosen.best) if found.is_needed else schedule
    return replace(found, lumping=estimate_lumping(machine, replace(scenario, schedule=warmed), asks=False))


class _Trial:
    """One speed: what moves after a warm-up of some length, every length computed once."""

    def __init__(self, machine: Machine, schedule: Schedule, name: str, value: float, wanted: Tolerance) -> None:
        self.machine, self.schedule, self.name, self.value, self.wanted = machine, schedule, name, value, wanted
        self.known: dict[float, float] = {}

    def left(self, length: float) -> float:
        if length not in self.known:
            warmed = _warmed(self.schedule, self.name, self.value, length)
            self.known[length] = _left(self.machine, warmed, self.wanted, length)
        return self.known[length]

    def serves(self, length: float) -> bool:
        return self.left(length) <= self.wanted.value

    def narrow(self, low: float, high: float) -> float:
        """The shortest length that serves between one that does not and one that does, to FINEST."""
        while high - low > FINEST:
            middle = (low + high) / 2
            low, high = (low, middle) if self.serves(middle) else (middle, high)
        return high

    def least(self, low: float, high: float) -> float:
        """Where least is left between two lengths that enclose a dip, to FINEST, by the golden section."""
        while high - low > FINEST:
            a, b = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
            low, high = (low, b) if self.left(a) < self.left(b) else (a, high)
        return min((low, high), key=self.left)


def _attempt(trial: _Trial, lengths: Array, none: float) -> Attempt:
    """Walks over the grid; where it passes a dip, the dip is looked into."""
    trial.known[0.0] = none
    tried = [0.0]
    for length in lengths.tolist():
        tried.append(length)
        if trial.serves(length):
            return _told(trial, tried, trial.narrow(tried[-2], length))
        if len(tried) > 2 and trial.left(tried[-3]) > trial.left(tried[-2]) < trial.left(length):
            dip = trial.least(tried[-3], length)
            if trial.serves(dip):
                return _told(trial, tried, trial.narrow(tried[-3], dip))
    return _told(trial, tried, None)


def _told(trial: _Trial, tried: list[float], shortest: float | None) -> Attempt:
    best = shortest if shortest is not None else min((n for n in trial.known if n), key=trial.left)
    left = np.array([trial.left(length) for length in tried[1:]])
    return Attempt(trial.value, np.array(tried[1:]), left, shortest, trial.left(best), best)


def _left(machine: Machine, schedule: Schedule, wanted: Tolerance, after: float) -> float:
    """The largest range of an axis that the tolerance concerns, from an instant on [m]."""
    run = simulate(machine, schedule, parts=False)
    work = run.t >= run.t[0] + after - 1e-6
    return max(float(np.ptp(values[work])) for axis, values in run.tcp.items() if wanted.concerns(axis))


def _warmed(schedule: Schedule, name: str, value: float, length: float) -> Schedule:
    """The schedule after so long at a value of one input, all others as they are at its start."""
    t0 = float(schedule.t[0])
    signals = {n: _later(s, t0, length, value if n == name else None) for n, s in schedule.signals.items()}
    return replace(schedule, t=np.append(t0, schedule.t + length), signals=signals)


def _later(signal: Signal, t0: float, length: float, value: float | None) -> Signal:
    """A signal that begins later; before, it holds its first value, or stands and then has `value`."""
    before = float(signal.at(np.array([t0]))[0])
    knots = [(t0, before)] if value is None else [(t0, 0.0), (t0 + STANDS, value)]
    first = np.array(knots).T
    at = signal.t > t0
    begin = signal.at(np.array([t0]))
    last = int(np.searchsorted(signal.t, t0, side="right")) - 1
    end = signal.end[max(last, 0)] if last >= 0 else signal.start[0]
    t = np.concatenate([first[0], [t0 + length], signal.t[at] + length])
    start = np.concatenate([first[1], begin, signal.start[at]])
    stop = np.concatenate([first[1], [end], signal.end[at]])
    return replace(signal, t=t, start=start, end=stop)


def _find_driven(machine: Machine, asked: str | None) -> str:
    """The input that warms up: the one asked for, else a speed, else a feed."""
    known = [name for name, text in machine.inputs.items() if text in DRIVEN]
    if asked is not None and asked not in known:
        raise refuse(Spot("--input"), f"'{asked}' is no speed and no feed of this machine", likely(asked, known))
    if not known:
        raise refuse(Spot(machine.file), "reads no speed and no feed, so nothing can warm it up", "add what heats it")
    return asked or min(known, key=lambda name: (DRIVEN.index(machine.inputs[name]), name != "speed"))


def _read_speeds(text: str | None, signal: Signal, unit_text: str) -> list[float]:
    """'4000, 8000 rpm' → SI; by default shares of the largest of the scenario."""
    if text is None:
        largest = float(np.abs([signal.start, signal.end]).max())
        if not largest:
            right = f"give them, as in --speeds '4000, 8000 {unit_text}'"
            raise refuse(Spot("--speeds"), f"is needed, for '{signal.name}' is zero throughout the scenario", right)
        return [share * largest for share in SHARES]
    try:
        *others, last = (part.strip() for part in text.split(","))
        _, shown = split_number(last, unit_text)
        values = [in_unit(part if part[-1:].isalpha() else f"{part} {shown}", unit_text) for part in (*others, last)]
    except BadNumber as bad:
        raise refuse(Spot("--speeds"), bad.wrong, bad.right) from None
    if not min(values) > 0:
        raise refuse(Spot("--speeds"), "holds a speed that is not above zero", f"give speeds like '8000 {unit_text}'")
    return values
