"""Heat by the clock is found at its instants, which have no slope."""

from __future__ import annotations

import pytest
from test_diagnosis import LADDERS, plant, recorded

from network.analysis.diagnosis.candidates import candidates
from network.analysis.diagnosis.hypothesis import Case, fit_hypothesis
from network.analysis.diagnosis.locate import locate
from network.analysis.diagnosis.timed_search import search_timed, settle_instants
from network.recordings.recording import Column, Recording

PUMP = {"kind": "timed_source", "into": {"column": 1}, "power": "300 W", "period": "47 min", "duration": "9 min",
        "phase": "12 min"}  # fmt: skip


def test_pulses_are_found_near_their_instants() -> None:
    case = Case(plant(), tuple(recorded(plant(sources={"pump": PUMP}), x, i) for i, x in enumerate(LADDERS)))
    h = fit_hypothesis(case, case.machine)
    proposed = candidates(h.machine, case.drivers)
    assert {c.kind.kind for c in proposed if c.is_timed} >= {"timed_source"}
    best = max(search_timed(h, proposed, locate(h.linearised, h.machine), 1, 1), key=lambda s: s.gain)
    assert best.candidate.kind.kind == "timed_source" and best.candidate.places == ("column",)
    c = best.candidate
    begun = fit_hypothesis(case, c.machine, (c,), c.own, h.values | best.best, steps=6)
    settled = settle_instants(begun)
    told = {path.rpartition(".")[2]: value for path, value in settled.own_values.items()}
    assert settled.chi < 0.15 * h.chi and settled.evidence > begun.evidence
    assert told["period"] == pytest.approx(47 * 60, rel=0.03) and told["power"] == pytest.approx(300, rel=0.3)


def thinned(run: Recording, every: int) -> Recording:
    """One sample of so many."""
    columns = {n: Column(n, c.unit, c.values[::every]) for n, c in run.columns.items()}
    return Recording(run.name, run.file, run.t[::every], columns)


def test_pulses_faster_than_the_samples_are_not_told() -> None:
    """One sample every 20 min: what goes on and off within some 40 min looks like what stays."""
    runs = tuple(thinned(recorded(plant(sources={"pump": PUMP}), x, i), 60) for i, x in enumerate(LADDERS))
    case = Case(plant(), runs)
    h = fit_hypothesis(case, case.machine)
    assert case.runs.interval == pytest.approx(1200.0)
    scores = search_timed(h, candidates(h.machine, case.drivers), locate(h.linearised, h.machine), 1, 1)
    periods = [value for s in scores for path, value in s.own.items() if path.endswith(".period")]
    assert periods and min(periods) > 1900.0, "the usual one, 30 min, is not among them"
