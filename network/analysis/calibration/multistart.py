"""Where a fit begins: at the priors' centres, and elsewhere too where one beginning may not be enough.

A relay's own numbers move its switchings, and a fit that begins a cycle off never finds back: where that has happened
they are searched for (`cycling`). Wide priors, a number at its bound and a bad first fit are answered by further
beginnings drawn from the priors, each number's by its path, so that the order of a file's entries does not matter.

After n searches that ended in w minima the expected share of beginnings that lead to a minimum not yet seen is
w (w + 1)/(n (n − 1)); no further ones are drawn once that is UNSEEN. Source: Boender & Rinnooy Kan, Math. Programming
37 (1987) 59; unverified.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from zlib import crc32

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised, Problem, minimise
from network.analysis.calibration.limit_cycle_matching import cycling, is_loose, relay_numbers
from network.analysis.calibration.misfit import chi_of, implausibility
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
DRAWN, SEARCHES, UNSEEN = 16, 6, 0.2
"""Beginnings drawn at most, searches that come to an end at most, and the share at which they do: four searches that
end alike, six that end in two minima."""
STEPS = 12
"""Of a search from where relays cycle alike."""
CYCLING = 2
"""Times that relays' own numbers are searched for: beside the priors' centres, then beside the best minimum."""
ALIKE, APART = 6.0, 3.0
"""Two minima fit alike if J in units of the misfit differ by less; they are two if a number differs by so many standard
errors."""
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
    problem: Problem, seed: int, tell: Callable[[float], None], is_late: Callable[[], bool],
    first: Array | None = None, is_enough: Callable[[], bool] = lambda: False,
) -> Found:  # fmt: skip
    """The most probable θ from as many beginnings as the problem asks for; once it is late, from those that came to an
    end, and once it is enough without others that only what is left asks for. first: where relays are in step, as no
    beginning drawn is, else at the priors' centres. Raises Failed where every run runs away."""
    begin = centres(problem.parameters) if first is None else first

    def is_done() -> bool:
        return is_late() or (is_enough() and not has_wide_priors(problem))

    say(tell, f"fitting {len(begin)} numbers")
    seeds, minima = [begin], _minima(problem, [begin], None, is_late)
    for _ in range(CYCLING if relay_numbers(problem) and (first is None or is_loose(problem)) else 0):
        about = min(minima, key=implausibility) if minima else None
        if (about is not None and rms(about.left) <= ADEQUATE) or is_late():
            break
        say(tell, f"{_tell_best(minima)}what switches: numbers of relays that cycle alike")
        more = cycling(problem, begin if about is None or len(seeds) == 1 else about.theta, is_late)
        minima, seeds = minima + _minima(problem, more, STEPS, is_late), seeds + more
    is_alone = first is None and minima and needs_more(problem, min(minima, key=implausibility))
    if not minima or (is_alone and not is_done()):
        say(tell, f"{_tell_best(minima)}other beginnings")
        for drawn in draw_beginnings(problem.parameters, seed):
            tell(0.7 * len(minima) / SEARCHES)
            minima += _search_beside(problem, drawn, minima)
            seeds.append(drawn)
            if has_seen_enough(minima) or is_late() or (minima and is_done()):
                break
    if not minima:
        raise Failed("the machine runs away wherever its uncertain numbers lie; check heat that grows with temperature")
    tell(0.7)
    best = min(minima, key=implausibility)
    best = minimise(best.problem, best.theta) if len(seeds) > 1 and not is_late() else best
    return Found(best, len(seeds), tuple(r for r in minima if _is_rival(r, best)))


def _search_beside(problem: Problem, seed: Array, minima: Sequence[Linearised]) -> list[Linearised]:
    """The minimum from another beginning, linear about what the best before is; it ends where it comes to one of those
    before."""
    about = min(minima, key=implausibility).problem if minima else problem
    try:
        return [minimise(about, seed, until=lambda at: any(_leads_to(at, other) for other in minima))]
    except Failed:
        return []


def _tell_best(minima: Sequence[Linearised]) -> str:
    return f"{rms(min(minima, key=implausibility).left):.3g} σ left; " if minima else ""


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
    return has_wide_priors(problem) or bool(at_bound(problem.parameters, at.theta)) or rms(at.left) > BAD


def has_wide_priors(problem: Problem) -> bool:
    return any(p.is_unknown or (p.is_log and p.spread > WIDE) for p in problem.parameters)


def draw_beginnings(parameters: Sequence[Parameter], seed: int) -> Iterator[Array]:
    """Draws from the priors; flat ones are drawn over their whole range. Each number is drawn by its own path."""
    rngs = [np.random.default_rng([seed, crc32(p.path.encode())]) for p in parameters]
    for _ in range(DRAWN):
        drawn = [r.uniform(p.low, p.high) if p.is_unknown else p.centre + p.spread * r.standard_normal()
                 for p, r in zip(parameters, rngs, strict=True)]  # fmt: skip
        yield np.array([float(np.clip(x, p.low, p.high)) for x, p in zip(drawn, parameters, strict=True)])


def has_seen_enough(minima: Sequence[Linearised]) -> bool:
    """Whether further searches would hardly end elsewhere, or there were as many as are made."""
    n, w = len(minima), 0
    for k, at in enumerate(minima):
        w += all(_are_apart(at, other) for other in minima[:k])
    return n >= SEARCHES or (n > 1 and w * (w + 1) <= UNSEEN * n * (n - 1))


def _is_rival(other: Linearised, best: Linearised) -> bool:
    return implausibility(other) - implausibility(best) < ALIKE and _are_apart(other, best)


def _leads_to(at: Linearised, other: Linearised) -> bool:
    """Whether a search is as near a minimum as none is that ends elsewhere: every number within APART standard errors,
    and no less plausible than that makes it."""
    most = APART**2 * at.free
    return implausibility(at) - implausibility(other) < most and not _are_apart(at, other)


def _are_apart(one: Linearised, other: Linearised) -> bool:
    """Whether a number differs by APART standard errors, the misfit counted as noise."""
    chi = max(1.0, chi_of(other))
    std = chi * np.sqrt(np.diag(other.temper(chi, chi).covariance)[: other.free])
    return bool((np.abs(one.theta - other.theta) > APART * std + 1e-9).any())
