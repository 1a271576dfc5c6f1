"""A run from edge to edge of speed, bursts and switches, in equal steps; switches are found where they happen."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import ceil

import numpy as np

from proof.programs import Program
from proof.stepping import Regime, Stepper
from proof.system import Array, Relay, System

STEP = 5.0
"""s: the longest step of the truth."""


@dataclass
class Track:
    """Steps as taken: start and length [s], temperatures and rates at both ends; in between, the cubic through them."""

    t: list[float] = field(default_factory=list)
    h: list[float] = field(default_factory=list)
    ends: list[tuple[Array, Array, Array, Array]] = field(default_factory=list)
    switches: list[tuple[float, int, bool]] = field(default_factory=list)

    def add(self, t: float, h: float, T0: Array, k0: Array, T1: Array, k1: Array) -> None:
        self.t.append(t)
        self.h.append(h)
        self.ends.append((T0, k0, T1, k1))

    def at(self, times: Array, weights: Array) -> Array:
        """What `weights` (channels × cells) read at the times: an array of times × channels."""
        i = np.clip(np.searchsorted(self.t, times + 1e-9, side="right") - 1, 0, len(self.t) - 1)
        h = np.array(self.h)[i]
        T0, k0, T1, k1 = (np.array([end[part] for end in self.ends]) @ weights.T for part in range(4))
        s = ((times - np.array(self.t)[i]) / h)[:, None]
        return np.asarray(cubic(s, h[:, None], T0[i], k0[i], T1[i], k1[i]))


def cubic(s: Array, h: Array, T0: Array, k0: Array, T1: Array, k1: Array) -> Array:
    """Hermite's cubic at the share s of a step."""
    r = 1 - s
    return np.asarray(r * r * ((1 + 2 * s) * T0 + s * h * k0) + s * s * ((1 + 2 * r) * T1 - r * h * k1))


class Switches:
    """Positions of the relays, and what they will do after their delay."""

    def __init__(self, relays: tuple[Relay, ...], T: Array) -> None:
        self.relays = relays
        self.on = tuple(bool(relay.reads @ T > relay.upper) for relay in relays)
        self.due: dict[int, float] = {}

    def crossed(self, T: Array) -> list[int]:
        """Relays that a temperature has brought to switch and that do not already wait."""
        read = enumerate(zip(self.relays, self.on, strict=True))
        return [i for i, (r, on) in read if i not in self.due and self._beyond(r, on, float(r.reads @ T)) > 0]

    @staticmethod
    def _beyond(relay: Relay, on: bool, T: float) -> float:
        return relay.lower - T if on else T - relay.upper

    def crossing(self, i: int, h: float, ends: tuple[Array, Array, Array, Array]) -> float:
        """The time into a step [s] at which relay i crosses its limit, by bisection on the cubic."""
        values = [float(self.relays[i].reads @ end) for end in ends]
        low, high = 0.0, 1.0
        for _ in range(45):
            middle = (low + high) / 2
            T = float(cubic(np.float64(middle), np.float64(h), *values))  # type: ignore[arg-type]
            low, high = (low, middle) if self._beyond(self.relays[i], self.on[i], T) > 0 else (middle, high)
        return high * h

    def flip(self, i: int) -> None:
        self.on = tuple(not on if j == i else on for j, on in enumerate(self.on))
        self.due.pop(i, None)


def air_of(airs: Sequence[Callable[[float], float]], program: Program) -> Callable[[float], float]:
    """The air [°C] as it is, which need not be what its program says; airs: what it has more [K]."""
    return (lambda t: program.air(t) + sum(more(t) for more in airs)) if airs else program.air


class Run:
    """Carries a system through a program."""

    def __init__(self, system: System, program: Program, start: Array, step: float = STEP) -> None:
        self.system, self.program, self.step = system, program, step
        self.track, self.t, self.T = Track(), 0.0, np.array(start, float)
        self.switches = Switches(system.relays, self.T)
        bursts = [edge for burst in system.bursts for edge in (burst.begin, burst.end)]
        breaks = [edge for each in system.exchanges for edge in each.breaks]
        inside = {edge for edge in (*program.edges, *bursts, *breaks) if 0 < edge < program.duration}
        self.edges = [*sorted(inside), program.duration]
        self.air: Callable[[float], float] = air_of(system.airs, program)

    def go(self) -> Track:
        while self.t < self.program.duration - 1e-9:
            self.leg(min([self.edges[bisect_right(self.edges, self.t + 1e-9)], *self.switches.due.values()]))
        return self.track

    def leg(self, stop: float) -> None:
        """Equal steps until `stop`, or until a relay crosses its limit."""
        at = self.program
        regime = Regime(self.system, at.speed(self.t), self.switches.on, self.t, self.air, at.feed(self.t))
        n = max(1, ceil((stop - self.t) / self.step - 1e-9))
        stepper, k = Stepper(regime, (stop - self.t) / n), regime.rate(self.t, self.T)
        for i in range(n):
            T, k_end = stepper.step(self.t, self.T, k)
            if self.system.relays and (crossed := self.switches.crossed(T)):
                return self.switch(regime, crossed, stepper.h, (self.T, k, T, k_end))
            self.keep(stepper.h, k, T, k_end)
            self.t, k = (stop if i == n - 1 else self.t), k_end
        for i in [i for i, due in self.switches.due.items() if due <= stop + 1e-9]:
            self.turn(i)

    def keep(self, h: float, k: Array, T: Array, k_end: Array) -> None:
        self.track.add(self.t, h, self.T, k, T, k_end)
        self.t, self.T = self.t + h, T

    def switch(self, regime: Regime, crossed: list[int], h: float, ends: tuple[Array, Array, Array, Array]) -> None:
        """Goes to the first crossing only, and switches there or after the delay."""
        into, i = min((self.switches.crossing(i, h, ends), i) for i in crossed)
        if into > 1e-6:
            self.keep(into, ends[1], *Stepper(regime, into).step(self.t, self.T, ends[1]))
        delay = self.system.relays[i].delay
        if delay:
            self.switches.due[i] = self.t + delay
        else:
            self.turn(i)

    def turn(self, i: int) -> None:
        self.switches.flip(i)
        self.track.switches.append((self.t, i, self.switches.on[i]))
