"""The proof's own truth against closed solutions, its seals, and its scorer on answers made by hand."""

from __future__ import annotations

import ast
import json
import sys
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from proof import cases, flagship, programs
from proof.assembly import Assembly, add_part, assemble
from proof.cases import concealed, make_cases
from proof.drawn import drawn_machine
from proof.effect import Effect, Setting
from proof.effects_heat import RunIn, WashBursts
from proof.judging import Judgement, judge
from proof.laws import air_drag, blown, vogel
from proof.layout import Layout, Part
from proof.observing import ROUGH, disturbed, observe, track_of
from proof.plan import DOUBLES, LAYOUTS, NULLS, RESERVED, SHARES, SINGLES, apportioned, slots
from proof.programs import Program, four_programs
from proof.running import Run
from proof.score import Rate, Score, answer, score
from proof.sealed import Broken, opened
from proof.system import Array, Loss, Relay, System
from proof.written import machine_text

from network import proving
from network.cli import main
from network.refusal import Refused

PROOF = Path(__file__).parent / "proof"
HOUR = 3600.0


def still(hours: float, rpm: float = 0.0, air: float = 20.0) -> Program:
    return Program(hours * HOUR, (0.0,), (rpm,), air)


def one_mass(**more: Any) -> System:
    """2 kJ/K behind 5 W/K in air."""
    G = np.array([5.0])
    return System(np.array([2000.0]), np.diag(G), {"ambient": G}, {}, **more)


# -- the truth --------------------------------------------------------------------------------------------------------
def test_it_imports_nothing_of_the_product() -> None:
    for path in PROOF.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert all(name.partition(".")[0] not in ("network", "lptn") for name in names), path.name


def test_a_mass_cools_as_an_exponential() -> None:
    track = Run(one_mass(), still(1), np.array([50.0])).go()
    times = np.linspace(0, HOUR, 50)
    expected = 20 + 30 * np.exp(-times * 5 / 2000)
    np.testing.assert_allclose(track.at(times, np.eye(1))[:, 0], expected, atol=1e-4)


def test_the_method_is_of_second_order_and_what_lies_between_its_steps_too() -> None:
    times = np.linspace(0, HOUR, 97)
    expected = 20 + 30 * np.exp(-times * 5 / 2000)
    errors = [
        np.abs(Run(one_mass(), still(1), np.array([50.0]), h).go().at(times, np.eye(1))[:, 0] - expected).max()
        for h in (60.0, 30.0, 15.0)
    ]
    orders = [np.log2(a / b) for a, b in pairwise(errors)]
    assert all(1.8 < order < 2.3 for order in orders), orders


def bar(cells: int) -> Assembly:
    """An insulated steel bar of 0.3 m."""
    portal = LAYOUTS["portal"]
    parts = {"bar": Part("shaft_steel", 0.3, 50e-4)}
    layout = Layout("bar", "bar", 20.0, 1.0, portal.materials, parts, {}, {}, {}, {}, {}, {})
    build = Assembly(layout, {}, {"bar": cells})
    add_part(build, "bar")
    return build


def bar_error(cells: int) -> float:
    """Against T = 20 + 10 cos(πx/L) e^(−a π² t/L²), the slowest mode of an insulated bar, after 10 minutes."""
    build = bar(cells)
    x = (np.arange(cells) + 0.5) / cells
    system = build.freeze()
    track = Run(system, still(1 / 6), 20 + 10 * np.cos(np.pi * x), 1.0).go()
    steel = build.layout.materials["shaft_steel"]
    decay = steel.conductivity / steel.density / steel.specific_heat * (np.pi / 0.3) ** 2
    expected = 20 + 10 * np.cos(np.pi * x) * np.exp(-decay * 600)
    return float(np.abs(track.at(np.array([600.0]), np.eye(cells))[0] - expected).max())


def test_an_insulated_bar_follows_its_slowest_mode_better_the_finer_it_is_cut() -> None:
    coarse, fine = bar_error(10), bar_error(20)
    assert fine < 0.01 and np.log2(coarse / fine) == pytest.approx(2, abs=0.1)


def test_a_closed_machine_keeps_its_heat_and_takes_up_what_it_is_given() -> None:
    build = bar(16)
    build.add("block", 5000.0)
    build.join("bar@0.2..0.55", "block", 12.0)
    build.losses["heater"] = (build.at("bar@0..0.3"), lambda rpm: 80.0)
    start = 20 + np.random.default_rng(0).uniform(0, 10, 17)
    end = Run(build.freeze(), still(1), start).go().at(np.array([HOUR]), np.eye(17))[0]
    taken = float(np.array(build.capacity) @ (end - start))
    assert taken == pytest.approx(80 * HOUR, rel=1e-10)


def test_every_layout_pays_out_what_it_takes_in() -> None:
    """Settled after 400 h at half speed: losses = Σ G (T − T_held), and everything that is stored has been stored."""
    for layout in LAYOUTS.values():
        build = assemble(layout, layout.nominal())
        system, rpm = build.freeze(), layout.top_speed / 2
        n = len(build.capacity)
        T = Run(system, still(400, rpm), np.full(n, 20.0), 600.0).go().at(np.array([400 * HOUR]), np.eye(n))[0]
        into = sum(float(loss.into.sum()) * loss.power(rpm) for loss in system.losses)
        held = {"ambient": 20.0, **system.temperature}
        out = sum(float(G @ (T - held[name])) for name, G in system.held.items())
        assert out == pytest.approx(into, rel=1e-6), layout.name


def test_a_relay_switches_where_its_saw_tooth_says() -> None:
    """An insulated tank with 400 W in and 1000 W out: up in 2 h C/400, down in 2 h C/600."""
    C, half = 50e3, 0.5
    whole = np.ones(1)
    relay = Relay(whole, whole, 1000.0, 20 + half, 20 - half)
    losses = (Loss(whole, lambda rpm: 400.0),)
    system = System(np.array([C]), np.zeros((1, 1)), {"ambient": np.zeros(1)}, {}, losses=losses, relays=(relay,))
    switches = Run(system, still(1), np.array([20 + half - 1e-9]), 37.0).go().switches
    spans = np.diff([t for t, _, _ in switches])
    np.testing.assert_allclose(spans[0::2], 2 * half * C / 600, rtol=1e-9)
    np.testing.assert_allclose(spans[1::2], 2 * half * C / 400, rtol=1e-9)


def test_a_relay_answers_after_its_delay() -> None:
    whole = np.ones(1)
    relay = Relay(whole, whole, 1000.0, 21.0, 20.0, delay=30.0)
    losses = (Loss(whole, lambda rpm: 400.0),)
    system = System(np.array([5e4]), np.zeros((1, 1)), {"ambient": np.zeros(1)}, {}, losses=losses, relays=(relay,))
    (first, _, on), *_ = Run(system, still(1), np.array([20.0])).go().switches
    assert on and first == pytest.approx(5e4 / 400 + 30)


def test_the_laws_are_what_they_are_called() -> None:
    assert vogel(20, 20, 1) == 1 and vogel(30, 20, 1) == pytest.approx(0.745, abs=0.001)
    assert blown(0, 3) == 1 and blown(1, 3) == 4 and 2 < blown(0.5, 3) < 3.2
    assert air_drag(1, 100) == pytest.approx(100) and 100 / air_drag(0.5, 100) == pytest.approx(6.98, abs=0.01)
    assert air_drag(0, 100) == 0


def test_truth_is_fast_and_its_steps_are_short_enough() -> None:
    layout = LAYOUTS["lathe"]
    program = four_programs(np.random.default_rng(0), layout.top_speed, layout.reference)[0]
    build = assemble(layout, layout.nominal(), fine=True)
    assert all(len(cells) >= 8 for cells in build.cells.values())
    usual, short = (observe(build, program, {}, program.times(60), step) for step in (5.0, 2.5))
    for name, sigma in layout.channels().items():
        assert np.abs(usual[name] - short[name]).max() < 0.01 * sigma


# -- effects ----------------------------------------------------------------------------------------------------------
def every_effect() -> list[tuple[type[Effect], str, Any]]:
    kinds = [kind for choice in SINGLES.values() for kind in choice] + [RunIn, WashBursts]
    return [(kind, name, at) for kind in kinds for name, x in LAYOUTS.items() for at in x.sites.get(kind.site, ())]


@pytest.mark.parametrize("kind", sorted({kind for kind, _, _ in every_effect()}, key=lambda kind: kind.name))
def test_every_effect_shows_at_every_site_and_names_places_of_the_machine(kind: type[Effect]) -> None:
    rng = np.random.default_rng(1)
    for _, name, at in (each for each in every_effect() if each[0] is kind):
        layout = LAYOUTS[name]
        known = {*layout.parts, *layout.held, *layout.sensors, *layout.sensors.values()}
        setting = Setting(layout, dict.fromkeys(layout.parts, layout.reference + 1), hard=True, fine=True)
        effect = kind.draw(setting, at, rng)
        program = Program(3 * HOUR, (0.0, 7003.3), (0.9 * layout.top_speed, 0.6 * layout.top_speed), layout.reference)
        without, seen = (shown(layout, program, effects) for effects in ([], [effect]))
        assert max(np.abs(seen[c] - without[c]).max() / s for c, s in layout.channels().items()) > 1, (name, at)
        assert all(set(group) <= known for group in effect.places())


def shown(layout: Layout, program: Program, effects: list[Effect]) -> dict[str, Array]:
    build = concealed(layout, layout.nominal(), False, program, effects, 0)
    return observe(build, program, {}, program.times(60), 60.0)


def test_coloured_noise_has_its_variance_and_memory() -> None:
    noise = disturbed(np.random.default_rng(0), np.zeros(40_000), 1.0, ROUGH, 0.0)
    assert noise.std() == pytest.approx(1, abs=0.03)
    assert np.corrcoef(noise[:-1], noise[1:])[0, 1] == pytest.approx(0.5 * np.exp(-10 / 90), abs=0.03)


# -- the plan, the cases and their seals ------------------------------------------------------------------------------
def test_forty_cases_are_mixed_as_planned() -> None:
    assert sum(SHARES.values()) == 40 and {*SINGLES, *NULLS, "two", "outside"} == set(SHARES)
    assert {kind for pair in DOUBLES for kind in pair} <= set(SINGLES)
    classes = apportioned(40)
    assert {what: classes.count(what) for what in SHARES} == SHARES
    plan = slots(40, np.random.default_rng(3))
    share = sum(slot.layout.name == RESERVED for slot in plan) / 40
    assert 0.05 < share < 0.2 and {slot.truth for slot in plan} == {"lumped", "fine", "hard"}
    assert all(slot.layout.name != RESERVED for slot in slots(40, np.random.default_rng(3), reserved=False))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three cases of short recordings."""
    folder = tmp_path_factory.mktemp("proof")
    make_short(folder, 3, 7)
    return folder


def make_short(folder: Path, count: int, seed: int, jobs: int = 1) -> list[str]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(programs, "HOURS", (0.5, 0.5, 0.5, 0.5))
        return make_cases(folder, count, seed, jobs)


def test_the_same_seed_makes_the_same_cases_and_another_does_not(made: Path, tmp_path: Path) -> None:
    assert make_short(tmp_path / "again", 3, 7) == ["case-001", "case-002", "case-003"]
    for path in sorted(made.rglob("*.*")):
        assert path.read_bytes() == (tmp_path / "again" / path.relative_to(made)).read_bytes(), path.name
    make_short(tmp_path / "other", 1, 8)
    for name in ("machine.yaml", "train1.csv", "holdout.csv"):
        assert (made / "case-001" / name).read_text() != (tmp_path / "other" / "case-001" / name).read_text()


def test_a_key_that_was_changed_is_not_opened(made: Path, tmp_path: Path) -> None:
    key = opened(made, "case-001")
    assert len(key["salt"]) == 32 and len(key["kinds"]) == len(key["places"])
    published = json.loads((made / "cases.json").read_text())["cases"]["case-001"]
    (tmp_path / "cases.json").write_text(json.dumps({"cases": {"case-001": published}}))
    (tmp_path / "keys").mkdir()
    (tmp_path / "keys" / "case-001.json").write_text(json.dumps({**key, "kinds": [["windage"]]}))
    with pytest.raises(Broken, match="case-001"):
        opened(tmp_path, "case-001")


@pytest.mark.parametrize("name", LAYOUTS)
def test_the_product_accepts_every_machine_file(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "machine.yaml"
    path.write_text(machine_text(LAYOUTS[name], LAYOUTS[name].nominal()), encoding="utf-8")
    main(["check", str(path)])
    assert not capsys.readouterr().err


def test_drawn_machines_have_as_many_numbers_as_they_say() -> None:
    for seed in range(5):
        drawn = drawn_machine(np.random.default_rng(seed), runs=1, hours=1.0)
        assert 8 <= len(drawn.true) <= 12 and drawn.machine.count("±") == len(drawn.true)
        assert set(np.diff(drawn.arrays[0]["time"])) == {10.0}


# -- the flagship -----------------------------------------------------------------------------------------------------
def test_the_flagship_is_what_its_generator_makes() -> None:
    for path, text in flagship.files().items():
        assert (flagship.ROOT / path).read_text(encoding="utf-8") == text, path
        assert len(text.encode()) < 200_000


def test_the_cooler_of_the_flagship_switches_faster_at_a_higher_speed() -> None:
    """By energy: a cycle is 2 h C (1/load + 1/(P − load)), and the load on the tank grows with speed."""
    periods = {}
    for rpm in (6000.0, 8000.0):
        program = still(4, rpm, 21.6)
        build = flagship.true_machine(program, 0)
        switches = track_of(build, program, {"coolant": 21.0}).switches
        periods[rpm] = np.diff([t for t, _, on in switches if on])[-1]
    assert 1200 < periods[8000] < 0.85 * periods[6000]


# -- the scorer -------------------------------------------------------------------------------------------------------
def key_of(kinds: Any, places: Any, what: str = "single") -> dict[str, Any]:
    return {"layout": "mill", "truth": "fine", "class": what, "kinds": kinds, "places": places,
            "in_noise": {"after_calibration": 2.0}}  # fmt: skip


def finding(kind: str, *places: str, confidence: float = 0.95, **more: Any) -> dict[str, Any]:
    return {"kind": kind, "places": list(places), "channels": [], "confidence": confidence, **more}


def told(*findings: Mapping[str, Any], verdict: str = "missing_physics", **more: Any) -> dict[str, Any]:
    fit = {"holdout": {"before": {"rmse_in_noise": 3.0}, "after": {"rmse_in_noise": 1.2}}}
    return {"verdict": verdict, "findings": list(findings), "fit": fit, "seconds": 12.0, **more}


PATH = key_of([["conduction"]], [[["sleeve"], ["ram"]]])
NOTHING = key_of([], [], "coarse")
BURSTS = key_of([["unknown"]], [[["table"]]], "outside")
TWO = key_of([["forced_convection"], ["tilt", "bending"]], [[["head"]], [["tcp.z", "dz"], ["head", "column"]]])


def outcome(key: Mapping[str, Any], answer: Mapping[str, Any] | None) -> Judgement:
    return judge("case", key, answer)


def test_a_path_needs_both_its_ends() -> None:
    right = outcome(PATH, told(finding("conduction", "ram@0.2..0.4", "sleeve")))
    assert right.named and right.placed and right.both and right.first and right.spurious == 0
    assert right.removed == pytest.approx(0.9) and right.seconds == 12 and not right.worse
    half = outcome(PATH, told(finding("conduction", "ram", "bed")))
    assert half.named and not half.placed and not half.both
    wrong = outcome(PATH, told(finding("contact", "ram", "sleeve")))
    assert wrong.placed and not wrong.named and wrong.sure_and_wrong and wrong.spurious == 1


def test_what_cannot_be_told_apart_counts_as_named() -> None:
    for alike in (["conduction"], [{"kind": "conduction", "places": []}]):
        assert outcome(PATH, told(finding("contact", "ram", "sleeve", indistinguishable=alike))).both


def test_the_right_name_second_is_named_but_not_first() -> None:
    judged = outcome(PATH, told(finding("windage", "rotor"), finding("conduction", "ram", "sleeve")))
    assert judged.named and judged.both and not judged.first and judged.spurious == 1
    finer = outcome(PATH, told(finding("lumping", "bed"), finding("conduction", "ram", "sleeve")))
    assert finer.first and finer.spurious == 0


def test_two_effects_need_two_findings() -> None:
    fan, tilt = finding("forced_convection", "head", "ambient"), finding("bending", "tcp.z", "head")
    assert outcome(TWO, told(tilt, fan)).both
    assert not outcome(TWO, told(fan)).named
    assert not outcome(TWO, told(finding("forced_convection", "head", indistinguishable=["tilt"]))).named


def test_channels_are_places_of_sensor_findings() -> None:
    key = key_of([["sensor_lag"]], [[["T_bed"]]])
    lag = {"kind": "sensor_lag", "places": [], "channels": ["T_bed"], "confidence": 0.8}
    assert outcome(key, told(lag, verdict="sensor_fault")).both


@pytest.mark.parametrize("verdict", ["adequate", "parameters_only", "too_coarse"])
def test_innocents_may_be_called_coarse_but_not_accused(verdict: str) -> None:
    assert not outcome(NOTHING, told(finding("lumping", "bed"), verdict=verdict)).accused
    assert outcome(NOTHING, told(finding("radiation", "bed"), verdict=verdict)).accused
    assert outcome(NOTHING, told(verdict="unexplained")).accused


def test_what_lies_outside_may_be_called_unexplained_or_unknown() -> None:
    assert outcome(BURSTS, told(finding("unknown", "table"))).both
    located = {"nodes": [{"name": "table", "probability": 0.9}, {"name": "bed", "probability": 0.1}]}
    unexplained = outcome(BURSTS, told(verdict="unexplained", located=located))
    assert unexplained.named and unexplained.placed and unexplained.first
    guessed = outcome(BURSTS, told(finding("timed_source", "table")))
    assert not guessed.named and guessed.spurious == 1 and guessed.sure_and_wrong


def test_no_answer_is_a_miss() -> None:
    missed = outcome(PATH, None)
    assert not missed.named and not missed.answered and missed.answer == "no answer"
    assert not outcome(NOTHING, None).accused


def test_rates_and_table_say_what_was_judged() -> None:
    both = told(finding("conduction", "ram", "sleeve"), finding("radiation", "bed"))
    answers = [(PATH, both), (PATH, None), (NOTHING, told(verdict="adequate")),
               (NOTHING, told(finding("windage", "rotor"))), (BURSTS, told(verdict="unexplained"))]  # fmt: skip
    total = Score(tuple(outcome(*each) for each in answers))
    rates = total.rates
    assert (rates["right name"].hits, rates["right name"].of) == (1, 2)
    assert (rates["something else named besides"].hits, rates["something else named besides"].of) == (1, 2)
    assert (rates["innocents accused"].hits, rates["innocents accused"].of) == (1, 2)
    assert (rates["outside called unknown"].hits, rates["outside placed right"].hits) == (1, 0)
    assert rates["no answer"].hits == 1 and total.removed == pytest.approx(0.9)
    assert total.confusion["conduction", "conduction + radiation"] == 1 and total.confusion["coarse", "windage"] == 1
    text = str(total)
    assert "5 cases: 2 with effects" in text and "nothing (coarse)" in text and "3.00 → 1.20" in text


def test_wilson_bounds_are_those_of_the_book() -> None:
    """0 of 30: 11.4 % at the most; 15 of 20: 53 to 89 %."""
    assert Rate(0, 30).bound(1) == pytest.approx(0.1135, abs=1e-3)
    assert (Rate(15, 20).bound(-1), Rate(15, 20).bound(1)) == pytest.approx((0.531, 0.888), abs=1e-3)
    assert (Rate(0, 0).bound(-1), Rate(0, 0).bound(1)) == (0, 1)


def test_answers_are_read_beside_their_cases(made: Path) -> None:
    out = made / "case-001" / "out"
    assert answer(made / "case-001") is None and not any(each.answered for each in score(made).judgements)
    out.mkdir()
    (out / "diagnosis.json").write_text(json.dumps(told(verdict="adequate")))
    assert [each.answered for each in score(made, {"case-001": 3.0}).judgements] == [True, False, False]
    (out / "diagnosis.json").write_text("{")
    assert answer(made / "case-001") is None


# -- the command's part -----------------------------------------------------------------------------------------------
DIAGNOSE = """
import json, pathlib, sys, time
assert sys.argv[1:] == "diagnose machine.yaml train1.csv train2.csv train3.csv \\
--holdout holdout.csv -o out --no-plots --jobs 1 --seed 5".split()
name = pathlib.Path.cwd().name
pathlib.Path("out").mkdir()
pathlib.Path("out/diagnosis.json").write_text(json.dumps({"verdict": "adequate", "findings": []}))
if name == "case-002":
    time.sleep(60)
sys.exit(3 if name == "case-003" else 0)
"""


def test_prove_makes_runs_and_scores(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "diagnose.py").write_text(DIAGNOSE)
    monkeypatch.setattr(proving, "COMMAND", (sys.executable, str(tmp_path / "diagnose.py")))
    monkeypatch.setattr(proving.diagnose, "__defaults__", (1.0,))
    monkeypatch.setattr(cases, "make_cases", make_short)
    said: list[str] = []
    total = proving.prove(3, 5, 1, tmp_path / "cases", lambda *told: said.append("{}/{} {}".format(*told)))
    assert [each.answered for each in total.judgements] == [True, False, False]
    assert said[0].startswith("1/3 case-001: answered after") and "no answer in time" in said[1]
    assert "failed with status 3" in said[2]


def test_prove_is_refused_outside_a_clone_and_over_other_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "letter.txt").write_text("dear")
    with pytest.raises(Refused, match="something else"):
        proving.prove(1, 0, 1, tmp_path)
    monkeypatch.setattr(proving, "TESTS", tmp_path)
    with pytest.raises(Refused, match="clone the repository"):
        proving.prove(1, 0, 1, tmp_path / "new")


def test_tracks_start_where_parts_do() -> None:
    layout = LAYOUTS["mill"]
    track = track_of(assemble(layout, layout.nominal()), still(0.1), {"head": 25.0})
    assert track.at(np.zeros(1), np.eye(len(layout.parts)))[0][list(layout.parts).index("head")] == 25
