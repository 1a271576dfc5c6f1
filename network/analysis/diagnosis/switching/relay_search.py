"""The search for a relay: draws, polished over ever more of the runs, then fits of the best, so that it keeps step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised, linearise
from network.analysis.diagnosis.candidates import Candidate, candidate
from network.analysis.diagnosis.compact_fit import compact, fit_with
from network.analysis.diagnosis.hypothesis import Case, Hypothesis, reweight, use_file_noise
from network.analysis.diagnosis.result import UnknownHeat
from network.analysis.diagnosis.switching.affine_surrogate import straighten
from network.analysis.diagnosis.switching.prior_samples import Judge, Space, View, apart, parts_about
from network.analysis.diagnosis.switching.sample_refinement import refine_samples
from network.catalogue.declaration.declare import Array
from network.engine.response.parameters import centres, values_at
from network.platform.parallel import run_all
from network.platform.refusal import Failed

MOST = 3
"""Switched candidates that are drawn."""
DRAWS, BEGUN, APART = 250, 30, 0.3
"""Draws of a candidate, how many of them are polished, and how far they are apart in prior σ."""
FIRST = (0.18, 0.12)
"""Share of each run where draws about the fit begin, and about the numbers of the file: over less a period is not told,
over more only from near."""
STEPS = ((1, 12), (2, 12))
"""Steps of polishing there, and how many draws go on."""
THEN = ((0.25, 2, 24), (0.35, 2, 12), (0.5, 2, 4))
"""Shares and steps after these, and how many draws go on there."""
ALIKE = 0.1
"""Prior σ within which polished draws are the same."""
NEAR = 0.85
"""Misfit of the best draw over that of the null, up to which draws are fitted."""
LADDER = ((0.5, 5, 3), (0.75, 6, 2), (1.0, 12, 1))
"""Shares of each run over which they are, steps there, and how many go on."""
ROUNDS = 3
"""Times that an affine machine that stands for another is made anew about the best relay."""
WELL = 0.9
"""Misfit χ over that of the null from which a relay counts as found."""


@dataclass(frozen=True)
class _Drawn:
    """A draw that was polished, and what judged it."""

    judge: Judge
    theta: Array
    misfit: float


@dataclass(frozen=True)
class _Start:
    """A candidate to be fitted from some numbers, about some starts of its parts."""

    candidate: Candidate
    values: Mapping[str, float]
    began: tuple[Mapping[str, float], ...]


def search_relays(
    case: Case, current: Hypothesis, switched: Sequence[Candidate], seed: int, jobs: int
) -> list[Hypothesis]:  # fmt: skip
    """The relay that comes nearest, fitted under the noise of the file and told under that of the case; none where no
    draw comes near. Draws are judged about the fit and about the numbers of the file, on an affine machine."""
    white = use_file_noise(case)
    null = reweight(white, current)
    plain, best = straighten(null), None
    for _ in range(ROUNDS):
        found = _search_about(white, null, plain, switched[:MOST], seed, jobs) if plain else None
        if found is None or (best is not None and found.chi >= best.chi):
            break
        best = found
        plain = None if plain is null else straighten(reweight(white, best), best.found[-1])
    return [compact(reweight(case, best))] if best is not None and best.chi < WELL * null.chi else []


def _search_about(
    case: Case, null: Hypothesis, plain: Hypothesis, switched: Sequence[Candidate], seed: int, jobs: int
) -> Hypothesis | None:
    """The relay that comes nearest of those drawn on a machine that stands for the null's."""
    about = [_about(plain, theta) for theta in (plain.fit.theta, _of_file(plain))]
    known = {c.key: c for c in switched}
    laid = [again for c in known.values() if (again := candidate(plain.machine, c.kind, c.patch)) is not None]
    drawn = [d for d in _draw_samples(about, laid, seed, jobs) if d.judge.space.candidate.key in known]
    fits = []
    for d in drawn:
        beside = null.values if d.judge.about is about[0] else null.own_values
        began = _all(case, d.judge.space.starts(d.theta))
        fits.append(_Start(known[d.judge.space.candidate.key], beside | _values(d), began))
    return _fit_samples(case, null, fits, jobs) if fits else None


def tell_unsearched(null: Hypothesis, switched: Sequence[Candidate]) -> str:
    """Why relays of some kind cannot be looked for; empty where they can."""
    plain = straighten(null)
    if plain is None:
        return "a part melts, or the laws of this machine cannot be taken as straight"
    laid = [candidate(plain.machine, c.kind, c.patch) for c in switched]
    return (
        "" if any(c is not None and Space(c).serves for c in laid) else "it would not be the only thing that switches"
    )


def rank_likely_places(switched: Sequence[Candidate], located: Sequence[UnknownHeat]) -> list[Candidate]:
    """Those at the places where unknown heat explains most first; of two there, the one with more to it."""
    gain = {u.at.nodes[0]: u.gain for u in located if u.at.kind == "node"}
    return sorted(switched, key=lambda c: (-max((gain.get(n, 0.0) for n in parts_about(c)), default=0.0), -len(c.own)))


def _about(null: Hypothesis, theta: Array) -> Linearised:
    return linearise(replace(null.fit.problem, firm_theta=1.0, firm_eta=1.0), theta)


def _of_file(null: Hypothesis) -> Array:
    """The numbers of the file, beside those of what was found."""
    own = {p.path for p in null.own}
    pairs = zip(null.fit.problem.parameters, null.fit.theta, centres(null.fit.problem.parameters), strict=True)
    return np.array([fitted if p.path in own else centre for p, fitted, centre in pairs])


def _draw_samples(abouts: Sequence[Linearised], switched: Sequence[Candidate], seed: int, jobs: int) -> list[_Drawn]:
    """The best draws of all, polished over ever more of the runs; none where they stay behind what is there."""
    spaces = [s for s in map(Space, switched) if s.serves]
    judges = [Judge(s, a, values_at(a.problem.parameters, a.theta)) for a in abouts for s in spaces]
    begins = [share for share in FIRST for _ in spaces]
    drawn = _each(judges, run_all(partial(_first, seed), list(zip(judges, begins, strict=True)), jobs))
    for share, steps, most in THEN:
        groups = [[d for d in drawn[:most] if d.judge is judge] for judge in judges]
        groups = [g for g in groups if g]
        further = run_all(partial(_further, share, steps), groups, jobs)
        drawn = _each([g[0].judge for g in groups], further)
    behind = min((View(a, THEN[-1][0]).misfit for a in abouts), default=0.0)
    return [d for d in drawn if d.misfit < NEAR * behind]


def _first(seed: int, of: tuple[Judge, float]) -> tuple[Array, Array]:
    """The best draws from the prior, polished over the beginning of the runs, and their misfits over more of it."""
    (judge, share), theta = of, of[0].space.draw(DRAWS, seed)
    view, further = View(judge.about, share), View(judge.about, THEN[0][0])
    try:
        misfit = judge.misfits(view, theta, judge.residuals(view, theta))
        theta = theta[apart(theta, misfit, judge.space.prior[1], APART, BEGUN)]
        for steps, most in STEPS:
            theta = _distinct(judge, *refine_samples(judge, view, theta, steps))[0][:most]
        return theta, judge.misfits(further, theta, judge.residuals(further, theta))
    except (Failed, np.linalg.LinAlgError):
        return theta[:0], np.empty(0)


def _further(share: float, steps: int, drawn: Sequence[_Drawn]) -> tuple[Array, Array]:
    judge = drawn[0].judge
    try:
        theta = np.array([d.theta for d in drawn])
        return _distinct(judge, *refine_samples(judge, View(judge.about, share), theta, steps))
    except (Failed, np.linalg.LinAlgError):
        return np.empty((0, 0)), np.empty(0)


def _distinct(judge: Judge, theta: Array, misfit: Array) -> tuple[Array, Array]:
    chosen = apart(theta, misfit, judge.space.prior[1], ALIKE, len(theta))
    return theta[chosen], misfit[chosen]


def _each(judges: Sequence[Judge], told: Sequence[tuple[Array, Array]]) -> list[_Drawn]:
    """Draws with what judged them, the best first."""
    pairs = zip(judges, told, strict=True)
    drawn = [_Drawn(j, t, float(m)) for j, (theta, misfit) in pairs for t, m in zip(theta, misfit, strict=True)]
    return sorted(drawn, key=lambda d: d.misfit)


def _values(drawn: _Drawn) -> dict[str, float]:
    return {**drawn.judge.values, **drawn.judge.space.numbers(drawn.theta)}


def _all(case: Case, starts: Mapping[str, float]) -> tuple[Mapping[str, float], ...]:
    """The starts beside those known before, for every run."""
    before = case.began or ({},) * len(case.recordings)
    return tuple({**run, **starts} for run in before) if starts else case.began


def _fit_samples(case: Case, null: Hypothesis, starts: Sequence[_Start], jobs: int) -> Hypothesis | None:
    """The best fit from some starts over ever more of the runs; None where all run away."""
    alive: list[Hypothesis] = []
    for share, steps, most in LADDER:
        part = case.until(share) if share < 1 else case
        fits = run_all(partial(_fit, part, null, steps), starts, jobs)
        alive = sorted((h for h in fits if h is not None), key=lambda h: h.chi)[:most]
        starts = [_Start(h.found[-1], h.values, h.case.began) for h in alive]
    return alive[0] if alive else None


def _fit(case: Case, null: Hypothesis, steps: int, start: _Start) -> Hypothesis | None:
    return fit_with(replace(case, began=start.began), null, start.candidate, start.values, steps)
