"""All pairs of channels exchanged in any of the runs, scored about a fit by its normal equations.

Of a pair the runs in which it is exchanged are those that leave least: J(x) = Σ J_r(x) + prior over the unknowns that
the runs share, their own ones folded in, starts as the exchanged readings tell them, is c − gᵀN⁻¹g at its least, once
for every choice of runs. Priors count by what the best exchange leaves, as in a fit. Source: block elimination as in
`arrow_matrix`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from operator import add

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised, chi_of
from network.analysis.diagnosis.exchange.exchanged_columns import Pair
from network.analysis.diagnosis.exchange.run_equations import Normal, list_runs
from network.catalogue.declaration.declare import Array

ROUNDS = 3
"""Times that priors are weighed anew by what the best exchange leaves."""

Runs = tuple[bool, ...]


@dataclass(frozen=True)
class Score:
    """A pair with the runs in which it is exchanged. cost: J there; without: J with none exchanged; firm: what noise
    counts with, in that of the case."""

    pair: Pair
    runs: Runs
    cost: float
    without: float
    firm: float

    @property
    def gain(self) -> float:
        """nats."""
        return (self.without - self.cost) / 2 / self.firm**2


@dataclass(frozen=True, eq=False)
class Ways:
    """Of one pair: each run as it is and, where it has both, with the two exchanged."""

    runs: tuple[tuple[Normal, Normal | None], ...]
    prior: Normal

    def cost(self, runs: Runs) -> float:
        """J at its least with the pair exchanged in some runs."""
        chosen = [ways[1] if is_exchanged else ways[0] for ways, is_exchanged in zip(self.runs, runs, strict=True)]
        return reduce(add, [self.prior, *(each for each in chosen if each is not None)]).least

    def flip(self, runs: Runs) -> list[tuple[float, Runs]]:
        """With one run flipped, each that can be."""
        able = [i for i, (_, exchanged) in enumerate(self.runs) if exchanged is not None]
        flipped = [(*runs[:i], not runs[i], *runs[i + 1 :]) for i in able]
        return [(self.cost(each), each) for each in flipped]

    @cached_property
    def best(self) -> tuple[float, Runs]:
        """From all that can be exchanged on, and from none, one run after the other flipped while that leaves less."""
        every = tuple(exchanged is not None for _, exchanged in self.runs)
        return min(self._descend(begin) for begin in (every, (False,) * len(every)))

    def _descend(self, runs: Runs) -> tuple[float, Runs]:
        best = (self.cost(runs), runs)
        while (then := min(self.flip(best[1]), default=best)) < best:
            best = then
        return best


class ExchangeScan:
    """All scores about some numbers."""

    def __init__(self, at: Linearised, pairs: Sequence[Pair]) -> None:
        self.at, self.pairs, self.runs = at, tuple(pairs), list_runs(at)
        self._raw = {pair: [self._exchange(i, pair) for i in range(len(self.runs))] for pair in self.pairs}

    def best(self) -> list[Score]:
        """Of every pair, the one that leaves least first."""
        firm, found = max(1.0, chi_of(self.at)), list[Score]()
        for _ in range(ROUNDS if self.pairs else 0):
            found = sorted((self.score(pair, firm) for pair in self.pairs), key=lambda s: s.cost)
            firm = max(1.0, float(np.sqrt(max(found[0].cost, 0.0) / len(self.at.residual))))
        return found

    def score(self, pair: Pair, firm: float) -> Score:
        ways = self.ways(pair, firm)
        cost, runs = ways.best
        return Score(pair, runs, cost, ways.cost((False,) * len(runs)), firm)

    def ways(self, pair: Pair, firm: float) -> Ways:
        """Priors as if noise were so many times as large."""
        blocks, k = self.at.rows.slopes.blocks, self.at.rows.slopes.shared
        mean, spread = self.at.problem.temper(firm, firm).prior
        mean = mean - np.concatenate([self.at.theta, np.zeros(len(mean) - self.at.free)])
        runs = list[tuple[Normal, Normal | None]]()
        for (_, own), run, raw in zip(blocks, self.runs, self._raw[pair], strict=True):
            folded = run.as_it_is.fold(Normal.prior(mean[own], spread[own]))
            if raw is None:
                runs.append((folded, None))
                continue
            exchanged, moved = raw
            runs.append((folded, exchanged.fold(Normal.prior(mean[own] + moved, spread[own]))))
        return Ways(tuple(runs), Normal.prior(mean[:k], spread[:k]))

    def _exchange(self, i: int, pair: Pair) -> tuple[Normal, Array] | None:
        """None where the run lacks one of the two."""
        run = self.runs[i]
        return (run.exchange(pair), run.move_starts(pair)) if {*pair} <= {*run.names} else None
