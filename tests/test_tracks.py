"""From which lumps the steps go: from those as written where one thing explains everything there."""

from __future__ import annotations

from functools import cache

import pytest
from test_diagnosis import LADDERS, SENSORS, recorded
from test_diagnosis_search import bars

from network import Machine
from network.analysis.diagnosis import tracks
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.lumps.lump_refinement import list_finer_machines
from network.analysis.diagnosis.screening.screening import Screening
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.time_budget import TimeBudget
from network.analysis.diagnosis.tracks import list_begins, list_tracks

SLOW = {"sensors": {"T_housing": {**SENSORS["T_housing"], "effects": [{"kind": "sensor_lag", "lag": "900 s"}]}}}
PUMP = {"sources": {"pump": {"kind": "heat_source", "into": {"column": 1}, "power": "90 W", "with": "running"}}}


@cache
def levels(*, pump: bool = False) -> tuple[Hypothesis, Hypothesis]:
    """A machine of bars that are one lump each, with a slow sensor, and with a heat that it lacks, too: on its lumps as
    written and on finer ones."""
    truth: Machine = bars().patched(SLOW)
    truth = truth.patched(PUMP) if pump else truth
    case = Case(bars(), tuple(recorded(truth, ladder, i) for i, ladder in enumerate(LADDERS)))
    finer, *_ = list_finer_machines(case.machine)
    return fit_hypothesis(case, case.machine), fit_hypothesis(case, finer)


def test_where_a_slow_sensor_is_all_that_is_missing_on_lumps_as_written_the_steps_go_from_there() -> None:
    written, finer = levels()
    assert finer.chi == pytest.approx(written.chi) and finer.chi > SETTINGS.adequate, "every bar has one temperature"
    first, *rest = list_tracks(finer, written, [finer, written], 1, 1)
    assert first.begin is written and [track.begin for track in rest] == [finer]
    assert first.screened.scores[0].candidate.kind.kind == "sensor_lag"


def test_where_no_one_thing_is_the_steps_go_from_finer_lumps_first() -> None:
    written, finer = levels(pump=True)
    told = [track.begin for track in list_tracks(finer, written, [finer, written], 1, 1)]
    assert [h is finer for h in told] == [True, False]


@pytest.mark.parametrize("chi", [SETTINGS.adequate - 0.01, SETTINGS.noise])
def test_where_finer_lumps_leave_little_nothing_is_looked_for_on_those_as_written(
    chi: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    written, finer = levels()
    seen: list[Hypothesis] = []
    monkeypatch.setattr(
        tracks, "screen_candidates", lambda h, seed, jobs: Screening(h) if seen.append(h) is None else None
    )
    monkeypatch.setattr(Hypothesis, "chi", property(lambda h: chi if h is finer else 4.0))
    assert [track.begin for track in list_tracks(finer, written, [finer], 1, 1)] == [finer] == seen


def test_once_it_is_late_it_is_not_asked_whether_one_thing_explains_everything_on_lumps_as_written(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    written, finer = levels()
    monkeypatch.setattr(tracks, "screen_candidates", lambda h, seed, jobs: Screening(h))
    monkeypatch.setattr(TimeBudget, "is_prepared", lambda budget: True)
    assert [track.begin for track in list_tracks(finer, written, [finer, written], 1, 1)] == [finer, written]


@pytest.mark.parametrize(("before", "best", "count"), [(4.0, 2.0, 2), (9.0, 2.0, 1), (4.0, 1.0, 1)])
def test_the_machine_as_written_counts_where_it_is_not_far_behind(
    before: float, best: float, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    written, finer = levels()
    monkeypatch.setattr(Hypothesis, "chi", property(lambda h: best if h is finer else before))
    assert len(list_begins([written, finer], finer)) == count and list_begins([written], written) == [written]
