"""Single decisions of a search on bare hypotheses: what mutation testing found no quick test to look at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pytest
from build import machine
from test_small_decisions import bare

from network.analysis.diagnosis import readings_set_right, search, search_end, time_budget, tracks
from network.analysis.diagnosis.experiments import advice, separation
from network.analysis.diagnosis.experiments.programs import Driver, _ladder
from network.analysis.diagnosis.findings import (
    conclusion,
    diagnosis_notes,
    findings,
    simulated_findings,
    simulated_runs,
    verdict,
)
from network.analysis.diagnosis.findings.finding import Finding
from network.analysis.diagnosis.hypotheses import falling_short, few_runs, fresh_fit
from network.analysis.diagnosis.intermittent import (
    channel_fault,
    channel_samples,
    corrected_onset,
    find_onset_fault,
    intermittent_fault,
)
from network.analysis.diagnosis.latent_heat.location import Location
from network.analysis.diagnosis.lumps import (
    coarse_surrogate,
    lump_convergence,
    lump_refinement,
    lump_shortfall,
    lumping_finding,
)
from network.analysis.diagnosis.screening import screening
from network.analysis.diagnosis.screening.crossed_splits import UnseenTest
from network.analysis.diagnosis.search_record import Search
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.standstill import find_standstill
from network.analysis.diagnosis.steps import (
    faint_candidates,
    finer_lead,
    forward_selection,
    next_finding,
    placement,
    refit,
    rival_acceptance,
    shortlist,
    trial_fits,
)
from network.analysis.diagnosis.steps.ranking import weigh_on_lumps
from network.analysis.diagnosis.steps.selection import Selection
from network.analysis.diagnosis.switching.relay_fits import keep_of_each
from network.analysis.diagnosis.switching.relay_search import rank_likely_places
from network.analysis.diagnosis.switching.sample_refinement import DAMPED, _At, _steps, refine_samples
from network.analysis.diagnosis.time_budget import BudgetReached, TimeBudget
from network.catalogue.declaration.patch import Patch
from network.platform.refusal import Failed, Refused

NOISE, ALIKE, DOUBTFUL = SETTINGS.noise, SETTINGS.alike, SETTINGS.doubtful


def h(chi: float = 1.0, evidence: float = 0.0, found: Any = (), **rest: Any) -> Any:
    told = {"chi": chi, "evidence": evidence, "weighed": evidence, "found": found, "case": bare(budget=TimeBudget())}
    return bare(**{**told, **rest})


def named(key: str, evidence: float = 0.0, is_searched_apart: bool = False) -> Any:
    """A hypothesis of one finding."""
    c = bare(key=key, kind=bare(kind=key), patch=key, places=(), channels=(), is_searched_apart=is_searched_apart)
    return Fit(evidence, (c,))


@dataclass(frozen=True, eq=False)
class Fit:
    evidence: float
    found: tuple[Any, ...]
    beside: float | None = None
    chi: float = 1.0

    @property
    def weighed(self) -> float:
        return self.evidence if self.beside is None else self.beside


@dataclass(frozen=True, eq=False)
class Trials:
    fits: Sequence[Any]

    def fit_further(self, begun: Any) -> Any:
        return h(begun.left)

    def rank(self, jobs: int) -> list[Any]:
        raise NotImplementedError


class FinerKind:
    kind = "finer"

    @staticmethod
    def told(now: Any, patch: str) -> str:
        return f"{patch} needs more lumps"


class Part(NamedTuple):
    """A candidate that needs more lumps."""

    places: tuple[str, ...]
    kind: Any
    section: str
    patch: str


def seat(start: float, stop: float) -> Any:
    return bare(start=start, stop=stop)


# -- whether to go on -----------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("soon", "late", "told", "ends"),
    [((2.4, 1.9), 1.0, False, 0), ((1.2, 1.9), 1.05, True, 1), ((1.2, 1.1), 1.2, False, 2), ((), 1.0, False, 0)],
)
def test_one_thing_explains_all_only_where_that_soon_leaves_hardly_anything(
    soon: tuple[float, ...], late: float, told: bool, ends: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """soon: what the trials leave after some steps, the third of them is not asked; late: what they leave in the end;
    ends: how many of them are fitted so far."""
    ranked = list[Any]()
    trials = Trials([h(evidence=-float(k), left=chi) for k, chi in enumerate(soon)] + [h(evidence=-9.0, left=1.0)])
    monkeypatch.setattr(Trials, "rank", lambda of, jobs: ranked.extend(of.fits) or [h(late) for _ in of.fits])
    of = h(5.0, linearised=None, values={}, machine=None, case=bare(drivers=(), runs=None), fit=bare(left=[0.0] * 10))
    monkeypatch.setattr(tracks, "candidates", lambda machine, drivers, runs: ())
    scores = [bare(gain=100.0 if soon else 0.0, candidate="c")]
    monkeypatch.setattr(tracks, "score_candidates", lambda fit, of, values, jobs: scores)
    monkeypatch.setattr(tracks, "start_trials", lambda h, of, likely, jobs: iter([trials]))
    assert tracks._is_explained(of, 1) is told
    assert len(ranked) == ends


@pytest.mark.parametrize(
    "of, told",
    [
        (h(NOISE + 0.01, offset_pull=0.0), True), (h(NOISE - 0.01, offset_pull=0.0), False),
        (h(NOISE - 0.01, offset_pull=SETTINGS.strained + 0.1), True),
        (h(SETTINGS.further + 0.01, found="a", offset_pull=0.0), True),
        (h(SETTINGS.further - 0.01, found="a", offset_pull=SETTINGS.strained - 0.1), False),
        (h(SETTINGS.further - 0.01, found="a", offset_pull=SETTINGS.strained + 0.1), True),
    ],
)  # fmt: skip
def test_more_is_looked_for_where_more_than_noise_is_left(of: Any, told: bool) -> None:
    assert screening.leaves_something(of) is told


@pytest.mark.parametrize(
    ("share", "of", "told"),
    [(1.01, h(1.0, is_bent=False), True), (0.99, h(1.0, is_bent=False), False), (1.01, h(1.0, is_bent=True), False),
     (1.01, h(1.0, found=("tilt",), is_bent=False), False)],
)  # fmt: skip
def test_one_candidate_that_shows_half_of_what_lumps_may_leave_is_looked_at_where_little_is_left(
    share: float, of: Any, told: bool
) -> None:
    """Half of (χ² − 1)/2 nats for each of 1000 readings, beside numbers that are near those of the file."""
    gain = share * 0.5 * (NOISE**2 - 1) / 2 * 1000
    seen = bare(scores=[bare(gain=1.0), bare(gain=gain)], before=bare(fit=bare(left=[0.0] * 1000)))
    assert faint_candidates.shows_name(of, seen) is told
    few = bare(scores=[bare(gain=SETTINGS.least)], before=bare(fit=bare(left=[0.0] * 100)))
    assert not faint_candidates.shows_name(of, few)


@pytest.mark.parametrize(("spent", "lumps", "looked"), [(0.0, 999, True), (1.0, 999, False), (1.0, 2, True)])
def test_where_little_is_left_of_many_lumps_candidates_are_scored_while_there_is_time(
    spent: float, lumps: int, looked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    budget = TimeBudget(100.0, prepared=50.0)
    case = bare(budget=replace(budget, began=budget.began - 100.0 * spent))
    monkeypatch.setattr(tracks, "screen_candidates", lambda *of: "scored")
    track = tracks._screen(h(1.0, offset_pull=0.0, case=case, machine=bare(lumps=lumps)), 0, 1)
    assert (track.screened == "scored") is looked


def test_a_finding_gains_more_than_chance_and_takes_away_what_is_worth_a_name() -> None:
    before, worth = h(2.0, 100.0, offset_pull=0.0), 2.0 * (1 - SETTINGS.worth)
    for after, told in (
        (h(worth - 0.01, 121), True), (h(worth - 0.01, 119), False), (h(worth + 0.01, 121), False), (h(1, 60), False)
    ):  # fmt: skip
        assert rival_acceptance.is_gain(before, after, 20.0) is told
    strained = h(1.0, 100.0, offset_pull=SETTINGS.strained + 0.1)
    assert rival_acceptance.is_gain(strained, h(1.0, 121.0, offset_pull=SETTINGS.errors - 0.1), 20.0)
    assert not rival_acceptance.is_gain(strained, h(1.0, 121.0, offset_pull=SETTINGS.errors + 0.1), 20.0)


@pytest.mark.parametrize(
    "briefly, share, is_screened, is_searched",
    [(0.49, 1.01, False, False), (0.51, 0.99, True, False), (0.51, 1.01, True, True)],
)
def test_under_the_noise_of_the_file_one_candidate_has_to_be_worth_a_name(
    briefly: float, share: float, is_screened: bool, is_searched: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    null, bent, taken, screened = h(2.0), h(2.0, fit=bare(left=[0.0] * 1000)), [], []
    monkeypatch.setattr(forward_selection, "scores_as_much", lambda of, least, *_: briefly * SETTINGS.worth >= least)
    monkeypatch.setattr(forward_selection, "reweight", lambda case, of: bent)
    monkeypatch.setattr(forward_selection, "use_file_noise", lambda case: case)

    def take(null: Any, about: Any, *_: Any) -> Any:
        taken.append(1)
        yield from ()
        return about

    seen = bare(scores=[bare(gain=share * SETTINGS.worth * 1000)], before=bent, whole=None)
    monkeypatch.setattr(forward_selection, "screen_candidates", lambda *_: screened.append(1) or seen)
    monkeypatch.setattr(forward_selection, "_take_steps", take)
    assert not [*forward_selection._select_under_file_noise(null, Selection(null), 0, 1, lambda share: None)]
    assert (bool(screened), bool(taken)) == (is_screened, is_searched)


@pytest.mark.parametrize(
    ("scores", "timed", "told"),
    [((9.0, 10.0), (), True), ((9.0,), (11.0,), True), ((9.0,), (9.0,), False), ((), (), False)],
)
def test_a_brief_look_tells_whether_anything_scores_as_much_heat_by_the_clock_too(
    scores: tuple[float, ...], timed: tuple[float, ...], told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A tenth of a nat for each of 100 readings."""
    before = bare(fit=bare(left=[0.0] * 100), linearised=None, machine=None, values={})
    monkeypatch.setattr(screening, "on_few_runs", lambda of, count: of)
    monkeypatch.setattr(screening, "build_surrogate", lambda of: of)
    monkeypatch.setattr(screening, "_propose", lambda of: ())
    monkeypatch.setattr(screening, "locate", lambda *of: ())
    monkeypatch.setattr(screening, "score_candidates", lambda *of: [bare(gain=gain) for gain in scores])
    monkeypatch.setattr(screening, "search_timed", lambda *of: [bare(gain=gain) for gain in timed])
    assert screening.scores_as_much(before, 0.1, 0, 1) is told


@pytest.mark.parametrize("found", [(), ("lag",)])
def test_time_that_is_up_under_the_noise_of_the_file_ends_only_a_search_that_found_nothing(
    found: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    def run_out(*_: Any) -> Any:
        raise BudgetReached

    monkeypatch.setattr(forward_selection, "scores_as_much", run_out)
    monkeypatch.setattr(forward_selection, "reweight", lambda case, of: h(2.0, found=found))
    monkeypatch.setattr(forward_selection, "use_file_noise", lambda case: case)
    null, told = h(2.0), Selection(h(1.0, found=found))
    if found:
        assert not [*forward_selection._select_under_file_noise(null, told, 0, 1, lambda share: None)]
        return
    with pytest.raises(BudgetReached):
        next(forward_selection._select_under_file_noise(null, told, 0, 1, lambda share: None))


def test_the_first_step_under_the_noise_of_the_file_is_tested_before_the_next_may_use_up_the_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    far = {"fit": bare(left=[0.0] * 1000)}

    def take(null: Any, about: Any, first: Any, seed: int, jobs: int, tell: Any, most: float) -> Any:
        if most > 1:
            raise BudgetReached
        yield from ()
        return Selection(h(1.0, found=("path",)))

    monkeypatch.setattr(forward_selection, "scores_as_much", lambda *_: True)
    monkeypatch.setattr(forward_selection, "reweight", lambda case, of: h(2.0, **far))
    monkeypatch.setattr(forward_selection, "use_file_noise", lambda case: case)
    seen = bare(scores=[bare(gain=1000.0)], before=h(2.0, **far), whole=None)
    monkeypatch.setattr(forward_selection, "screen_candidates", lambda *_: seen)
    monkeypatch.setattr(forward_selection, "_take_steps", take)
    monkeypatch.setattr(forward_selection, "_on_all_runs", lambda null, of: of)
    monkeypatch.setattr(forward_selection, "check_selection", lambda null, of, jobs: replace(of, is_checked=True))
    told = [*forward_selection._select_under_file_noise(h(2.0), Selection(h(1.0)), 0, 1, lambda share: None)]
    assert [(of.best.found, of.is_checked) for of in told] == [(("path",), True)]


@pytest.mark.parametrize(
    ("chi", "alone", "found", "is_searched", "is_told"),
    [
        (2.0, h(1.8, offset_pull=0.0), ("fan",), True, True),
        (2.0, h(1.8, offset_pull=0.0), (), True, False),
        (2.0, h(1.0, offset_pull=0.0), ("fan",), False, False),
        (2.0, None, ("fan",), False, False),
        (1.2, h(1.8, offset_pull=0.0), ("fan",), False, False),
    ],
)  # fmt: skip
def test_heat_is_looked_for_on_thermometers_alone_where_much_is_left_and_they_show_some(
    chi: float, alone: Any, found: tuple[str, ...], is_searched: bool, is_told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Then on from there on all channels, under their noise."""
    begun = []

    @dataclass(frozen=True)
    class Noisy:
        sigma: Any

    def take(of: Any, about: Any, *_: Any) -> Any:
        begun.append((of, about.best))
        yield from ()
        return (
            replace(about, best=h(1.0, found=found, case=Noisy("blind"), root="root", values="told"))
            if len(begun) == 1
            else about
        )

    monkeypatch.setattr(forward_selection, "on_few_runs", lambda of, count: of)
    monkeypatch.setattr(forward_selection, "fit_thermometers", lambda of: alone)
    monkeypatch.setattr(forward_selection, "leaves_heat", lambda of: of.chi > SETTINGS.further)
    monkeypatch.setattr(forward_selection, "screen_candidates", lambda *_: bare(whole=None))
    monkeypatch.setattr(forward_selection, "_take_steps", take)
    monkeypatch.setattr(forward_selection, "fit_findings", lambda case, *of: ("all channels", case.sigma, *of))
    monkeypatch.setattr(forward_selection, "_on_all_runs", lambda of, now: now)
    monkeypatch.setattr(forward_selection, "check_selection", lambda of, now, jobs: now)
    null = h(3.0, case=Noisy("stated"))
    told = forward_selection._select_by_thermometers(null, Selection(h(chi)), bare(), 0, 1, lambda share: None)
    assert (bool(begun), told is not None) == (is_searched, is_told)
    if told is not None:
        whole = ("all channels", "stated", "root", found, "told")
        assert told.best == whole and begun == [(alone, alone), (null, whole)]


def test_scores_count_in_full_only_far_from_an_explanation() -> None:
    scores = [bare(gain=gain) for gain in (0.0, 5.0, 50.0)]
    near = bare(before=h(SETTINGS.adequate - 0.01, found="a", fit=bare(left=np.zeros(1000))), scores=scores)
    worth = next_finding.HOPE * SETTINGS.worth * 1000
    assert [s.gain for s in next_finding._worth_fitting(near)] == [g for g in (0, 5, 50) if g >= worth]
    far, first = (bare(before=of, scores=scores) for of in (h(SETTINGS.adequate + 0.01, found="a"), h(1.0)))
    assert [*next_finding._worth_fitting(far)] == scores == [*next_finding._worth_fitting(first)]
    assert not next_finding.shows_nothing(near)
    assert next_finding.shows_nothing(bare(before=near.before, scores=scores[:1]))
    assert not next_finding.shows_nothing(bare(before=far.before, scores=[]))


def test_what_was_kept_stands_first_and_the_others_by_their_evidence() -> None:
    one, other, third = (h(evidence=e, found=(bare(key=k),)) for e, k in ((1.0, "a"), (3.0, "b"), (2.0, "c")))
    assert forward_selection._put_first(one, (other, third, one)) == (one, other, third)


def test_rivals_on_the_lumps_there_are_need_no_further_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rival_acceptance, "reweight", lambda case, of: of)
    now, best = h(), h(case="its")
    assert rival_acceptance._fit_contenders(now, now, [best], 1) == [best]
    assert rival_acceptance.accept_best(now, h(), [best], [], 20.0, 1) == (None, [best])
    several = [best, h(case="other")]
    assert rival_acceptance.list_contenders(now, now, several, best, 1) == [best]


def test_what_shows_most_on_finer_lumps_comes_along_where_coarse_ones_leave_it_behind() -> None:
    first, alike, far, lead = (named(k, evidence=e) for k, e in (("a", 9.0), ("b", 8.5), ("c", 2.0), ("d", 1.0)))
    told = partial(rival_acceptance.list_contenders, h(), h(), [first, alike, far])
    assert told(None, 1) == [first, alike] and told(alike, 1) == [first, alike]
    assert told(lead, 1) == [first, alike, lead]


def test_rivals_are_weighed_by_what_finer_lumps_change_in_each_beside_the_first() -> None:
    first, alike, far = (named(k, evidence=e) for k, e in (("a", 9.0), ("b", 8.5), ("c", 2.0)))
    lead = named("d", evidence=1.0)
    there = [h(evidence=e) for e in (29.0, 27.5, 61.0)]
    ranked = weigh_on_lumps([first, alike, far], [first, alike, lead], there)
    assert [(r.found[-1].key, r.weighed) for r in ranked] == [("d", 41.0), ("a", 9.0), ("b", 7.5), ("c", 2.0)]
    assert weigh_on_lumps([first, far], [first, alike], [there[0], None]) == [first, far]


def test_what_shows_most_is_looked_for_on_finer_lumps_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    ranked, begun = [named("a"), named("b")], [named("c"), named("d", is_searched_apart=True)]
    current = h(machine="fine", linearised=None, values={})
    trials = bare(current=current, fits=begun, fit_further=lambda fit: ("further", fit))
    monkeypatch.setattr(finer_lead, "expand", lambda of: of)
    monkeypatch.setattr(finer_lead, "candidate", lambda machine, kind, patch: patch)
    best = "c"
    monkeypatch.setattr(finer_lead, "score_candidates", lambda fit, of, values, jobs: [bare(candidate=bare(key=best))])
    assert finer_lead.find_lead(current, trials, ranked, 1) is None
    trials.current = h()
    assert finer_lead.find_lead(current, trials, ranked, 1) == ("further", begun[0])
    best = "b"
    assert finer_lead.find_lead(current, trials, ranked, 1) is ranked[1]


ADEQUATE, LITTLE = SETTINGS.adequate, 1.1


@pytest.mark.parametrize(
    "early, kept, late, told",
    [
        ((), h(1.0, 9.0), (), (True, 0, "smooth")),
        ((), h(ADEQUATE + 0.1, 9.0), (h(1.0, 12.0),), (True, 1, "relay")),
        ((), h(ADEQUATE + 0.1, 9.0), (h(1.0, 8.0),), (True, 1, "smooth")),
        ((), h(ADEQUATE - 0.1, 9.0), (h(1.0, 12.0),), (True, 0, "smooth")),
        ((h(LITTLE - 0.01, 12.0),), h(1.2, 9.0), (), (True, 1, "relay")),
        ((h(LITTLE + 0.01, 12.0),), h(1.2, 9.0), (), (False, 1, "relay")),
        (None, h(1.2, 9.0), (), (False, 1, "smooth")),
    ],
)  # fmt: skip
def test_relays_are_looked_for_first_where_little_is_explained_and_last_where_much_is_left(
    early: Any, kept: Any, late: Any, told: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """told: whether what explains so far is enough not to try more, how often relays are looked for, what is kept;
    early: those found first (none found: None), nothing where what is likely explains much; late: those found last.
    Rivals are weighed by finer lumps once."""
    case = bare(recordings=("run",) * 2, budget=TimeBudget())
    seen = bare(before=h(case=case), proposed=(), scores=())
    for k, each in enumerate((kept, *late, *(early or ()))):
        each.found = (bare(key=(str(k),), is_timed=False),)
    is_poor, asked, widened = early is None or bool(early), list[int](), list[bool]()
    monkeypatch.setattr(
        next_finding, "_search_switching", lambda *of: asked.append(1) or list((early or ()) if is_poor else late)
    )
    trials = bare(rank=lambda jobs: [kept], is_poor=lambda smooth: is_poor, little=LITTLE, current=seen.before)
    monkeypatch.setattr(next_finding, "start_trials", lambda *of: iter([trials]))
    monkeypatch.setattr(
        next_finding, "_fit_wider", lambda trials, ranked, is_told, jobs: widened.append(is_told) or ranked
    )
    monkeypatch.setattr(next_finding, "place_ranked", lambda before, smooth, jobs: smooth)
    monkeypatch.setattr(rival_acceptance, "_skip_misleading", lambda before, ranked, jobs: ranked)
    monkeypatch.setattr(next_finding, "rank_beside_rest", lambda ranked, jobs: ranked)

    def accept(current: Any, before: Any, ranked: Any, tried: Any, threshold: float, jobs: int) -> Any:
        assert not any("by_lumps" in vars(each) for each in ranked), "weighed once"
        return tried[0], [bare(**vars(each), by_lumps=True) for each in ranked]

    monkeypatch.setattr(next_finding, "accept_best", accept)
    monkeypatch.setattr(next_finding, "exchange_kind", lambda current, kept, proposed, jobs: kept)
    monkeypatch.setattr(next_finding, "take_first", lambda current, before, ranked, threshold: None)
    *_, (best, ranked) = next_finding.select_next(seen.before, seen, 12.0, 0, 1, lambda share: None)
    assert (widened, len(asked), "smooth" if best is kept else "relay") == ([told[0]], *told[1:])
    assert [each.evidence for each in ranked] == sorted((each.evidence for each in ranked), reverse=True)


@pytest.mark.parametrize(("lumps", "able"), [(8, ["a"]), (20, ["a", "b"])])
def test_relays_behind_what_is_kept_take_finer_lumps_only_where_that_did(lumps: int, able: list[str]) -> None:
    before, kept = h(evidence=100.0, machine=bare(lumps=8)), h(evidence=200.0, machine=bare(lumps=lumps))
    found = [named("a", 210.0), named("b", 190.0), named("c", 120.0)]
    assert [each.found[-1].key for each in next_finding._list_able(before, kept, found)] == able
    assert next_finding._list_able(before, None, found) == found


@pytest.mark.parametrize("runs", [2, 1])
def test_what_explains_best_so_far_is_told_where_the_time_is_up(runs: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """From the first fits on, each better founded than the one before, while nothing else is found; no step further is
    told before it is at its end, and nothing so far of a single recording."""
    case = bare(recordings=("run",) * runs)
    fits = [h(chi, gain, ("tilt",), case=case) for chi, gain in ((2.0, 50.0), (1.5, 90.0), (1.2, 120.0))]
    null = h(5.0, 0.0, offset_pull=0.0, case=case)

    def run_out(*of: Any) -> Any:
        yield None, []
        for fit in fits:
            yield fit, [fit]
        raise BudgetReached

    monkeypatch.setattr(forward_selection, "select_next", run_out)
    monkeypatch.setattr(forward_selection, "null_threshold", lambda scores, seed: 12.0)
    monkeypatch.setattr(forward_selection, "compact", lambda fit: fit)
    monkeypatch.setattr(forward_selection, "_put_first", lambda best, ranked: (best, *ranked))
    seen = bare(before=fits[-1], scores=(), unseen=None)
    monkeypatch.setattr(forward_selection, "screen_candidates", lambda *of: seen)
    monkeypatch.setattr(forward_selection, "shows_nothing", lambda seen: False)
    told = []
    with pytest.raises(BudgetReached):
        seen = bare(before=null, scores=(), whole=None, unseen=None)
        for now in forward_selection.select_forward(null, seen, 0, 1, print):
            told.append(now)
    if runs == 1:
        assert not told
        return
    assert [now.best for now in told] == [null, *fits] and [now.gains for now in told[1:]] == [
        (50.0,),
        (90.0,),
        (120.0,),
    ]
    assert all(now.threshold == 12.0 and not now.is_checked for now in told[1:])


@pytest.mark.parametrize(
    ("spent", "chi", "ends", "told"),
    [(0.0, 1.0, False, 0), (0.5, 1.0, False, 1), (0.5, 3.0, False, 0), (0.5, 3.0, True, 1), (0.5, 4.0, True, 0)],
)
def test_what_is_fitted_first_is_told_before_the_others_where_half_the_time_is_gone(
    spent: float, chi: float, ends: bool, told: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where it explains most; once all of them are fitted, where it explains half."""
    budget = TimeBudget(100.0)
    case = bare(recordings=("run",) * 2, budget=replace(budget, began=budget.began - 100.0 * spent))
    null, first = h(5.0, 0.0, offset_pull=0.0, case=case), h(chi, 90.0, ("tilt",), case=case)

    def start(*of: Any) -> Any:
        yield bare(foremost=first, fit_in_passing=lambda begun: [begun])
        yield bare(foremost=first, fit_in_passing=None, rank=run_out)
        if not ends:
            raise BudgetReached

    def run_out(jobs: int) -> Any:
        raise BudgetReached

    monkeypatch.setattr(next_finding, "start_trials", start)
    monkeypatch.setattr(rival_acceptance, "reweight", lambda case, fit: fit)
    seen, kept = bare(before=null, proposed=(), scores=()), []
    with pytest.raises(BudgetReached):
        kept.extend(next_finding.select_next(null, seen, 12.0, 0, 1, lambda share: None))
    assert kept == [(first, [first])] * told


@pytest.mark.parametrize(
    ("chi", "switches", "led", "told"),
    [
        (1.4, True, 500.0, "led"), (1.4, True, 300.0, "direct"), (1.4, True, None, "direct"),
        (1.4, False, 500.0, "direct"), (1.05, True, 500.0, "direct"),
    ],
)  # fmt: skip
def test_a_trial_whose_relays_slip_is_led_back_into_step_from_the_file(
    chi: float, switches: bool, led: float | None, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Numbers at hand are bent to what it explains: only its own go along."""

    def lead(case: Any, of: Any, values: Any, shares: Any) -> Any:
        assert values == {"own": 1.0}
        return led and h(chi, led, name="led", **same)

    def fit(case: Any, machine: Any, found: Any, own: Any, start: Any) -> Any:
        fitted = bare(problem=bare(model=bare(switches=switches)))
        return h(chi, 400.0, name="direct", fit=fitted, **same)

    same = {"case": bare(budget=TimeBudget()), "machine": "machine", "own": (), "own_values": {"own": 1.0}}
    monkeypatch.setattr(trial_fits, "fit_hypothesis", fit)
    monkeypatch.setattr(trial_fits, "lead_into_step", lead)
    monkeypatch.setattr(trial_fits, "settle_hypothesis", lambda each, is_late, steps: each)
    monkeypatch.setattr(trial_fits, "compact", lambda each: each)
    assert trial_fits._finish_fit(h(1.4, 350.0, **same, values="bent")).name == told


def test_what_grows_does_not_fill_the_list_of_what_is_fitted() -> None:
    """All that moves one axis scores alike."""
    grows = [bare(candidate=bare(key=("tcp", i), kind=i // 3, section="tcp"), gain=900.0 - i) for i in range(15)]
    paths = [bare(candidate=bare(key=("links", i), kind=9, section="links"), gain=50.0 - i) for i in range(2)]
    told = shortlist.shortlist([*grows, *paths], (), shortlist.LONGER)
    assert {*map(id, told)} == {*map(id, [*grows[: shortlist.THAT_MOVE], *paths])}


@pytest.mark.parametrize("is_late", [(False,) * 2, (True,) * 2, (False, True)])
def test_the_foremost_of_both_screenings_are_fitted_first_where_it_is_late(
    is_late: tuple[bool, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same trials in any case, each from where it was screened about the fit; where it becomes late on the way,
    what is there so far."""

    def score(name: str, gain: float) -> Any:
        return bare(candidate=bare(key=(name,), kind=name, section=name), gain=gain)

    about_fit = [score(name, gain) for name, gain in zip("abcd", (9e3, 8e3, 7e3, 6e3), strict=True)]
    about_file = [score(name, gain) for name, gain in zip("eda", (9e3, 8e3, 7e3), strict=True)]
    monkeypatch.setattr(refit, "_about_file", lambda *of: about_file)
    monkeypatch.setattr(refit, "score_by_thermometers", lambda *of: None)
    monkeypatch.setattr(refit, "on_few_runs", lambda current: current)
    monkeypatch.setattr(refit, "fit_all", lambda begin, trials, jobs, tell: tell(1.0) or [*trials])
    monkeypatch.setattr(refit, "AT_ONCE", 4)
    asked, shares = iter(is_late), list[float]()
    told = [
        *refit.start_trials(bare(machine=bare(lumps=9)), (), about_fit, 1, shares.append, is_late=lambda: next(asked))
    ]
    names = [{s.candidate.key[0] for s in each.fits} for each in told]
    assert names == ([set("abde")] if any(is_late) else []) + [set("abcde")] and shares == [0.5, 1.0]
    assert len(told[-1].fits) == 5 and all(s in told[-1].fits for s in about_fit) and not told[-1].rest


# -- lumps ----------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "gains, bent, told",
    [
        ([SETTINGS.structure + 1, SETTINGS.structure - 1], [False] * 3, 1),
        ([SETTINGS.structure + 1, None], [False] * 3, 1), ([SETTINGS.structure - 1], [False] * 2, 0),
        ([1.0], [True, False], 1), ([-1.0], [True, False], 0), ([1.0], [True, True], 0),
    ],
)  # fmt: skip
def test_lumps_are_added_while_they_explain(
    gains: list[Any], bent: list[bool], told: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Or, at once, where numbers of the file come back by them; not where hardly more than noise is left."""
    steps = [0.0]
    for gain in gains:
        steps.append(steps[-1] + gain if gain is not None else None)  # type: ignore[arg-type]
    levels = [
        None if e is None else h(2.0, e, is_bent=b, level=i) for i, (e, b) in enumerate(zip(steps, bent, strict=True))
    ]
    monkeypatch.setattr(lump_convergence, "expand", lambda each: each)
    monkeypatch.setattr(
        lump_convergence, "choose_lumps", lambda each, jobs, **of: "finer" if levels[each.level + 1 :] else None
    )
    monkeypatch.setattr(lump_convergence, "_begin_on_few", lambda each, *of: each)
    monkeypatch.setattr(lump_convergence, "fit_on_finer_lumps_afresh", lambda case, each, *of: levels[each.level + 1])
    assert lump_convergence.refine_until_converged(bare(), levels[0]).level == told
    calm = h(NOISE - 0.01, 0.0, is_bent=False, level=0)
    assert lump_convergence.refine_until_converged(bare(), calm) is calm


@pytest.mark.parametrize(
    "chis, gains, tried",
    [([2, 1.4, 1.2, 1.0], [30, 30, 30], 4), ([2, 1.6, 1.2], [30, 30], 2), ([2, 1.4, 1.3], [10, 30], 2), ([1.0], [], 1)],
)  # fmt: skip
def test_the_machine_as_written_is_cut_more_finely_while_that_helps(
    chis: list[float], gains: list[float], tried: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not where lumps gain little, or leave what they do not mend."""
    evidence = np.cumsum([0.0, *gains])
    of = {"root": "machine", "fit": bare(problem=bare(model=bare(switches=True)))}
    levels = [
        h(chi, float(e), values={"level": i}, **of) for i, (chi, e) in enumerate(zip(chis, evidence, strict=True))
    ]
    begun = list[Any]()
    monkeypatch.setattr(lump_refinement, "LEVELS", 9)
    monkeypatch.setattr(lump_refinement, "bars_of", lambda machine: {"bar": 1})
    monkeypatch.setattr(lump_refinement, "choose_lumps", lambda each, jobs: each.values["level"] + 1)
    monkeypatch.setattr(
        lump_refinement, "_fit_finer", lambda case, level, best, written: begun.append(best) or levels[level]
    )
    assert lump_refinement.refine_lumps(bare(), levels[0]) == levels[:tried]
    assert begun == levels[: tried - 1]


@pytest.mark.parametrize(
    "chi, able, switches, told",
    [
        (70.0, {"chosen", "cut"}, False, ["chosen"]), (70.0, {"cut"}, False, ["cut"]), (70.0, {"cut"}, True, []),
        (70.0, set(), False, []), (DOUBTFUL - 0.1, {"cut"}, False, []),
    ],
)  # fmt: skip
def test_where_much_is_left_every_bar_is_cut_if_the_lumps_it_takes_do_not_fit(
    chi: float, able: set[str], switches: bool, told: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Numbers that are bent by coarse lumps do not tell which lumps they take; beside a relay no misfit does."""
    written = h(chi, 0.0, root="written", fit=bare(problem=bare(model=bare(switches=switches))))
    monkeypatch.setattr(lump_refinement, "choose_lumps", lambda each, jobs: "chosen" if each is written else None)
    monkeypatch.setattr(lump_refinement, "bars_of", lambda machine: {"bar": 1, "fine": 9})
    monkeypatch.setattr(lump_refinement, "cut_bars", lambda machine, counts: counts == {"bar": 4} and "cut")
    monkeypatch.setattr(
        lump_refinement, "_fit_finer",
        lambda case, finer, *of: h(0.6 * chi, 99.0, machine=finer) if finer in able else None,
    )  # fmt: skip
    levels = lump_refinement.refine_lumps(bare(), written)
    assert [each.machine for each in levels[1:]] == told


@pytest.mark.parametrize(
    ("left", "tried", "told"),
    [({"chosen": 0.4, "cut": 0.3}, ["chosen"], "chosen"), ({"chosen": 0.6, "cut": 0.4}, ["chosen", "cut"], "cut"),
     ({"chosen": 0.6, "cut": 0.8}, ["chosen", "cut"], "chosen")],
)  # fmt: skip
def test_every_bar_is_cut_too_where_the_lumps_it_takes_are_no_matter(
    left: dict[str, float], tried: list[str], told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the first ones leave of the misfit may be as little as half."""
    fit = bare(problem=bare(model=bare(switches=False)))
    written, fitted = h(70.0, 0.0, root="written", fit=fit), list[str]()
    monkeypatch.setattr(lump_refinement, "choose_lumps", lambda each, jobs: "chosen" if each is written else None)
    monkeypatch.setattr(lump_refinement, "bars_of", lambda machine: {"bar": 1})
    monkeypatch.setattr(lump_refinement, "cut_bars", lambda machine, counts: "cut")

    def fit_finer(case: Any, finer: str, *of: Any) -> Any:
        fitted.append(finer)
        return h(left[finer] * 70.0, 99.0 - left[finer], root=finer, machine=finer, fit=fit)

    monkeypatch.setattr(lump_refinement, "_fit_finer", fit_finer)
    levels = lump_refinement.refine_lumps(bare(), written)
    assert (fitted, [each.machine for each in levels[1:]]) == (tried, [told])


LATE = bare(budget=TimeBudget(100.0, prepared=-1.0))


@pytest.mark.parametrize("chi, late, tried", [(9.0, True, 1), (9.0, False, 2), (DOUBTFUL - 0.1, True, 2)])
def test_before_anything_is_tried_lumps_are_refined_while_there_is_time(
    chi: float, late: bool, tried: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What leaves little takes what it takes: there nothing may be missing but lumps."""
    case = LATE if late else bare(budget=TimeBudget(100.0))
    levels = [h(chi, 0.0, case=case, values={"level": 0}), h(1.0, 99.0, case=case, values={"level": 1})]
    monkeypatch.setattr(lump_refinement, "choose_lumps", lambda each, jobs: "finer")
    monkeypatch.setattr(lump_refinement, "_fit_finer", lambda *of: levels[1])
    assert lump_refinement.refine_lumps(bare(), levels[0]) == levels[:tried]
    chosen = list[Any]()
    monkeypatch.setattr(lump_convergence, "expand", lambda each: each)
    monkeypatch.setattr(lump_convergence, "choose_lumps", lambda each, jobs: chosen.append(each))
    lump_convergence.refine_until_converged(bare(), levels[0], is_late=lump_refinement.is_late)
    assert chosen == levels[: tried - 1]


@pytest.mark.parametrize("left, told", [(13.0, None), (11.0, "ended")])
def test_a_fit_on_finer_lumps_that_time_cuts_short_is_ended_where_they_leave_less_than_half(
    left: float, told: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is not at its minimum is no null: whatever is tried would gain what the fit had left over."""
    before = h(24.0, 5.0, case=LATE, fit=bare(problem=bare(model=bare(switches=True))))
    asked = list[Any]()

    def fit(case: Any, machine: Any, start: Any = None, until: Any = None) -> Any:
        asked.append((start, until is not None and until(None)))
        return h(left, 9.0, values="cut") if until else "ended"

    monkeypatch.setattr(lump_refinement, "on_few_runs", lambda each: each)
    monkeypatch.setattr(lump_refinement, "fit_hypothesis", fit)
    assert lump_refinement._fit_finer("all", "fine", before, before) == told  # type: ignore[arg-type]
    assert asked == [(None, True), *([("cut", False)] if told else [])]


@pytest.mark.parametrize("slow, told", [(False, {"short": 2, "long": 8}), (True, {"short": 2, "long": 4})])
def test_lumps_are_looked_at_again_unless_that_is_slow(
    slow: bool, told: dict[str, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A bar gets four times as many lumps at once at most; what it takes then shows in a further look."""
    clock = [0.0]

    def leave(each: Any, now: Any, bars: Any, jobs: int) -> dict[str, float]:
        clock[0] += 1.0 if slow else 0.1
        return {"short": 3.0 / now["short"] ** 2, "long": 48.0 / now["long"] ** 2}

    monkeypatch.setattr(time_budget.time, "monotonic", lambda: clock[0])
    monkeypatch.setattr(lump_refinement, "on_few_runs", lambda each: each)
    monkeypatch.setattr(lump_refinement, "bars_of", lambda machine: {"short": 1, "long": 1})
    monkeypatch.setattr(lump_refinement, "lasting_misfit", lambda at: 2 / np.sqrt(2 * ALIKE))
    monkeypatch.setattr(lump_refinement, "leave_each", leave)
    monkeypatch.setattr(lump_refinement, "cut_bars", lambda machine, counts: counts)
    now = h(root=bare(), machine=bare(lumps=2), fit=bare(left=np.zeros(4)), linearised=None)
    now.case = bare(budget=TimeBudget(100.0, began=0.0))
    assert lump_refinement.choose_lumps(now) == told


def test_finer_lumps_whose_runs_break_down_are_left(monkeypatch: pytest.MonkeyPatch) -> None:
    """The search goes on with the machine as it was written."""

    def break_down(*of: Any) -> Any:
        raise Failed("a heat source may run away")

    written = h(5.0, 0.0, root="written", fit=bare(problem=bare(model=bare(switches=True))))
    monkeypatch.setattr(lump_refinement, "choose_lumps", lambda each, jobs: "finer")
    monkeypatch.setattr(lump_refinement, "bars_of", lambda machine: {})
    monkeypatch.setattr(lump_refinement, "_fit_finer", break_down)
    assert lump_refinement.refine_lumps(bare(), written) == [written]


def test_readings_are_looked_at_on_the_lumps_as_written_where_finer_ones_hardly_matter(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def look(of: Any, jobs: int, is_finest: bool) -> Any:
        looked.append((of, is_finest))
        return None, of

    looked, few = list[Any](), bare(lumps=9)
    monkeypatch.setattr(readings_set_right, "build_surrogate", lambda fine: fine)
    monkeypatch.setattr(readings_set_right, "set_right", look)
    monkeypatch.setattr(readings_set_right, "find_exchange_on_lumps", lambda *of: None)
    written, alike, better = h(13.0, machine=few), h(12.0, machine=few), h(5.0, machine=few)
    for finest in (alike, better):
        assert readings_set_right.set_right_on_lumps(written, finest, 1) == (None, finest)
    assert looked == [(written, True), (better, True)]


@pytest.mark.parametrize(
    "lumps, root, coarse, told", [(9, 9, 0.0, 30.0), (1, 1, 0.0, 30.0), (1, 9, 20.0, 50.0), (1, 9, None, 0.0)]
)
def test_what_finer_lumps_add_is_told_beside_what_was_found_where_the_null_has_none(
    lumps: int, root: int, coarse: float | None, told: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fit(case: Any, machine: Any, found: Any, values: Any, steps: int) -> Any:
        assert (machine.lumps, found, values) == (1, ("it",), {"own": 1.0})
        return None if coarse is None else h(evidence=coarse)

    monkeypatch.setattr(lumping_finding, "fit_findings", fit)
    monkeypatch.setattr(lumping_finding, "replace", lambda case, budget: case)
    null, written = h(evidence=40.0, machine=bare(lumps=lumps)), h(evidence=10.0, machine=bare(lumps=1))
    best = h(evidence=70.0, found=("it",), values={"own": 1.0}, root=bare(lumps=root))
    assert lumping_finding.gain_of_lumps(written, null, best) == told


def test_lumps_are_cut_again_where_much_is_left_but_far_less_than_before() -> None:
    before = h(24.0)
    assert lump_refinement._is_no_matter_of_lumps(h(13.0), before)
    assert not lump_refinement._is_no_matter_of_lumps(h(5.0), before)
    assert not lump_refinement._is_no_matter_of_lumps(h(DOUBTFUL - 0.1), h(DOUBTFUL))
    assert lump_refinement.hardly_matter(h(22.0), before) and not lump_refinement.hardly_matter(h(13.0), before)


def test_once_it_is_late_finer_lumps_that_leave_more_than_half_are_not_gone_on_from() -> None:
    """Runs on them are slow, and what is missing is found sooner on those of the file."""
    written = h(24.0, 0.0)
    for finer, on_time, in_the_end in (
        (h(13.0, 99.0), False, True), (h(11.0, 99.0), False, False), (h(DOUBTFUL - 0.1, 99.0), False, False),
    ):  # fmt: skip
        slow = bare(**{**vars(finer), "case": LATE})
        assert lump_refinement.hardly_matter(finer, written) == on_time
        assert lump_refinement.hardly_matter(slow, written) == in_the_end
        assert search._choose_level([written, finer]) is finer
        assert search._choose_level([written, slow]) is (written if in_the_end else slow)


@pytest.mark.parametrize("gain, goes_on", [(1.0, True), (-1.0, False)])
def test_finer_lumps_are_fitted_to_all_runs_only_where_they_explain_more_of_a_few(
    gain: float, goes_on: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    still = bare(problem=bare(model=bare(switches=False)))
    few, before = h(2.0, 5.0), h(2.0, 9.0, fit=still)
    fits = {"few": h(2.0, 5.0 + gain, values={"of": "few"}), "all": h(1.0, 20.0)}
    asked = list[Any]()

    def fit(case: Any, machine: Any, start: Any = None, steps: int = 0, until: Any = None) -> Any:
        case = case if case == "all" else "few"
        asked.append((case, start))
        assert until(None) is False if case == "all" else until.needed == few.evidence
        return fits[case]

    monkeypatch.setattr(lump_refinement, "on_few_runs", lambda each: few)
    monkeypatch.setattr(lump_refinement, "fit_hypothesis", fit)
    told = lump_refinement._fit_finer("all", "fine", before, before)  # type: ignore[arg-type]
    assert told is (fits["all"] if goes_on else None)
    assert asked == [("few", None), *([("all", {"of": "few"})] if goes_on else [])]


@pytest.mark.parametrize("gain, stays", [(SETTINGS.least * 4 + 1, True), (SETTINGS.least * 4 - 1, False)])
def test_a_fault_has_to_explain_more_than_chance_on_the_finer_lumps_too(
    gain: float, stays: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As the noise of the null counts it, and in units of how long a misfit lasts; on the same lumps it was just
    found."""
    monkeypatch.setattr(search, "lasting_misfit", lambda at: 2.0)
    monkeypatch.setattr(search, "replace", lambda case, **more: (case, more))
    asked = list[Any]()
    monkeypatch.setattr(
        search, "fit_hypothesis", lambda case, machine, *found, start: asked.append((case, machine)) or h(1.0, 100.0)
    )
    null = h(1.0, 100.0 + gain, machine="fine", values={}, linearised=None, own=(), case=bare(noise="n", sigma="s"))
    fault = bare(leave_wrong=lambda case: case)
    now = bare(fault=fault, null=null, written=bare(machine="coarse"))
    assert search._is_found_again(now, bare(case="bare")) == stays
    assert asked == [(("bare", {"noise": "n", "sigma": "s"}), "fine")]
    assert search._is_found_again(bare(fault=None), bare())
    now.written.machine = "fine"
    assert search._is_found_again(now, bare(case="bare"))


@pytest.mark.parametrize("beside, told", [(False, ["null", "found", "without"]), (True, ["null", "found", "resized"])])
def test_a_fault_that_what_was_found_takes_in_is_looked_at_without_it(
    beside: bool, told: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A missing fan looks like a thermometer that drifts: the fan is found beside it, and explains the readings as they
    were better still."""

    def go_on(begun: Any, seed: int, jobs: int, tell: Any, sets_right: bool = True) -> Any:
        yield from [state("null"), state("found", found=("fan",))] if sets_right else [state("without")]

    def state(name: str, found: Any = ()) -> Any:
        fault = None if name == "without" else bare(competes=False, lay_alike=lambda case: case)
        return bare(name=name, fault=fault, null=h(), best=h(found=found), case=None)

    for name, does in {
        "keep_in_step": lambda case, null: case, "state": lambda *of: h(), "fit_written": lambda at: at,
        "Search": lambda *of: bare(case=None), "Screening": lambda of: None, "Selection": lambda of: None,
        "set_right": lambda of, jobs: (None, None), "_search_from": go_on, "_is_found_again": lambda *of: True,
        "_shows_beside": lambda best, fault, first: beside, "lay_alike": lambda now, other: other.best,
        "is_told_better": lambda laid, now, jobs: True, "resize_fault": lambda now, case, jobs: [state("resized")],
    }.items():  # fmt: skip
        monkeypatch.setattr(search, name, does)
    case: Any = bare(machine=None)
    states: Any = search.search(case, bare(values={}), 0, 1, lambda share: None)  # type: ignore[arg-type]
    assert [now.name for now in states if hasattr(now, "name")] == told


@pytest.mark.parametrize("again, best", [(h(1.4, 9.0), 1), (h(1.4, 7.0), 0), (None, 0)])
def test_what_leaves_much_on_finer_lumps_is_tried_from_where_it_was_proposed(
    again: Any, best: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    fits, asked = [h(1.4, 8.0), again], list[Any]()
    monkeypatch.setattr(coarse_surrogate, "replace", lambda case, began: case)
    monkeypatch.setattr(
        coarse_surrogate, "fit_findings",
        lambda about, root, found, *rest, **more: asked.append(found) or fits[len(asked) - 1],
    )  # fmt: skip
    last = bare(back=bare(usual={"b": 2.0}))
    coarse = h(found=("a", "b", last), case=bare(began=()), values={}, own_values={"a": 1.0}, switches=False)
    assert coarse_surrogate.fit_on_finer_lumps_afresh(bare(), coarse, bare()) is fits[best]
    assert asked == [("a", "b", last), ("a", "b", last.back)]
    fits[0], asked[:] = h(SETTINGS.adequate - 0.01, 1.0), []
    assert coarse_surrogate.fit_on_finer_lumps_afresh(bare(), coarse, bare()) is fits[0] and len(asked) == 1


@pytest.mark.parametrize("lacks, tries", [((0.4,), 1), ((0.6, 0.4), 2), ((0.6, 0.6), 0), ((2.1, 0.1), 0)])
def test_a_stand_in_serves_whose_lack_stays(
    lacks: tuple[float, ...], tries: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    moved, fits = iter(2.0 * np.array(lacks)), list[int]()
    monkeypatch.setattr(
        coarse_surrogate, "_fit_with_correction", lambda coarse, lack: fits.append(1) or bare(machine=len(fits))
    )
    monkeypatch.setattr(coarse_surrogate, "correction_of", lambda coarse, machine: [np.zeros(1)])
    monkeypatch.setattr(coarse_surrogate, "_rms", lambda fine, lack: next(moved))
    told = coarse_surrogate._fit_until_steady(bare(), [np.zeros(1)], h(2.0, machine=None))
    assert (told.machine if told else 0) == tries


def test_parts_are_meant_whose_lumps_change_much_of_what_those_of_any_do(monkeypatch: pytest.MonkeyPatch) -> None:
    """Told with the one that changes most first; none where no lump changes anything."""
    size = {"bed": 10.0, "column": 2.9, "spindle": 3.1, "rail": None}
    kind = FinerKind()
    parts = [Part((name,), kind, "nodes", name) for name in size]
    monkeypatch.setattr(lumping_finding, "linearise_at_priors", lambda *of: bare(problem=bare(data=()), predictions=()))
    monkeypatch.setattr(lumping_finding, "list_structural", lambda machine: [*parts, Part((), kind, "nodes", "")])
    monkeypatch.setattr(lumping_finding, "respond_to_candidates", lambda able, *rest: [size[c.patch] for c, _ in able])
    monkeypatch.setattr(lumping_finding, "whiten", lambda fit, change: np.array([change]))
    tree = {"nodes": {name: {"lumps": "1"} for name in size}}
    finer = {"nodes": {name: {"lumps": "4" if name in ("bed", "spindle") else "1"} for name in size}}
    written = bare(fit=bare(problem=bare(parameters=())), machine=bare(to_plain=lambda: tree))
    now = bare(to_plain=lambda: finer, nodes=[*size])
    finding = lumping_finding.find_lumping(written, now, 40.0, 12.0)
    assert (
        finding is not None and finding.places == ("bed", "spindle") and (finding.gain, finding.threshold) == (40, 12)
    )
    assert finding.sentence == "Bed needs more lumps; spindle needs more lumps." and finding.confidence == 0.95
    assert [*finding.patch["nodes"]] == ["bed", "spindle"]
    size.update(dict.fromkeys(size))  # type: ignore[arg-type]
    assert lumping_finding.find_lumping(written, now, 40.0, 12.0) is None


# -- what is said ---------------------------------------------------------------------------------------------------
SHOWN, CHANCE = (bare(gain=gain, at=Location(("bed",)), probability=0.4) for gain in (13.0, 11.0))


IN = ("named",)
"""What a search found."""


def search_of(
    chi: float, explained: float = 1.0, located: Any = (SHOWN,), shift: float = 0.0, found: Any = (),
    untested_from: float = 0.0,
) -> Any:  # fmt: skip
    p = bare(path="links.joint.conductance")
    machine = bare(sensors={})
    best = h(
        chi, found=found, own=(), shift=np.array([shift]), fit=bare(problem=bare(parameters=(p,))), machine=machine
    )
    of = bare(
        best=best, located=located, selection=bare(is_checked=not untested_from, explained=explained),
        null=bare(linearised=None, chi=untested_from), fault=None, threshold=12.0, ended="",
    )  # fmt: skip
    of.share_that_holds = Search.share_that_holds.__get__(of)
    return of


@pytest.mark.parametrize(
    "search, given, coarse, refuted, told",
    [
        (search_of(1.0), ["named"], None, False, (["named"], "missing_physics")),
        (search_of(1.0), ["named"], "cut", False, (["named", "cut"], "missing_physics")),
        (search_of(1.0), ["sensor"], None, False, (["sensor"], "sensor_fault")),
        (search_of(1.0), ["sensor", "named"], None, False, (["sensor", "named"], "missing_physics")),
        (search_of(DOUBTFUL + 0.1, 0.4), ["named"], None, False, (["unknown", "named"], "missing_physics")),
        (search_of(DOUBTFUL + 0.1, 0.4), ["sensor"], None, False, (["unknown", "sensor"], "missing_physics")),
        (search_of(DOUBTFUL + 0.1, 0.6), ["named"], None, False, (["named"], "missing_physics")),
        (search_of(DOUBTFUL + 0.1, 0.6), ["unsure"], None, False, (["unknown", "unsure"], "missing_physics")),
        (search_of(DOUBTFUL - 0.1, 0.4), ["named"], None, False, (["named"], "missing_physics")),
        (search_of(DOUBTFUL - 0.1, 0.4, found=IN), ["named"], None, False, (["unknown", "named"], "missing_physics")),
        (search_of(SETTINGS.adequate - 0.1, 0.4, found=IN), ["named"], None, False, (["named"], "missing_physics")),
        (search_of(2.0, found=IN, untested_from=2.4), ["sure"], None, False, (["unknown", "sure"], "missing_physics")),
        (search_of(2.0, found=IN, untested_from=2.8), ["named"], None, False, (["named"], "missing_physics")),
        (search_of(2.0, untested_from=2.0), ["sensor"], None, False, (["sensor"], "sensor_fault")),
        (search_of(DOUBTFUL + 0.1, 0.6), ["bent"], None, False, (["unknown", "bent"], "missing_physics")),
        (search_of(DOUBTFUL - 0.1, 0.6), ["bent"], None, False, (["bent"], "missing_physics")),
        (search_of(DOUBTFUL + 0.1), [], "cut", False, (["cut", "unknown"], "unexplained")),
        (search_of(DOUBTFUL + 0.1, located=()), [], "cut", False, (["cut"], "too_coarse")),
        (search_of(SETTINGS.adequate + 0.1), [], None, True, (["unknown"], "unexplained")),
        (search_of(SETTINGS.adequate + 0.1, located=(CHANCE,)), [], None, True, ([], "adequate")),
        (search_of(SETTINGS.adequate + 0.1), [], None, False, ([], "adequate")),
        (search_of(SETTINGS.adequate - 0.1), [], None, True, ([], "adequate")),
        (search_of(1.0, shift=SETTINGS.shift - 0.1), [], None, False, ([], "adequate")),
        (search_of(1.0, shift=-SETTINGS.shift - 0.1), [], None, False, ([], "parameters_only")),
    ],
)  # fmt: skip
def test_the_verdict(
    search: Any, given: list[str], coarse: Any, refuted: bool, told: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        verdict,
        "find_unknown",
        lambda search, alone=False: bare(name="unknown", kind="unknown", channels=(), places=()),
    )
    monkeypatch.setattr(verdict, "_was_off", lambda search: False)
    monkeypatch.setattr(verdict, "is_finer", lambda search: bool(coarse))
    monkeypatch.setattr(verdict, "is_shadow", lambda search: "bent" in given)
    told_findings = [
        bare(name=n, channels=("T",) * (n == "sensor"), confidence=0.3 if n == "unsure" else 0.9, is_stop=False)
        for n in given
    ]
    found, said = verdict.decide_verdict(search, told_findings, coarse and bare(name=coarse), refuted)
    assert ([f.name for f in found], said) == told


@pytest.mark.parametrize(
    ("refuted", "chi", "relays", "told"),
    [(["worse"], 1.0, True, True), ([], 1.0, True, False), (["worse"], NOISE + 0.1, True, False),
     (["worse"], 1.0, False, False)],
)  # fmt: skip
def test_lumps_that_explain_all_and_were_taken_back_are_what_is_told(
    refuted: list[str], chi: float, relays: bool, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    search = search_of(DOUBTFUL + 0.1)
    search.null, search.written = bare(chi=chi, machine=bare(lumps=9)), bare(machine=bare(lumps=3))
    monkeypatch.setattr(conclusion, "has_relays", lambda machine: relays)
    assert conclusion._is_untaken(search, refuted) is told
    monkeypatch.setattr(verdict, "is_finer", lambda search: False)
    assert verdict.decide_verdict(search, [], bare(name="cut"), True)[1] == "too_coarse"


@pytest.mark.parametrize(
    ("ended", "lacks", "told"),
    [("budget", True, ([], "too_coarse")), ("budget", False, (["unknown"], "unexplained")),
     ("", True, (["unknown"], "unexplained")), ("stopped", True, (["unknown"], "unexplained"))],
)  # fmt: skip
@pytest.mark.parametrize("finer", [False, True])
def test_nothing_is_told_that_lumps_may_be_where_there_was_no_time_for_them(
    ended: str, lacks: bool, told: Any, finer: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    search = search_of(DOUBTFUL + 0.1)
    search.ended = ended
    monkeypatch.setattr(verdict, "lacks_what_is_left", lambda h, jobs: lacks)
    monkeypatch.setattr(verdict, "is_finer", lambda search: finer)
    monkeypatch.setattr(verdict, "find_unknown", lambda search: bare(name="unknown", kind="unknown"))
    found, said = verdict.decide_verdict(search, [], None, False)
    assert ([f.name for f in found], said) == told


@pytest.mark.parametrize(
    ("at", "probability", "told"),
    [(("bed",), 0.999, False), (("bed",), 0.98, True), (("bed", "column"), 0.999, True)],
)
def test_heat_in_one_part_alone_is_not_what_lumps_lack(
    at: tuple[str, ...], probability: float, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    search = search_of(DOUBTFUL + 0.1)
    search.ended, search.located = "budget", [bare(at=Location(at), probability=probability)]
    monkeypatch.setattr(verdict, "lacks_what_is_left", lambda h, jobs: True)
    assert verdict._may_be_lumps(search, 1) is told


@pytest.mark.parametrize(
    ("chi", "ended", "lacks", "found", "fault", "told"),
    [(DOUBTFUL + 0.1, "budget", False, (), "loose", True), (DOUBTFUL - 0.1, "budget", False, (), "loose", False),
     (DOUBTFUL + 0.1, "", False, (), "loose", False), (DOUBTFUL + 0.1, "budget", True, (), "loose", False),
     (DOUBTFUL + 0.1, "budget", False, IN, "loose", False), (DOUBTFUL + 0.1, "budget", False, (), None, False)],
)  # fmt: skip
def test_what_is_left_beside_a_fault_of_readings_is_told_where_there_was_no_time_to_look_for_it(
    chi: float, ended: str, lacks: bool, found: tuple[str, ...], fault: str | None, told: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setattr(verdict, "lacks_what_is_left", lambda h, jobs: lacks)
    monkeypatch.setattr(verdict, "find_unknown", lambda search: "unknown")
    monkeypatch.setattr(verdict, "replace", lambda of, **new: of)
    whole, search = search_of(9.0, untested_from=chi), search_of(9.0, found=found)
    search.fault, search.ended = fault, ended
    assert verdict.find_beside(whole, search, [bare(is_unnamed=False)], 1) == (["unknown"] if told else [])
    assert verdict.find_beside(whole, search, [bare(is_unnamed=True)], 1) == []


@pytest.mark.parametrize(("lack", "told"), [(0.0, False), (44.0, False), (46.0, True)])
def test_lumps_lack_what_is_left_where_their_error_is_as_large(
    lack: float, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """1200 rows at twice their noise: 60 σ beyond it."""
    few = bare(fit=bare(left=np.zeros(1200)), chi=2.0, machine="machine")
    monkeypatch.setattr(lump_shortfall, "on_few_runs", lambda of: few)
    monkeypatch.setattr(lump_shortfall, "bars_of", lambda machine: {"shaft": 4, "bed": 2})
    monkeypatch.setattr(lump_shortfall, "leave_each", lambda *of: {"shaft": lack / 2, "bed": lack / 2})
    assert lump_shortfall.lacks_what_is_left(few) is told


@pytest.mark.parametrize(("kind", "told"), [("input_fault", 0.5), ("sensor_fault", 0.98)])
def test_a_stop_beside_what_has_no_name_is_not_sure(kind: str, told: float) -> None:
    """What ages, or comes and goes, looks like a drive that stood still."""
    found = Finding(kind, "scenario", (), ("feed",), 0.98, {}, "Feed stood still.", Patch({}), 6000.0, 12.0)
    doubted = verdict._doubt_stop(found)
    assert doubted.confidence == told and bool(doubted.doubts) is (told == 0.5)


@pytest.mark.parametrize(
    ("counts", "told"),
    [
        ((3, 0, 2), "cooler switched 5 times in the 3 fitted runs together, as readings show; it was"),
        ((4,), "cooler switched 4 times in the fitted run, as readings show; it was"),
        ((0, 1), "cooler switched once in the 2 fitted runs together, as readings show; it was"),
    ],
)
def test_how_often_a_relay_switched_says_over_which_runs(counts: tuple[int, ...], told: str) -> None:
    runs = tuple(bare(modes={"mode of cooler": bare(t=np.arange(1.0 + n))}) for n in counts)
    best = h(fit=bare(problem=bare(data=())), case=bare(noise=bare(coloured={})))
    (note,) = diagnosis_notes.tell_recordings(bare(case=bare(recordings=runs), best=best))
    assert note.startswith(told)


@pytest.mark.parametrize(
    ("added", "share", "is_located", "is_shadow"),
    [
        (SETTINGS.alike - 0.1, 0.9, True, True),
        (SETTINGS.alike + 0.1, 0.9, True, False),
        (SETTINGS.alike + 0.1, 0.4, True, True),
        (-50.0, 0.0, False, False),
    ],
)
def test_what_hardly_lowers_heat_of_any_course_is_a_shadow(
    added: float, share: float, is_located: bool, is_shadow: bool
) -> None:
    search = bare(selection=bare(added=added, share_of_rest=share), located=(CHANCE,) * is_located)
    assert findings.is_shadow(search) is is_shadow


def test_what_simulated_runs_refute_is_taken_back_step_by_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """The last finding first, then all, then finer lumps; at once where the time is up; nothing twice, and with all the
    time it takes."""
    monkeypatch.setattr(simulated_findings, "replace", lambda of, **new: bare(**{**vars(of), **new}))
    monkeypatch.setattr(simulated_findings, "fit_findings", lambda case, root, found, values: h(found=found, case=case))
    monkeypatch.setattr(simulated_findings, "reweight", lambda case, of: of)
    written, null = h(name="written"), h(name="null")
    best = h(found=("a", "b", "c"), case=bare(budget="is over"), root=None, values={})
    search = bare(
        case=bare(budget="has no end"),
        best=best,
        selection=bare(best=best, gains=(3, 2, 1)),
        ended=False,
        null=null,
        written=written,
        fault=None,
    )
    tried = [each.selection for each in simulated_findings.list_retreats(search)]
    assert [t.best.case.budget for t in tried[:2]] == ["has no end"] * 2
    assert [t.best.found for t in tried[:2]] == [("a", "b"), ("a",)] and [t.gains for t in tried[:2]] == [(3, 2), (3,)]
    assert [t.best for t in tried[2:]] == [null, written]
    search.ended = True
    assert [t.selection.best for t in simulated_findings.list_retreats(search)] == [null, written]
    search.best = h(name="null", case=bare())
    search.null = search.best
    assert [t.selection.best for t in simulated_findings.list_retreats(search)] == [written]


@pytest.mark.parametrize(
    ("shows_itself", "told"),
    [(False, ["fit from calibrated", "fit from fitted"]), (True, ["calibrated"])],
)
def test_a_fault_that_stands_alone_is_told_before_it_is_taken_back(
    shows_itself: bool, told: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """At ever other numbers; where readings show it by themselves at those as calibrated."""
    monkeypatch.setattr(simulated_findings, "replace", lambda of, **new: bare(**{**vars(of), **new}))
    monkeypatch.setattr(simulated_findings, "reweight", lambda case, of: of)
    monkeypatch.setattr(simulated_findings, "use_file_noise", lambda case: case)
    monkeypatch.setattr(simulated_findings, "state", lambda case, machine, values: h(name=values, case=case))
    monkeypatch.setattr(simulated_findings, "fit_lasting", lambda of: h(name=f"fit from {of.name}", case=of.case))
    case = bare(budget="has no end", machine=None)
    written = h(name="written", case=case, values="fitted")
    search = bare(
        case=case,
        best=written,
        selection=bare(best=written, gains=()),
        ended=True,
        null=written,
        written=written,
        given=bare(machine=None),
        calibrated=bare(values="calibrated"),
        fault=bare(stands_alone=True, shows_itself=shows_itself, changes_machine=False),
    )
    *alone, bared = simulated_findings.list_retreats(search)
    assert [t.null.name for t in alone] == told
    assert all(t.fault is search.fault and t.written is t.null is t.selection.best for t in alone)
    assert bared.fault is None


@pytest.mark.parametrize(
    ("now", "fault", "told"),
    [
        ({"a": 2.0 + 1e-12}, bare(changes_machine=False), True),
        ({"a": 2.1}, bare(changes_machine=False), False),
        ({"a": 2.0, "b": 1.0}, bare(changes_machine=False), False),
        ({"a": 2.0}, bare(changes_machine=True), False),
        ({"a": 2.0}, None, False),
    ],
)
def test_readings_set_right_at_the_numbers_as_calibrated_leave_the_machine_as_it_is(
    now: dict[str, float], fault: Any, told: bool
) -> None:
    search = bare(calibrated=bare(values={"a": 2.0}), best=bare(values=now), fault=fault)
    assert simulated_findings._is_as_calibrated(search) is told


@pytest.mark.parametrize(
    "gain, mended, left, kept",
    [(1.0, True, 9.0, True), (-1.0, True, 1.0, False), (0.0, True, 1.0, False), (1.0, False, 6.0, False),
     (1.0, False, 4.0, True)],
)  # fmt: skip
def test_a_sensor_is_said_to_fail_now_and_then_where_that_mends_it(
    gain: float, mended: bool, left: float, kept: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Or, whatever else is missing, where it halves what is left of that channel itself."""
    monkeypatch.setattr(intermittent_fault, "is_mended", lambda before, after: mended and before == "before")
    monkeypatch.setattr(intermittent_fault, "excess_of", lambda x, channels, runs: {"before": 10.0, "after": left}[x])
    fault = bare(channel="T", recordings=())
    assert intermittent_fault._holds(fault, "before", "after", gain) is kept


def test_share_and_windows_are_found_again_about_the_better_fit_until_none_is(monkeypatch: pytest.MonkeyPatch) -> None:
    chis = iter([5.0, 3.0, 3.5])
    monkeypatch.setattr(intermittent_fault, "replace", lambda of, **new: bare(**{**vars(of), **new}))
    monkeypatch.setattr(
        intermittent_fault, "fit_both", lambda of, e: ("before", h(next(chis), share=e.share), 10.0 * e.share)
    )
    monkeypatch.setattr(intermittent_fault, "_update_fault", lambda of, e, about: bare(share=e.share + 0.1, gain=0.0))
    monkeypatch.setattr(intermittent_fault, "_holds", lambda e, before, after, gain: e.share > 0.5)
    monkeypatch.setattr(intermittent_fault, "_mends_nothing", lambda e, before, after: after.chi > 5.0)
    fault, after = intermittent_fault._settle(bare(), bare(share=0.6, gain=0.0))
    assert (fault.share, after.share, after.chi) == (0.7, 0.7, 3.0) and fault.gain == pytest.approx(7.0)
    chis = iter([5.0, 3.0, 3.5])
    assert intermittent_fault._settle(bare(), bare(share=0.2, gain=0.0)) is None
    chis = iter([6.0])
    assert intermittent_fault._settle(bare(), bare(share=0.6, gain=0.0)) is None
    monkeypatch.setattr(intermittent_fault, "fit_both", lambda of, e: None)
    assert intermittent_fault._settle(bare(), bare(share=0.6, gain=0.0)) is None


@pytest.mark.parametrize(
    ("chi", "own", "told"), [(6.0, 3.0, True), (6.0, 1.0, False), (4.0, 3.0, False), (4.0, 1.0, False)]
)
def test_a_fault_that_leaves_more_also_of_its_own_channel_mends_nothing(
    chi: float, own: float, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, after = h(5.0), h(chi)
    monkeypatch.setattr(intermittent_fault, "excess_of", lambda of, *where: 2.0 if of is before else own)
    assert intermittent_fault._mends_nothing(bare(channel="T", recordings=(1, 2)), before, after) is told


def test_a_fit_is_read_at_samples_straight_between_knots_to_the_last() -> None:
    """Of three intervals the readings at their beginnings, then those at their ends."""
    values = np.array([[0.0] * 6, [1.0, 2.0, 3.0, 2.0, 3.0, 9.0]])
    plan = bare(edges=np.array([0.0, 10.0, 20.0, 30.0]))
    fit = bare(values=values, run=bare(channels=["other", "T"]), course=bare(problem=bare(plan=plan)))
    told = channel_samples.truth_at_samples(fit, bare(t=np.array([0.0, 5.0, 20.0, 25.0, 30.0])), "T")
    np.testing.assert_allclose(told, [1.0, 1.5, 3.0, 6.0, 9.0])


def test_every_window_of_a_fault_costs_what_chance_would_explain_by_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """The fit to readings set right begins at the numbers of the file, or where it is told to; the one beside it, to
    those as they were, at hand, and briefly."""
    begun = list[Any]()
    monkeypatch.setattr(
        channel_fault, "_fit", lambda of, case, begin, *brief: begun.append((begin, *brief)) or h(evidence=case)
    )
    fault, of = (
        bare(
            windows=(((0.0, 1.0), (2.0, 3.0)), ((4.0, 5.0),), ()),
            correct=lambda case, right=True: 100.0 if right else 20.0,
        ),
        bare(case=None, values="bent", own_values="file"),
    )
    before, after, gain = channel_fault.fit_both(of, fault) or (None, None, 0.0)
    assert (before.evidence, after.evidence) == (20.0, 100.0) and gain == 80.0 - 3 * channel_fault.PER_WINDOW
    assert channel_fault.fit_both(of, fault, bare(values="told")) is not None
    brief = ("bent", channel_fault.BRIEF)
    assert begun == [brief, ("file",), brief, ("told",)]


def test_readings_set_right_are_fitted_from_bent_numbers_where_the_file_s_lead_astray(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As where relays fall out of step."""
    ends = {("as they were", "bent"): 20.0, ("set right", "file"): -500.0, ("set right", "bent"): 90.0}
    monkeypatch.setattr(
        channel_fault, "_fit", lambda of, case, begin, *brief: h(evidence=ends[case, begin], values=begin)
    )
    fault = bare(windows=(((0.0, 1.0),),), correct=lambda case, right=True: "set right" if right else "as they were")
    _, after, gain = channel_fault.fit_both(bare(case=None, values="bent", own_values="file"), fault) or (None, None, 0)
    assert after is not None and (after.values, gain) == ("bent", 70.0 - channel_fault.PER_WINDOW)


@pytest.mark.parametrize(
    ("channel", "gain", "beats"), [("T motor", 1.0, True), ("", 50.0, True), ("", 30.0, False), ("dz", 30.0, False)]
)
def test_a_fault_with_its_few_numbers_explains_more_than_any_course_of_heat(
    channel: str, gain: float, beats: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Or an error of any course of its own channel does. channel: where unknown errors or heat (none) explain most."""
    monkeypatch.setattr(find_onset_fault, "locate", lambda fit, machine: [bare(at=bare(channel=channel), gain=40.0)])
    of = bare(linearised=None, machine=None)
    assert find_onset_fault._beats_unknown(of, bare(channel="T motor", gain=gain)) is beats


@pytest.mark.parametrize(
    "is_clear, left, told",
    [(False, 1.2, (True, True)), (False, 9.0, (True, False)), (False, 19.0, (False, False)), (True, 9.0, (True, True))],
)
def test_a_fault_that_could_be_heat_is_told_where_hardly_anything_is_left(
    is_clear: bool, left: float, told: tuple[bool, bool], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Half of a large misfit may be what a drift imitates, unless lumps leave the rest; a clear jump is a fault
    whatever else is missing."""
    monkeypatch.setattr(corrected_onset, "ResidualSteps", lambda fit, recordings: None)
    jump = bare(is_due=False, is_seen=False, is_clear=is_clear)
    monkeypatch.setattr(corrected_onset, "watch_jump", lambda steps, o: jump)
    monkeypatch.setattr(corrected_onset, "excess_of", lambda fit, channels, runs: fit.chi**2 - 1)
    fault = bare(recordings=(), onset=bare(run=0), channel="T motor")
    tried = corrected_onset.Corrected(fault, h(20.0), h(left))
    assert (tried.holds, tried.is_alone) == told


@pytest.mark.parametrize(
    ("holds", "told"),
    [({"loose", "offset"}, "loose"), ({"offset"}, "offset"), ({"later"}, None), ({"less"}, None), (set(), None)],
)
@pytest.mark.parametrize("count", [3, 6])
def test_what_else_a_jump_could_be_is_told_where_the_best_does_not_hold(
    holds: set[str], told: str | None, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of that jump alone, and only what explains more than without it; of many runs fitted to all after two of them."""
    asked: list[str] = []
    gains = {"offset": 40.0, "loose": 90.0, "later": 70.0, "less": -5.0}
    jumps = {"later": ("T", 1, 500.0)}
    faults = [bare(name=name, gain=gain, jump=jumps.get(name, ("T", 0, 100.0))) for name, gain in gains.items()]
    monkeypatch.setattr(find_onset_fault, "replace", lambda of, **new: of.name)
    whole = count > 3
    monkeypatch.setattr(
        find_onset_fault, "_try_first", lambda of, f: bare(fault=f, is_of=lambda f: not whole) if f.gain > 0 else None
    )
    monkeypatch.setattr(find_onset_fault, "correct_onset", lambda of, f: asked.append(f.name) or bare(fault=f))
    monkeypatch.setattr(
        find_onset_fault,
        "_settle",
        lambda of, c: bare(fault=c.fault, holds=c.fault.name in holds, is_alone=True, after=c.fault.gain),
    )
    pair = find_onset_fault._confirm_best(h(), faults)
    assert pair == (None if told is None else (told, gains[told]))
    assert asked == ([] if not whole else ["loose"] if told == "loose" else ["loose", "offset"])


@pytest.mark.parametrize(
    ("count", "is_clear", "mends", "runs", "told"),
    [(6, True, True, [1, 4], True), (6, True, False, [1, 4], False), (6, False, False, None, True),
     (3, True, False, None, True)],
)  # fmt: skip
def test_a_clear_jump_of_many_runs_is_tried_in_its_own_and_the_worst_of_the_others_first(
    count: int, is_clear: bool, mends: bool, runs: list[int] | None, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Any] = []
    monkeypatch.setattr(find_onset_fault, "list_worst_runs", lambda of, few: [1, 4])
    monkeypatch.setattr(find_onset_fault, "on_runs", lambda of, chosen: bare(case=of.case.of(chosen)))
    monkeypatch.setattr(find_onset_fault, "replace", lambda of, **new: bare(**{**of.__dict__, **new}))
    monkeypatch.setattr(find_onset_fault, "correct_onset", lambda of, f: asked.append(f) or bare(fault=f, holds=mends))
    case = bare(recordings=tuple(range(count)), of=lambda chosen: bare(recordings=tuple(chosen)))
    fault = bare(onset=bare(run=1), is_clear=is_clear, gain=9.0, recordings=case.recordings)
    assert (find_onset_fault._try_first(bare(case=case), fault) is not None) is told
    few = (runs, 0) if runs else (list(range(count)), 1)
    assert [(list(f.recordings), f.onset.run) for f in asked] == [few]


def test_clear_jumps_of_which_no_score_agrees_with_what_is_read_are_tried_last(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(find_onset_fault, "_list_best", lambda faults: sorted(faults, key=lambda f: -f.gain))
    far, near = (bare(run=run, gain=gain, agrees=run == 1)
                 for run, gain in ((0, 90.0), (1, 30.0)))  # fmt: skip
    monkeypatch.setattr(find_onset_fault, "list_lone_jumps", lambda steps: [(0, "T", 1.0, 2.0), (1, "T", 1.0, 2.0)])
    monkeypatch.setattr(find_onset_fault, "begin_with_jump", lambda steps, o, at: o)
    monkeypatch.setattr(find_onset_fault, "OnsetFault", lambda recordings, gain, o, is_clear: bare(
        onset=o, gain=gain, is_clear=is_clear, jump=o.run))  # fmt: skip
    monkeypatch.setattr(find_onset_fault, "_make_fault", lambda steps, o: bare(
        onset=o, gain=o.gain, is_clear=o.agrees, jump=o.run))  # fmt: skip
    scan = bare(begun_at=lambda run, *of: [(far, near)[run]], best=lambda: [])
    told = find_onset_fault._list_faults(scan, bare(recordings=()))
    assert [f.jump for f in told] == [1, 0] and find_onset_fault._at_first_jumps(told) == told


def test_the_share_of_a_fault_is_told_by_all_readings_in_its_windows(monkeypatch: pytest.MonkeyPatch) -> None:
    """By least squares over both runs, gaps apart, whatever lies outside of them."""
    t = np.arange(6.0)
    first = bare(t=t, residual=np.array([9, 1, 2, np.nan, 9, 9.0]), change=np.array([1, 2, 4, 7, 1, 1.0]))
    runs = [first, bare(t=t, residual=3 + 0 * t, change=5 + 0 * t)]
    monkeypatch.setattr(intermittent_fault, "_list_residuals", lambda about, c, recordings: runs)
    monkeypatch.setattr(intermittent_fault, "_list_steps", lambda residuals: [None, None])
    monkeypatch.setattr(intermittent_fault, "list_as_fitted", lambda recordings, about: ())
    monkeypatch.setattr(intermittent_fault, "replace", lambda of, **new: bare(**{**vars(of), **new}))
    windows = (((1.0, 3.0),), ((4.0, 5.0),))
    fault = bare(candidate=None, loose=bare(share=0.1, windows=windows))
    inside = [intermittent_fault.inside(t, spans) for spans in windows]
    full = np.concatenate([run.change[i] for run, i in zip(runs, inside, strict=True)])
    left = np.concatenate([run.residual[i] for run, i in zip(runs, inside, strict=True)])
    good = np.isfinite(left)
    expected = np.linalg.lstsq(full[good, None], left[good], rcond=None)[0][0]
    found = intermittent_fault._update_fault(bare(case=bare(recordings=())), fault, bare())
    assert found.loose.share == pytest.approx(expected) and found.loose.windows == windows
    assert 0.3 < expected < 0.65


# -- places, programs, rivals ---------------------------------------------------------------------------------------
def test_stretches_are_promised_what_they_would_gain_beside_what_is_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    """(dᵀr)² / 2 dᵀMd where the change goes the way of what is left, and nothing where it goes the other."""
    left, seats = np.array([3.0, 1.0, -2.0]), [(seat(0, 1),), (seat(0, 0.5),), (seat(0, 0.2),), (seat(0, 0.4),)]
    changes = [np.array([1.0, 0, 0]), np.array([0, 2.0, 2.0]), None, np.array([2.0, 1.0, -1.0])]
    half = np.array([0.5, 1.0, 1.0])
    monkeypatch.setattr(placement, "linearise", lambda problem, theta: bare(
        problem=bare(data=()), predictions=(), unexplained=left * half, project=lambda D: D * half))  # fmt: skip
    monkeypatch.setattr(placement, "respond_to_candidates", lambda moved, data, predictions: changes)
    monkeypatch.setattr(placement, "whiten", lambda fit, D: D)
    moved = [bare(seats=each) for each in seats]
    fit = bare(fit=bare(problem=None, theta=None), values={})
    told = placement._promise_of(fit, placement._linearise(fit), moved)
    assert [round(gain, 6) for gain, _ in told] == [round(6.0**2 / (2 * 4.0), 6), round(1.5**2 / (2 * 0.5), 6), 0.0]
    assert [c for _, c in told] == [moved[3], moved[0], moved[1]] and placement._promise_of(bare(), None, []) == []


def test_of_stretches_that_explain_alike_the_longest_is_taken() -> None:
    short, long, far = (h(evidence=e, found=(bare(seats=s),)) for e, s in (
        (10.0, (seat(0.2, 0.4),)), (10.0 - 0.9 * placement.GAIN, (seat(0, 0.5), seat(0, 0.1))),
        (10.0 - 1.1 * placement.GAIN, (seat(0, 1),))))  # fmt: skip
    assert placement._widest(far, [short, long, far]) is long and placement._widest(far, []) is far


def test_the_last_finding_is_moved(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = list[Any]()
    monkeypatch.setattr(placement, "_elsewhere", lambda c: asked.append(c) or [])
    monkeypatch.setattr(placement, "_aside", lambda c, step: asked.append(c) or [])
    monkeypatch.setattr(placement, "_promise_of", lambda best, about, moved: [])
    monkeypatch.setattr(placement, "run_all", lambda deed, of, jobs: [])
    best = h(found=("a", "b", "c"), fit=bare(left=np.ones(3)))
    assert placement.place_best(best) is best and asked == ["c"] * (1 + len(placement.STEPS))


def test_relays_are_looked_for_first_where_unknown_heat_explains_most() -> None:
    """And not where it explains hardly anything beside the best, nor what is looked for where it shows alone."""
    parts = {n: (of,) for n, of in zip("abcdef", ["bed", "spindle", "spindle", "room", "head", "spindle"], strict=True)}
    relays = [bare(name=n, places=p, kind=bare(kind="relay"), own=(1,) * (n == "c")) for n, p in parts.items()]
    located = [
        bare(at=bare(kind="node", nodes=(n,)), gain=g) for n, g in (("bed", 5.0), ("spindle", 9.0), ("head", 0.8))
    ]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("network.analysis.diagnosis.switching.relay_search.parts_about", lambda c: {*c.places})
        patch.setattr("network.analysis.diagnosis.switching.relay_search.is_drawn", lambda c: c.name != "f")
        assert [c.name for c in rank_likely_places(relays, located)] == ["c", "b", "a"]


def test_a_ladder_goes_up_in_four_even_steps_and_rests() -> None:
    speed, fan = Driver("speed", "rpm", 0.0, 8000.0, False), Driver("fan", "W", 0.0, 100.0, False)
    ((text, (signal,)),) = _ladder([speed, fan], {speed: []}, 5.0)
    np.testing.assert_allclose(signal.t, np.arange(5) * 3600)
    assert "at 0 rpm" not in text.partition(" and ")[0] and text.endswith("1 h each")
    np.testing.assert_allclose(signal.start, [speed.level(s) for s in (0.25, 0.5, 0.75, 1.0)] + [0.0])


def test_findings_are_in_doubt_beside_the_nearest_rival_of_their_step() -> None:
    def named(key: str, evidence: float) -> Any:
        return h(1.0, evidence, (bare(key=key, kind=bare(kind=key), places=(key,), channels=()),))

    first, rival = named("a", 100.0), named("x", 100.0 - 0.5 * ALIKE)
    second, other = named("b", 150.0), named("y", 150.0 - 0.1 * ALIKE)
    third, far = named("c", 190.0), named("z", 50.0)
    search = bare(best=h(found=(first.found[0], second.found[0], third.found[0])),
                  steps=[[first, rival], [second, other], [third, far]])  # fmt: skip
    assert [(p.holds, p.rival) for p in advice.in_doubt(search)] == [(second, other), (first, rival)]
    search.steps = [[first, rival]]
    assert [(p.holds, p.rival) for p in advice.in_doubt(search)] == [(first, rival)]
    search.steps = [[first, rival], [second, other]]  # a third was found beside these
    assert [(p.holds, p.rival) for p in advice.in_doubt(search)] == [(second, other), (first, rival)]
    search.steps = []
    assert advice.in_doubt(search) == []


def test_pairs_are_told_apart_by_the_root_of_what_separates_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """Over the misfit that both leave; supposed sensors when asked; what rounding leaves below nothing is nothing."""
    of = bare(at=bare(slopes=np.ones((1, 3))), moved=np.array([3.0, 4.0, 12.0]), channel=np.array(["T", "T", "T_bed"]),
              extra={"bed": "T_bed"}, pair=bare(chi=2.0), _known=np.zeros((1, 1)))  # fmt: skip
    monkeypatch.setattr(separation, "Projector", lambda S, normal: bare(misfit=lambda moved: float(moved @ moved)))
    assert separation.Outcome.sigma(of) == 2.5 and separation.Outcome.sigma(of, ["bed"]) == 6.5
    monkeypatch.setattr(separation, "Projector", lambda S, normal: bare(misfit=lambda moved: -1e-12))
    assert separation.Outcome.sigma(of) == 0.0


# -- draws ----------------------------------------------------------------------------------------------------------
def linear_draws() -> tuple[Any, Any, Any, Any]:
    """Residuals r₀ − Jᵀθ of three rows beside one nuisance number; θ ~ N(1, 2²)."""
    J, S, r0 = np.array([[1.0, 2.0, 0.5], [1.0, -1.0, 2.0]]), np.array([[1.0, 1.0, 0.0]]), np.array([3.0, 1.0, 2.0])
    normal = S @ S.T + 1.0
    prior = (np.ones(2), np.full(2, 2.0), np.full(2, -9.0), np.full(2, 9.0))
    M = np.eye(3) - S.T @ np.linalg.inv(normal) @ S

    def cost(view: Any, theta: Any, r: Any) -> Any:
        return np.einsum("dr,rs,ds->d", r, M, r) + (((theta - 1) / 2) ** 2).sum(axis=1)

    judge = bare(space=bare(prior=prior), residuals=lambda view, theta: r0 - theta @ J, misfits=cost)
    view = bare(projector=bare(slopes=S, root=np.linalg.cholesky(normal)),
                take_up=lambda r: (r @ S.T @ np.linalg.inv(normal), None))  # fmt: skip
    best = np.linalg.solve(J @ M @ J.T + np.eye(2) / 4, J @ M @ r0 + np.ones(2) / 4)
    return judge, view, J, best


@pytest.mark.parametrize("told, gives_up", [
    ([-900.0, -800.0], False), ([-900.0, -800.0, -790.0], True), ([-900.0, -500.0, -300.0], False),
    ([-300.0, -100.0, -100.0, -100.0], True), ([-10.0, -9.0, 1.0], False),
])  # fmt: skip
def test_a_fit_is_given_up_that_would_not_come_to_what_is_needed_twice_as_fast(
    told: list[float], gives_up: bool
) -> None:
    asked = falling_short.FallsShort(0.0, 5)
    each = [bare(temper=lambda *firm, value=v: bare(log_evidence=value), problem=bare(firm_eta=1.0)) for v in told]
    assert [asked(at) for at in each][-1] is gives_up


@pytest.mark.parametrize("damped", [0.0, *DAMPED])
def test_a_step_of_draws_is_that_of_damped_gauss_newton(damped: float) -> None:
    judge, view, J, best = linear_draws()
    theta = np.array([[0.5, 1.5], [2.0, -1.0]])
    at = _At(theta, judge.residuals(view, theta), np.stack([J, J]), np.zeros(2))
    S, normal = view.projector.slopes, view.projector.root @ view.projector.root.T
    told = J @ (np.eye(3) - S.T @ np.linalg.solve(normal, S)) @ J.T
    H = told + np.eye(2) / 4
    expected = [np.linalg.solve(H + damped * np.diag(np.diag(told)), H @ (best - each)) for each in theta]
    (step,) = _steps(judge, view, at, [damped])
    np.testing.assert_allclose(step, expected, rtol=1e-9)


def test_draws_go_to_where_they_are_most_likely() -> None:
    """What the slightly damped step leaves after three of them is a millionth of where it began."""
    judge, view, _, best = linear_draws()
    found, misfits = refine_samples(judge, view, best + np.array([[0.9, -0.9], [0.1, 0.5]]), 3)
    np.testing.assert_allclose(found, [best, best], atol=1e-3 * 0.05)
    assert misfits == pytest.approx(judge.misfits(view, best[None], judge.residuals(view, best[None]))[0], rel=1e-6)


@pytest.mark.parametrize("error", [Failed("housing runs away"), Refused(["on too long"])])
def test_what_breaks_down_when_it_is_simulated_is_taken_back(error: Exception, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing of it is told; where nothing at all can be simulated, that ends the diagnosis with its sentence."""
    before: Any = bare(held=())
    whole, rest = (bare(selection=name) for name in ("whole", "rest"))

    def simulate(search: Any, *_: Any) -> tuple[Any, str, str]:
        if search is whole:
            raise error
        return search, "machine", "fits"

    monkeypatch.setattr(simulated_findings, "_simulate_both", simulate)
    monkeypatch.setattr(simulated_findings, "list_refutations", lambda selection, fits: [])
    monkeypatch.setattr(simulated_findings, "list_retreats", lambda search: iter([rest]))
    last, after, fits, refuted = simulated_findings.withdraw_refuted(whole, before, 1)
    assert (last, after, fits) == (rest, "machine", "fits")
    how = "its numbers make no machine" if isinstance(error, Refused) else "with it a run breaks down"
    assert refuted == [f"{how}: {error}"]
    monkeypatch.setattr(simulated_findings, "list_retreats", lambda search: iter(()))
    with pytest.raises(Failed, match=how):
        simulated_findings.withdraw_refuted(whole, before, 1)


def test_a_recording_is_simulated_once_with_the_same_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those as calibrated are not simulated again beside what was found, whatever of it is taken back."""
    tried: list[tuple[str, bool, str]] = []

    def compare(of: Any, run: Any, held_out: bool) -> Any:
        tried.append((of.name, held_out, run.file))
        return bare(recording=run, of=of.name)

    monkeypatch.setattr(simulated_runs, "compare_estimated", compare)
    first, second, other, held = (bare(file=name) for name in ("first", "second", "other", "held"))
    known, found = bare(name="calibrated", machine="as it was"), bare(name="found", machine="better")
    before = simulated_runs.simulate_runs(known, (first, second), (held,), 1)
    again = simulated_runs.simulate_runs(known, (first, other), (held,), 1, before)
    better = simulated_runs.simulate_runs(found, (first,), (), 1, before)
    assert tried == [
        ("calibrated", False, "first"), ("calibrated", False, "second"), ("calibrated", True, "held"),
        ("calibrated", False, "other"), ("found", False, "first"),
    ]  # fmt: skip
    assert [r.recording for r in again.train.recordings] == [first, other] and again.train.machine == "as it was"
    assert again.holdout is not None and again.holdout.recordings == before.holdout.recordings
    assert [r.of for r in better.train.recordings] == ["found"] and better.holdout is None


def test_what_a_named_fault_leaves_of_its_own_channel_comes_after_it() -> None:
    """And so does heat in the part that this channel reads, and no other."""
    part = {"heat_capacity": "1 kJ/K"}
    path = {"path": {"kind": "conduction", "between": ["a", "b"], "conductance": "1 W/K"}}
    known = machine({"a": part, "b": part}, links=path, sensors={"T": {"measures": "a", "noise": "0.1 K"}})
    fault, heat = bare(channels=("T",), places=()), bare(channels=(), places=("b",))
    same, other = bare(channels=("T",), places=()), bare(channels=("U",), places=())
    there, elsewhere = bare(channels=(), places=("a",)), bare(channels=(), places=("a", "b"))

    def order(unknown: list[Any], told: list[Any]) -> list[Any]:
        return verdict._put_in_order(known, unknown, told)

    assert order([same], [fault, heat]) == [fault, heat, same]
    assert order([other], [fault, heat]) == [other, fault, heat]
    assert order([there], [fault]) == [fault, there]
    assert order([elsewhere], [fault]) == [elsewhere, fault]
    assert order([there], [heat]) == [there, heat]


# -- steps from both numbers, and what goes on -----------------------------------------------------------------------
@pytest.mark.parametrize(
    "of_file, at_hand, told", [(3.0, 5.0, 5.0), (7.0, 5.0, 7.0), (None, 5.0, 5.0), (None, None, None)]
)
def test_a_trial_begins_from_the_file_and_from_the_numbers_at_hand(
    of_file: float | None, at_hand: float | None, told: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The better of both is what goes on; at hand it begins where it was screened."""
    about = bare(case="few", own_values={"own": 1.0}, values={"own": 1.0, "file": 9.0})
    trial = bare(candidate=bare(key="it", section="links"), best={"new": 4.0})

    def fit(case: Any, current: Any, c: Any, start: Any, steps: int) -> Any:
        evidence = at_hand if "file" in start else of_file
        assert start["new"] == 4.0 and steps == (refit.BRIEFER if "file" in start else refit.BRIEF)
        return None if evidence is None else h(evidence=evidence)

    monkeypatch.setattr(refit, "fit_with", fit)
    monkeypatch.setattr(refit, "move_stretch", lambda each: each)
    monkeypatch.setattr(refit, "compact", lambda each: each)
    begun = refit._start_trial(about, {}, None, trial)
    assert (begun and begun.evidence) == told


@pytest.mark.parametrize(("section", "begins"), [("tcp", ("thermometers", 3.0)), ("links", ("file", 7.0))])
def test_what_moves_the_tool_centre_point_begins_where_thermometers_alone_come_to(
    section: str, begins: tuple[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    about = bare(case="few", own_values={"from": "file"}, values={"from": "hand"})
    there = bare(key=("it",), section=section, direction=-1)
    scores = {side: {("it",): bare(gain=99.0, best={"new": size}, candidate=there)}
              for side, size in (("file", 7.0), ("aside", 3.0))}  # fmt: skip
    aside, tried = bare(scores=scores["aside"], values={"from": "thermometers"}), []
    monkeypatch.setattr(
        refit, "fit_with", lambda case, of, c, start, steps: tried.append((start["from"], start["new"], c.direction))
    )
    trial = bare(candidate=bare(key=("it",), section=section, direction=1), best={"new": 4.0})
    assert refit._start_trial(about, scores["file"], aside, trial) is None
    assert tried == [(*begins, -1), ("hand", 4.0, 1)]  # each the way in which it shows there


@pytest.mark.parametrize(
    "found, left, under, told",
    [
        (("a",), SETTINGS.further - 0.01, SETTINGS.further + 0.1, True),
        (("a",), SETTINGS.further + 0.01, SETTINGS.further + 0.1, False),
        (("a",), SETTINGS.further - 0.01, SETTINGS.further - 0.01, False),
        (("a", "b"), SETTINGS.further - 0.01, SETTINGS.further + 0.1, False), ((), 1.0, 9.0, False),
    ],
)  # fmt: skip
def test_what_passed_for_noise_is_looked_for_again(
    found: tuple[str, ...], left: float, under: float, told: bool
) -> None:
    """Where one finding leaves something under the noise that is left in the end, and not under that of the null; or
    where it is what is left of two."""
    now, checked = (bare(best=h(chi, found=found, offset_pull=0.0)) for chi in (left, under))
    assert forward_selection._shows_more(now, checked) is told
    fewer = bare(best=h(left, found=(*found, "c"), offset_pull=0.0))
    assert forward_selection._shows_more(fewer, checked) is (len(found) == 1 and under > SETTINGS.further)


@pytest.mark.parametrize(("gain", "told"), [(90.0, "finer"), (60.0, "few")])
def test_what_a_few_lumps_lack_is_no_candidate_where_finer_ones_explain_more(
    gain: float, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing is left, and a candidate shows 66 nats; finer lumps explain 90 or 60."""
    few, finer = (h(1.0, e, name=name, offset_pull=0.0, is_bent=False) for e, name in ((0.0, "few"), (gain, "finer")))
    first = bare(scores=[bare(gain=66.0)], before=bare(fit=bare(left=[0.0] * 100)))
    monkeypatch.setattr(lump_convergence, "choose_lumps", lambda *of: "cut")
    monkeypatch.setattr(lump_convergence, "fit_on_finer_lumps", lambda *of: finer)
    monkeypatch.setattr(faint_candidates, "screen_candidates", lambda of, seed, jobs: of.name)
    begun, seen = faint_candidates.settle_lumps(few, first, 0, 1)
    assert begun.name == told and (seen is first) is (told == "few")
    far = h(SETTINGS.noise + 0.1, offset_pull=0.0)
    assert faint_candidates.settle_lumps(far, first, 0, 1) == (far, first)


def test_a_step_that_went_from_what_held_in_the_end_is_not_taken_again() -> None:
    def state(*keys: str, noise: float = 1.0, runs: int = 3) -> Any:
        case = bare(noise=noise, sigma={}, recordings=(0,) * runs)
        return h(found=tuple(bare(key=key) for key in keys), case=case)

    now = Selection(state("oil", "clock"), (state(), state("oil")))
    assert now.went_from(state("oil")) and now.went_from(state())
    other = (state("oil", noise=2.0), state("fan"), state("oil", runs=4), state("oil", "clock"))
    assert not any(now.went_from(each) for each in other)


def test_steps_of_what_is_not_there_any_more_are_left_out() -> None:
    kept = [h(1.0, found=(bare(key=key),)) for key in ("tilt", "heat")]
    now = Selection(
        h(1.0, found=(bare(key="heat"),)), ("before", "after tilt"), ((kept[0],), (kept[1],)), unseen=("one",)
    )  # type: ignore[arg-type]
    told = now.keep_steps_found()
    assert (told.befores, told.steps, told.unseen) == (("after tilt",), ((kept[1],),), ())


@pytest.mark.parametrize(
    ("end", "is_checked", "is_doubted", "told"),
    [(BudgetReached(), False, False, "finished"), (BudgetReached(), True, False, "in passing"),
     (KeyboardInterrupt(), False, False, "in passing"), (BudgetReached(), False, True, "null"),
     (BudgetReached(), True, True, "in passing")],
)  # fmt: skip
def test_what_was_fitted_in_passing_is_finished_where_the_time_is_up(
    end: BaseException, is_checked: bool, is_doubted: bool, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not where it was tested, and not where somebody waits for it to stop; nor is it told where recordings that did
    not choose it do not show it."""
    monkeypatch.setattr(search_end, "replace", lambda of, **new: bare(**{**of.__dict__, **new}))
    monkeypatch.setattr(search_end, "finish_in_passing", lambda best: "finished")
    chosen = bare(best="in passing", gains=(9.0,), is_checked=is_checked, is_doubted=is_doubted)
    ended = search_end._end_early(bare(null="null", selection=chosen), end).selection
    assert (ended.best, ended.gains) == (told, () if told == "null" else (9.0,))


@pytest.mark.parametrize(
    ("doubts", "agree", "is_apart", "told"),
    [(("",), False, False, False), (("p = 0.4",), False, False, True), (("p = 0.4",), True, False, False),
     (("p = 0.4",), False, True, False), (("", "p = 0.4"), False, False, False), ((None,), False, False, False)],
)  # fmt: skip
def test_a_selection_is_doubted_where_recordings_that_did_not_choose_its_first_finding_do_not_show_it(
    doubts: tuple[str | None, ...], agree: bool, is_apart: bool, told: bool
) -> None:
    found = tuple(bare(key=str(k), is_searched_apart=is_apart) for k in range(len(doubts)))
    steps = tuple((h(1.0, found=found[: k + 1]),) for k in range(len(found)))
    unseen = tuple(None if doubt is None else bare(doubt=doubt, halves_agree=agree) for doubt in doubts)
    now = Selection(h(1.0, found=found), ("before",) * len(found), steps, unseen=unseen)  # type: ignore[arg-type]
    assert now.is_doubted is told


def test_a_stop_while_something_is_finished_leaves_what_there_was(monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(best: Any) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr(search_end, "replace", lambda of, **new: bare(**{**of.__dict__, **new}))
    monkeypatch.setattr(search_end, "finish_in_passing", stop)
    chosen = bare(best="in passing", is_checked=False, is_doubted=False)
    now = search_end._end_early(bare(selection=chosen), BudgetReached())
    assert (now.ended, now.selection.best) == ("stopped", "in passing")


@pytest.mark.parametrize(("evidence", "lumps", "told"), [(9.0, 4, 9.0), (4.0, 4, 5.0), (None, 4, 5.0), (9.0, 48, 5.0)])
def test_what_was_fitted_in_passing_is_kept_where_some_steps_further_tell_less_or_there_is_no_time_for_them(
    evidence: float | None, lumps: int, told: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the 10 s that are left telling it takes 5 on the lumps of the file, and 20 on 12 times as many."""
    monkeypatch.setattr(few_runs, "replace", lambda of, **new: bare(**{**of.__dict__, **new}))
    more = None if evidence is None else h(evidence=evidence)
    monkeypatch.setattr(few_runs, "fit_findings", lambda *of, **how: more)
    budget = TimeBudget(100.0, reserved=5.0)
    case = bare(budget=replace(budget, began=budget.began - 90.0), machine=bare(lumps=4))
    now = h(evidence=5.0, found=("it",), case=case, machine=bare(lumps=lumps), root=None, values={})
    assert few_runs.finish_in_passing(now).evidence == told
    assert few_runs.finish_in_passing(nothing := h(found=())) is nothing


def test_steps_beside_what_was_tested_are_no_part_of_the_search_once_the_time_is_up(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def steps(*of: Any) -> Any:
        yield "one"
        raise BudgetReached

    monkeypatch.setattr(forward_selection, "replace", lambda of, **new: of)
    monkeypatch.setattr(forward_selection, "on_few_runs", lambda best, count: best)
    monkeypatch.setattr(forward_selection, "_take_steps", steps)
    told = bare(best=None, keep_steps_found=lambda: bare(best=None))
    assert forward_selection._go_on(None, told, None, 0, 1, lambda share: None) is None  # type: ignore[arg-type]


def test_steps_that_are_run_out_tell_where_they_come_to() -> None:
    def steps() -> Any:
        yield "one"
        yield "two"
        return "end"

    assert forward_selection._run_out(steps()) == "end"


def test_relays_at_every_place_go_on_beside_the_best() -> None:
    fits = [h(chi, found=(bare(key=key),)) for chi, key in ((1.0, "a"), (1.1, "a"), (1.2, "a"), (1.3, "b"), (1.4, "b"))]
    assert [each.chi for each in keep_of_each(fits, 2)] == [1.0, 1.1, 1.3]
    assert [each.chi for each in keep_of_each(fits, 1)] == [1.0, 1.3]
    assert keep_of_each([], 3) == []


@pytest.mark.parametrize(
    "p, of_one, told", [(0.6, False, True), (0.4, False, False), (0.6, True, False), (1e-9, False, False)]
)
def test_halves_speak_against_a_finding_where_chance_is_more_likely_than_not(
    p: float, of_one: bool, told: bool
) -> None:
    assert UnseenTest((p / 2, p / 2), (("a",), ("b",)), of_one).speaks_against is told


@pytest.mark.parametrize(
    "p, agree, of_one, told",
    [(4e-3, False, False, False), (4e-3, True, False, True), (9e-5, False, False, True), (0.9, False, True, True)],
)
def test_a_further_finding_shows_where_it_was_not_chosen(p: float, agree: bool, of_one: bool, told: bool) -> None:
    chosen = (("a",), ("a",)) if agree else (("a",), ("b",))
    assert UnseenTest((p / 2, p / 2), chosen, of_one).shows_again is told


@pytest.mark.parametrize(
    "chi, switches, tried, told",
    [(SETTINGS.adequate - 0.1, False, 0, 10.0), (9.0, True, 0, 10.0), (9.0, False, 3, 30.0)],
)
def test_a_fit_that_leaves_much_is_made_again_from_other_numbers(
    chi: float, switches: bool, tried: int, told: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From those of the file and with its strength smaller and larger; what breaks down tells nothing."""
    c, starts = bare(own=(bare(path="late"),)), list[Any]()
    held = h(
        chi, 10.0, (c,), case=None, machine=None, own=c.own, own_values={"late": 300.0}, switches=switches,
        values={"late": 300.0, "file": 2.0},
    )  # fmt: skip

    def fit(case: Any, machine: Any, found: Any, own: Any, start: Any, until: Any) -> Any:
        starts.append(start)
        if start["late"] < 300:
            raise Failed("it runs away")
        assert until.needed == 10.0
        return h(1.0, 30.0 if start["late"] > 300 else 5.0)

    monkeypatch.setattr(fresh_fit, "fit_hypothesis", fit)
    assert fresh_fit.fit_afresh(held).evidence == told and len(starts) == tried
    if tried:
        assert starts == [{"late": 300.0}, *({"late": 300.0 * kick, "file": 2.0} for kick in fresh_fit.KICKS)]


def test_a_stop_lasts_for_more_than_its_edges() -> None:
    """60 s a step: two of them are what an edge takes that is stamped early or late."""
    of = bare(predictions=(bare(run=bare(knots=bare(t=np.arange(0.0, 3600.0, 60.0)))),))
    short, long, both = ((600.0, 710.0),), ((600.0, 730.0),), ((0.0, 900.0), (1200.0, 1260.0))
    for windows, told in ((short, False), (long, True), (both, False)):
        assert find_standstill._spans_steps(of, bare(stops=(windows,))) is told
    once, always = ((), ((3.0, 5.0),)), (((3.0, 5.0),), ((1.0, 2.0),))

    idle = (*always, ())

    def is_plain(source: str, stops: Any, chi: float) -> bool:
        moves = [1.0, 1.0, 0.0][: len(stops)]
        runs = tuple(bare(columns={"speed": bare(values=np.array([0.0, x]))}) for x in moves)
        driver, before = bare(source=source, inputs=("speed",)), bare(case=bare(recordings=runs))
        return find_standstill._is_plain(bare(driver=driver, before=before, stops=stops, after=h(chi)))

    assert is_plain("", once, 9.0) and is_plain("", always[:1], 9.0)
    assert not is_plain("", always, 9.0) and is_plain("", always, 1.0) and not is_plain("", idle, 9.0)
    assert not is_plain("pump", once, 9.0) and is_plain("pump", once, 1.0)


@pytest.mark.parametrize(
    "left, first, slight, told",
    [
        ((15.2, 13.0, 6.1), 5.9, (), 2), ((12.0, 13.0, 6.1), 5.9, (), 0), ((4.4, 2.9, 4.8), 2.1, (), 0),
        ((17.0, 18.0, 19.0), 5.9, (), 0),
        ((15.2, 13.0, 6.1), ADEQUATE - 0.1, (), 0),
        ((15.2, 13.0, 6.1), 5.9, (2,), 1), ((6.1, 15.2, 13.0), 5.9, (0,), 2), ((6.1, 5.0, 4.0), 5.9, (0,), 1),
        ((6.1, 15.2, 13.0), 5.9, (0, 1, 2), 0),
    ],
)  # fmt: skip
def test_of_rivals_that_leave_much_one_that_tells_unseen_runs_well_goes_on(
    left: tuple[float, ...], first: float, slight: tuple[int, ...], told: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first that explains half of what the best of them explains there, of those that are worth a name (slight: the
    others); as they are where none explains anything, or little is left."""
    before, rivals = h(9.6), [h(first, float(-k)) for k in range(3)]
    unseen = {id(before): 16.9} | {id(each): x for each, x in zip(rivals, left, strict=True)}

    def tell(all_of: list[Any], jobs: int, with_rest: bool) -> list[Any]:
        return [bare(chi=unseen[id(each)]) for each in all_of]

    monkeypatch.setattr(rival_acceptance, "tell_all_unseen", tell)
    monkeypatch.setattr(rival_acceptance, "distinct", lambda ranked: [*ranked])
    monkeypatch.setattr(rival_acceptance, "is_worth", lambda _, after: all(after is not rivals[k] for k in slight))
    assert [*rival_acceptance._skip_misleading(before, rivals, 1)] == rivals[told:]
