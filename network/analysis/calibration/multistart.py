"""Where a fit begins: at the priors' centres, and elsewhere too where one beginning may not be enough.

A relay's own numbers move its switchings, and a fit that begins a cycle off never finds back: where that has happened
they are searched for (`cycling`). Wide priors, a number at its bound and a bad first fit are answered by further
beginnings drawn from the priors.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised, Problem, linearise, minimise, residual_cost
from network.analysis.calibration.limit_cycle_matching import cycling, is_loose, relay_numbers
from network.catalogue.declaration.declare import Array
from network.engine.response.parameters import Parameter, centres
from network.platform.refusal import Failed
from network.platform.stages import say

WIDE = 0.7
"""A prior σ of the logarithm from which one beginning is not enough."""
ADEQUATE = 1.5
"""rms of whitened residuals up to which a fit is taken for good."""
BAD = 3.0
"""rms of a first fit that asks for further beginnings."""
DRAWN, KEPT, STEPS = 16, 3, 12
"""Beginnings drawn, those that are fitted, and steps of each but the best."""
CYCLING = 2
"""Times that relays' own numbers are searched for: beside the priors' centres, then beside the best minimum."""
ALIKE, APART = 6.0, 3.0
"""Two minima fit alike if their J differ by less; they are two if a number differs by so many standard errors."""
AT_BOUND = 1e-3
"""Prior σ from a bound that count as being there."""


@dataclass(frozen=True, eq=False)
class Found:
    """The best minimum of several; tried: beginnings; rivals: other minima that fit alike."""

    at: Linearised
    tried: int
    rivals: tuple[Linearised, ...]


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def at_bound(parameters: Sequence[Parameter], theta: Array) -> list[int]:
    """Which numbers lie at a bound."""
    return [j for j, (p, x) in enumerate(zip(parameters, theta, strict=True))
            if min(x - p.low, p.high - x) < AT_BOUND * p.spread]  # fmt: skip


def best_start(
    problem: Problem, rng: np.random.Generator, tell: Callable[[float], None], is_late: Callable[[], bool],
    first: Array | None = None,
) -> Found:  # fmt: skip
    """The most probable θ from as many beginnings as the problem asks for; once it is late, from those that came to an
    end. first: where relays are in step, as no beginning drawn is, else at the priors' centres. Raises Failed where
    every run runs away."""
    begin = centres(problem.parameters) if first is None else first
    say(tell, f"fitting {len(begin)} numbers")
    seeds, minima = [begin], _minima(problem, [begin], None, is_late)
    for _ in range(CYCLING if relay_numbers(problem) and (first is None or is_loose(problem)) else 0):
        about = min(minima, key=_cost) if minima else None
        if (about is not None and rms(about.left) <= ADEQUATE) or is_late():
            break
        say(tell, f"{_tell_best(minima)}what switches: numbers of relays that cycle alike")
        more = cycling(problem, begin if about is None or len(seeds) == 1 else about.theta, is_late)
        minima, seeds = minima + _minima(problem, more, STEPS, is_late), seeds + more
    is_alone = first is None and minima and needs_more(problem, min(minima, key=_cost))
    if not minima or (is_alone and not is_late()):
        say(tell, f"{_tell_best(minima)}other beginnings")
        drawn = np.array([draw_from(problem.parameters, rng) for _ in range(DRAWN)])
        tell(0.3)
        more = _best_of(problem, drawn, KEPT)
        minima += _minima(problem, more, STEPS, is_late)
        seeds += more
    if not minima:
        raise Failed("the machine runs away wherever its uncertain numbers lie; check heat that grows with temperature")
    tell(0.7)
    best = min(minima, key=_cost)
    best = minimise(problem, best.theta) if len(seeds) > 1 and not is_late() else best
    return Found(best, len(seeds), tuple(r for r in minima if _is_rival(r, best)))


def _tell_best(minima: Sequence[Linearised]) -> str:
    return f"{rms(min(minima, key=_cost).left):.3g} σ left; " if minima else ""


def _cost(at: Linearised) -> float:
    return at.cost


def _minima(
    problem: Problem, seeds: Sequence[Array], steps: int | None, is_late: Callable[[], bool]
) -> list[Linearised]:
    minima: list[Linearised] = []
    for seed in seeds:
        if is_late() and (minima or seed is not seeds[0]):
            break
        try:
            minima.append(minimise(problem, seed, steps) if steps else minimise(problem, seed))
        except Failed:
            continue
    return minima


def needs_more(problem: Problem, at: Linearised) -> bool:
    """Whether one beginning may not have been enough."""
    if not problem.parameters:
        return False
    wide = any(p.is_unknown or (p.is_log and p.spread > WIDE) for p in problem.parameters)
    return wide or bool(at_bound(problem.parameters, at.theta)) or rms(at.left) > BAD


def draw_from(parameters: Sequence[Parameter], rng: np.random.Generator) -> Array:
    """One draw from the priors; a flat one is drawn over its whole range."""
    values = []
    for p in parameters:
        x = rng.uniform(p.low, p.high) if p.is_unknown else p.centre + p.spread * rng.standard_normal()
        values.append(float(np.clip(x, p.low, p.high)))
    return np.array(values)


def _best_of(problem: Problem, thetas: Array, count: int) -> list[Array]:
    """The most probable of many, far enough apart to be worth a fit each."""
    about = None
    for theta in [centres(problem.parameters), *thetas]:
        try:
            about = linearise(problem, np.asarray(theta))
            break
        except Failed:
            continue
    if about is None:
        return []
    costs = np.array([residual_cost(about, theta) for theta in thetas])
    order = [k for k in np.argsort(costs) if np.isfinite(costs[k])]
    spread = np.array([p.spread for p in problem.parameters])
    chosen: list[Array] = []
    for k in order:
        if all(np.abs((thetas[k] - other) / spread).max() > 0.3 for other in chosen):
            chosen.append(thetas[k])
        if len(chosen) == count:
            break
    return chosen


def _is_rival(other: Linearised, best: Linearised) -> bool:
    n = best.free
    scale = max(1.0, rms(best.left)) ** 2
    std = np.sqrt(np.diag(best.covariance)[:n] * scale)
    far = np.abs(other.theta - best.theta) > APART * std + 1e-9
    return bool((other.cost - best.cost) / scale < ALIKE and far.any())
