"""Windows and trains of pulses on a grid of instants, all scored at once.

Heat from an instant t on answers d(t); a pulse from a to b answers d(a) − d(b), and a train the sum of its pulses, w D
with the rows D = d(t) of the grid, between which it goes straight. With g = D r and G = D M Dᵀ (screen.py) its gain is
a w g − a² w G wᵀ/2 at most: of some thousands, no run but those of the grid is computed.
Range: pulses of two steps of the grid at least; what goes faster is drawn (timed_search).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, product

import numpy as np

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.candidates.candidate_response import respond_to_candidates
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.screening.screen import MOST, whiten
from network.catalogue.declaration.declare import Array

STEPS = 96
"""Of the grid over the longest run (budget)."""
PERIODS, DUTIES, PHASES = 24, (0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9), 12
"""Of the trains that are looked at (budget)."""
SHORTEST = 4
"""Steps of the shortest period."""
SHAPES = ("period", "duration", "phase")
ONCE = 2.0
"""Lengths of the longest run from one window to the next: it is not seen twice."""


@dataclass(frozen=True)
class Pulses:
    """Instants at which heat goes on [s], and what they explain [nats]."""

    period: float
    duration: float
    phase: float
    gain: float = 0.0

    def edges(self, end: float) -> Iterator[tuple[float, float]]:
        """Each pulse within a run."""
        first = int(np.floor((-self.duration - self.phase) / self.period)) + 1
        for k in range(first, int(np.ceil((end - self.phase) / self.period))):
            begin = self.phase + k * self.period
            yield max(begin, 0.0), min(begin + self.duration, end)


@dataclass(frozen=True, eq=False)
class PulseGrid:
    """What heat from each instant of the grid on explains about a fit: g and G, with the instant at the end of the run
    last, from which on nothing is left. misfit: of what is left, in whose square gains count."""

    end: float
    g: Array
    G: Array
    misfit: float

    @cached_property
    def instants(self) -> Array:
        return np.linspace(0.0, self.end, len(self.g))

    def best(self, count: int) -> list[Pulses]:
        """The windows and the trains that explain most."""
        kinds = (self._score([*self._list_windows()]), self._score([*self._list_trains()]))
        return [p for told in kinds for p in sorted(told, key=lambda p: -p.gain)[:count] if p.gain > 0]

    def _list_windows(self) -> Iterator[Pulses]:
        for a, b in combinations(self.instants.tolist(), 2):
            if a > 0 or b < self.end:
                yield Pulses(ONCE * self.end, b - a, a)

    def _list_trains(self) -> Iterator[Pulses]:
        periods = np.geomspace(SHORTEST * self.instants[1], self.end, PERIODS).tolist()
        for period, duty, phase in product(periods, DUTIES, range(PHASES)):
            yield Pulses(period, duty * period, phase / PHASES * period)

    def _score(self, tried: list[Pulses]) -> list[Pulses]:
        w = np.array([self._weigh(p) for p in tried])
        g, kappa = w @ self.g, np.einsum("ij,ij->i", w @ self.G, w)
        seen = kappa > 1e-6
        a = np.clip(np.divide(g, kappa, out=np.zeros_like(g), where=seen), 0.0, MOST)
        gains = (a * g - a * a * kappa / 2) / self.misfit**2
        return [Pulses(p.period, p.duration, p.phase, gain) for p, gain in zip(tried, gains.tolist(), strict=True)]

    def _weigh(self, p: Pulses) -> Array:
        """By instants of the grid: +1 where heat goes on, −1 where it goes off, shared between neighbours."""
        w = np.zeros(len(self.g))
        for edge, sign in (
            (edge, sign) for pulse in p.edges(self.end) for edge, sign in zip(pulse, (1, -1), strict=True)
        ):
            at = edge / self.instants[1]
            i = min(int(at), len(w) - 2)
            w[i] += sign * (1 - at + i)
            w[i + 1] += sign * (at - i)
        return w


def lay_grid(before: Hypothesis, c: Candidate) -> PulseGrid | None:
    """The grid of a heat by the clock about a fit; None where its instants are others, or its answer is not had."""
    path = {p.attribute: p.path for p in c.own}
    if {*SHAPES} - path.keys():
        return None
    fit, end = before.linearised, before.case.runs.longest
    lasting = {path["period"]: (ONCE + 1) * end, path["duration"]: end}
    begins = np.linspace(0.0, end, STEPS + 1)[:-1].tolist()
    tried = [(c, {**before.values, **c.usual, **lasting, path["phase"]: t}) for t in begins]
    changes = [d for d in respond_to_candidates(tried, fit.problem.data, fit.predictions) if d is not None]
    if len(changes) < len(tried):
        return None
    D = whiten(fit, np.array([*changes, np.zeros_like(changes[0])]))
    misfit = max(1.0, float(np.sqrt(np.mean(fit.left**2))))
    return PulseGrid(end, D @ fit.unexplained, D @ fit.project(D).T, misfit)


def numbers_of(c: Candidate, p: Pulses) -> Mapping[str, float]:
    """The shapes of a candidate that pulses so, by path."""
    return {q.path: getattr(p, q.attribute) for q in c.own if q.attribute in SHAPES}
