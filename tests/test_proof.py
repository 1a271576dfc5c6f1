"""The proof's own truth against closed solutions, its cases and their seals."""

from __future__ import annotations

import ast
import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from proof import flagship, programs
from proof.assembly import Assembly, add_part, assemble
from proof.cases import concealed, make_cases
from proof.drawn import drawn_machine
from proof.effect import Effect, Setting
from proof.effects_heat import RunIn, WashBursts
from proof.laws import air_drag, blown, vogel
from proof.layout import Layout, Part
from proof.observing import ROUGH, disturbed, observe, track_of
from proof.plan import DOUBLES, LAYOUTS, NULLS, RESERVED, SHARES, SINGLES, apportioned, slots
from proof.programs import Program, four_programs
from proof.running import Run
from proof.sealed import Broken, opened
from proof.system import Array, Loss, Relay, System
from proof.written import machine_text

from network.cli import main

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


def test_tracks_start_where_parts_do() -> None:
    layout = LAYOUTS["mill"]
    track = track_of(assemble(layout, layout.nominal()), still(0.1), {"head": 25.0})
    assert track.at(np.zeros(1), np.eye(len(layout.parts)))[0][list(layout.parts).index("head")] == 25
