"""The proof's own truth against closed solutions, its cases and their seals."""

from __future__ import annotations

import ast
import json
from collections import Counter
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from proof import cases, flagship, programs
from proof.assembly import Assembly, add_part, assemble
from proof.cases import make_cases
from proof.drawn import drawn_machine
from proof.effect import Effect, Setting
from proof.effects_odd import SteepJoint
from proof.effects_room import feed_at
from proof.laws import air_drag, blown, vogel
from proof.layout import Layout, Part
from proof.observing import ROUGH, disturbed, observe, record, track_of
from proof.places_for import usual_sites
from proof.plan import CHEAP, EACH, EFFECTS, FIRST, LAYOUTS, NULLS, OUTSIDE, SENSORS, TWO, classes, slot
from proof.programs import Program
from proof.running import Run
from proof.scattered import FEATURES, scattered
from proof.sealed import Broken, opened
from proof.system import Array, Loss, Relay, System
from proof.written import machine_text
from scipy.integrate import trapezoid

from network import Machine, Recording, simulate

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
    program = programs.programs(np.random.default_rng(0), layout.top_speed, layout.reference)[0]
    build = assemble(layout, layout.nominal(), fine=True)
    assert all(len(cells) >= 8 for cells in build.cells.values())
    usual, short = (observe(build, program, {}, program.times(60), step) for step in (5.0, 2.5))
    for name, sigma in layout.channels().items():
        assert np.abs(usual[name] - short[name]).max() < 0.01 * sigma


# -- effects ----------------------------------------------------------------------------------------------------------
def laid_out() -> list[Layout]:
    """The machines drawn by hand, and two that nobody drew, with every site."""
    rng = np.random.default_rng(0)
    odd = [scattered(rng, parts, ("loop", "fan", "seat", "feed")) for parts in (4, 9)]
    return [usual_sites(rng, layout) for layout in (*LAYOUTS.values(), *odd)]


def every_effect() -> list[type[Effect]]:
    return sorted({*EFFECTS, *SENSORS, *OUTSIDE, *(kind for pair in TWO for kind in pair)}, key=lambda kind: kind.name)


@pytest.mark.parametrize("kind", every_effect(), ids=lambda kind: kind.name)
def test_every_effect_shows_at_every_site_and_names_places_of_the_machine(kind: type[Effect]) -> None:
    rng, tried = np.random.default_rng(1), 0
    for whole in laid_out():
        for at in whole.sites.get(kind.site, ())[:3]:
            layout, tried = kind.without(whole, at), tried + 1
            known = {*layout.parts, *layout.held, *layout.sensors, *layout.sensors.values()}
            setting = Setting(layout, dict.fromkeys(layout.parts, layout.reference + 1), hard=True, fine=True)
            effect = kind.draw(setting, at, rng)
            without, seen = (all_shown(layout, effects) for effects in ([], [effect]))
            most = max(np.abs(seen[c] - without[c]).max() / channel_noise(layout, c) for c in without)
            assert most > 1, (layout.name, at)
            assert all(set(group) <= known for group in effect.places())
            assert all(0 <= a < b for i in range(3) for a, b in effect.acts(program_of(layout), i))
    assert tried, "no machine has a site for it"


def channel_noise(layout: Layout, of: str) -> float:
    return layout.channels()[of.partition(" ")[0]]


def program_of(layout: Layout) -> Program:
    edges, speeds = (0.0, 2600.0, 7003.3), (0.9, 0.25, 0.6)
    top = layout.top_speed
    return Program(3 * HOUR, edges, tuple(share * top for share in speeds), layout.reference, (), (9.0, 0.0, 15.0))


def all_shown(layout: Layout, effects: list[Effect]) -> dict[str, Array]:
    """What the channels show in three recordings: some effects come in one of them only."""
    program, told = program_of(layout), {}
    for index in range(3):
        build = assemble(layout, layout.nominal())
        for effect in effects:
            effect.conceal(build, program, index)
        values = observe(build, program, {"head": layout.reference + 3}, program.times(60), 60.0)
        told |= {f"{name} in run {index}": x for name, x in values.items()}
    return told


@pytest.mark.parametrize("kind", OUTSIDE, ids=lambda kind: kind.name)
def test_what_is_outside_the_catalogue_tells_the_course_of_its_heat(kind: type[Effect]) -> None:
    """C dT/dt of an insulated mass without anything else is that heat; a joint has none of its own."""
    layout = usual_sites(np.random.default_rng(0), LAYOUTS["mill"])
    at = layout.sites[kind.site][0]
    program = replace(program_of(layout), mean=layout.reference - 5)
    effect = kind.draw(Setting(layout, dict.fromkeys(layout.parts, 21.0)), at, np.random.default_rng(3))
    bare = replace(layout, joints={}, heats={}, growths={}, sensors={}, held={"ambient": None})
    build = assemble(bare, {path: 0.0 for path, _, _ in bare.uncertain()})
    if effect.course(np.zeros(2), np.zeros(2), program, 0) is None:
        assert kind is SteepJoint
        return
    effect.conceal(build, program, 0)
    cell = build.cells[str(at).partition("@")[0]][0]
    times = np.arange(0, program.duration + 1, 30.0)
    T = track_of(build, program, {}, 5.0).at(times, np.eye(len(build.capacity)))[:, cell]
    heat = effect.course(T, times, program, 0)
    absorbed = build.capacity[cell] * (T[-1] - T[0])
    assert heat is not None and absorbed == pytest.approx(trapezoid(heat, times), rel=0.03, abs=300)


def test_coloured_noise_has_its_variance_and_memory() -> None:
    noise = disturbed(np.random.default_rng(0), np.zeros(40_000), 1.0, ROUGH, 0.0)
    assert noise.std() == pytest.approx(1, abs=0.03)
    assert np.corrcoef(noise[:-1], noise[1:])[0, 1] == pytest.approx(0.5 * np.exp(-10 / 90), abs=0.03)


# -- the plan, the cases and their seals ------------------------------------------------------------------------------
def test_a_whole_proof_holds_sixty_of_every_class() -> None:
    assert Counter(classes(200)) == FIRST and FIRST["innocent"] == FIRST["effect"] == EACH
    assert Counter(classes(300)) == dict.fromkeys(FIRST, EACH)
    assert classes(200)[:40] == classes(40) and set(classes(40)) == set(FIRST)


def test_every_effect_every_tier_and_every_kind_of_machine_comes_up() -> None:
    plan = [slot(234, index) for index in range(300)]
    assert {effect for each in plan for effect in each.effects} >= {*EFFECTS, *SENSORS, *OUTSIDE}
    assert {each.what for each in plan if each.group == "innocent"} == set(NULLS)
    for group in FIRST:
        assert {each.truth for each in plan if each.group == group} == {"lumped", "fine", "hard"}
        assert {each.runs for each in plan if each.group == group} == {1, 3, 6}
        assert {each.room for each in plan if each.group == group} == {"recorded", "stated"}
    sizes = [len(each.layout.parts) for each in plan]
    assert min(sizes) == 3 and max(sizes) > 30 and max(sizes[:CHEAP]) <= 8
    kinds = {joint.kind for each in plan for joint in each.layout.joints.values()}
    assert kinds == {"conduction", "convection", "radiation", "natural_convection", "forced_convection"}
    assert all(any(getattr(each.layout, has) for each in plan) for has in ("streams", "coolers", "seats", "feeds"))
    assert {each.layout.name for each in plan} > set(LAYOUTS)


def test_a_case_depends_on_its_number_and_the_seed_alone() -> None:
    assert slot(5, 17) == slot(5, 17) and slot(5, 17) != slot(6, 17)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three cases of short recordings."""
    folder = tmp_path_factory.mktemp("proof")
    make_short(folder, 3, 7)
    return folder


def make_short(folder: Path, count: int, seed: int, jobs: int = 1) -> list[str]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(programs, "HOURS", {runs: (0.5,) * (runs + 1) for runs in (1, 3, 6)})
        return make_cases(folder, count, seed, jobs)


@pytest.mark.parametrize(("left", "told"), [([0.5, 1e50, 2.0, 9.0], 2.0), ([1e50, 0.5] * 4, 0.5), ([1e50] * 8, 1e50)])
def test_a_truth_that_runs_away_is_drawn_again(left: list[float], told: float, monkeypatch: pytest.MonkeyPatch) -> None:
    tried: Any = iter(left)
    monkeypatch.setattr(cases, "site", lambda *of: "somewhere")
    monkeypatch.setattr(cases, "sized", lambda rng, on, effect: next(tried))
    monkeypatch.setattr(cases, "seen", lambda on, effects: {"after_calibration": effects[0]})
    any_of_it: Any = SimpleNamespace(layout=None, draw=lambda *of: None)
    assert cases.visible(any_of_it, any_of_it, any_of_it, any_of_it) == told  # type: ignore[comparison-overlap]


def test_a_place_where_a_truth_runs_away_is_not_the_most_visible() -> None:
    assert max([0.5, 1e50, 2.0], key=cases.rank_of) == 2.0 and not cases.is_shown(1e50) and cases.is_shown(2.0)


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


@pytest.mark.parametrize("number", range(10))
def test_the_product_agrees_with_the_truth_where_nothing_is_concealed(number: int, tmp_path: Path) -> None:
    """Two codes on the same network, one cell each: within a tenth of a sensor's noise, displacements too."""
    features = (("loop",), ("radiation",), ("buoyancy",), ("fan", "seat"), ("feed", "loop"), tuple(FEATURES))
    rng = np.random.default_rng([77, number])
    odd = [scattered(rng, 3 + number, features[number % len(features)])]
    layout = [*LAYOUTS.values(), *odd * 6][number]
    (tmp_path / "machine.yaml").write_text(machine_text(layout, layout.nominal()), encoding="utf-8")
    machine = Machine.load(tmp_path / "machine.yaml", sets=rounded(layout))
    program = replace(program_of(layout), duration=1.5 * HOUR, edges=(0.0, 1200.0, 3600.0))
    times = program.times()
    told = observe(assemble(layout, layout.nominal()), program, {}, times, 2.5)
    record(rng, program, times, told, layout.channels(), feed=feed_at(program, times))
    recording = record(rng, program, times, told, layout.channels(), feed=feed_at(program, times))
    (tmp_path / "run.csv").write_text(recording.text(), encoding="utf-8")
    run = simulate(machine, Recording.load(tmp_path / "run.csv"))
    for name, sigma in layout.channels().items():
        assert np.abs(run.shown(name) - told[name]).max() < 0.1 * sigma, (layout.name, name)


def rounded(layout: Layout) -> list[str]:
    """The numbers as they are: a file has three digits of them."""
    units = {"torque": "N m", "copper": "W", "iron": "W", "power": "W", "power_per_feed": "W/(m/min)", "gain": "",
             "heat_capacity": "J/K", "extra_heat_capacity": "J/K", "capacity_flow": "W/K", "conductance": "W/K",
             "coefficient": "W/(m^2 K^1.25)", "emissivity_area": "m^2"}  # fmt: skip
    return [f"{path}={value:.12g} {units[path.rpartition('.')[2]]}".strip() for path, value in layout.nominal().items()]


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


def test_tracks_start_where_parts_do() -> None:
    layout = LAYOUTS["mill"]
    track = track_of(assemble(layout, layout.nominal()), still(0.1), {"head": 25.0})
    begins = track.at(np.zeros(1), np.eye(len(layout.parts)))[0]
    assert begins[list(layout.parts).index("head")] == pytest.approx(25, abs=1e-9)
