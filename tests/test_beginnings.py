"""Where a fit ends hangs neither on where it began nor on the order of a file's entries."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import yaml
from bench.rigs.splits import RECORDINGS, ROOT
from measured import BLOCKS, blocks, recorded, steps

from network import Machine, Recording, calibrate
from network.analysis.calibration import multistart
from network.analysis.calibration.gauss_newton import make_problem, minimise
from network.analysis.calibration.linearised import Linearised
from network.analysis.calibration.measured_means import weigh_recording
from network.analysis.calibration.misfit import implausibility
from network.analysis.calibration.multistart import best_start, draw_beginnings, has_seen_enough
from network.analysis.diagnosis import diagnose, time_budget
from network.analysis.diagnosis.time_budget import BudgetReached, TimeBudget
from network.engine.response.parameters import free_parameters
from network.platform.refusal import Failed, Spot
from network.platform.yaml.document import Branch, tree_of

WIDE = {"joint": {"conductance": "unknown 0.1..50 W/K"}, "cold skin": {"conductance": "0.5 W/K ± 100 %"}}


def blocks_backwards() -> Machine:
    given: dict[str, Any] = {k: dict(reversed(v.items())) if isinstance(v, dict) else v for k, v in BLOCKS.items()}
    tree = tree_of(given, Spot("blocks"))
    assert isinstance(tree, Branch)
    return Machine.read(tree, "blocks")


def test_draws_go_by_path_and_not_by_order() -> None:
    forwards, backwards = ([*free_parameters(m)] for m in (blocks(), blocks_backwards()))
    paths = [p.path for p in forwards]
    again = [[p.path for p in backwards].index(path) for path in paths]
    assert again != sorted(again)
    for one, other in zip(draw_beginnings(forwards, 3), draw_beginnings(backwards, 3), strict=True):
        np.testing.assert_array_equal(one, other[again])
    first, second = (next(draw_beginnings(forwards, seed)) for seed in (3, 4))
    assert not np.any(first == second) and len(set(first.tolist())) == len(first)


def test_the_order_of_entries_leads_to_the_same_minimum() -> None:
    patch = {f"links.{name}.{key}": value for name, keys in WIDE.items() for key, value in keys.items()}
    recording = recorded(blocks().patched({"links.joint.conductance": "2.4 W/K"}), steps())
    one, other = (calibrate(m.patched(patch), recording) for m in (blocks(), blocks_backwards()))
    assert one.tried > 1 and one.tried == other.tried
    told = {p.path: x for p, x in zip(other.parameters, other.theta, strict=True)}
    for p, x, std in zip(one.parameters, one.theta, one.std, strict=True):
        assert told[p.path] == pytest.approx(x, abs=0.05 * std)


@pytest.mark.parametrize(("ends", "enough"), [([0], False), ([0, 0, 0], False), ([0, 0, 0, 0], True),
    ([0, 0, 1, 0, 0], False), ([0, 0, 1, 0, 0, 1], True), ([0, 1, 2, 3, 4, 5], True)])  # fmt: skip
def test_as_many_searches_as_minima_that_were_found_ask_for(
    ends: list[int], enough: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """w (w + 1)/(n (n − 1)) ≤ 0.2: 2/12 after four that ended alike, 6/30 after six that ended in two minima."""
    monkeypatch.setattr(multistart, "_are_apart", lambda one, other: one.end != other.end)
    assert has_seen_enough(cast(list[Linearised], [SimpleNamespace(end=e) for e in ends])) is enough


@pytest.mark.parametrize(
    ("wide", "enough", "fails", "tried"),
    [(True, False, 0, 4), (True, True, 0, 4), (False, False, 0, 4), (False, True, 0, 1), (False, True, 2, 3)],
)
def test_no_others_are_drawn_once_it_is_enough_but_where_priors_are_wide_or_none_came_to_an_end(
    wide: bool, enough: bool, fails: int, tried: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three more where all end alike; one that runs away is no end. What is left always asks for others here."""
    monkeypatch.setattr(multistart, "BAD", 0.0)
    keys = WIDE if wide else {"joint": {"conductance": "3 W/K ± 30 %"}}
    patch = {f"links.{name}.{key}": value for name, of in keys.items() for key, value in of.items()}
    machine = blocks().patched(patch)
    recording = recorded(blocks(), steps())
    problem = make_problem(machine, free_parameters(machine), [weigh_recording(machine, recording)])
    left = [fails]
    fit = multistart.minimise

    def minimise_at_last(*given: Any, **more: Any) -> Linearised:
        left[0] -= 1
        if left[0] >= 0:
            raise Failed("it runs away")
        return fit(*given, **more)

    monkeypatch.setattr(multistart, "minimise", minimise_at_last)
    monkeypatch.setattr(multistart, "_are_apart", lambda one, other: False)
    found = best_start(problem, 1, lambda share: None, lambda: False, is_enough=lambda: enough)
    assert found.tried == tried


@pytest.mark.skipif(not RECORDINGS.is_dir(), reason="the recordings in ../shared/recordings are not here")
def test_a_real_gantry_ends_alike_wherever_it_begins(tmp_path: Path) -> None:
    """Starts of parts are told by their slopes: by those of where a fit began, it ended up to 170 apart."""
    mapping = ROOT / "tests" / "recordings" / "voron_2021_06_05.yaml"
    text = yaml.safe_load(mapping.read_text())
    text["file"] = str((mapping.parent / text["file"]).resolve())
    (tmp_path / "run.yaml").write_text(yaml.safe_dump(text))
    machine = Machine.load(ROOT / "machines" / "heated_gantry.yaml")
    parameters = free_parameters(machine)
    problem = make_problem(machine, parameters, [weigh_recording(machine, Recording.load(tmp_path / "run.yaml"), None)])
    drawn = [theta for theta, _ in zip(draw_beginnings(parameters, 0), range(4), strict=False)]
    left = [implausibility(minimise(problem, theta)) for theta in drawn]
    assert np.ptp(left) < 2.0


def test_other_beginnings_of_the_null_have_a_third_of_its_time(monkeypatch: pytest.MonkeyPatch) -> None:
    budget, now = TimeBudget(100.0, began=0.0), [0.0]
    monkeypatch.setattr(time_budget.time, "monotonic", lambda: now[0])
    told = {}
    for now[0] in (4.9, 5.1, 14.9, 15.1):
        told[now[0]] = (budget.is_begun(), budget.is_calibrated())
    assert told == {4.9: (False, False), 5.1: (True, False), 14.9: (True, False), 15.1: (True, True)}


@pytest.mark.parametrize("reserved, until", [(0.0, 37.5), (42.5, 32.5)])
def test_what_comes_before_all_that_is_tried_has_a_quarter_of_what_is_left(
    reserved: float, until: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = [20.0]
    budget = TimeBudget(112.5, reserved=reserved, began=0.0)
    monkeypatch.setattr(time_budget.time, "monotonic", lambda: now[0])
    allotted, endless = budget.allot(), TimeBudget(began=0.0).allot()
    for now[0] in (until - 0.1, until + 0.1):
        assert allotted.is_prepared() == (now[0] > until)
        assert not budget.is_prepared() and not endless.is_prepared()


def test_what_runs_take_in_the_end_is_kept_from_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 100 s the search has 80, or what simulating all runs leaves, before it and after it; its shares do not count
    what was simulated before it."""
    begun, now = TimeBudget(100.0, began=0.0), [10.0]
    monkeypatch.setattr(time_budget.time, "monotonic", lambda: now[0])

    def simulate(*_: Any) -> str:
        now[0] += 25.0
        return "as calibrated"

    monkeypatch.setattr(diagnose, "simulate_calibrated", simulate)
    let_in: Any = SimpleNamespace(recordings=(), holdout=())
    null: Any = None
    before, budget = diagnose._simulate_first(null, let_in, None, 1, begun)
    assert before == "as calibrated" and budget.reserved == 25.0 and budget.spent == 10.0
    ends = {}
    for now[0] in (74.9, 75.1, 79.9, 80.1):
        ends[now[0]] = (begun.is_searched(), budget.is_searched())
    assert ends == {74.9: (False, False), 75.1: (False, True), 79.9: (False, True), 80.1: (True, True)}
    assert not replace(budget, reserved=0.0).is_past(0.8) and begun.is_past(0.8)
    with pytest.raises(BudgetReached):
        budget.check()
