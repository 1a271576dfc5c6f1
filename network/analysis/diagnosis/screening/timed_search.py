"""Heat by the clock: its instants have no slope, so they are drawn, and scored linearly about the fit of any network.

The best windows and trains of a grid (pulse_grid), moved between its instants, and draws from the priors of what goes
faster, then steps of all lengths from the best of them, taken where they gain (an evolution strategy; Rechenberg 1973;
unverified). A score costs the answer to one heat, but on the grid next to nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from network.analysis.calibration.linearised import linearise
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.hypotheses.compact_fit import fit_or_none
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import parameters_of, theta_of
from network.analysis.diagnosis.latent_heat.locate import list_likely_parts
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.screening.pulse_grid import PulseGrid, draw_steps, lay_grid, numbers_of, pulses_of
from network.analysis.diagnosis.screening.screen import Score, score_variants
from network.catalogue.declaration.declare import Array
from network.catalogue.mechanisms.mechanism import Mechanism
from network.platform.parallel import run_all

PLACES = 3
"""Places at which they are looked for, those where unknown heat explains most (budget)."""
DRAWS, AGAIN, ROUNDS, ROUNDS_FROM_GRID = 64, 32, 8, 2
"""Draws from the priors, and about the best in each further round; such rounds, and those where a grid had told it
(budget)."""
GRIDDED = 4
"""Windows, and trains, of the grid that are scored by themselves (budget)."""
CLOSEST = 1e-3
"""Prior σ: the shortest step, some seconds of a period."""
SETTLED, BRIEFLY, SETTLED_STEPS, ENOUGH = 8, 2, 6, 1.0
"""Times that they are drawn again beside a fit, and beside one of several, its steps then, and nats that it must gain
by it (budget)."""


def search_timed(
    before: Hypothesis, proposed: Sequence[Candidate], located: Sequence[UnknownHeat], seed: int, jobs: int
) -> list[Score]:
    """Scores of what acts by the clock at the likely places, at the instants at which each explains most."""
    gain = list_likely_parts(located)
    able = [c for c in proposed if c.is_timed and c.parts & gain.keys()]
    likely = sorted(able, key=lambda c: -max(gain.get(n, 0.0) for n in c.parts))[:PLACES]
    return [s for s in run_all(partial(_settle, before, seed), likely, jobs) if s is not None]


def settle_instants(h: Hypothesis, rounds: int = SETTLED) -> Hypothesis:
    """A hypothesis with the instants of its last finding drawn again about its other numbers, where that is better."""
    c = h.found[-1]
    for _ in range(rounds if c.is_timed else 0):
        rest = h.own[: len(h.own) - len(c.own)]
        parameters = parameters_of(c.base, rest)
        about = linearise(h.case.problem(c.base, parameters), theta_of(parameters, h.values))
        before = Hypothesis(h.case, c.base, h.found[:-1], rest, about)
        best = _settle(before, 0, c, {p.path: h.values[p.path] for p in c.own})
        if best is None:
            break
        other = fit_or_none(h.case, h.found, h.own, h.values | best.best, SETTLED_STEPS)
        if other is None or other.evidence <= h.evidence + ENOUGH:
            break
        h = other
    return h


def _settle(
    before: Hypothesis, seed: int, c: Candidate, about: Mapping[str, float] | None = None
) -> Score | None:  # fmt: skip
    """The best score of a candidate over its shapes; about: numbers near which they are already."""
    shapes, rng = c.own[1:], np.random.default_rng(seed)
    grid = None if about else lay_grid(before, c)
    best = _score_best(before, c, [theta_of(shapes, about or {}), *([] if about else _draw_first(c, grid, rng))])
    is_gridded = best is not None and grid is not None and grid.clock.resolves(pulses_of(c, best.own))
    for _ in range(ROUNDS_FROM_GRID if is_gridded else ROUNDS):
        before.case.budget.check()
        middle = theta_of(shapes, best.own if best is not None else about or {})
        again = _score_best(before, c, _draw(c, middle, draw_steps(rng, AGAIN, len(shapes), CLOSEST)))
        best = again if best is None or (again is not None and again.gain > best.gain) else best
    return best


def _score_best(before: Hypothesis, c: Candidate, shapes: Sequence[Array]) -> Score | None:
    """The best of some shapes of a candidate; None where none of them is seen."""
    tried = [_at(c, theta) for theta in shapes if _is_seen(before, c, theta)]
    return next(iter(score_variants(before.linearised, tried, before.values)), None)


def _draw(c: Candidate, middle: Array, steps: Array) -> list[Array]:
    """Shapes some prior σ about others, within their bounds."""
    spread, low, high = (np.array([getattr(p, x) for p in c.own[1:]]) for x in ("spread", "low", "high"))
    return [*np.clip(middle + spread * steps, low, high)]


def _draw_first(c: Candidate, grid: PulseGrid | None, rng: np.random.Generator) -> list[Array]:
    """Shapes drawn from their priors; where there is a grid only those that go faster than it tells, and its best."""
    shapes = c.own[1:]
    drawn = _draw(c, theta_of(shapes, {}), rng.standard_normal((DRAWS, len(shapes))))
    if grid is None:
        return drawn
    fast = [theta for theta in drawn if not grid.clock.resolves(pulses_of(c, _list_numbers(c, theta)))]
    told = [theta_of(shapes, numbers_of(c, grid.sharpen(p, rng))) for p in grid.best(GRIDDED)]
    return [*fast, *(x for x in told if all(p.low <= t <= p.high for p, t in zip(shapes, x, strict=True)))]


def _is_seen(before: Hypothesis, c: Candidate, theta: Array) -> bool:
    """Whether it goes on or off at all, and stays so for a sample at least: what goes faster looks like what stays, and
    a pulse between two samples like a jump."""
    runs, shapes = before.case.runs, c.own[1:]
    laws = {p.entry: c.machine.by_path[p.entry] for p in shapes}
    numbers = _list_numbers(c, theta)
    values = {p.attribute: numbers[p.path] for p in shapes}
    begin, end = before.case.clock
    laid = [law.replaced(**values).edges(end) for law in laws.values() if isinstance(law, Mechanism)]
    edges = [each[each > begin] for each in laid]
    return all(len(each) and (np.diff(each) >= runs.interval).all() for each in edges)


def _at(c: Candidate, theta: Array) -> tuple[Candidate, float, dict[str, float]]:
    return c, 1.0, {**c.usual, **_list_numbers(c, theta)}


def _list_numbers(c: Candidate, theta: Array) -> dict[str, float]:
    """Shapes by path."""
    return {p.path: p.value(float(x)) for p, x in zip(c.own[1:], theta, strict=True)}
