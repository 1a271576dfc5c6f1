"""Inputs that leave the range in which a machine was calibrated."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from network.catalogue.declaration.declare import Array
from network.machine.machine import Machine
from network.machine.validity import Range
from network.platform.quantities.number_format import format_amount
from network.recordings.inputs import Schedule, Signal

SLACK = 0.1
"""Of a range's own width that an input may lie outside it untold: a convention, so that a room a little warmer than the
warmest day of a calibration is no warning. An input that was constant has no width."""
ROUNDED = 1e-5
"""Of a value: what a range loses where it is written to six digits."""


def list_extrapolated(machine: Machine, schedules: Iterable[Schedule]) -> Iterator[str]:
    """A sentence on every input that goes beyond what the machine was calibrated in, over all schedules together; none
    for a machine that does not say in what."""
    known, several = machine.validity, tuple(schedules)
    for name, allowed in (known.ranges if known is not None else {}).items():
        there = [extent(schedule.signals[name], schedule.t) for schedule in several if name in schedule.signals]
        if there and name in machine.inputs:
            yield from _list_beyond(name, allowed, min(low for low, _ in there), max(high for _, high in there))


def _list_beyond(name: str, allowed: Range, low: float, high: float) -> Iterator[str]:
    slack = SLACK * (allowed.high - allowed.low) + ROUNDED * max(abs(allowed.low), abs(allowed.high))
    ends = [f"falls to {format_amount(low, allowed.unit)}"] if low < allowed.low - slack else []
    ends += [f"reaches {format_amount(high, allowed.unit)}"] if high > allowed.high + slack else []
    if ends:
        told = f"{name} {' and '.join(ends)}, and the machine was calibrated {_tell_range(allowed)}"
        yield f"{told}: what it says there is extrapolated"


def _tell_range(allowed: Range) -> str:
    low, high = (format_amount(x, allowed.unit) for x in (allowed.low, allowed.high))
    behind = high.rpartition(" ")[2]
    return f"at {low}" if low == high else f"from {low.removesuffix(f' {behind}')} to {high}"


def extent(signal: Signal, t: Array) -> tuple[float, float]:
    """Smallest and largest value of an input over a schedule's time [SI]."""
    inside = signal.t[(signal.t > t[0]) & (signal.t < t[-1])]
    edges = np.concatenate([t[:1], inside, t[-1:]])
    values = np.concatenate(signal.span(edges[:-1], edges[1:])) if t[-1] > t[0] else signal.at(t[:1])
    return float(values.min()), float(values.max())


def find_ranges(machine: Machine, schedules: Sequence[Schedule]) -> dict[str, Range]:
    """Of every input that the machine reads: its smallest and largest value over schedules, by its 1σ wider where it
    was not known exactly."""
    ranges = {}
    for name in machine.inputs:
        signals = [schedule.signals[name] for schedule in schedules]
        ends = [extent(signal, schedule.t) for signal, schedule in zip(signals, schedules, strict=True)]
        low = min(a - s.std for (a, _), s in zip(ends, signals, strict=True))
        high = max(b + s.std for (_, b), s in zip(ends, signals, strict=True))
        ranges[name] = Range(low, high, signals[0].unit)
    return ranges
