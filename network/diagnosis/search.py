"""The search for a relay: where it switches is not a smooth matter, so its numbers are drawn before they are fitted.

Draws from the priors are run all at once and judged by their misfit with the other parameters adjusted linearly; the
best ones set the next draws (the cross-entropy method, Rubinstein & Kroese 2004), and the best few are fitted in full.
The first rounds look at the beginning of each run only, where a wrong period has not yet lost its step.
The parameters about which all this happens come from a fit that allows any heat at the places in question.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from network.calibration.batch import Draws, draws_of, means_of, serves, step_of
from network.calibration.fitting import Linearised, linearise, minimise
from network.calibration.noise import slack_covariance, whitener
from network.calibration.parameters import Parameter, values_at
from network.calibration.partials import Slots
from network.checks import places_of
from network.declare import Array, Mask
from network.diagnosis.candidates import Candidate
from network.diagnosis.case import Case, Hypothesis, early, suppose
from network.diagnosis.screen import whitened
from network.graph import build
from network.mechanisms.base import Relay
from network.refusal import Failed

DRAWS, ELITE, STARTS, APART = 400, 40, 2, 0.3
"""Draws of a round, how many set the next ones, how many are fitted, and how far these are apart in prior σ."""
HORIZONS = (0.35, 0.35, 0.45, 0.45)
"""Share of each run that a round looks at."""
WIDER, LEAST = 1.5, 0.02
"""How much wider than the best draws the next ones are, every other round; and the least, in prior σ."""
LADDER = ((0.45, 8), (0.65, 6), (1.0, 12))
"""Shares of each run that a fit is extended to, and its steps there."""
HOPELESS = 1.6
"""Misfit χ over the beginning of the runs at which a draw is given up."""
ATTEMPTS = 2
"""How often it is drawn anew where no fit explains everything."""
NEAR = 0.8
"""Cost of the best draw over a rival's, up to which it is fitted in full."""
GOOD = 1.03
"""Misfit χ at which no further draw is fitted."""
MOST_SWITCHES = 25
"""An hour, beyond which a draw is not looked at."""
SLACK_SHARE, SLACK_TIME = 0.6, 900.0
"""1σ of the heat allowed at the places in question over the installed heat, and its correlation time [s]."""


@dataclass(frozen=True)
class Draw:
    """Numbers of a candidate and the misfit they leave, the others adjusted linearly."""

    theta: Array
    misfit: float


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


def search(
    case: Case, null: Hypothesis, candidate: Candidate, power: float, seed: int, beat: float = np.inf
) -> Hypothesis | None:
    """The candidate at the best of its numbers; None where it cannot be searched, or no draw comes near the cost J of a
    rival that is to be beaten."""
    if not serves(build(candidate.machine)):
        return None
    about = freed(null, parts_about(candidate), power)
    best: Hypothesis | None = None
    for attempt in range(ATTEMPTS):
        draws = _drawn(about, candidate, _values(about), seed + attempt)
        if not draws or draws[0].misfit > NEAR * beat:
            break
        for draw in _apart(draws, candidate.own):
            fitted = _fitted(case, null, candidate, _values(about), draw)
            best = min((f for f in (best, fitted) if f is not None), key=lambda f: f.fit.cost, default=None)
            if best is not None and best.chi < GOOD:
                return best
        if best is None or best.fit.cost > beat:
            break
    return best


def _values(about: Linearised) -> dict[str, float]:
    return values_at(about.problem.parameters, about.theta)


def _fitted(
    case: Case, null: Hypothesis, candidate: Candidate, values: Mapping[str, float], draw: Draw
) -> Hypothesis | None:
    """The candidate fitted from a draw, to ever more of each run, so that it keeps step; None where it runs away."""
    start = {**values, **values_at(candidate.own, draw.theta)}
    found, own = (*null.found, candidate), (*null.own, *candidate.own)
    fitted = None
    try:
        for horizon, steps in LADDER:
            seen = case if horizon == 1.0 else case.until(horizon)
            fitted = suppose(seen, candidate.machine, found, own, start, steps=steps)
            start = fitted.values
            if fitted.chi > HOPELESS:
                return None
    except (Failed, np.linalg.LinAlgError):
        return None
    return fitted


def _drawn(about: Linearised, candidate: Candidate, values: dict[str, float], seed: int) -> list[Draw]:
    """Rounds of draws from the priors with a growing horizon, the best first."""
    rng = np.random.default_rng(seed)
    low, high = (np.array([getattr(p, s) for p in candidate.own]) for s in ("low", "high"))
    centre, spread = (np.array([getattr(p, s) for p in candidate.own]) for s in ("centre", "spread"))
    root = np.diag(spread)
    kept: list[Draw] = []
    pool: list[Draw] = []
    for i, horizon in enumerate(HORIZONS):
        theta = np.clip(centre + rng.standard_normal((DRAWS, len(centre))) @ root.T, low, high)
        if kept:
            theta[:ELITE] = [d.theta for d in kept]
        kept = sorted(_judged(about, candidate, values, theta, horizon), key=lambda d: d.misfit)
        pool += kept if horizon == HORIZONS[-1] else []
        kept = kept[:ELITE]
        best = np.array([d.theta for d in kept])
        wider = WIDER if i % 2 == 0 else 1.0
        centre = best.mean(axis=0)
        root = np.linalg.cholesky(wider**2 * np.cov(best.T).reshape(len(centre), -1) + np.diag(LEAST * spread) ** 2)
    return sorted(pool, key=lambda d: d.misfit)


def _judged(
    about: Linearised, candidate: Candidate, values: dict[str, float], theta: Array, horizon: float
) -> list[Draw]:
    network = build(candidate.machine)
    parameters = (*(p for p in about.problem.parameters if p.path in candidate.machine.uncertain), *candidate.own)
    slots = Slots(network, parameters)
    shared = {p.path: values[p.path] for p in parameters if p.path in values}
    networks = [slots.at(shared | values_at(candidate.own, row)) for row in theta]
    reference = candidate.machine.reference
    new = {n for n, node in candidate.machine.nodes.items() if node.is_part and not _was_part(candidate, n)}
    steps: dict[float, Draws] = {}
    runs = []
    for d in about.problem.data:
        h = round(step_of(d.run), 6)
        draws = steps[h] if h in steps else steps.setdefault(h, draws_of(networks, d.run))
        runs.append(means_of(candidate.machine, draws, d.run, reference, new, horizon))
    seen_early = np.concatenate([early(d, horizon) for d in about.problem.data])
    measured = np.concatenate([d.means for d in about.problem.data])
    means = np.concatenate([m for m, _ in runs], axis=1)
    residual = np.stack([whitened(about, np.where(seen_early, measured - row, 0.0)) for row in means])
    seen = whitened(about, seen_early.astype(float)) > 0
    misfit = _adjusted(about, residual, seen)
    hours = sum(float(np.ptp(d.run.knots.samples)) for d in about.problem.data) * horizon / 3600
    many = sum(switches for _, switches in runs) > MOST_SWITCHES * hours
    own = np.array([[(x - p.centre) / p.spread for p, x in zip(candidate.own, row, strict=True)] for row in theta])
    misfit = np.where(many, np.inf, misfit + np.sum(own**2, axis=1))
    return [Draw(row, float(m)) for row, m in zip(theta, misfit, strict=True)]


def _was_part(candidate: Candidate, name: str) -> bool:
    return name in candidate.base.nodes and candidate.base.nodes[name].is_part


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


def _apart(draws: Sequence[Draw], own: Sequence[Parameter]) -> list[Draw]:
    """The best draws that are not nearly the same."""
    chosen: list[Draw] = []
    for draw in draws:
        far = all(np.abs((draw.theta - c.theta) / [p.spread for p in own]).max() > APART for c in chosen)
        if far and np.isfinite(draw.misfit):
            chosen.append(draw)
    return chosen[:STARTS]
