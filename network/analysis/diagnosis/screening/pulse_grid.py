"""Windows and trains of pulses on a grid of instants, all scored at once.

Heat from an instant t on answers d(t); a pulse from a to b answers d(a) − d(b), and a train the sum of its pulses, w D
with the rows D = d(t) of the grid, between which it goes straight. With g = D r and G = D M Dᵀ (screen.py) its gain is
a w g − a² w G wᵀ/2 at most: of some thousands, no run but those of the grid is computed.
The clock is that of the recordings, from where the first begins to where the last ends.
Range: on and off for two steps of the grid at least; what goes faster is drawn (timed_search).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import combinations, product

import numpy as np

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.candidates.candidate_response import respond_to_candidates
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.screening.screen import SEEN, best_amplitude, firm_of, whiten
from network.catalogue.declaration.declare import Array

STEPS = 96
"""Of the grid over all runs (budget)."""
CYCLES, DUTIES, PHASES = 24, (0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9), 12
"""Periods in the grid, from one to so many by halves, shares of them that trains are on, and phases (budget)."""
SHAPES = ("period", "duration", "phase")
ONCE = 2.0
"""Lengths of the grid from one window to the next: it is not seen twice."""
SHARPENED, AROUND, CLOSEST, SOME = 8, 32, 1e-2, 0.5
"""Times that the best are moved between the instants of the grid, by how many steps each (budget), the shortest of
these in steps of the grid, and the share of the numbers that one moves."""
RESOLVED = 2.0
"""Steps of the grid that are on and off at least for what it tells as well as a run of its own does."""


@dataclass(frozen=True)
class Pulses:
    """Instants at which heat goes on [s], and what they explain [nats]."""

    period: float
    duration: float
    phase: float
    gain: float = 0.0

    def edges(self, begin: float, end: float) -> Iterator[tuple[float, float]]:
        """Each pulse within some time."""
        first = int(np.floor((begin - self.duration - self.phase) / self.period)) + 1
        for k in range(first, int(np.ceil((end - self.phase) / self.period))):
            on = self.phase + k * self.period
            yield max(on, begin), min(on + self.duration, end)


@dataclass(frozen=True)
class Clock:
    """The instants of a grid: so many from one to another [s]."""

    begin: float
    end: float
    count: int

    @cached_property
    def instants(self) -> Array:
        return np.linspace(self.begin, self.end, self.count)

    @property
    def step(self) -> float:
        return (self.end - self.begin) / (self.count - 1)

    def resolves(self, p: Pulses) -> bool:
        """Whether it is on and off for long enough to be scored on the grid."""
        return min(p.duration, p.period - p.duration) >= RESOLVED * self.step

    def list_windows(self) -> Iterator[Pulses]:
        for a, b in combinations(self.instants.tolist(), 2):
            if a > self.begin or b < self.end:
                yield Pulses(ONCE * (self.end - self.begin), b - a, a)

    def list_trains(self) -> Iterator[Pulses]:
        periods = ((self.end - self.begin) / (np.arange(2, 2 * CYCLES + 1) / 2)).tolist()
        for period, duty, phase in product(periods, DUTIES, range(PHASES)):
            if min(duty, 1 - duty) * period >= self.step:
                yield Pulses(period, duty * period, self.begin + phase / PHASES * period)

    def weigh(self, p: Pulses) -> Array:
        """By instants: +1 where heat goes on, −1 where it goes off, shared between neighbours."""
        w = np.zeros(self.count)
        for pulse in p.edges(self.begin, self.end):
            for edge, sign in zip(pulse, (1, -1), strict=True):
                at = (edge - self.begin) / self.step
                i = min(int(at), self.count - 2)
                w[i] += sign * (1 - at + i)
                w[i + 1] += sign * (at - i)
        return w


@lru_cache(maxsize=1)
def weigh_pulses(clock: Clock) -> tuple[tuple[Sequence[Pulses], Array], ...]:
    """All windows and all trains, each with its weights: they are those of the clock, whatever is heated."""
    kinds = ([*clock.list_windows()], [*clock.list_trains()])
    return tuple((tried, np.array([clock.weigh(p) for p in tried])) for tried in kinds)


@dataclass(frozen=True, eq=False)
class PulseGrid:
    """What heat from each instant of a clock on explains about a fit: g and G, with the end last, from which on nothing
    is left. firm: the square of the misfit, in which gains count."""

    clock: Clock
    g: Array
    G: Array
    firm: float

    def best(self, count: int) -> list[Pulses]:
        """The windows and the trains that explain most."""
        told: list[Pulses] = []
        for tried, weights in weigh_pulses(self.clock):
            gains = self.gains(weights)
            first = np.argsort(-gains, kind="stable")[:count]
            told += [replace(tried[i], gain=float(gains[i])) for i in first if gains[i] > 0]
        return told

    def sharpen(self, p: Pulses, rng: np.random.Generator) -> Pulses:
        """The same with its instants moved between those of the grid, where that explains more: steps of all lengths
        along some of the numbers."""
        for _ in range(SHARPENED):
            steps = self.clock.step * draw_steps(rng, AROUND, len(SHAPES), CLOSEST)
            moved = np.array([p.period, p.duration, p.phase]) + steps
            tried = [q for q in (Pulses(*x) for x in moved.tolist()) if self.clock.resolves(q)]
            if not tried:
                break
            gains = self.gains(np.array([self.clock.weigh(q) for q in tried]))
            k = int(np.argmax(gains))
            p = replace(tried[k], gain=float(gains[k])) if gains[k] > p.gain else p
        return p

    def gains(self, weights: Array) -> Array:
        """What pulses explain at their best strength [nats]."""
        g, kappa = weights @ self.g, np.einsum("ij,ij->i", weights @ self.G, weights)
        seen = kappa > SEEN
        return np.where(seen, best_amplitude(g, np.where(seen, kappa, 1.0), 0.0, self.firm)[1], 0.0)


def lay_grid(before: Hypothesis, c: Candidate) -> PulseGrid | None:
    """The grid of a heat by the clock about a fit; None where its instants are others, or its answer is not had.
    Raises BudgetReached."""
    before.case.budget.check()
    path = {p.attribute: p.path for p in c.own}
    if {*SHAPES} - path.keys():
        return None
    fit, clock = before.linearised, Clock(*before.case.clock, STEPS + 1)
    length = clock.end - clock.begin
    lasting = {path["period"]: (ONCE + 1) * length, path["duration"]: length}
    tried = [(c, {**before.values, **c.usual, **lasting, path["phase"]: t}) for t in clock.instants[:-1].tolist()]
    told = respond_to_candidates(tried, fit.problem.data, fit.predictions)
    changes = [d for d in told if d is not None and np.isfinite(d).all()]
    if len(changes) < len(tried):
        return None
    D = whiten(fit, np.array([*changes, np.zeros_like(changes[0])]))
    return PulseGrid(clock, D @ fit.unexplained, D @ fit.project(D).T, firm_of(fit))


def draw_steps(rng: np.random.Generator, count: int, axes: int, closest: float) -> Array:
    """Steps of all lengths from the closest up to one, along some of the axes (count, axes)."""
    length = closest ** rng.uniform(size=(count, 1))
    some = rng.uniform(size=(count, axes)) < SOME
    return np.asarray(length * some * rng.standard_normal((count, axes)))


def numbers_of(c: Candidate, p: Pulses) -> Mapping[str, float]:
    """The shapes of a candidate that pulses so, by path."""
    return {q.path: getattr(p, q.attribute) for q in c.own if q.attribute in SHAPES}


def pulses_of(c: Candidate, numbers: Mapping[str, float]) -> Pulses:
    """The same the other way round: how a candidate with such shapes pulses."""
    told = {p.attribute: numbers[p.path] for p in c.own[1:]}
    return Pulses(*(told[name] for name in SHAPES))
