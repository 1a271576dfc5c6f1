"""Input channels over time: piecewise linear, with jumps, in SI (speed in rad/s, temperatures in °C)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.platform.printing import Brief
from network.platform.quantities.units import Unit, unit


@dataclass(frozen=True, repr=False)
class Signal(Brief):
    """One input. Between t[k] and t[k+1] it runs straight from start[k] to end[k]; after the last knot it stays at
    end[-1], before the first at start[0]. A held step has start == end.

    t: [s], K knots, strictly increasing; start, end: K values in SI; unit: what it is shown in; std: 1σ, SI, of one
    that is constant and not known exactly, 0 for all others.
    """

    name: str
    unit: str
    t: Array
    start: Array
    end: Array
    std: float = 0.0

    @property
    def value(self) -> float:
        """The first value, which is that of a constant [SI]."""
        return float(self.start[0])

    def shift(self, by: float) -> Signal:
        """The same, higher by a constant [SI]."""
        return replace(self, start=self.start + by, end=self.end + by)

    @property
    def dimension(self) -> str:
        return unit(self.unit).dimension

    def span(self, left: Array, right: Array) -> tuple[Array, Array]:
        """Values just after `left` and just before `right`; no knot lies between left[i] and right[i]."""
        k = np.clip(np.searchsorted(self.t, (left + right) / 2, side="right") - 1, 0, None)
        if self.start is self.end:
            return self.start[k], self.start[k]
        return self._in(k, left), self._in(k, right)

    def at(self, t: Array) -> Array:
        """Values at t; at a jump the value after it."""
        return self._in(np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, None), t)

    def _in(self, k: Indices, t: Array) -> Array:
        ends = np.append(self.t, np.inf)
        length = ends[k + 1] - ends[k]
        share = np.clip((t - ends[k]) / length, 0.0, 1.0)
        return np.asarray(self.start[k] + share * np.where(np.isfinite(length), self.end[k] - self.start[k], 0.0))

    @property
    def is_held(self) -> bool:
        """Constant between its knots."""
        return bool(np.array_equal(self.start, self.end))


def hold(name: str, unit_text: str, t: Array, values: Array) -> Signal:
    """Each value holds until the next knot."""
    return Signal(name, unit_text, t, values, values)


def linear(name: str, unit_text: str, t: Array, values: Array) -> Signal:
    """Straight lines between the values."""
    return Signal(name, unit_text, t, values, np.append(values[1:], values[-1]))


def constant(name: str, unit_text: str, value: float, std: float = 0.0) -> Signal:
    return replace(hold(name, unit_text, np.zeros(1), np.array([value])), std=std)


def is_slow(of: Unit) -> bool:
    """Temperatures and other slow quantities run straight between samples; speeds, feeds, positions of axes and bare
    numbers (switches, levels in %) hold until the next sample."""
    fast = {unit(text).dimension for text in ("rpm", "m/min", "m", "1")}
    return of.dimension not in fast


def is_stepped(of: Unit, values: Array) -> bool:
    """Whether a slow quantity that is no temperature (power, current, flow) is set in steps: at half of all samples and
    more it reads exactly what it read before. One that only creeps is then held wrongly by its last digit, at most."""
    given = values[np.isfinite(values)]
    return not of.is_temperature and len(given) > 1 and 2 * int((np.diff(given) == 0).sum()) >= len(given) - 1


@dataclass(frozen=True)
class Start:
    """Where a run begins. `steady`: in equilibrium with the inputs at its start; `read`: at its first readings, also
    where these lie near the reference. Else temperatures [°C] by node, and `others` for the rest; None everywhere means
    the reference."""

    steady: bool = False
    read: bool = False
    others: float | None = None
    nodes: Mapping[str, float] | None = None


@dataclass(frozen=True, repr=False)
class Schedule(Brief):
    """What drives a simulation: inputs over time, the instants asked for, and where it starts.

    name: for titles; file: for messages; t: instants of output [s], increasing, t[0] is the start of the run;
    signals: inputs by name; start: None for the default.
    """

    name: str
    file: str
    t: Array
    signals: Mapping[str, Signal]
    start: Start | None = None
