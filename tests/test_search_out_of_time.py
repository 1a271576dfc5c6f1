"""What is told where the time is up before a search came to its end: what was tested before what was not."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from diagnosed import diagnosed
from test_search_decisions import h
from test_small_decisions import bare

from network.analysis.diagnosis import diagnose, search
from network.analysis.diagnosis.lumps import lump_refinement
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps import forward_selection, next_finding
from network.analysis.diagnosis.time_budget import BudgetReached, TimeBudget


def run_out(*of: Any, **more: Any) -> Any:
    raise BudgetReached


@pytest.mark.parametrize("fitted", [0, 1])
def test_finer_lumps_that_were_fitted_are_kept(fitted: int, monkeypatch: pytest.MonkeyPatch) -> None:
    levels = [h(2.0, 0.0), h(1.2, 40.0)]
    told = iter(levels[1 : 1 + fitted])
    monkeypatch.setattr(lump_refinement, "_fit_first_that_matters", lambda *of: next(told, None) or run_out())
    if fitted:
        assert lump_refinement.refine_lumps(bare(), levels[0]) == levels
    else:
        with pytest.raises(BudgetReached):
            lump_refinement.refine_lumps(bare(), levels[0])


def test_finer_lumps_are_told_where_there_was_no_time_for_a_null(monkeypatch: pytest.MonkeyPatch) -> None:
    written, finest = h(2.0, 0.0), h(1.2, 40.0)
    now = bare(case=bare(), written=written, allot=lambda: now)
    monkeypatch.setattr(search, "refine_lumps", lambda *of: [written, finest])
    monkeypatch.setattr(search, "_settle_null", run_out)
    monkeypatch.setattr(search, "_begin_from", lambda now, null: null)
    states = search._search_from(now, 0, 1, lambda share: None)
    assert next(states) is finest
    with pytest.raises(BudgetReached):
        next(states)


@pytest.mark.parametrize(
    ("found", "before_checked", "checked", "taken"),
    [((), False, False, True), ((), True, False, False), ((), True, True, True), (("fan",), False, False, False)],
)
def test_what_was_not_tested_does_not_stand_for_a_null_that_was(
    found: Any, before_checked: bool, checked: bool, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(search, "_beats", lambda *of: True)
    before = bare(null=h(), best=h(found=found), selection=bare(is_checked=before_checked), case=None)
    now: Any = bare(is_checked=checked, best=h(found=("mass",)))
    assert search._is_taken(now, bare(begin=h()), before) is taken  # type: ignore[arg-type]


@pytest.mark.parametrize("look", [run_out, lambda *of, **more: (None, None)])
def test_a_last_look_at_readings_is_no_part_of_the_search(look: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "set_right", look)
    monkeypatch.setattr(search, "reweight", lambda case, best: best)
    found: Any = bare(best=h())
    assert [*search._search_beside(found, 0, 1, lambda share: None)] == []


def test_a_fault_that_is_not_found_again_is_not_what_is_told_while_it_is_looked_for_without_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def go_on(begun: Any, *of: Any, sets_right: bool = True) -> Iterator[Any]:
        if not sets_right:
            raise BudgetReached
        yield bare(name="null", fault=fault)

    fault, told = bare(competes=False), list[Any]()
    for name, does in {
        "keep_in_step": lambda case, null: case, "state": lambda *of: h(), "fit_written": lambda at: at,
        "Search": lambda *of: bare(name="written", fault=None), "Screening": lambda of: None,
        "Selection": lambda of: None, "set_right": lambda of, jobs: (fault, None), "_search_from": go_on,
        "_search_set_right": lambda begun, first, *of: go_on(begun),
        "_with_fault": lambda *of: bare(name="mended", fault=fault), "_is_found_again": lambda *of: False,
    }.items():  # fmt: skip
        monkeypatch.setattr(search, name, does)
    with pytest.raises(BudgetReached):
        for now in search.search(bare(machine=None), bare(values={}), 0, 1, lambda share: None):  # type: ignore[arg-type]
            told.append(now.name)  # type: ignore[attr-defined]
    assert told[-2:] == ["null", "written"]


@pytest.mark.parametrize(
    ("found", "test", "chi", "told"),
    [
        (("fan",), bare(shows_again=False), 2.0, True), (("fan", "mass"), bare(shows_again=True), 2.0, True),
        (("fan", "mass"), None, 2.0, True), (("fan", "mass"), bare(shows_again=False), 2.0, False),
        (("fan", "mass"), bare(shows_again=False), SETTINGS.noise, True),
    ],
)  # fmt: skip
def test_a_further_finding_is_told_before_its_test_where_it_shows_or_leaves_nothing(
    found: Any, test: Any, chi: float, told: bool
) -> None:
    now: Any = bare(best=h(chi, found=found), unseen_of=lambda c: test)
    assert forward_selection._shows_again(now) is told


def test_another_first_is_told_before_it_is_fitted_on_finer_lumps() -> None:
    fan, mass = (h(found=(bare(key=(name,)),)) for name in ("fan", "mass"))
    assert next_finding._is_another([mass], [fan]) and not next_finding._is_another([fan, mass], [fan])
    assert not next_finding._is_another([], [fan]) and not next_finding._is_another([], [])


@pytest.mark.parametrize(
    ("chi", "seconds", "told"),
    [(SETTINGS.adequate, 0.0, ()), (2.0, 60.0, ("apart",)), (2.0, 0.0, None)],
)
def test_whether_runs_are_of_one_machine_is_asked_last_and_while_there_is_time(
    chi: float, seconds: float, told: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(diagnose, "find_disagreements", lambda null, jobs: ("apart",))
    assert diagnose._find_disagreements(None, chi, 1, TimeBudget(seconds)) == told  # type: ignore[arg-type]


def test_runs_of_which_it_was_not_asked_are_not_said_to_agree(tmp_path: Path) -> None:
    d = replace(diagnosed(tmp_path), disagreements=None)
    assert d.summary()["one_machine"] == {"agree": None, "numbers": []}
