"""Draws of a relay: where it switches is not a smooth matter, so its numbers are drawn before they are fitted.

Draws from the priors are run all at once and judged by their misfit with the other parameters adjusted linearly; the
best ones set the next draws (the cross-entropy method, Rubinstein & Kroese 2004). They look at the beginning of each
run only, where a wrong period has not yet lost its step.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from network.calibration.batch import Draws, draws_of, means_of, serves, step_of
from network.calibration.evidence import START_ANYWHERE
from network.calibration.fitting import Linearised, linearise, minimise
from network.calibration.noise import slack_covariance, whitener
from network.calibration.parameters import values_at
from network.calibration.partials import Slots
from network.checks import places_of
from network.declare import Array, Mask
from network.diagnosis.candidates import Candidate
from network.diagnosis.case import Hypothesis, early
from network.diagnosis.screen import whitened
from network.graph import Network, build
from network.mechanisms.base import Relay

DRAWS, ELITE, APART = 300, 40, 0.3
"""Draws of a round, how many set the next ones, and how far those that are fitted are apart in prior σ."""
WIDER, LEAST = 1.5, 0.02
"""How much wider than the best draws the next ones are, every other round; and the least, in prior σ."""
BEGUN = 4
"""Draws that are fitted."""
FARTHEST = 4.0
"""Prior 1σ that a start may lie off."""
MOST_SWITCHES = 25
"""An hour, beyond which a draw is not looked at."""
SLACK_SHARE, SLACK_TIME = 0.6, 900.0
"""1σ of the heat allowed at the places in question over the installed heat, and its correlation time [s]."""


@dataclass(frozen=True)
class Draw:
    """Numbers of a candidate, then where its new parts start [°C], and the misfit that is left, the others adjusted
    linearly."""

    theta: Array
    misfit: float


@dataclass(frozen=True, eq=False)
class Space:
    """What is drawn: the numbers of a candidate, then the starts of the parts that it brings or lets go."""

    candidate: Candidate

    @cached_property
    def network(self) -> Network:
        return build(self.candidate.machine)

    @cached_property
    def parts(self) -> tuple[str, ...]:
        base = self.candidate.base.nodes
        named = self.candidate.machine.nodes.items()
        return tuple(n for n, node in named if node.is_part and not (n in base and base[n].is_part))

    @cached_property
    def prior(self) -> tuple[Array, Array, Array, Array]:
        """Centre, 1σ, and bounds."""
        own = [(p.centre, p.spread, p.low, p.high) for p in self.candidate.own]
        middle = self.candidate.machine.reference
        far = FARTHEST * START_ANYWHERE
        rows = [*own, *((middle, START_ANYWHERE, middle - far, middle + far) for _ in self.parts)]
        centre, spread, low, high = np.array(rows, float).T
        return centre, spread, low, high

    def numbers(self, theta: Array) -> dict[str, float]:
        return values_at(self.candidate.own, theta[: len(self.candidate.own)])

    def starts(self, theta: Array) -> dict[str, float]:
        return dict(zip(self.parts, theta[len(self.candidate.own) :].tolist(), strict=True))


@dataclass(frozen=True)
class Look:
    """Share of each run that every round of draws looks at; is_free: about a fit that allows any heat at the places in
    question, else about the null."""

    horizons: tuple[float, ...]
    is_free: bool

    @property
    def share(self) -> float:
        return self.horizons[-1]


SHORT, LONG = Look((0.2, 0.2, 0.3, 0.3), False), Look((0.35, 0.35, 0.5, 0.5), True)


@dataclass(frozen=True, eq=False)
class Sought:
    """A candidate with its best draws, how they were looked for, and the numbers of the file they were made at. ratio:
    misfit of the best over that of the null there."""

    space: Space
    values: Mapping[str, float]
    look: Look
    draws: tuple[Draw, ...]
    ratio: float


def parts_about(candidate: Candidate) -> tuple[str, ...]:
    """The parts that its switched heat enters; where it enters a node held until now, the parts linked to that."""
    base = candidate.base
    relays = (e for _, e in candidate.machine.entries() if isinstance(e, Relay))
    into = {place.node for relay in relays for place, _ in relay.into}
    own = [n for n in into if n in base.nodes and base.nodes[n].is_part]
    if own:
        return tuple(own)
    pairs = [{place.node for _, place in places_of(link)} for link in base.links.values()]
    return tuple(dict.fromkeys(n for pair in pairs for n in pair if base.nodes[n].is_part and pair & into))


def freed(null: Hypothesis, parts: Sequence[str], power: float) -> Linearised:
    """The null refitted with any heat allowed in some parts, under the noise of the case again."""
    problem = null.fit.problem
    noise = replace(null.case.noise, slack={p: SLACK_SHARE * power / len(parts) for p in parts}, ell=SLACK_TIME)
    loose = []
    for data, prediction in zip(problem.data, null.predictions, strict=True):
        loose.append(whitener(data, noise, slack_covariance(prediction, data, noise)))
    about = minimise(replace(problem, whiteners=tuple(loose)), None, 8)
    return linearise(replace(problem, firm_theta=1.0, firm_eta=1.0), about.theta)


def seek(null: Hypothesis, power: float, seed: int, look: Look, candidate: Candidate) -> Sought | None:
    """Draws of a candidate; None where it cannot be searched."""
    space = Space(candidate)
    if not serves(space.network):
        return None
    if look.is_free:
        about = freed(null, parts_about(candidate), power)
    else:
        about = linearise(replace(null.fit.problem, firm_theta=1.0, firm_eta=1.0), null.fit.theta)
    values = values_at(about.problem.parameters, about.theta)
    draws = _drawn(about, space, values, look, seed)
    if not draws:
        return None
    chosen = tuple(_apart(draws, space.prior[1]))
    return Sought(space, values, look, chosen, draws[0].misfit / _misfit_of_null(about, look.share))


def _misfit_of_null(about: Linearised, horizon: float) -> float:
    """What the null leaves over a share of the runs, its numbers adjusted linearly to that share."""
    seen_early = np.concatenate([early(d, horizon) for d in about.problem.data])
    left = np.concatenate([d.means - p.cells for d, p in zip(about.problem.data, about.predictions, strict=True)])
    seen = whitened(about, seen_early.astype(float)) > 0
    return float(_adjusted(about, whitened(about, np.where(seen_early, left, 0.0))[None], seen)[0])


def _drawn(
    about: Linearised, space: Space, values: dict[str, float], look: Look, seed: int
) -> list[Draw]:  # fmt: skip
    """Rounds of draws from the priors with a growing horizon, the best first."""
    rng = np.random.default_rng(seed)
    middle, spread, low, high = space.prior
    root = np.diag(spread)
    kept: list[Draw] = []
    pool: list[Draw] = []
    for i, horizon in enumerate(look.horizons):
        theta = np.clip(middle + rng.standard_normal((DRAWS, len(middle))) @ root.T, low, high)
        if kept:
            theta[:ELITE] = [d.theta for d in kept]
        kept = sorted(_judged(about, space, values, theta, horizon), key=lambda d: d.misfit)
        pool += kept if horizon == look.share else []
        kept = kept[:ELITE]
        best = np.array([d.theta for d in kept])
        wider = WIDER if i % 2 == 0 else 1.0
        middle = np.asarray(best.mean(axis=0), float)
        covariance = wider**2 * np.cov(best.T).reshape(len(middle), -1) + np.diag(LEAST * spread) ** 2
        root = np.asarray(np.linalg.cholesky(covariance), float)
    return sorted(pool, key=lambda d: d.misfit)


def _judged(
    about: Linearised, space: Space, values: dict[str, float], theta: Array, horizon: float
) -> list[Draw]:  # fmt: skip
    candidate, (centre, spread, _, _) = space.candidate, space.prior
    parameters = (*(p for p in about.problem.parameters if p.path in candidate.machine.uncertain), *candidate.own)
    slots = Slots(space.network, parameters)
    shared = {p.path: values[p.path] for p in parameters if p.path in values}
    networks = [slots.at(shared | space.numbers(row)) for row in theta]
    began = dict(zip(space.parts, theta[:, len(candidate.own) :].T, strict=True))
    steps: dict[float, Draws] = {}
    runs = []
    for d in about.problem.data:
        h = round(step_of(d.run), 6)
        draws = steps[h] if h in steps else steps.setdefault(h, draws_of(networks, d.run))
        runs.append(means_of(candidate.machine, draws, d.run, began, horizon))
    seen_early = np.concatenate([early(d, horizon) for d in about.problem.data])
    measured = np.concatenate([d.means for d in about.problem.data])
    means = np.concatenate([m for m, _ in runs], axis=1)
    residual = np.stack([whitened(about, np.where(seen_early, measured - row, 0.0)) for row in means])
    seen = whitened(about, seen_early.astype(float)) > 0
    misfit = _adjusted(about, residual, seen)
    hours = sum(float(np.ptp(d.run.knots.samples)) for d in about.problem.data) * horizon / 3600
    many = sum(switches for _, switches in runs) > MOST_SWITCHES * hours
    misfit = np.where(many, np.inf, misfit + np.sum(((theta - centre) / spread) ** 2, axis=1))
    return [Draw(row, float(m)) for row, m in zip(theta, misfit, strict=True)]


def _adjusted(about: Linearised, residual: Array, seen: Mask) -> Array:
    """Misfits |r|² less what the parameters take up, within their priors, of the rows that are seen."""
    mean, spread = about.problem.prior
    n = about.free
    slopes = about.slopes * seen
    off = (mean - np.concatenate([about.theta, np.zeros(len(mean) - n)])) / spread**2
    right = residual @ slopes.T + off
    precision = slopes @ slopes.T + np.diag(spread**-2.0)
    taken = np.linalg.solve(precision, right.T).T
    misfit = np.einsum("ij,ij->i", residual, residual) - np.einsum("ij,ij->i", right, taken)
    return np.where(np.isfinite(misfit), misfit, np.inf)


def _apart(draws: Sequence[Draw], spreads: Array) -> list[Draw]:
    """The best draws that are not nearly the same."""
    chosen: list[Draw] = []
    for draw in draws:
        near = np.array([np.abs(draw.theta - c.theta) / spreads for c in chosen]).reshape(-1, len(spreads)).max(axis=1)
        if (near > APART).all() and np.isfinite(draw.misfit):
            chosen.append(draw)
        if len(chosen) == BEGUN:
            break
    return chosen
