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
from network.declare import Array
from network.diagnosis.candidates import Candidate
from network.diagnosis.candidates import candidate as other_candidate
from network.diagnosis.case import Case, Hypothesis, relaid, suppose
from network.diagnosis.screen import whitened
from network.graph import build
from network.mechanisms.base import Relay
from network.refusal import Failed

DRAWS, ELITE, STARTS = 400, 40, 3
HORIZONS = (0.35, 0.35, 0.5, 0.5, 0.75, 1.0, 1.0)
"""Share of each run that a round looks at."""
WIDER, LEAST = 1.5, 0.02
"""How much wider than the best draws the next ones are, every other round; and the least, in prior σ."""
STEPS, POLISHES, NEARBY = 14, 2, 0.2
"""Steps of a fit from a draw; how often it is drawn again around the best, and how near, in prior σ."""
NEAR = 1.6
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
    rival that is to be beaten. A refined machine is searched as it was written: relays do not need its lumps."""
    rough, small = _rough(case, null, candidate)
    if rough is None or small is None or not serves(build(small.machine)):
        return None
    about = freed(rough, parts_about(small), power)
    draws = _drawn(about, small, _values(about), seed)
    if not draws or draws[0].misfit > NEAR * beat:
        return None
    fits = [_fitted(case, null, candidate, _values(about), draw) for draw in _apart(draws, small.own)]
    best = min((f for f in fits if f is not None), key=lambda f: f.fit.cost, default=None)
    for i in range(POLISHES):
        if best is None or best.chi < GOOD:
            break
        better = _polished(case, null, candidate, rough, small, best, seed + i)
        if better is None or better.fit.cost > best.fit.cost - 1:
            break
        best = better
    return best


def _values(about: Linearised) -> dict[str, float]:
    return values_at(about.problem.parameters, about.theta)


def _fitted(
    case: Case, null: Hypothesis, candidate: Candidate, values: Mapping[str, float], draw: Draw
) -> Hypothesis | None:
    """The candidate fitted from a draw; None where it runs away."""
    start = {**values, **values_at(candidate.own, draw.theta)}
    try:
        return suppose(case, candidate.machine, (*null.found, candidate), (*null.own, *candidate.own), start, steps=STEPS)
    except (Failed, np.linalg.LinAlgError):
        return None


def _polished(
    case: Case, null: Hypothesis, candidate: Candidate, rough: Hypothesis, small: Candidate, best: Hypothesis, seed: int
) -> Hypothesis | None:
    """Drawn again around a fit, about the parameters that it found, and fitted from the best."""
    theta = np.array([p.centre if p.path not in best.values else _theta(p, best.values[p.path])
                      for p in rough.fit.problem.parameters])  # fmt: skip
    about = linearise(replace(rough.fit.problem, firm_theta=1.0, firm_eta=1.0), theta)
    centre = np.array([_theta(p, best.values[q.path]) for p, q in zip(small.own, candidate.own, strict=True)])
    draws = _drawn(about, small, _values(about), seed, centre, NEARBY)
    return _fitted(case, null, candidate, best.values, draws[0]) if draws else None


def _theta(p: Parameter, value: float) -> float:
    return float(np.log(value)) if p.is_log else value


def _rough(case: Case, null: Hypothesis, candidate: Candidate) -> tuple[Hypothesis | None, Candidate | None]:
    """The null and the candidate on the machine as it was written."""
    if null.root.to_plain() == case.machine.to_plain():
        return null, candidate
    rough = relaid(case, case.machine, null.found, null.values)
    return rough, rough and other_candidate(rough.machine, candidate.kind, candidate.patch)


def _drawn(
    about: Linearised, candidate: Candidate, values: dict[str, float], seed: int, centre: Array | None = None,
    share: float = 1.0,
) -> list[Draw]:  # fmt: skip
    """Rounds of draws, the best first: from the priors with a growing horizon, or near a centre (share of the priors'
    spread) with the whole runs in view."""
    rng = np.random.default_rng(seed)
    low, high = (np.array([getattr(p, s) for p in candidate.own]) for s in ("low", "high"))
    first, spread = (np.array([getattr(p, s) for p in candidate.own]) for s in ("centre", "spread"))
    horizons = HORIZONS if centre is None else (1.0, 1.0)
    centre, root = first if centre is None else centre, np.diag(share * spread)
    kept: list[Draw] = []
    for i, horizon in enumerate(horizons):
        theta = np.clip(centre + rng.standard_normal((DRAWS, len(centre))) @ root.T, low, high)
        if kept:
            theta[:ELITE] = [d.theta for d in kept]
        kept = sorted(_judged(about, candidate, values, theta, horizon), key=lambda d: d.misfit)[:ELITE]
        best = np.array([d.theta for d in kept])
        wider = WIDER if i % 2 == 0 else 1.0
        centre = best.mean(axis=0)
        root = np.linalg.cholesky(wider**2 * np.cov(best.T).reshape(len(centre), -1) + np.diag(LEAST * spread) ** 2)
    return kept


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
    early = _early(about, horizon)
    measured = np.concatenate([d.means for d in about.problem.data])
    means = np.concatenate([m for m, _ in runs], axis=1)
    residual = np.stack([whitened(about, np.where(early, measured - row, 0.0)) for row in means])
    seen = whitened(about, early.astype(float)) > 0
    misfit = _adjusted(about, residual, seen)
    hours = sum(float(np.ptp(d.run.knots.samples)) for d in about.problem.data) * horizon / 3600
    many = sum(switches for _, switches in runs) > MOST_SWITCHES * hours
    own = np.array([[(x - p.centre) / p.spread for p, x in zip(candidate.own, row, strict=True)] for row in theta])
    misfit = np.where(many, np.inf, misfit + np.sum(own**2, axis=1))
    return [Draw(row, float(m)) for row, m in zip(theta, misfit, strict=True)]


def _was_part(candidate: Candidate, name: str) -> bool:
    return name in candidate.base.nodes and candidate.base.nodes[name].is_part


def _early(about: Linearised, horizon: float) -> Array:
    """Which cells of all runs end before the horizon."""
    parts = []
    for data in about.problem.data:
        knots = data.run.knots
        ends = knots.t[knots.cell_ends]
        until = knots.t[0] + horizon * (knots.t[-1] - knots.t[0]) + 1e-6
        parts.append(np.tile(ends <= until, len(data.run.channels)))
    return np.concatenate(parts)


def _adjusted(about: Linearised, residual: Array, seen: Array) -> Array:
    """Misfits |r|² less what the parameters take up, within their priors, of the rows that are seen."""
    mean, spread = about.problem.prior
    n = about.free
    slopes = about.slopes * seen
    off = (mean - np.concatenate([about.theta, np.zeros(len(mean) - n)])) / spread**2
    right = residual @ slopes.T + off
    precision = slopes @ slopes.T + np.diag(spread**-2.0)
    misfit = np.einsum("ij,ij->i", residual, residual) - np.einsum("ij,ij->i", right, np.linalg.solve(precision, right.T).T)
    return np.where(np.isfinite(misfit), misfit, np.inf)


def _apart(draws: Sequence[Draw], own: Sequence[Parameter]) -> list[Draw]:
    """The best draws that are not nearly the same."""
    chosen: list[Draw] = []
    for draw in draws:
        far = all(np.abs((draw.theta - c.theta) / [p.spread for p in own]).max() > 0.05 for c in chosen)
        if far and np.isfinite(draw.misfit):
            chosen.append(draw)
    return chosen[:STARTS]
