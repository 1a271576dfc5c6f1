"""Heat at a place that is on or off, of one size: what of a mismatch it explains at most, and when it is on.

Of modes m ∈ {0, 1} at n knots and a size P the misfit falls by P gᵀm − ½ P² mᵀH m, with H = R M Rᵀ and g = R r of the
answers R to 1 W about each knot (numbers taken up linearly). m is bettered knot by knot, from quantiles of the heat
that is free and leaves no more than noise (heat_evidence), P = gᵀm / mᵀHm in between; a further instant has to explain
ln n nats at what is left, for it is one of n. Source: iterated conditional modes, Besag, J. R. Stat. Soc. B 48 (1986)
259; unverified.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised
from network.analysis.diagnosis.latent_heat.heat_evidence import explain_best
from network.analysis.diagnosis.latent_heat.locate import list_sizes, weigh_place
from network.analysis.diagnosis.latent_heat.location import Location
from network.analysis.diagnosis.latent_heat.unknown_heat import heat_knots
from network.catalogue.declaration.declare import Array, Mask

APART, MOST = 60.0, 240
"""s: distance of the knots, and how many of a run at most: beyond four hours they are farther apart."""
SHARES = (0.2, 0.4, 0.6, 0.8)
"""Quantiles of the free heat above which it is on to begin with."""
ROUNDS = 10
"""Times that modes and size are bettered in turn."""


@dataclass(frozen=True, eq=False)
class SwitchedHeat:
    """t: knots of each run [s]; on: 1 or 0 at each; size [W]; gain: by how much the misfit falls [½ χ²]; worth: what
    that is beyond chance, in units of the χ² that is left, its instants paid [nats]."""

    t: tuple[Array, ...]
    on: tuple[Array, ...]
    size: float
    gain: float
    worth: float

    def list_switchings(self, run: int) -> list[float]:
        """Instants half way between knots at which it goes on or off [s]."""
        t, on = self.t[run], self.on[run]
        return [float(t[k : k + 2].mean()) for k in np.flatnonzero(np.diff(on))]


def trace_switched(fit: Linearised, at: Location) -> tuple[SwitchedHeat, SwitchedHeat]:
    """The heat that is on or off at a place, with what is worth most: taken out, and given."""
    knots = [heat_knots(d, APART, MOST) for d in fit.problem.data]
    H, g = weigh_place(fit, at, knots)
    free, left = explain_best(H, g, knots, list_sizes(H)).course, float(fit.left @ fit.left)
    breaks = np.cumsum([len(t) for t in knots])[:-1]
    cold, warm = (_Levels(H, sign * g, breaks, left, len(fit.left)) for sign in (-1.0, 1.0))
    return cold.find(tuple(knots), -free), warm.find(tuple(knots), free)


@dataclass(frozen=True, eq=False)
class _Levels:
    """breaks: where the knots of another run begin; left: χ² without such a heat, of so many readings."""

    H: Array
    g: Array
    breaks: Array
    left: float
    readings: int

    def find(self, knots: tuple[Array, ...], free: Array) -> SwitchedHeat:
        """The best that begins where a heat that is free is large."""
        return max((self._from(knots, free > np.quantile(free, q)) for q in SHARES), key=lambda heat: heat.worth)

    def _from(self, knots: tuple[Array, ...], begun: Mask) -> SwitchedHeat:
        on = self.better(begun.astype(float), self.rest(0.0))
        on = self.better(on, self.rest(self.gain(on)))
        modes, gain = tuple(np.split(on, self.breaks)), self.gain(on)
        paid = np.log(len(on)) * sum(np.count_nonzero(np.diff(each)) for each in modes)
        return SwitchedHeat(knots, modes, self.size(on), gain, gain / self.rest(gain) - float(paid))

    def rest(self, gain: float) -> float:
        """χ² a reading that is left beside what gains so much, 1 at least."""
        return max((self.left - 2 * gain) / self.readings, 1.0)

    def size(self, on: Array) -> float:
        """P, at least 0."""
        within = float(on @ self.H @ on)
        return max(float(self.g @ on) / within, 0.0) if within > 0 else 0.0

    def gain(self, on: Array) -> float:
        return 0.5 * self.size(on) * float(self.g @ on)

    def better(self, on: Array, left: float) -> Array:
        """Modes from which no knot can be changed for the better; left: χ² a reading, in which an instant counts."""
        cost = np.log(len(self.g)) * left
        for _ in range(ROUNDS):
            size, before = self.size(on), on
            on = self._change(on, size, cost) if size > 0 else on
            if np.array_equal(on, before):
                break
        return on

    def _change(self, on: Array, size: float, cost: float) -> Array:
        """The knot whose change explains most is changed, as long as one explains something."""
        on, felt = on.copy(), self.H @ on
        for _ in range(2 * len(on)):
            away = 1 - 2 * on
            gains = size * away * self.g - size**2 * (away * felt + 0.5 * np.diag(self.H)) - cost * self._added(on)
            k = int(np.argmax(gains))
            if gains[k] <= 0:
                break
            felt += away[k] * self.H[k]
            on[k] += away[k]
        return on

    def _added(self, on: Array) -> Array:
        """Instants that come to be, less those that go, where a knot is changed."""
        differs = np.diff(on) != 0
        inner = 1.0 - 2.0 * differs
        inner[self.breaks - 1] = 0.0
        return np.asarray(np.concatenate([[0.0], inner]) + np.concatenate([inner, [0.0]]))
