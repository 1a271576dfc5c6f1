"""Heat by the clock is found at its instants, which have no slope."""

from __future__ import annotations

import numpy as np
import pytest
from test_diagnosis import LADDERS, plant, recorded

from network.analysis.diagnosis.candidates.candidate_response import respond_to_candidates
from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis, theta_of
from network.analysis.diagnosis.latent_heat.locate import locate
from network.analysis.diagnosis.screening.timed_search import _is_seen, search_timed, settle_instants
from network.engine.response.model import Model
from network.engine.response.parameters import at_values
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


def test_edges_between_samples_count_as_they_do_in_a_whole_run() -> None:
    """On 20 s later and off 7 s earlier, with a sample every 20 s: the answers change as those of the machine do."""
    case = Case(plant(), tuple(recorded(plant(), x, i) for i, x in enumerate(LADDERS)))
    h = fit_hypothesis(case, case.machine, steps=1)
    c = next(
        c for c in candidates(h.machine, case.drivers) if c.kind.kind == "timed_source" and c.places == ("column",)
    )
    moved = [
        dict(zip((p.path for p in c.own), of, strict=True)) for of in ((300, 2820, 540, -2100), (300, 2820, 513, -2080))
    ]
    of = h.linearised
    told = respond_to_candidates([(c, h.values | own) for own in moved], of.problem.data, of.predictions)
    runs = [Model(at_values(c.machine, h.values | own), (), [d.run for d in of.problem.data]) for own in moved]
    whole = [np.concatenate([p.cells for p in run.predict(np.empty(0))]) for run in runs]
    assert told[0] is not None and told[1] is not None
    change, expected = told[1] - told[0], whole[1] - whole[0]
    assert np.abs(change - expected).max() < 0.2 * np.abs(expected).max()


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


@pytest.mark.parametrize("duration, seen", [(10.0, False), (25.0, True), (2810.0, False)])
def test_what_is_on_or_off_for_less_than_a_sample_is_not_told(duration: float, seen: bool) -> None:
    case = Case(plant(), tuple(recorded(plant(), x, i) for i, x in enumerate(LADDERS[:1])))
    h = fit_hypothesis(case, case.machine, steps=1)
    proposed = candidates(h.machine, case.drivers)
    c = next(c for c in proposed if c.kind.kind == "timed_source" and c.places == ("column",))
    values = {"period": 2820.0, "duration": duration, "phase": 600.0}
    always = values | {"period": 90000.0, "duration": 80000.0, "phase": -600.0}
    assert not _is_seen(h, c, theta_of(c.own[1:], {p.path: always[p.attribute] for p in c.own[1:]}))
    shapes = theta_of(c.own[1:], {p.path: values[p.attribute] for p in c.own[1:]})
    assert h.case.runs.interval == 20.0 and _is_seen(h, c, shapes) is seen
