"""A meshed machine as arrays: C dT/dt = −L T + heat, with everything that depends on speed, time and switches."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Film:
    """Losses [W/K] of every cell to a held node, times a factor of speed [rpm]."""

    losses: Array
    to: str
    growth: Callable[[float], float]


@dataclass(frozen=True)
class Loss:
    """Heat that depends on speed alone: shares of every cell times W(rpm)."""

    into: Array
    power: Callable[[float], float]


@dataclass(frozen=True)
class Law:
    """Heat that depends on time, speed and the temperature at a place: shares of every cell times W(t, rpm, T)."""

    into: Array
    reads: Array
    power: Callable[[float, float, float], float]


@dataclass(frozen=True)
class Exchange:
    """Heat [W] of every cell by any law: (t [s], rpm, air [°C], T [°C]) → W; `breaks` [s] are where it jumps."""

    heat: Callable[[float, float, float, Array], Array]
    breaks: tuple[float, ...] = ()


@dataclass(frozen=True)
class Burst:
    """Heat of every cell [W] from one instant to another [s]."""

    begin: float
    end: float
    heat: Array


@dataclass(frozen=True)
class Relay:
    """A cooler: `power` [W] and `slope` of it for each kelvin over `lower`, on above `upper`, off below `lower`.

    It answers `delay` [s] after the crossing.
    """

    into: Array
    reads: Array
    power: float
    upper: float
    lower: float
    delay: float = 0.0
    slope: float = 0.0


@dataclass(frozen=True)
class System:
    """Heat capacities [J/K] and conductances [W/K]; L also holds the losses to held nodes, which `held` names."""

    C: Array
    L: Array
    held: dict[str, Array]
    temperature: dict[str, float]
    films: tuple[Film, ...] = ()
    losses: tuple[Loss, ...] = ()
    laws: tuple[Law, ...] = ()
    bursts: tuple[Burst, ...] = ()
    relays: tuple[Relay, ...] = ()
    fed: tuple[Loss, ...] = ()
    """Heat that depends on feed [m/min] alone."""
    exchanges: tuple[Exchange, ...] = ()
    airs: tuple[Callable[[float], float], ...] = ()
    """What the air has more [K] at a time [s] than its program says."""

    def conductance(self, rpm: float, on: tuple[bool, ...]) -> Array:
        """L at a speed and with switches: films add to the diagonal, a running cooler takes more when it is warmer."""
        L = self.L.copy()
        for film in self.films:
            L[np.diag_indices_from(L)] += film.losses * film.growth(rpm)
        for relay, runs in zip(self.relays, on, strict=True):
            if runs and relay.slope:
                L += np.outer(relay.into, relay.reads) * relay.power * relay.slope
        return L

    def drive(self, rpm: float) -> Array:
        """Conductance to the air [W/K] of every cell."""
        air = self.held.get("ambient", np.zeros_like(self.C))
        return air + sum((f.losses * f.growth(rpm) for f in self.films if f.to == "ambient"), np.zeros_like(self.C))

    def heat(self, rpm: float, on: tuple[bool, ...], t: float, feed: float = 0.0) -> Array:
        """All heat [W] that is constant until the next edge of speed, feed, burst or switch, from t [s] on."""
        q = sum((loss.into * loss.power(rpm) for loss in self.losses), np.zeros_like(self.C))
        q = q + sum((loss.into * loss.power(feed) for loss in self.fed), np.zeros_like(self.C))
        for name, T in self.temperature.items():
            films = (film.losses * film.growth(rpm) for film in self.films if film.to == name)
            q = q + T * sum(films, self.held[name])
        for burst in self.bursts:
            if burst.begin <= t < burst.end:
                q = q + burst.heat
        for relay, runs in zip(self.relays, on, strict=True):
            if runs:
                q = q - relay.into * relay.power * (1 - relay.slope * relay.lower)
        return q
