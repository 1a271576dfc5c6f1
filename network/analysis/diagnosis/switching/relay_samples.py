"""Draws of relays: many of every candidate over the beginning of the runs, the best polished over ever more of them.

And over whole runs at once: one that holds its part about the set point is told by its mean, however out of step.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.switching.prior_samples import Judge, Space, apart
from network.analysis.diagnosis.switching.sample_refinement import refine_samples
from network.analysis.diagnosis.switching.share_view import View
from network.catalogue.declaration.declare import Array
from network.engine.response.parameters import values_at
from network.platform.parallel import run_all
from network.platform.refusal import Failed

DRAWS, BEGUN, APART = 250, 30, 0.3
"""Draws of a candidate, how many of them are polished, and how far they are apart in prior σ."""
ONSETS = (0.7, 0.6, 0.5, 0.4, 0.3)
"""Shares of each run until which nothing may be missing; what begins before shows where draws begin and go on."""
FIRST = (0.18, 0.12)
"""Share of each run, from the onset on, where draws about the fit begin, and about the numbers of the file: over less a
period is not told, over more only from near."""
STEPS = ((1, 12), (2, 12))
"""Steps of polishing there, and how many draws go on."""
THEN = ((0.25, 2, 24), (0.35, 2, 12), (0.5, 2, 4))
"""Shares and steps after these, and how many draws go on there."""
WHOLE = (12, 3, 4)
"""How many draws over whole runs are polished, in how many steps, and how many of a candidate go on."""
ALIKE = 0.1
"""Prior σ within which polished draws are the same."""
NEAR = 0.85
"""Misfit of the best draw over that of the null, up to which draws are fitted."""

Near = Mapping[tuple[str, ...], Array]
"""Of candidates, by key, numbers near which to draw."""


@dataclass(frozen=True)
class Drawn:
    """A draw that was polished, and what judged it."""

    judge: Judge
    theta: Array
    misfit: float


def find_onset(abouts: Sequence[Linearised]) -> float:
    """Share of the runs until which some fit leaves no more than noise: what would show there has not switched yet."""
    views = ((share, [View(a, share) for a in abouts]) for share in ONSETS)
    quiet = (share for share, of in views if any(v.misfit <= SETTINGS.noise**2 * v.rows for v in of))
    return next(quiet, 0.0)


def after(onset: float, share: float) -> float:
    """The share of the runs that ends a share of their length after the onset."""
    return min(1.0, onset + share)


def draw_samples(
    abouts: Sequence[Linearised], switched: Sequence[Candidate], known: Near, onset: float, seed: int, jobs: int
) -> list[Drawn]:
    """The best draws of all, polished over ever more of the runs; none where they stay behind what is there. known: of
    some candidates the numbers about which they are drawn."""
    spaces, judges = _list_judges(abouts, switched)
    begins = [after(onset, share) for share in FIRST[: len(abouts)] for _ in spaces]
    drawn = _each(
        judges,
        run_all(partial(_first, known, seed, after(onset, THEN[0][0])), list(zip(judges, begins, strict=True)), jobs),
    )
    for share, steps, most in THEN:
        groups = [[d for d in drawn[:most] if d.judge is judge] for judge in judges]
        groups = [g for g in groups if g]
        further = run_all(partial(_further, after(onset, share), steps), groups, jobs)
        drawn = _each([g[0].judge for g in groups], further)
    return _keep_near(drawn, min((View(a, after(onset, THEN[-1][0])).misfit for a in abouts), default=0.0))


def draw_over_whole(
    abouts: Sequence[Linearised], switched: Sequence[Candidate], known: Near, seed: int, jobs: int
) -> list[Drawn]:
    """The best draws over whole runs, of every candidate some; none where they stay behind what is there. known: of
    some candidates the numbers about which they are drawn."""
    spaces, judges = _list_judges(abouts, switched)
    drawn = _each(judges, run_all(partial(_whole, known, seed), judges, jobs))
    near = _keep_near(drawn, min((View(a, 1.0).misfit for a in abouts), default=0.0))
    return [d for s in spaces for d in [d for d in near if d.judge.space is s][: WHOLE[-1]]]


def _whole(known: Near, seed: int, judge: Judge) -> tuple[Array, Array]:
    """The best draws over whole runs, polished, and their misfits; none where none comes near."""
    view, theta = View(judge.about, 1.0), judge.space.draw(DRAWS, seed, known.get(judge.space.candidate.key))
    begun, steps, _ = WHOLE
    try:
        misfit = judge.misfits(view, theta, judge.residuals(view, theta))
        if not misfit.min() < NEAR * view.misfit:
            return theta[:0], np.empty(0)
        theta = theta[apart(theta, misfit, judge.space.prior[1], APART, begun)]
        return _distinct(judge, *refine_samples(judge, view, theta, steps))
    except (Failed, np.linalg.LinAlgError):
        return theta[:0], np.empty(0)


def _keep_near(drawn: Sequence[Drawn], behind: float) -> list[Drawn]:
    """Draws, the best first, that come near, and explain half of what the best does; behind: misfit of the null."""
    near = [d for d in drawn if d.misfit < NEAR * behind]
    return [d for d in near if behind - d.misfit >= SETTINGS.half * (behind - near[0].misfit)]


def _list_judges(abouts: Sequence[Linearised], switched: Sequence[Candidate]) -> tuple[list[Space], list[Judge]]:
    """What can be drawn of some candidates, and each beside every fit."""
    spaces = [s for s in map(Space, switched) if s.serves]
    return spaces, [Judge(s, a, values_at(a.problem.parameters, a.theta)) for a in abouts for s in spaces]


def _first(known: Near, seed: int, then: float, of: tuple[Judge, float]) -> tuple[Array, Array]:
    """The best draws, polished over the beginning of the runs, and their misfits over more of it."""
    (judge, share), theta = of, of[0].space.draw(DRAWS, seed, known.get(of[0].space.candidate.key))
    view, further = View(judge.about, share), View(judge.about, then)
    try:
        misfit = judge.misfits(view, theta, judge.residuals(view, theta))
        theta = theta[apart(theta, misfit, judge.space.prior[1], APART, BEGUN)]
        for steps, most in STEPS:
            theta = _distinct(judge, *refine_samples(judge, view, theta, steps))[0][:most]
        return theta, judge.misfits(further, theta, judge.residuals(further, theta))
    except (Failed, np.linalg.LinAlgError):
        return theta[:0], np.empty(0)


def _further(share: float, steps: int, drawn: Sequence[Drawn]) -> tuple[Array, Array]:
    judge = drawn[0].judge
    try:
        theta = np.array([d.theta for d in drawn])
        return _distinct(judge, *refine_samples(judge, View(judge.about, share), theta, steps))
    except (Failed, np.linalg.LinAlgError):
        return np.empty((0, 0)), np.empty(0)


def _distinct(judge: Judge, theta: Array, misfit: Array) -> tuple[Array, Array]:
    chosen = apart(theta, misfit, judge.space.prior[1], ALIKE, len(theta))
    return theta[chosen], misfit[chosen]


def _each(judges: Sequence[Judge], told: Sequence[tuple[Array, Array]]) -> list[Drawn]:
    """Draws with what judged them, the best first."""
    pairs = zip(judges, told, strict=True)
    drawn = [Drawn(j, t, float(m)) for j, (theta, misfit) in pairs for t, m in zip(theta, misfit, strict=True)]
    return sorted(drawn, key=lambda d: d.misfit)
