"""The most probable parameters: Gauss–Newton on whitened residuals and priors, each step within a region of trust.

A refused step is shortened to the least of the parabola through both costs and the slope at the first. Source: Moré,
The Levenberg–Marquardt algorithm, Lecture Notes in Mathematics 630 (1978) 105, as in MINPACK; unverified. One that was
accepted is lengthened to the least of the same where that lies far beyond.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from network.analysis.calibration.expansion_point import expand_anew
from network.analysis.calibration.linearised import (
    Linearised,
    linearise,
    move_beside,
    residual_cost,
    with_nuisance_slopes,
    with_slopes,
)
from network.analysis.calibration.misfit import chi_of, implausibility
from network.analysis.calibration.problem import Problem, make_problem
from network.analysis.calibration.trust_region import bounded_step, length_of
from network.catalogue.declaration.declare import Array
from network.engine.response.parameters import Parameter, centres

__all__ = ["Linearised", "Problem", "chi_of", "linearise", "make_problem", "minimise", "residual_cost"]

STEPS = 60
"""At most; nearly all fits end within 25, those of numbers far beyond their priors, along bent valleys, within 50."""
CLOSE, CLOSE_SHARE, CLOSE_SHARE_FAR, FLAT = 1e-2, 1e-5, 1e-4, 0.25
"""Decrease of J that no longer matters (J counts in squared σ), as a share of J, also where the run is far off, and in
squares of the misfit: a number moves by less than half of its standard error."""
FAR = 3.0
"""Misfit χ from which priors of θ are narrowed."""
NEAR = 0.02
"""Distance in units of θ over which slopes count as the same."""
NEAR_ETA = 0.2
"""The same of slopes by η, once they were found anew."""
SETTLED = 1.0
"""Decrease of J, in squares of the misfit, below which slopes by η found anew change nothing: a number moves by less
than its standard error."""
LONGER, LONGEST = 2.0, 16.0
"""Times a step from which a longer one is tried, and at most."""
POOR, GOOD, LEAST_SHRINK = 0.25, 0.75, 0.1
"""Shares of the expected gain below which the region shrinks and from which it grows, and by how much it shrinks."""


def minimise(
    problem: Problem, theta: Array | None = None, steps: int = STEPS, tell: Callable[[float], None] | None = None,
    until: Callable[[Linearised], bool] = lambda at: False,
) -> Linearised:  # fmt: skip
    """The most probable θ, from a start (the priors' centres).

    While the run is far off all priors are narrowed by the misfit χ, as if the noise were that much larger, which keeps
    the numbers plausible; then those of θ are as they are, and those of η stay narrowed by what misfit is left. Slopes
    by η are those of the start until no step betters J, then those found there, until that changes nothing. Where that
    changes much, runs are laid out anew about the η that is most probable, from then on with all slopes. Where
    relays switch, J is rough: slopes by η are found as often as those by θ, and the best that was met is what counts.
    Instants, which have no slope, stay where they are, and no prior moves them.
    """
    theta = centres(problem.parameters) if theta is None else theta
    low, high = (np.array([getattr(p, side) for p in problem.parameters]) for side in ("low", "high"))
    best = at = _temper_priors(linearise(problem, np.clip(theta, low, high)))
    radius, settled = np.inf, np.inf
    for k in range(steps):
        if tell:
            tell(k / steps)
        before, best = at, _better(best, at)
        at, radius, gain = _improve(at, radius, low, high)
        at = _temper_priors(at)
        if until(at):
            break
        is_far, was_far = (x.problem.firm_theta > 1 for x in (at, before))
        if gain >= _least_gain(at, settled < np.inf or at.problem.moves) or is_far != was_far:
            if settled < np.inf and not _lies_within(at, at.eta_made_at, NEAR_ETA):
                at = _temper_priors(_complete_slopes(at))
            continue
        done, at = at, _temper_priors(_complete_slopes(at))
        if not at.problem.moves and _has_bent(done, at):
            at = _temper_priors(expand_anew(at))
        if at is done or settled - at.cost < SETTLED * max(1.0, chi_of(at)) ** 2:
            break
        settled = min(settled, at.cost)
    return _complete_slopes(_temper_priors(_better(best, _complete_slopes(at)), free=True))


def _has_bent(before: Linearised, at: Linearised) -> bool:
    """Whether slopes by η found anew change J by more than as if every number were a standard error off."""
    return abs(at.cost - before.cost) > SETTLED * at.free * max(1.0, chi_of(at)) ** 2


def _better(best: Linearised, at: Linearised) -> Linearised:
    """Where relays switch, the more plausible, but none whose slopes by η are not from there; else the last."""
    if not at.problem.model.switches:
        return at
    return at if at.eta_made_at is None and implausibility(at) < implausibility(best) else best


def _temper_priors(at: Linearised, free: bool = False) -> Linearised:
    """The same point with priors narrowed by the misfit that is left; those of θ only far off."""
    chi = max(1.0, chi_of(at))
    return at.temper(1.0, chi) if free else narrow_priors(at, chi)


def narrow_priors(at: Linearised, chi: float) -> Linearised:
    """The same with priors narrowed by a misfit χ; those of θ only far off."""
    return at.temper(chi if chi > FAR else 1.0, chi)


def _least_gain(at: Linearised, is_last: bool = True) -> float:
    """Decrease of J that no longer matters there or, before slopes by η are found anew, is not worth a step; where
    relays are out of step by what is left beyond the noise, J is as rough as that, and less moves no number by its
    standard error."""
    misfit = max(1.0, chi_of(at)) ** 2
    rough = SETTLED * (misfit - 1) if at.problem.model.switches else 0.0
    share = CLOSE_SHARE_FAR if at.problem.firm_theta > 1 else CLOSE_SHARE
    return max(CLOSE, share * at.cost, (FLAT if is_last else SETTLED) * misfit, rough)


def _improve(at: Linearised, radius: float, low: Array, high: Array) -> tuple[Linearised, float, float]:
    """One accepted step, the radius after it, and what J lost (what it would lose, where that is next to nothing; after
    a refused one, where it would not matter: a rough J refuses the more the shorter a step is)."""
    least = CLOSE / 2
    while True:
        precision, gradient = at.reduced
        gradient = gradient * [not p.field.is_instant for p in at.problem.parameters]
        units = units_of(at.problem.parameters)
        step = bounded_step(precision, gradient, units, radius, (low - at.theta, high - at.theta))
        expected = float(2 * step @ gradient - step @ precision @ step)
        if expected < least or float(np.abs(step).max(initial=0.0)) < 1e-9:
            return at, radius, max(expected, 0.0)
        trial = move_beside(at, np.clip(at.theta + step, low, high))
        if trial is not None and trial.cost < at.cost:
            longer = _lengthen(at, trial, step, (low, high), float(step @ gradient))
            for tried in dict.fromkeys((longer, trial)):
                new = _renew_slopes(tried, at)
                gain = at.cost - (new if new.problem.moves else tried).cost
                if gain > 0:
                    radius = _radius_after(radius, length_of(tried.theta - at.theta, units), gain / expected)
                    return new, radius, at.cost - new.cost if at.problem.model.switches else gain
            trial = new
        if at.made_at is not None or at.is_rough:
            at = with_slopes(at.problem, at.theta, at.predictions, _keep_slopes(at))
        else:
            share = _shrink(at, trial, float(step @ gradient))
            radius, least = length_of(step, units) * share, _least_gain(at) / 2


def _radius_after(radius: float, length: float, ratio: float) -> float:
    """The region after an accepted step of some length, by what of the expected gain came about."""
    if ratio < POOR:
        return length / 2
    return max(radius, 2 * length) if ratio > GOOD else radius


def _shrink(at: Linearised, new: Linearised | None, descent: float) -> float:
    """By how much a refused step is shortened: to the least of the parabola through both costs and the first slope."""
    if new is None:
        return LEAST_SHRINK
    return float(np.clip(descent / (new.cost - at.cost + 2 * descent), LEAST_SHRINK, 0.5))


def _lengthen(
    at: Linearised, new: Linearised, step: Array, bounds: tuple[Array, Array], descent: float
) -> Linearised:  # fmt: skip
    """An accepted step, or a longer one to the least of the same parabola, where J falls farther: where it is flatter
    than slopes alone tell, they creep along it."""
    bend = 2 * descent - (at.cost - new.cost)
    longer = min(descent / bend, LONGEST) if bend > 0 else LONGEST
    if longer < LONGER or at.problem.model.switches:
        return new
    trial = move_beside(at, np.clip(at.theta + longer * step, *bounds))
    return new if trial is None or trial.cost > new.cost else trial


def _renew_slopes(new: Linearised, at: Linearised) -> Linearised:
    """With slopes from there, where θ has moved far since they were found; always where runs are laid out anew, for J
    with slopes by η from elsewhere is no J to go by there."""
    if new.problem.moves:
        return expand_anew(new)
    if _is_near(new):
        return new
    return with_slopes(new.problem, new.theta, new.predictions, _keep_slopes(at), at.bent)


def _keep_slopes(at: Linearised) -> Linearised | None:
    """Whose slopes by η are good nearby; none where relays switch, whose instants move with θ."""
    return None if at.problem.model.switches else at


def units_of(parameters: Sequence[Parameter]) -> Array:
    """In which distances in θ are told: a logarithm, or a prior 1σ."""
    return np.array([1.0 if p.is_log else p.spread for p in parameters])


def _is_near(at: Linearised) -> bool:
    """Whether slopes that were found elsewhere are good here."""
    return _lies_within(at, at.made_at, NEAR)


def _lies_within(at: Linearised, made_at: Array | None, reach: float) -> bool:
    units = units_of(at.problem.parameters)
    return made_at is None or bool((np.abs(at.theta - made_at) < reach * units).all())


def _complete_slopes(at: Linearised) -> Linearised:
    """With slopes by θ that are good here, and slopes by η from here."""
    if at.is_rough or not _is_near(at):
        return with_slopes(at.problem, at.theta, at.predictions)
    return at if at.eta_made_at is None else with_nuisance_slopes(at)
