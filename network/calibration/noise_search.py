"""The climb to the most probable noise: the evidence as a function of coloured noise by channel and slack heat.

Slack heat is so many more nuisances with spread q, coloured noise a block of the covariance for each channel and run.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from network.calibration.linearised import Linearised
from network.calibration.noise import Noise, of_channel
from network.calibration.slack import installed_power, shares, slack_columns
from network.declare import Array

SHARES = (0.001, 0.002, 0.004, 0.008, 0.016, 0.03, 0.06, 0.12)
"""Slack heat tried, as a share of the installed power."""
SIZES = (0.25, 0.7, 2.0, 6.0)
"""Coloured 1σ tried first, over the white 1σ of a sample."""
TIMES = tuple(15.0 * 1.5**k for k in range(16))
"""s: correlation times tried, every third of them first."""
WORTH_SLACK, WORTH_COLOUR = 2.0, 3.0
"""Gain of log evidence below which there is none."""
SWEEPS, ENOUGH = 4, 0.5
"""Rounds through all amounts at most, and the gain of log evidence below which no other follows."""
BEGINNINGS = (0.0, 0.5)
"""Coloured 1σ at the beginning, over the white 1σ of a sample."""
WHITE = (0.0, TIMES[0])


@dataclass(frozen=True, eq=False)
class Block:
    """One channel in one run. columns: parameters, offsets, nuisances of the run, slack and the residual, over its
    known cells, not whitened."""

    run: int
    columns: Array
    variance: Array
    known: Array

    def product(self, correlation: Array | None, size: float) -> tuple[Array, float]:
        """Products of the whitened columns, and log |D|."""
        if correlation is None:
            scaled = self.columns / np.sqrt(self.variance)
            return scaled @ scaled.T, float(np.log(self.variance).sum())
        root = cholesky(np.diag(self.variance) + size**2 * correlation, lower=True, check_finite=False)
        scaled = solve_triangular(root, self.columns.T, lower=True, check_finite=False).T
        return scaled @ scaled.T, 2 * float(np.log(np.diag(root)).sum())


Products = list[tuple[Array, float]]
"""Of every run: products of columns, log |D|."""


class Search:
    """Amounts of noise and where they stand. q: slack as a share of the installed power; best: log evidence."""

    def __init__(self, at: Linearised, ell: float) -> None:
        self.at, self.ell, self.power = at, ell, installed_power(at.predictions)
        self.channels = list(dict.fromkeys(n for d in at.problem.data for n in d.run.channels))
        self.slack = [slack_columns(p, d, shares(p), self.power, ell)
                      for p, d in zip(at.predictions, at.problem.data, strict=True)]  # fmt: skip
        self.q, self.colour = 0.0, dict.fromkeys(self.channels, WHITE)
        self.shared = at.free + len(at.problem.offsets)
        mean, self.spread = replace(at.problem, firm_theta=1.0, firm_eta=1.0).prior
        self.mean = np.concatenate([mean[: at.free] - at.theta, mean[at.free :]])
        self.blocks = {name: list(self._blocks(name)) for name in self.channels}
        self.correlations: dict[tuple[int, bytes, float], Array] = {}
        self.sigma = {n: max(d.sigma[n] for d in at.problem.data if n in d.run.channels) for n in self.channels}
        self.stand((0.0, 0.0, self.colour))

    def stand(self, end: tuple[float, float, dict[str, tuple[float, float]]]) -> None:
        """Goes to an amount of slack and some colours."""
        _, self.q, colour = end
        self.colour = dict(colour)
        self.products = {name: self._products(name, own) for name, own in colour.items()}
        self.best = self._evidence(self.q, self._total())

    def climbed(self, size: float) -> tuple[float, float, dict[str, tuple[float, float]]]:
        """The best found from a beginning: log evidence, slack, colours."""
        self.stand((0.0, 0.0, {n: (size * s, TIMES[7]) if size else WHITE for n, s in self.sigma.items()}))
        for sweep in range(SWEEPS):
            before = self.best
            self.try_slack()
            for name in self.channels:
                self.try_colour(name, not sweep)
            if self.best < before + ENOUGH:
                break
        return self.best, self.q, self.colour

    def _blocks(self, name: str) -> Iterator[Block]:
        runs = zip(self.at.blocks, self.at.problem.data, self.at.problem.whiteners, self.slack, strict=True)
        for i, ((rows, _), data, whiten, slack) in enumerate(runs):
            if name not in data.run.channels:
                continue
            cells, place = data.run.knots.cells, data.run.channels.index(name)
            mine = np.flatnonzero(data.known) // cells == place
            part = self.at.parts[i]
            slopes = np.concatenate([part.by_theta, part.by_offset, part.by_own])
            fit = whiten.undone(np.vstack([slopes, self.at.residual[rows]]))[:, mine]
            columns = np.concatenate([fit[:-1], slack[:, data.known][:, mine], fit[-1:]])
            known = data.known[place * cells : (place + 1) * cells]
            yield Block(i, columns, data.variance[data.known][mine], known)

    def _products(self, name: str, colour: tuple[float, float]) -> Products:
        size, tau = colour
        found: Products = [(np.zeros(0), 0.0)] * len(self.slack)
        for block in self.blocks[name]:
            found[block.run] = block.product(self._correlation(block, name, tau) if size else None, size)
        return found

    def _correlation(self, block: Block, name: str, tau: float) -> Array:
        data = self.at.problem.data[block.run]
        key = block.run, data.run.present[name].tobytes(), tau
        if key not in self.correlations:
            self.correlations[key] = of_channel(data, name, tau)
        return np.asarray(self.correlations[key][np.ix_(block.known, block.known)])

    def _total(self, exchanged: str = "", own: Products | None = None) -> Products:
        """Sums over the channels, one of them exchanged."""
        all_of = [own if name == exchanged and own else p for name, p in self.products.items()]
        return [(sum((p[i][0] for p in all_of if len(p[i][0])), np.zeros(())), sum(p[i][1] for p in all_of))
                for i in range(len(self.slack))]  # fmt: skip

    def _evidence(self, q: float, total: Products) -> float:
        """Log evidence but for a constant, with θ moved to where it is best under this noise: run by run its own
        columns are integrated out, then the shared ones."""
        k = self.shared
        scale, shift = self.spread[:k], self.mean[:k] / self.spread[:k]
        inner, ahead, least, log = np.eye(k), shift.copy(), float(shift @ shift), 0.0
        for (gram, log_d), (_, own), slack in zip(total, self.at.blocks, self.slack, strict=True):
            count = own.stop - own.start + (len(slack) if q else 0)
            into = np.concatenate([self.spread[own], np.full(count - (own.stop - own.start), q)])
            moved = np.zeros(count)
            moved[: own.stop - own.start] = self.mean[own] / self.spread[own]
            here = slice(k, k + count)
            right = np.column_stack([gram[here, :k] * np.outer(into, scale), gram[here, -1] * into + moved])
            root = cholesky(gram[here, here] * np.outer(into, into) + np.eye(count), lower=True, check_finite=False)
            felt = solve_triangular(root, right, lower=True, check_finite=False)
            inner += gram[:k, :k] * np.outer(scale, scale) - felt[:, :k].T @ felt[:, :k]
            ahead += gram[:k, -1] * scale - felt[:, :k].T @ felt[:, k]
            least += float(gram[-1, -1] + moved @ moved - felt[:, k] @ felt[:, k])
            log += log_d + 2 * float(np.log(np.diag(root)).sum())
        root = cholesky(inner, lower=True, check_finite=False)
        felt = solve_triangular(root, ahead, lower=True, check_finite=False)
        return -0.5 * float(least - felt @ felt + log + 2 * np.log(np.diag(root)).sum())

    def try_slack(self) -> None:
        """The best amount of slack with the colours as they are."""
        total = self._total()
        tried = {0.0: self._evidence(0.0, total)} | {q: self._evidence(q, total) for q in SHARES}
        q = max(tried, key=lambda x: tried[x])
        for factor in (0.75, 1.35, 0.87, 1.15) if q else ():
            tried[q * factor] = self._evidence(q * factor, total)
        self.q = max(tried, key=lambda x: tried[x])
        self.best = tried[self.q]

    def try_colour(self, name: str, first: bool) -> None:
        """The best coloured noise of one channel with all else as it is."""
        tried = {self.colour[name]: (self.best, self.products[name])}

        def attempt(size: float, tau: float) -> None:
            colour = (size, tau) if size else WHITE
            if colour not in tried:
                own = self._products(name, colour)
                tried[colour] = self._evidence(self.q, self._total(name, own)), own

        for size, tau in ((s * self.sigma[name], t) for s in SIZES for t in TIMES[1::3]) if first else ():
            attempt(size, tau)
        for factor in (1.7, 1.3, 1.14):
            size, tau = max(tried, key=lambda x: tried[x][0])
            place = TIMES.index(tau)
            for s in (size * factor, size / factor):
                attempt(s, tau)
            for t in TIMES[max(place - 1, 0) : place + 2]:
                attempt(size, t)
        self.colour[name] = max(tried, key=lambda x: tried[x][0])
        self.best, self.products[name] = tried[self.colour[name]]

    def drop_idle(self) -> None:
        """Takes out what brings next to nothing."""
        for name in (n for n in self.channels if self.colour[n][0]):
            own = self._products(name, WHITE)
            without = self._evidence(self.q, self._total(name, own))
            if without > self.best - WORTH_COLOUR:
                self.colour[name], self.products[name], self.best = WHITE, own, without
        without = self._evidence(0.0, self._total())
        if self.q and without > self.best - WORTH_SLACK:
            self.q, self.best = 0.0, without

    @property
    def noise(self) -> Noise:
        slack = {part: self.q * self.power * share for part, share in shares(self.at.predictions[0]).items()}
        return Noise({n: (float(s), t) for n, (s, t) in self.colour.items() if s}, slack if self.q else {}, self.ell)
