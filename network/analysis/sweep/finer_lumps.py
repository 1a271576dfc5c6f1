"""A machine with its bars cut otherwise, and how far the channels of two runs lie apart."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.trajectory import Trajectory, axis_unit
from network.machine.machine import Machine
from network.machine.overrides import set_lumps
from network.platform.printing import Brief
from network.platform.quantities.units import difference, unit

SHARE = 0.02
"""Of its range: how far a channel may be off, unless another tolerance is given."""
CYCLES = 3
"""From so many on a relay's swings are averaged."""
PAUSE = 3.0
"""Times the median of its cycles: what lasts longer is none."""

STILL = {"K": 1e-6}
STILL_AXIS = 1e-12
"""K, and m or rad: what moves by less stands still, and differs by the rounding of its temperatures."""


@dataclass(frozen=True, eq=False, repr=False)
class Course(Brief):
    """A channel over time, SI. noise: σ of a reading, 0 where nothing reads it."""

    name: str
    unit: str
    values: Array
    noise: float

    def allow(self, share: float) -> float:
        """What it may be off: a share of its range, and for a sensor no less than the σ of one reading."""
        return max(share * float(np.ptp(self.values)), self.noise)


@dataclass(frozen=True)
class Change:
    """What finer lumps change of a channel where they change it most, SI; range: of the channel; allowed: what it may
    be off."""

    name: str
    unit: str
    largest: float
    range: float
    allowed: float

    @property
    def share(self) -> float:
        """Of the range."""
        return abs(self.largest) / self.range if self.range else 0.0

    @property
    def size(self) -> float:
        """As a share of what is allowed; 0 for a channel that stands still."""
        return abs(self.largest) / self.allowed if self.allowed else 0.0

    @property
    def is_within(self) -> bool:
        return self.size <= 1

    def summary(self) -> dict[str, Any]:
        shown = difference(unit(self.unit))
        return {"max": self.largest / shown.scale, "unit": shown.text, "share_of_range": self.share}


def bars_of(machine: Machine) -> dict[str, int]:
    """Bar → its lumps."""
    return {name: node.lumps for name, node in machine.nodes.items() if node.is_bar}


def cut_bars(machine: Machine, lumps: Mapping[str, int]) -> Machine:
    """The machine with these bars in so many lumps."""
    tree = machine.tree
    for name, count in lumps.items():
        if machine.nodes[name].lumps != count:
            tree = set_lumps(tree, f"{name}={count}")
    return machine if tree is machine.tree else type(machine).read(tree, machine.file)


def courses(run: Trajectory) -> Iterator[Course]:
    """Every axis of the tool centre point and every thermometer; the parts where there is none of either."""
    sensors = run.machine.sensors
    for axis, values in run.tcp.items():
        yield Course(axis, axis_unit(axis), values, 0.0)
    own = [name for name, sensor in sensors.items() if sensor.place is not None and name in run.sensors]
    for name in own:
        yield Course(name, "K", run.sensors[name], sensors[name].sigma)
    if not own and not run.tcp:
        yield from (Course(n, "K", T, 0.0) for n, T in run.parts.items() if run.machine.nodes[n].is_part)


def compare_courses(run: Trajectory, finer: Trajectory, share: float = SHARE) -> tuple[Change, ...]:
    """What changes from one run to a finer one, channel by channel; over the cycles of relays their mean."""
    before = {course.name: course for course in courses(run)}
    window = average_window(finer)
    return tuple(_change(before[after.name], after, share, window) for after in courses(finer))


def _change(before: Course, after: Course, share: float, window: int) -> Change:
    off = moving_mean(after.values - before.values, window)
    largest, swing = float(off[int(np.argmax(np.abs(off)))]), float(np.ptp(after.values))
    if max(abs(largest), swing) < STILL.get(after.unit, STILL_AXIS):
        largest = swing = 0.0
    return Change(after.name, after.unit, largest, swing, after.allow(share))


def average_window(run: Trajectory) -> int:
    """Samples that the slowest cycle of a relay takes; 1 without relays that cycle. When it switches hangs on the last
    hundredth of a kelvin: two runs that agree in everything else are soon out of step."""
    periods = []
    for name in dict.fromkeys(name for _, name, _ in run.switches):
        begins = [t for t, source, on in run.switches if source == name and on]
        apart = np.array([b - a for a, b in pairwise(begins)])
        if len(apart) >= CYCLES:
            periods.append(float(apart[apart <= PAUSE * np.median(apart)].max()))
    step = float(np.median(np.diff(run.t))) if len(run.t) > 1 else 1.0
    return min(max(round(max(periods, default=0.0) / step), 1), max(len(run.t) // 2, 1))


def moving_mean(values: Array, window: int) -> Array:
    """Means over so many neighbours, fewer of them at the ends left out."""
    if window < 2:
        return values
    total = np.concatenate([[0.0], np.cumsum(values)])
    return np.asarray((total[window:] - total[:-window]) / window)
