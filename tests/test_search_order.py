"""Which of two searches is told, one on readings set right and one without that."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import pytest
from test_small_decisions import bare

from network.analysis.diagnosis import search, weighed_fault
from network.analysis.diagnosis.findings import findings
from network.analysis.diagnosis.latent_heat import unrecorded_surroundings
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps import forward_selection, next_finding
from network.analysis.diagnosis.time_budget import BudgetReached


def state(told: float, chi: float | None) -> Any:
    """As good as its number; chi: what its finding leaves, None where it has none."""
    return bare(told=told, best=bare(found=chi is not None, chi=chi, told=told))


@pytest.mark.parametrize(
    ("right", "other", "told"),
    [
        ((5.0, 6.0, 9.0), (4.0, 7.0, 8.0), [6.0, 9.0]),
        ((5.0, 6.0, 9.0), (4.0, 7.0, 20.0), [6.0, 9.0, 20.0]),
        ((5.0, 6.0, 9.0), (10.0, 11.0), [10.0, 11.0]),
        ((5.0,), (4.0,), []),
    ],
)
def test_lumps_alone_that_explain_more_come_before_readings_set_right(
    right: Any, other: Any, told: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And else the search on these is told to its end, before the other one, which has to beat it."""
    monkeypatch.setattr(weighed_fault, "is_told_better", lambda other, now, jobs: other.told > now.told)
    monkeypatch.setattr(weighed_fault, "lay_alike", lambda now, other: other.best)
    first, *rest = (state(each, None) for each in right)
    others = iter([state(each, None) for each in other])
    assert [s.told for s in weighed_fault.weigh_fault(first, iter(rest), others, 1)] == told


@pytest.mark.parametrize(
    ("right", "other", "told"),
    [
        (((5.0, None), (6.0, 8.0), (9.0, 8.0)), ((4.0, None), (20.0, 1.0), (21.0, 1.0)), [6.0, 20.0, 21.0]),
        (((5.0, None), (6.0, 8.0), (9.0, 8.0)), ((4.0, None), (20.0, 8.0), (21.0, 8.0)), [6.0, 9.0, 21.0]),
        (((5.0, None), (6.0, 1.0), (9.0, 1.0)), ((4.0, None), (20.0, 1.0), (21.0, 1.0)), [6.0, 9.0, 21.0]),
        (((5.0, None), (6.0, 8.0), (9.0, 8.0)), ((4.0, None), (5.5, 1.0), (5.8, 1.0)), [6.0, 9.0]),
        (((5.0, None), (6.0, None)), ((4.0, None), (20.0, 1.0)), [6.0, 20.0]),
    ],
)
def test_what_hardly_leaves_anything_without_a_fault_comes_before_more_steps_with_one(
    right: Any, other: Any, told: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the first step with the fault leaves much; what was not asked then has its turn in the end."""
    monkeypatch.setattr(weighed_fault, "is_told_better", lambda other, now, jobs: other.told > now.told)
    monkeypatch.setattr(weighed_fault, "lay_alike", lambda now, other: other.best)
    first, *rest = (state(*each) for each in right)
    others = iter([state(*each) for each in other])
    assert [s.told for s in weighed_fault.weigh_fault(first, iter(rest), others, 1)] == told


@pytest.mark.parametrize(
    ("evidence", "chi", "unseen", "told"),
    [
        (20.0, SETTINGS.adequate + 1, (3.0, 2.0), False), (20.0, SETTINGS.adequate + 1, (2.0, 3.0), True),
        (20.0, SETTINGS.adequate - 0.1, (3.0, 2.0), True), (5.0, SETTINGS.adequate + 1, (2.0, 3.0), False),
    ],
)  # fmt: skip
def test_where_both_leave_much_the_one_that_explains_more_has_to_tell_unseen_runs_better(
    evidence: float, chi: float, unseen: Any, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is wrong anyway explains the runs that it was fitted to all the better the more it bends to them."""
    monkeypatch.setattr(weighed_fault, "use_file_noise", lambda case: case)
    monkeypatch.setattr(weighed_fault, "reweight", lambda case, h: h)
    monkeypatch.setattr(weighed_fault, "lasting_misfit", lambda at: 1.0)
    monkeypatch.setattr(weighed_fault, "unseen_misfit", lambda h, jobs: h.unseen)
    gains = zip((evidence, 0.0), unseen, strict=True)
    other, now = (bare(case=None, chi=chi, linearised=None, evidence=e, unseen=u, found=("it",)) for e, u in gains)
    for bent, is_better in (
        ((False, False), told),
        ((True, True), told),
        ((False, True), told),
        ((True, False), False),
    ):
        other.is_bent, now.is_bent = bent
        assert weighed_fault.is_told_better(other, now, 1) is is_better
    other.found = ()
    assert weighed_fault.is_told_better(other, now, 1) is told


@pytest.mark.parametrize(
    ("competes", "is_better", "told"), [(False, False, ["set right"]), (True, False, []), (True, True, ["set right"])]
)
def test_what_competes_beside_what_was_found_has_to_explain_more(
    competes: bool, is_better: bool, told: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As long as lumps are as fine as they get: one that leaves much is looked for, too."""
    asked = list[bool]()
    for name, does in {
        "reweight": lambda case, h: h, "_with_fault": lambda found, fault, h: found,
        "set_right": lambda h, jobs, is_finest: (asked.append(is_finest), (bare(competes=competes), h))[1],
        "_search_set_right": lambda *of: iter([bare(best="step", name="step"), bare(best="end", name="set right")]),
        "is_told_better": lambda other, now, jobs: is_better and (other, now) == ("end", "laid"),
        "lay_alike": lambda now, other: "laid",
    }.items():  # fmt: skip
        monkeypatch.setattr(search, name, does)
    found: Any = bare(best=bare(case=None))
    states: Any = search._search_beside(found, 0, 1, lambda share: None)
    assert [now.name for now in states] == told
    assert asked == [True]


@pytest.mark.parametrize(
    ("resized", "again", "told"),
    [
        ({}, [], ["null", "step", "end"]),
        ({"step": "resized"}, ["null", "step again", "end again"], ["null", "resized", "step again", "end again"]),
        ({"end": "resized"}, ["null", "end again"], ["null", "step", "resized", "end again"]),
        ({"step": "resized"}, ["null", "null in the end"], ["null", "resized", "null in the end"]),
        ({"step": "resized"}, ["null", "null that leaves nothing", "time"], ["null", "resized",
                                                                             "null that leaves nothing"]),
        ({"step": "resized"}, ["null", "time"], ["null", "resized"]),
    ],
)  # fmt: skip
def test_all_begins_again_with_the_size_a_fault_has_beside_what_was_found(
    resized: dict[str, str], again: list[str], told: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def state(name: str, fault: Any = "as found") -> Any:
        chi = 1.0 if name.endswith("leaves nothing") else 2.0
        return bare(name=name, fault=fault, best=bare(found=not name.startswith("null"), chi=chi))

    def go_on(begun: Any, *of: Any) -> Any:
        for name in ("null", "step", "end") if begun.fault == "as found" else again:
            if name == "time":
                raise BudgetReached
            yield state(name)

    def resize(now: Any, case: str) -> Any:
        assert case == "recorded"
        return state(resized[now.name], "of another size") if now.name in resized else None

    monkeypatch.setattr(search, "_search_from", go_on)
    monkeypatch.setattr(search, "resize_beside", resize)
    monkeypatch.setattr(search, "_with_fault", lambda first, fault, h: state("null", fault))
    first: Any = bare(case="recorded")
    seen = []
    with suppress(BudgetReached):
        seen.extend(now.name for now in search._search_set_right(state("null"), first, 0, 1, lambda share: None))
    assert seen == told


def test_a_fault_of_readings_is_told_before_what_may_be_out_of_time(monkeypatch: pytest.MonkeyPatch) -> None:
    written, mended = bare(case=None, machine=None), bare()
    for name in ("keep_in_step", "state", "fit_written"):
        monkeypatch.setattr(search, name, lambda *of: written)
    monkeypatch.setattr(search, "Selection", lambda h: h)
    monkeypatch.setattr(search, "Screening", lambda h: h)
    monkeypatch.setattr(search, "set_right", lambda h, jobs: ("fault", mended))
    monkeypatch.setattr(search, "_with_fault", lambda first, fault, h: bare(fault=fault, mended=h))
    told = search.search(bare(machine=None), bare(values={}), 0, 1, lambda share: None)
    assert next(told).fault is None
    second = next(told)
    assert (second.fault, second.mended) == ("fault", mended)


@pytest.mark.parametrize(
    ("kept", "count", "is_timed", "told"),
    [(3.0, 1, False, True), (6.0, 1, False, False), (3.0, 2, False, True), (None, 0, False, False),
     (3.0, 1, True, False)],
)  # fmt: skip
def test_what_explains_nearly_all_is_not_contested_but_followed(
    kept: Any, count: int, is_timed: bool, told: bool
) -> None:
    """Also where nothing more is looked for after it; but not heat by the clock, which a relay may look like."""
    found = kept and bare(chi=kept, found=(bare(is_timed=is_timed),) * count)
    assert next_finding._is_next(bare(chi=10.0), found) is told


@pytest.mark.parametrize(
    ("ended", "competes", "chi", "told"),
    [("budget", True, 9.0, ["found", "fault"]), ("", True, 9.0, ["fault", "found"]),
     ("budget", False, 9.0, ["fault", "found"]), ("budget", True, 1.0, ["fault", "found"])],
)  # fmt: skip
def test_an_exchange_that_was_not_weighed_is_told_last(
    ended: str, competes: bool, chi: float, told: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where it leaves much, and the time was up before a search without it came to its end."""
    monkeypatch.setattr(findings, "_faults", lambda search, after: iter(["fault"]))
    monkeypatch.setattr(findings, "_findings", lambda search, after: iter(["found"]))
    assert findings.list_findings(bare(fault=bare(competes=competes), best=bare(chi=chi), ended=ended), bare()) == told


def test_what_does_not_fit_all_runs_leaves_no_gains_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(forward_selection, "replace", lambda of, **new: new)
    monkeypatch.setattr(forward_selection, "on_all_runs", lambda null, best, steps: null)
    told = forward_selection._on_all_runs(bare(found=()), bare(best=bare(found=(1,)), gains=(9.0,)))
    assert told["gains"] == ()


def _replace(of: Any, **more: Any) -> Any:
    best = {"best": more["selection"].best} if "selection" in more else {}
    return bare(**{**vars(of), **more, **best})


def follow(monkeypatch: pytest.MonkeyPatch, null: float, *tracks: tuple[float, list[tuple[float, float, bool]]]) -> Any:
    """What is told on the way: tracks by the evidence that they begin with and what their steps come to (evidence, χ,
    whether it was tested); something is found where the evidence is another than at the beginning."""
    begins = {e: bare(evidence=e, chi=2.0, found=(), case=None) for e, _ in tracks}
    steps = dict(tracks)

    def select(begin: Any, *_: object) -> Iterator[Any]:
        for e, chi, is_checked in steps[begin.evidence]:
            best = begin if e == begin.evidence else bare(evidence=e, chi=chi, found=("it",), case=None)
            yield bare(best=best, is_checked=is_checked)

    monkeypatch.setattr(search, "select_forward", select)
    monkeypatch.setattr(search, "reweight", lambda case, h: h)
    monkeypatch.setattr(search, "replace", _replace)
    untested = bare(is_checked=False)
    now = bare(null=begins[null], best=begins[null], case=None, screened="", selection=untested)
    each = [bare(begin=begins[e], screened=f"about {e:g}") for e, _ in tracks]
    told = [(s.best.evidence, s.screened) for s in search._follow_tracks(now, iter(each), 1, 1, lambda share: None)]
    return told


def test_where_the_machine_as_written_comes_first_the_null_is_left_alone_once_that_holds(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    told = follow(monkeypatch, 50.0, (10.0, [(90.0, 1.0, False), (91.0, 1.0, True)]), (50.0, [(60.0, 1.0, True)]))
    assert told == [(50.0, "about 10"), (90.0, "about 10"), (91.0, "about 10")]


def test_what_does_not_hold_there_is_taken_back_to_the_null_before_its_steps_are_taken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    told = follow(monkeypatch, 50.0, (10.0, [(90.0, 1.4, False), (10.0, 2.0, True)]), (50.0, [(60.0, 1.0, False)]))
    assert told == [(50.0, "about 10"), (90.0, "about 10"), (50.0, "about 10"), (60.0, "about 50")]


def test_steps_from_another_track_have_to_be_tested_and_to_explain_more(monkeypatch: pytest.MonkeyPatch) -> None:
    first, second = (50.0, [(60.0, 1.5, True)]), (10.0, [(70.0, 1.0, False), (55.0, 1.0, True), (65.0, 1.0, True)])
    assert follow(monkeypatch, 50.0, first, second) == [(50.0, "about 50"), (60.0, "about 50"), (65.0, "about 10")]


@pytest.mark.parametrize(
    ("beside", "told"),
    [(90.0, ["null"]), (110.0, ["null", "first", "last"])],
)
def test_a_room_of_any_course_stands_until_something_explains_as_much(
    beside: float, told: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Then that is told, and the search goes on; else it is over, for what is left is the room."""
    monkeypatch.setattr(unrecorded_surroundings, "reweight", lambda case, h: h)
    monkeypatch.setattr(unrecorded_surroundings, "explains_more", lambda h, room: beside > room.evidence)
    monkeypatch.setattr(unrecorded_surroundings, "replace", lambda of, **changes: bare(name=of.name, **changes))
    null = bare(case=None)
    each = [bare(name=name, null=null, best=bare(found=found), unrecorded="room")
            for name, found in (("null", ()), ("first", ("fan",)), ("last", ("fan", "mass")))]  # fmt: skip
    states = [*unrecorded_surroundings.weigh_unrecorded(bare(evidence=100.0), iter(each))]
    assert [now.name for now in states] == told
    assert [now.unrecorded for now in states] == ["room", None, None][: len(told)]


@pytest.mark.parametrize(
    ("evidence", "is_room", "gain", "told"),
    [(110.0, False, 50.0, True), (90.0, False, 50.0, False), (110.0, True, 50.0, False), (110.0, True, 1.0, True)],
)
def test_what_needs_such_a_room_itself_explains_no_more(
    evidence: float, is_room: bool, gain: float, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    rest = bare(evidence=evidence, heat=bare(is_room=is_room, gain=gain))
    monkeypatch.setattr(unrecorded_surroundings, "replace", lambda of, **changes: of)
    monkeypatch.setattr(unrecorded_surroundings, "find_rest", lambda h: rest)
    h = bare(linearised=bare(temper=lambda *of: None))
    assert unrecorded_surroundings.explains_more(h, bare(evidence=100.0)) is told
