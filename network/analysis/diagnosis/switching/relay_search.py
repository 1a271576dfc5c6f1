"""The search for a relay: draws, polished over ever more of the runs, then fits of the best, so that it keeps step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from network.analysis.calibration.measured_means import RunPoint
from network.analysis.diagnosis.candidates.candidate import Candidate, candidate
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.case_noise import use_file_noise
from network.analysis.diagnosis.hypotheses.compact_fit import compact
from network.analysis.diagnosis.hypotheses.falling_short import explains_most
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import reweight, theta_of
from network.analysis.diagnosis.latent_heat.locate import list_likely_parts
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.switching.affine_surrogate import straighten
from network.analysis.diagnosis.switching.certain_levels import is_drawn
from network.analysis.diagnosis.switching.prior_samples import Space, parts_about
from network.analysis.diagnosis.switching.relay_fits import (
    LADDER,
    WELL,
    RelayStart,
    fit_over_more,
    keep_of_each,
    leave_of_null,
    linearise_firmly,
)
from network.analysis.diagnosis.switching.relay_samples import Drawn, draw_over_whole, draw_samples, find_onset
from network.analysis.diagnosis.switching.written_numbers import write_own
from network.catalogue.declaration.declare import Array
from network.engine.response.parameters import centres
from network.platform.parallel import run_all
from network.platform.refusal import Failed

MOST = 3
"""Switched candidates that are drawn."""
ROUNDS = 3
"""Times that draws are made about the best relay so far, on an affine machine that stands for another made anew."""


def search_relays(
    case: Case, current: Hypothesis, switched: Sequence[Candidate], seed: int, jobs: int
) -> list[Hypothesis]:  # fmt: skip
    """The relays that come nearest, of each place the best, fitted under the noise of the file and told under that of
    the case; none where no draw comes near. Draws are judged about the fit and about the numbers of the file, on an
    affine machine."""
    white = use_file_noise(case)
    null = reweight(white, current)
    plain, best = straighten(null), list[Hypothesis]()
    able = switched[:MOST]
    for _ in range(ROUNDS):
        found = _search_about(white, null, plain, able, best[:1], seed, jobs) if plain else []
        if not found or (best and found[0].chi >= best[0].chi):
            break
        is_near = (plain is null and explains_most(null, found[0])) or bool(
            best and found[0].chi > best[0].chi * (1 - SETTINGS.worth)
        )
        best, able = found, [h.found[-1] for h in found]
        if is_near:
            break
        plain = null if plain is null else straighten(reweight(white, best[0]), best[0].found[-1])
    return [compact(reweight(case, h)) for h in best if h.chi < WELL * null.chi]


def _search_about(
    case: Case, null: Hypothesis, plain: Hypothesis, switched: Sequence[Candidate], best: Sequence[Hypothesis],
    seed: int, jobs: int,
) -> list[Hypothesis]:  # fmt: skip
    """The relays that come nearest of those drawn on a machine that stands for the null's; best: the one that came
    nearest so far, beside the numbers of which they are drawn."""
    values = {**null.values, **(best[0].values if best else {})}
    about = [
        linearise_firmly(plain, theta) for theta in (theta_of(plain.fit.problem.parameters, values), _of_file(plain))
    ]
    known, onset = {c.key: c for c in switched}, find_onset(about)
    written = write_own(plain)
    laid = [again for c in known.values() if (again := candidate(written, c.kind, c.patch)) is not None]
    near = {h.found[-1].key: _numbers(h, Space(h.found[-1])) for h in best}
    leave = partial(leave_of_null, about)
    fits: list[Hypothesis] = []
    for drawn, ladder in (
        (draw_samples(about, laid, {}, onset, seed, jobs), LADDER),
        (draw_over_whole(about, laid, near, seed, jobs), LADDER[-1:]),
    ):
        able = [d for d in drawn if d.judge.space.candidate.key in known]
        starts = [_start_of(case, known, values if d.judge.about is about[0] else null.own_values, d) for d in able]
        fits += fit_over_more(case, null, starts, ladder, leave, onset, jobs) if starts else []
    return keep_of_each(sorted(fits, key=lambda h: h.chi), 1)


def search_near(
    null: Hypothesis, starts: Sequence[RelayStart], onset: float, seed: int, jobs: int
) -> list[Hypothesis]:  # fmt: skip
    """Relays whose numbers are known about, drawn near these and fitted like others; null: under the noise of the
    file."""
    plain = straighten(null) if starts else None
    if plain is None:
        return []
    near = run_all(partial(_draw_near, plain, onset, seed), starts, jobs)
    leave = partial(leave_of_null, [linearise_firmly(null, null.fit.theta)])
    fits = [fit_over_more(null.case, null, begun, LADDER, leave, onset, jobs) for begun in near if begun]
    return [h for each in fits for h in each]


def _draw_near(plain: Hypothesis, onset: float, seed: int, start: RelayStart) -> list[RelayStart]:
    """The best draws about some numbers, on a machine that stands for the null's."""
    again = candidate(write_own(plain), start.candidate.kind, start.candidate.patch)
    if again is None or not (space := Space(again)).serves:
        return []
    began, middle = start.began[0].start if start.began else {}, again.machine.reference
    near = np.array([*theta_of(again.own, start.values), *(began.get(n, middle) for n in space.parts)])
    try:
        about = [linearise_firmly(plain, theta_of(plain.fit.problem.parameters, start.values))]
        drawn = draw_samples(about, [again], {again.key: near}, onset, seed, jobs=1)
    except (Failed, np.linalg.LinAlgError):
        return []
    known, case = {again.key: start.candidate}, replace(plain.case, began=start.began or plain.case.began)
    return [replace(_start_of(case, known, start.values, d), followed=start.followed) for d in drawn]


def _numbers(h: Hypothesis, space: Space) -> Array:
    """The numbers of its relay, and the starts of what that brings."""
    start = h.case.began[0].start if h.case.began else {}
    return np.array([*theta_of(space.candidate.own, h.own_values), *(start[n] for n in space.parts)])


def _start_of(
    case: Case, known: Mapping[tuple[str, ...], Candidate], beside: Mapping[str, float], drawn: Drawn
) -> RelayStart:
    """A draw as the beginning of a fit, beside the numbers about which it was judged."""
    began = _all(case, drawn.judge.space.starts(drawn.theta))
    return RelayStart(known[drawn.judge.space.candidate.key], {**beside, **_values(drawn)}, began)


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
    """Those to be drawn at the parts where unknown heat explains most first; of two there, the one with more to it."""
    gain = list_likely_parts(located)
    able = [c for c in switched if gain.keys() & parts_about(c) and is_drawn(c)]
    return sorted(able, key=lambda c: (-max(gain.get(n, 0.0) for n in parts_about(c)), -len(c.own)))


def _of_file(null: Hypothesis) -> Array:
    """The numbers of the file, beside those of what was found."""
    own = {p.path for p in null.own}
    pairs = zip(null.fit.problem.parameters, null.fit.theta, centres(null.fit.problem.parameters), strict=True)
    return np.array([fitted if p.path in own else centre for p, fitted, centre in pairs])


def _values(drawn: Drawn) -> dict[str, float]:
    return {**drawn.judge.values, **drawn.judge.space.numbers(drawn.theta)}


def _all(case: Case, starts: Mapping[str, float]) -> tuple[RunPoint, ...]:
    """The starts beside those known before, for every run."""
    before = case.began or (RunPoint(),) * len(case.recordings)
    return tuple(replace(run, start={**run.start, **starts}) for run in before) if starts else case.began
