"""The parts of a diagnosis that make it fast or keep it honest, each against a computation that does without it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from build import machine
from test_diagnosis import LADDERS, LINKS, NODES, SENSORS, SOURCES, plant, recorded

from network.analysis.calibration.coloured_noise import estimate_colours
from network.analysis.calibration.estimated_constants import Numbers, estimate_constants
from network.analysis.calibration.gauss_newton import linearise
from network.analysis.diagnosis.candidates.candidate import Candidate, candidate
from network.analysis.diagnosis.candidates.candidate_response import respond_to_candidates
from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.hypotheses import hypothesis_fit
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.compact_fit import compact
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_findings, fit_hypothesis, start_from
from network.analysis.diagnosis.lumps.coarse_surrogate import build_surrogate
from network.analysis.diagnosis.lumps.lump_refinement import list_finer_machines
from network.analysis.diagnosis.screening.screen import Score
from network.analysis.diagnosis.screening.screening import Screening
from network.analysis.diagnosis.search_end import last_of
from network.analysis.diagnosis.search_record import Search
from network.analysis.diagnosis.steps import (
    backward_elimination,
    first_rivals,
    forward_selection,
    refit,
    trial_fits,
    unseen_runs,
)
from network.analysis.diagnosis.steps.other_kinds import exchange_kind, put_in_place
from network.analysis.diagnosis.steps.placement import _widest, move_stretch, place_best
from network.analysis.diagnosis.steps.selection import Selection
from network.analysis.diagnosis.steps.unseen_runs import Unseen
from network.analysis.diagnosis.switching.prior_samples import Judge, Space, apart
from network.analysis.diagnosis.switching.sample_refinement import refine_samples
from network.analysis.diagnosis.switching.share_view import View
from network.analysis.diagnosis.time_budget import TimeBudget
from network.catalogue.mechanisms.conduction import Conduction
from network.engine.assembly import build
from network.engine.channels import readouts
from network.engine.response.batch import draws_of, serves
from network.engine.response.batch_march import means_of
from network.engine.response.heat_sensitivity import Slots
from network.engine.response.model import Model
from network.engine.response.parameters import values_at
from network.engine.response.run_beginning import Beginning
from network.machine.machine import Machine
from network.platform.refusal import Failed

COOLER = {"cooler": {"kind": "thermostat_cooling", "into": {"housing": 1}, "watches": "housing", "set": "24 degC",
                     "hysteresis": "0.6 K", "power": "250 W"}}  # fmt: skip
BARS = {
    **NODES,
    "housing": {"material": "steel", "length": "600 mm", "area": "130 cm^2", "lumps": 1},
    "column": {"material": "steel", "length": "1500 mm", "area": "160 cm^2", "lumps": 1},
}
STEEL = {"steel": {"density": "7800 kg/m^3", "specific_heat": "470 J/(kg K)", "conductivity": "45 W/(m K)",
                   "expansion": "1.1e-5 1/K"}}  # fmt: skip


@cache
def null(concealed: str = "") -> Hypothesis:
    truth = plant(sources=COOLER if concealed else {})
    case = Case(plant(), tuple(recorded(truth, ladder, i) for i, ladder in enumerate(LADDERS)))
    return fit_hypothesis(case, case.machine)


def bars(lumps: int = 1) -> Machine:
    nodes = {n: {**body, "lumps": lumps} if "lumps" in body else body for n, body in BARS.items()}
    return machine(nodes, links=LINKS, sources=SOURCES, sensors=SENSORS, materials=STEEL)


@cache
def fine() -> Hypothesis:
    case = Case(bars(), tuple(recorded(bars(40), ladder, i) for i, ladder in enumerate(LADDERS)))
    _, twice, *_ = list_finer_machines(case.machine)
    return fit_hypothesis(case, twice)


def relay_on(part: str, h: Hypothesis) -> Candidate:
    return next(c for c in candidates(h.machine, h.case.drivers) if c.switches and c.places == (part,))


@pytest.mark.parametrize("kind", ["conduction", "forced_convection", "heat_source", "viscous_friction"])
def test_a_candidates_heat_alone_tells_what_the_whole_run_does(kind: str) -> None:
    h = null()
    c = next(c for c in candidates(h.machine, h.case.drivers) if c.kind.kind == kind)
    small = {p.path: p.value(p.centre) for p in c.own} | {c.own[0].path: 1e-3 * c.own[0].value(c.own[0].centre)}
    (told,) = respond_to_candidates([(c, {**h.values, **small})], h.fit.problem.data, h.predictions)
    theta = np.array([np.log(small[p.path]) if p.is_log else small[p.path] for p in c.own])
    whole = Model(c.machine, (*h.fit.problem.parameters, *c.own), [d.run for d in h.fit.problem.data])
    there = whole.predict(np.concatenate([h.fit.theta, theta]))
    moved = np.concatenate([m.cells - p.cells for m, p in zip(there, h.predictions, strict=True)])
    assert told is not None
    np.testing.assert_allclose(told, moved, atol=0.02 * np.abs(moved).max())


def test_candidates_answered_together_are_answered_as_each_alone() -> None:
    h = null()
    some = [c for c in candidates(h.machine, h.case.drivers) if not (c.switches or c.is_structural)][::4]
    tried = [(c, {**h.values, **c.usual}) for c in some]
    together = respond_to_candidates(tried, h.fit.problem.data, h.predictions, jobs=2)
    assert len(together) == len(tried) > 8
    for of, moved in zip(tried, together, strict=True):
        (alone,) = respond_to_candidates([of], h.fit.problem.data, h.predictions)
        assert (alone is None) == (moved is None)
        if alone is not None:
            np.testing.assert_allclose(moved, alone, atol=1e-9 * max(1.0, np.abs(alone).max()))


def test_heat_is_moved_along_its_bar_to_where_it_is() -> None:
    ends = {f"T_{end}": {"measures": f"column@{end}", "noise": "0.05 K"} for end in (0.15, 0.85)}
    plain = bars(10).patched({"sensors": ends})
    hidden = {"kind": "heat_source", "into": {"column@0.7..0.9": 1}, "power": "120 W", "with": "always"}
    truth = plain.patched({"sources": {"hidden": hidden}})
    case = Case(plain, tuple(recorded(truth, ladder, i) for i, ladder in enumerate(LADDERS)))
    heats = [c for c in candidates(case.machine, case.drivers) if c.kind.kind == "heat_source"]
    c = next(c for c in heats if c.places == ("column",))
    off = c.move_place("column", "column@0.5..0.75")
    assert off is not None
    before = fit_hypothesis(case, off.machine, (off,), off.own)
    found = place_best(before)
    ((place, _),) = found.found[0].machine.sources[next(iter(c.patch["sources"]))].into
    assert found.evidence > before.evidence + 100 and abs((place.start + place.stop) / 2 - 0.8) < 0.11
    back = found.found[0].back
    assert back is not None and back.patch == c.patch and c.back is c


def test_at_the_stretch_that_was_found_another_kind_is_tried() -> None:
    """A wall that is warm does nearly what a source does there, with a number more; the source stood behind it where it
    heats the whole bar."""
    ends = {f"T_{end}": {"measures": f"column@{end}", "noise": "0.05 K"} for end in (0.15, 0.85)}
    plain = bars(10).patched({"sensors": ends})
    hidden = {"kind": "heat_source", "into": {"column@0.7..0.9": 1}, "power": "120 W", "with": "always"}
    truth = plain.patched({"sources": {"hidden": hidden}})
    case = Case(plain, tuple(recorded(truth, ladder, i) for i, ladder in enumerate(LADDERS)))
    before, proposed = fit_hypothesis(case, plain), candidates(plain, case.drivers)
    of_kind = {kind: [c for c in proposed if c.kind.kind == kind and c.places == ("column",)]
               for kind in ("foundation", "heat_source")}  # fmt: skip
    wall, whole = of_kind["foundation"][0], of_kind["heat_source"][0]
    there = wall.move_place("column", "column@0.7..0.9")
    assert there is not None
    kept = fit_hypothesis(case, there.machine, (there,), there.own)
    rival = fit_hypothesis(case, whole.machine, (whole,), whole.own)
    assert kept.evidence > rival.evidence
    told = exchange_kind(before, kept, proposed, 1)
    ranked = put_in_place(told, kept, [kept, rival])
    assert told.found[0].kind.kind == "heat_source" and told.evidence > kept.evidence
    assert [str(seat) for seat in told.found[0].seats] == ["column@0.7..0.9"]
    assert [h.found[0].kind.kind for h in ranked] == ["heat_source", "foundation"]
    assert ranked[0].weighed - kept.weighed == pytest.approx(told.evidence - kept.evidence)
    assert exchange_kind(before, told, proposed, 1) is told and put_in_place(told, told, ranked) is ranked
    assert exchange_kind(before, rival, proposed, 1) is rival


def crossed() -> tuple[Case, Candidate]:
    """A path that is missing between the far ends of two bars, and the same between the bars as a whole."""
    plain = bars(8).patched({"sensors": {
        **{f"T_{end}": {"measures": f"column@{end}", "noise": "0.05 K"} for end in (0.1, 0.35, 0.6, 0.85)},
        **{f"H_{end}": {"measures": f"housing@{end}", "noise": "0.05 K"} for end in (0.15, 0.85)},
    }})  # fmt: skip
    hidden = {"kind": "conduction", "between": ["housing@0.75..1", "column@0.75..1"], "conductance": "40 W/K"}
    truth = plain.patched({"links": {"hidden": hidden}})
    case = Case(plain, tuple(recorded(truth, ladder, i) for i, ladder in enumerate(LADDERS)))
    path = {"kind": "conduction", "between": ["housing", "column"], "conductance": "20 W/K"}
    c = candidate(case.machine, Conduction, {"links": {"path": path}})
    assert c is not None
    return case, c


def ends(h: Hypothesis) -> set[str]:
    return {str(place) for place in h.found[0].machine.links["path"].between}


def test_both_ends_of_a_path_are_moved_together() -> None:
    case, c = crossed()
    found = place_best(fit_hypothesis(case, c.machine, (c,), c.own))
    assert ends(found) == {"housing@0.75..1", "column@0.75..1"} and found.chi < 1.05


def test_a_path_is_moved_to_where_it_is_much_stronger() -> None:
    case, c = crossed()
    aside = c.move_place("column", "column@0.75..1")
    assert aside is not None
    start_from = compact(fit_hypothesis(case, aside.machine, (aside,), aside.own))
    assert start_from.values[c.own[0].path] < 0.6 * 40
    assert ends(move_stretch(start_from)) == {"housing@0.75..1", "column@0.75..1"}
    assert move_stretch(found := move_stretch(start_from)) is found


def test_draws_stepped_together_run_like_each_run_by_itself() -> None:
    h = null()
    c, data = relay_on("housing", h), h.fit.problem.data[0]
    network = build(c.machine)
    assert serves(network)
    slots = Slots(network, c.own)
    rows = [[p.centre + 0.1 * k * p.spread for p in c.own] for k in range(3)]
    networks = [slots.at(values_at(c.own, np.array(row))) for row in rows]
    begun = Beginning(c.machine, network, readouts(network, parts=False), data.run, 1.0)
    (means,), switches = means_of([begun], draws_of(networks, data.run), {})
    for row, together in zip(rows, means, strict=True):
        alone = Model(c.machine, c.own, [data.run]).predict(np.array(row))[0]
        assert np.abs(together - alone.cells).max() < 0.03
    assert (switches > 0).any()


def judge_of(part: str, h: Hypothesis) -> Judge:
    about = linearise(h.fit.problem, h.fit.theta)
    return Judge(Space(relay_on(part, h)), about, values_at(about.problem.parameters, about.theta))


def test_draws_find_a_relay_at_its_part_and_at_no_other() -> None:
    h = null("cooler")
    best = {}
    for part in ("housing", "column"):
        judge = judge_of(part, h)
        view, theta = View(judge.about, 0.3), judge.space.draw(200, 0)
        misfit = judge.misfits(view, theta, judge.residuals(view, theta))
        some = apart(theta, misfit, judge.space.prior[1], 0.3, 8)
        theta, better = refine_samples(judge, view, theta[some], 4)
        assert (better <= misfit[some] + 1e-6).all()
        k = int(np.argmin(better))
        best[part] = better[k], judge.space.numbers(theta[k])
    assert best["housing"][0] < 0.5 * best["column"][0]
    assert best["housing"][1]["sources.thermostat cooling housing.power"] == pytest.approx(250, rel=0.3)


def test_where_no_draw_runs_none_is_polished() -> None:
    judge = judge_of("housing", null())
    view, none = View(judge.about, 0.2), np.empty((0, len(judge.space.prior[0])))
    theta, misfit = refine_samples(judge, view, none, 2)
    assert theta.shape == none.shape and misfit.shape == (0,)


def test_draws_that_are_kept_apart_are_the_best_that_differ() -> None:
    theta, misfit = np.array([[0.0], [0.1], [1.0], [9.0]]), np.array([2.0, 1.0, 3.0, np.inf])
    assert apart(theta, misfit, np.ones(1), 0.3, 4) == [1, 2]


def test_a_held_node_that_becomes_a_tank_may_start_anywhere() -> None:
    jacket = {"kind": "convection", "between": ["housing", "coolant"], "conductance": "20 W/K ± 30 %"}
    cooled = machine(
        {**NODES, "coolant": {"temperature": "21 degC"}}, links={**LINKS, "jacket": jacket}, sources=SOURCES,
        sensors=SENSORS,
    )  # fmt: skip
    tanks = [Space(c) for c in candidates(cooled, ["speed", "ambient"]) if c.switches and "coolant" in c.places]
    assert [t.parts for t in tanks] == [("coolant",)]
    centre, spread, low, high = tanks[0].prior
    assert centre[-1] == cooled.reference and low[-1] < centre[-1] - spread[-1] < high[-1]


def test_coarser_lumps_that_are_told_what_they_lack_leave_the_same() -> None:
    h = fine()
    coarse = build_surrogate(h)
    assert coarse.machine.lumps < h.machine.lumps
    assert coarse.chi == pytest.approx(h.chi, rel=0.02)
    for p, values in ((p, coarse.values[p.path]) for p in h.fit.problem.parameters):
        assert values == pytest.approx(h.values[p.path], rel=0.02)


def test_what_is_kept_of_a_fit_is_what_it_said() -> None:
    h = null()
    kept = compact(h)
    assert not hasattr(kept.fit, "predictions") and kept.evidence == h.evidence and kept.chi == h.chi
    np.testing.assert_array_equal(kept.fit.covariance, h.fit.covariance)


def test_a_fit_about_other_starts_comes_to_the_same() -> None:
    h = null()
    again = fit_hypothesis(start_from(h.case, h), h.machine, start=h.values)
    assert again.fit.cost == pytest.approx(h.fit.cost, rel=1e-3)
    moved = again.fit.eta[len(again.fit.problem.offsets) :][: len(again.fit.problem.data[0].starts)]
    assert np.abs(moved).max() < 0.02


def test_where_a_run_began_is_found_again() -> None:
    h = null()
    warm = recorded(plant(), LADDERS[0], 5, start=20.4)
    numbers = Numbers(h.machine, h.machine, h.fit.problem.parameters, h.fit.theta)
    start = estimate_constants(numbers, warm).start
    assert [start[n] for n in ("spindle", "housing", "column")] == pytest.approx([20.4] * 3, abs=0.06)


def test_channels_that_sway_together_are_moved_by_heat_and_not_by_noise() -> None:
    h = null("cooler")
    assert all(tinted == 0 for _, tinted, _ in estimate_colours(h.fit.problem.data, h.predictions).values())


def test_noise_that_is_each_sensors_own_keeps_its_colour() -> None:
    h, rng = null(), np.random.default_rng(3)
    runs = []
    for recording in h.case.recordings:
        columns = dict(recording.columns)
        for name in SENSORS:
            e = np.zeros(len(recording.t))
            for k in range(1, len(e)):
                e[k] = 0.9 * e[k - 1] + 0.06 * rng.standard_normal()
            columns[name] = replace(columns[name], values=columns[name].values + e)
        runs.append(replace(recording, columns=columns))
    loud = fit_hypothesis(replace(h.case, recordings=tuple(runs)), h.machine)
    told = estimate_colours(loud.fit.problem.data, loud.predictions)
    assert all(tinted == pytest.approx(0.06 / np.sqrt(1 - 0.81), rel=0.3) for _, tinted, _ in told.values())


def test_a_case_on_another_recording_knows_nothing_of_its_runs() -> None:
    h = null()
    about = start_from(h.case, h)
    alone = about.on(about.recordings[:1])
    assert len(alone.lay_out(h.machine)) == 1 and not alone.began and not alone.lacking


def test_of_stretches_that_are_hardly_apart_the_longest_is_taken() -> None:
    _, c = crossed()
    long, short = (c.move_place("column", f"column@{stretch}") for stretch in ("0.5..0.7", "0.55..0.65"))
    as_it_is, first, second, third = (
        SimpleNamespace(evidence=e, found=(x,)) for e, x in ((0.0, c), (50.0, long), (53.0, short), (60.0, short))
    )
    assert _widest(as_it_is, [first, second]) is first  # type: ignore[arg-type, list-item]
    assert _widest(as_it_is, [first, third]) is third  # type: ignore[arg-type, list-item]
    assert _widest(as_it_is, []) is as_it_is  # type: ignore[arg-type, comparison-overlap]


def test_what_does_not_help_to_tell_runs_left_out_goes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Misfits on runs left out, by what is in; density goes with it, but for "d" and relays: heat of any course lowers
    that; "r" is out of step, and tells more beside as much heat as there is without it, "s" does not even then."""
    misfit = {"": 5.0, "a": 3.0, "b": 5.2, "ab": 3.1, "c": 5.1, "d": 4.9, "r": 4.0, "s": 4.0, "ar": 2.0}
    heat: Any = SimpleNamespace()

    class Name(str):
        @property
        def switches(self) -> bool:
            return self in ("r", "s")

    def hypothesis(names: str) -> SimpleNamespace:
        return SimpleNamespace(found=tuple(map(Name, names)), name=names)

    def tell_one(h: SimpleNamespace, less: float) -> Unseen:
        return Unseen.together([Unseen(misfit[h.name] ** 2, 1, -misfit[h.name] - less, heat)])

    def tell(all_of: list[SimpleNamespace], jobs: int) -> list[Unseen]:
        return [tell_one(h, 3.0 * bool({*h.name} & {"d", "r", "s"})) for h in all_of]

    def tell_beside(h: SimpleNamespace, jobs: int, heats: tuple[Any, ...]) -> Unseen:
        assert heats == (heat,)
        return tell_one(h, 3.0 * ("s" in h.name))

    monkeypatch.setattr(backward_elimination, "tell_all_unseen", tell)
    monkeypatch.setattr(backward_elimination, "tell_unseen", tell_beside)
    monkeypatch.setattr(backward_elimination, "build_surrogate", lambda h: h)
    without = lambda before, now, out: hypothesis(now.name.replace(out, ""))  # noqa: E731
    monkeypatch.setattr(backward_elimination, "_without", without)
    for names, left, gains, explained in (
        ("ab", "a", (1.0,), 16 / 24),
        ("a", "a", (1.0,), 16 / 24),
        ("c", "", (), 0.0),
        ("d", "", (), 0.0),
        ("r", "r", (1.0,), 9 / 24),
        ("s", "", (), 0.0),
        ("ar", "ar", (1.0, 2.0), 21 / 24),
    ):
        before, now = hypothesis(""), hypothesis(names)
        told = backward_elimination._keep_what_predicts(before, now, (1.0, 2.0)[: len(names)], 1)  # type: ignore[arg-type]
        assert (told[0].name, told[1], told[2]) == (left, gains, pytest.approx(explained))  # type: ignore[attr-defined]


def test_what_does_not_hold_at_the_end_goes_and_the_rest_is_judged_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Evidence by what is left in: taking one out may lift what another adds above what chance gives, or below it."""
    evidence = {"": 0.0, "a": 3.0, "b": 30.0, "ab": 35.0, "c": 2.0, "bc": 60.0, "abc": 66.0, "ac": 30.0}

    class Name(str):
        is_steady = False

    def hypothesis(names: str) -> SimpleNamespace:
        return SimpleNamespace(
            found=tuple(map(Name, names)),
            evidence=evidence[names],
            values={},
            case=None,
            chi=(3.4 if "B" in names or names == "p" else 1.0) * 0.9 ** len(names.replace("e", "")),
            offset_pull=0.0,
        )

    def chosen(names: str, of_one_half: str = "") -> SimpleNamespace:
        """What was chosen; of_one_half: findings that other runs speak against."""
        test = {
            name: SimpleNamespace(speaks_against=name in of_one_half, shows_again=name not in of_one_half)
            for name in names
        }
        return SimpleNamespace(best=hypothesis(names), threshold=12.0, unseen_of=test.get, step_of=names.index)

    evidence |= {"d": 1.0, "bd": 80.0}
    evidence |= {"e": 1.0, "be": 90.0}  # e adds much to b by evidence, and takes nothing off the misfit
    evidence |= {"p": 30.0, "q": 1.0, "pq": 80.0}  # p alone leaves much, and q all but nothing of it
    beside_heat = {"bd": 303.0}  # d adds 50 nats to b, and 3 where heat of any course stands beside both

    def find_rest(h: SimpleNamespace) -> SimpleNamespace:
        return SimpleNamespace(evidence=beside_heat.get("".join(h.found), 10 * h.evidence))

    monkeypatch.setattr(backward_elimination, "find_rest", find_rest)
    monkeypatch.setattr(
        backward_elimination,
        "_leave_out_briefly",
        lambda current, out: hypothesis("".join(current.found).replace(out, "")),
    )
    monkeypatch.setattr(backward_elimination, "finish_fit", lambda h: h)
    monkeypatch.setattr(backward_elimination, "reweight", lambda case, h: h)
    monkeypatch.setattr(backward_elimination, "estimate_noise", lambda case, h: case)
    monkeypatch.setattr(backward_elimination, "run_all", lambda work, items, jobs: [work(x) for x in items])
    expected = {
        "a": ("", ()), "ab": ("b", (30.0,)), "abc": ("bc", (58.0, 30.0)), "": ("", ()), "B": ("", ()),
        "bd": ("b", (30.0,)), "be": ("b", (30.0,)),
    }  # fmt: skip
    evidence["B"] = 40.0  # the capital leaves three times the noise: √80/3 is less than three standard errors
    for names, (left, gains) in expected.items():
        held, told = backward_elimination._eliminate_at_end(chosen(names), 1, True)  # type: ignore[arg-type]
        assert ("".join(held.found), told) == (left, gains), names  # type: ignore[arg-type]
    held, told = backward_elimination._eliminate_at_end(chosen("bd"), 1, False)  # type: ignore[arg-type]
    assert ("".join(held.found), told) == ("bd", (79.0, 50.0))  # type: ignore[arg-type]
    held, _ = backward_elimination._eliminate_at_end(chosen("bc", "c"), 1, True)  # type: ignore[arg-type]
    assert "".join(held.found) == "b"  # type: ignore[arg-type]
    held, _ = backward_elimination._eliminate_at_end(chosen("pq", "q"), 1, True)  # type: ignore[arg-type]
    assert "".join(held.found) == "pq"  # type: ignore[arg-type]
    held, _ = backward_elimination._eliminate_at_end(chosen("b", "b"), 1, True)  # type: ignore[arg-type]
    assert "".join(held.found) == "b"  # type: ignore[arg-type]


def test_paths_that_touch_the_best_one_are_fitted_whatever_their_score() -> None:
    """A strong path does what the linear score gives a weak one beside it."""
    h, begun = null(), list[Score]()
    skin = {"kind": "convection", "between": ["shelf", "air"], "conductance": "2 W/K"}
    shelf = h.machine.patched({"nodes": {"shelf": {"heat_capacity": "5 kJ/K"}}, "links": {"shelf skin": skin}})
    proposed = candidates(shelf, h.case.drivers, runs=h.case.runs)
    first = next(c for c in proposed if c.kind is Conduction and len(c.places) == 2)
    scores = tuple(Score(c, 0.0, 0.01, 1.0, np.empty(0)) for c in proposed if c is not first)
    best = replace(h, found=(first,))
    trials = trial_fits.TrialFits(h, h, (), begun.append, scores)  # type: ignore[arg-type]
    assert trials.around([best], 1).fits == ()
    assert [s.amplitude for s in begun] == [1.0] * len(begun)
    beside = {s.candidate.places for s in begun}
    links = {c.places for c in proposed if c.kind is Conduction}
    assert beside == {at for at in links if len(at) == 2 and len({*at} & {*first.places}) == 1}
    assert beside


def test_relays_are_looked_for_again_where_they_may_show(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside what leaves less than half of what was there, both under one noise, or where the last step found one."""

    def at(chi: float, switches: bool = False, noise: str = "null") -> SimpleNamespace:
        case = SimpleNamespace(noise=noise, sigma={})
        return SimpleNamespace(chi=chi, found=(SimpleNamespace(switches=switches),), case=case)

    def chosen(best: SimpleNamespace, *befores: SimpleNamespace) -> SimpleNamespace:
        return SimpleNamespace(best=best, befores=befores)

    monkeypatch.setattr(forward_selection, "reweight", lambda case, h: at(9.0, noise=case.noise))
    before, may_show = at(4.0), forward_selection._may_show_relays
    assert may_show(chosen(before)) and may_show(chosen(at(2.0), before))  # type: ignore[arg-type]
    assert not may_show(chosen(at(3.5), before))  # type: ignore[arg-type]
    assert may_show(chosen(at(3.5, switches=True), before))  # type: ignore[arg-type]
    assert may_show(chosen(at(3.5, noise="file"), before))  # type: ignore[arg-type]


def test_what_comes_late_goes_on_only_near_what_led_before() -> None:
    current, far, near = (SimpleNamespace(evidence=x) for x in (0.0, 500.0, 900.0))
    part = trial_fits.part_likely
    assert part(current, [near, far], 6, 0.7)[0] == [near, far], "two go on in any case"  # type: ignore[arg-type]
    assert part(current, [near, far], 6, 0.7, 1000.0)[0] == [near]  # type: ignore[arg-type]
    assert part(current, [near, far], 6, 0.7, 9000.0)[0] == []  # type: ignore[arg-type]
    assert part(current, [], 6, 0.7, 9000.0) == ([], [])  # type: ignore[arg-type]


def test_another_kind_in_the_place_of_the_first_finding_is_tried_beside_the_later_ones() -> None:
    """A floor under the housing was told as a mass there before the friction of the spindle was found."""
    known = plant()
    truth = known.patched(
        {
            "nodes": {"floor": {"temperature": "17 degC"}},
            "links": {"feet": {"kind": "conduction", "between": ["housing", "floor"], "conductance": "12 W/K"}},
            "sources": {"pump": {"kind": "heat_source", "into": {"column": 1}, "power": "40 W", "with": "always"}},
        }
    )
    case = Case(known, tuple(recorded(truth, ladder, i) for i, ladder in enumerate(LADDERS)))
    bare_machine = fit_hypothesis(case, known)
    able = candidates(known, case.drivers, runs=case.runs)
    mass = next(c for c in able if c.kind.kind == "hidden_mass" and c.places == ("housing",))
    pump = next(c for c in able if c.kind.kind == "heat_source" and c.places == ("column",))
    wrong = fit_findings(case, known, (mass, pump), {**bare_machine.values, **mass.usual, **pump.usual})
    assert wrong is not None
    there = [c for c, _ in first_rivals._list_there(wrong, {mass.key}, 1)]
    assert there[0].kind.kind == "foundation" and all(c.parts == mass.parts and c.key != mass.key for c in there)
    steps = ((replace(wrong, found=(mass,)),), (wrong,))
    now = Selection(wrong, (bare_machine, wrong), steps, (50.0, 50.0))
    told = first_rivals.rerank_first(now, 1)
    assert [c.kind.kind for c in told.best.found] == ["foundation", "heat_source"]
    assert told.steps[0][0].found[-1].kind.kind == "foundation" and told.steps[0][1] is steps[0][0]
    lead = told.steps[0][0].weighed - steps[0][0].weighed
    assert lead == pytest.approx(told.best.evidence - wrong.evidence) and told.best.evidence > wrong.evidence


@pytest.mark.parametrize("alone, together, told", [("", "ab", "ab"), ("", "", ""), ("a", "ab", "a")])
def test_findings_that_hold_only_together_are_not_taken_apart(
    alone: str, together: str, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def keep(null: object, now: object, jobs: int, is_apart: bool = True) -> SimpleNamespace:
        return SimpleNamespace(best=SimpleNamespace(found=tuple(alone if is_apart else together)))

    monkeypatch.setattr(backward_elimination, "_keep_what_holds", keep)
    now = SimpleNamespace(best=SimpleNamespace(found=("a", "b")))
    assert "".join(backward_elimination.check_selection(None, now, 1).best.found) == told  # type: ignore[arg-type]


def test_a_kind_that_takes_the_place_of_another_may_lack_numbers_of_it() -> None:
    """A skin told by coefficient and area: a fan in its place knows a conductance only."""
    skin = {"kind": "convection", "between": ["column", "air"], "coefficient": "6 W/(m^2 K) ± 30 %", "area": "0.8 m^2"}
    known = plant(links={"column skin": skin})
    h = fit_hypothesis(Case(known, (recorded(plant(), LADDERS[0], 0),)), known)
    fans = [c for c in candidates(h.machine, h.case.drivers) if c.patch.get("links", {}).get("column skin")]
    assert fans and any("links.column skin.coefficient" in h.values for _ in fans)
    told = respond_to_candidates([(c, h.values) for c in fans], h.fit.problem.data, h.predictions)
    assert len(told) == len(fans)


def test_runs_that_break_down_end_a_search_and_not_the_diagnosis() -> None:
    h = null()
    found = Search(h.case, h.case, None, h, None, h, Selection(h), Screening(h))  # type: ignore[arg-type]

    def breaks(*known: Search) -> Iterator[Search]:
        yield from known
        raise Failed("a relay switched 428 times by 8151 s")

    assert last_of(breaks(found), TimeBudget()).ended == "broken"
    with pytest.raises(Failed, match="428 times"):
        last_of(breaks(), TimeBudget())


def test_where_the_file_s_own_numbers_break_down_nothing_is_screened_about_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def breaks(*_: object) -> None:
        raise Failed("a relay switched 428 times by 8151 s")

    h = null()
    monkeypatch.setattr(hypothesis_fit, "linearise", breaks)
    assert refit._about_file(h, candidates(h.machine, h.machine.inputs), 1) == []
    monkeypatch.setattr(unseen_runs, "linearise", breaks)
    assert unseen_runs.unseen_misfit(h) == np.inf


@pytest.mark.parametrize("error", [2.0, 0.0])
def test_constants_of_runs_left_out_do_not_take_up_what_is_missing(error: float) -> None:
    """Beside much that noise does not explain, a sensor said to be 2 K off tells runs left out better where it is, and
    worse where it is not: readings that are told no better than that do not tell a constant error either."""
    sharp = plant(sensors={name: {**body, "noise": "0.001 K"} for name, body in SENSORS.items()})
    truth = plant(sources={"pump": {"kind": "heat_source", "into": {"column": 1}, "power": "60 W"}})
    runs = [recorded(truth, ladder, i) for i, ladder in enumerate(LADDERS)]
    pairs = [(run, run.columns["T_spindle"]) for run in runs]
    read = tuple(replace(r, columns={**r.columns, c.name: replace(c, values=c.values + error)}) for r, c in pairs)
    off = {**sharp.sensors["T_spindle"].to_plain(), "effects": [{"kind": "sensor_offset", "offset": "2 K"}]}
    machines = sharp.patched({"sensors": {"T_spindle": off}}), sharp
    with_it, without = (unseen_runs.unseen_misfit(fit_hypothesis(Case(m, read), m)) for m in machines)
    assert (with_it < without) is (error > 0)
