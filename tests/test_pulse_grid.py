"""Windows and trains of pulses are scored on a grid as each would be by itself, and found where they lie."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from test_diagnosis import LADDERS, plant, recorded

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.latent_heat.locate import locate
from network.analysis.diagnosis.screening.pulse_grid import STEPS, Clock, Pulses, lay_grid, numbers_of, pulses_of
from network.analysis.diagnosis.screening.screen import score_variants
from network.analysis.diagnosis.screening.timed_search import search_timed
from network.recordings.recording import Recording

WINDOW = {"kind": "timed_source", "into": {"column": 1}, "power": "200 W", "begins": "41 min", "ends": "67 min"}
END = 9000.0


@cache
def fitted() -> Hypothesis:
    truth = plant(sources={"lamp": WINDOW})
    case = Case(plant(), tuple(recorded(truth, ladder, i) for i, ladder in enumerate(LADDERS)))
    return fit_hypothesis(case, case.machine)


def by_the_clock(kind: str = "timed_source") -> Candidate:
    h = fitted()
    proposed = candidates(h.machine, h.case.drivers, runs=h.case.runs)
    return next(c for c in proposed if c.kind.kind == kind and c.places == ("column",))


@pytest.mark.parametrize(
    "pulses", [Pulses(18000.0, 1500.0, 2437.5), Pulses(3000.0, 750.0, 750.0), Pulses(6000.0, 2250.0, 1875.0)]
)
def test_the_grid_scores_what_the_heat_itself_scores(pulses: Pulses) -> None:
    """At instants of the grid nothing lies between; what is on when a run begins is."""
    h, c = fitted(), by_the_clock()
    grid = lay_grid(h, c)
    assert grid is not None and (grid.clock.begin, grid.clock.end) == (0.0, END) and pulses.phase % (END / STEPS) == 0
    (gain,) = grid.gains(np.array([grid.clock.weigh(pulses)]))
    (alone,) = score_variants(h.linearised, [(c, 1.0, {**c.usual, **numbers_of(c, pulses)})], h.values)
    assert gain == pytest.approx(alone.gain, rel=0.02) and alone.gain > 1


def test_a_pulse_that_is_on_when_a_run_begins_is_on_from_its_first_instant() -> None:
    assert [*Pulses(4000.0, 1000.0, 3500.0).edges(0.0, 9000.0)] == [(0.0, 500.0), (3500.0, 4500.0), (7500.0, 8500.0)]
    assert [*Pulses(20000.0, 1000.0, 8500.0).edges(0.0, 9000.0)] == [(8500.0, 9000.0)]


def test_a_single_window_is_found_where_it_lies() -> None:
    h = fitted()
    proposed = candidates(h.machine, h.case.drivers, runs=h.case.runs)
    best = max(search_timed(h, proposed, locate(h.linearised, h.machine), 1, 1), key=lambda s: s.gain)
    assert best.candidate.places == ("column",)
    told = {path.rpartition(".")[2]: value for path, value in best.own.items()}
    assert told["period"] > END
    assert told["phase"] == pytest.approx(41 * 60, abs=120)
    assert told["phase"] + told["duration"] == pytest.approx(67 * 60, abs=240)


def test_the_best_of_the_grid_is_the_window() -> None:
    grid = lay_grid(fitted(), by_the_clock())
    assert grid is not None
    window, *_ = grid.best(1)
    assert window.phase == pytest.approx(41 * 60, abs=200) and window.duration == pytest.approx(26 * 60, abs=400)


def test_between_instants_of_the_grid_it_explains_more_and_as_much_as_the_heat_itself() -> None:
    h, c = fitted(), by_the_clock()
    grid = lay_grid(h, c)
    assert grid is not None
    window, *_ = grid.best(1)
    moved = grid.sharpen(window, np.random.default_rng(1))
    assert moved.gain > window.gain and grid.clock.resolves(moved)
    assert moved.phase == pytest.approx(41 * 60, abs=120) and moved.duration == pytest.approx(26 * 60, abs=240)
    (alone,) = score_variants(h.linearised, [(c, 1.0, {**c.usual, **numbers_of(c, moved)})], h.values)
    assert moved.gain == pytest.approx(alone.gain, rel=0.02)


@pytest.mark.parametrize(("duration", "is_told"), [(200.0, True), (180.0, False), (5900.0, False)])
def test_what_is_on_or_off_for_less_than_two_steps_is_left_to_runs_of_its_own(duration: float, is_told: bool) -> None:
    pulses = Pulses(6000.0, duration, 0.0)
    c = by_the_clock()
    assert Clock(0.0, END, STEPS + 1).resolves(pulses) is is_told
    told = numbers_of(c, pulses)
    again = pulses_of(c, told)
    assert (again.period, again.duration) == pytest.approx((pulses.period, pulses.duration))


def shifted(run: Recording, by: float) -> Recording:
    return Recording(run.name, run.file, run.t + by, run.columns)


def test_clocks_that_do_not_begin_at_zero_are_kept() -> None:
    """The second of the runs begins where the first ends: heat is on in one of them only."""
    day = 8 * 3600.0
    lit, dark = recorded(plant(sources={"lamp": WINDOW}), LADDERS[0], 0), recorded(plant(), LADDERS[1], 1)
    runs = [shifted(lit, day), shifted(dark, day + END)]
    case = Case(plant(), tuple(runs))
    h = fit_hypothesis(case, case.machine)
    assert case.clock == (day, day + 2 * END)
    c = next(c for c in candidates(h.machine, case.drivers, runs=case.runs)
             if c.kind.kind == "timed_source" and c.places == ("column",))  # fmt: skip
    grid = lay_grid(h, c)
    assert grid is not None
    window, *_ = grid.best(1)
    assert window.phase == pytest.approx(day + 41 * 60, abs=400)


def test_other_laws_have_no_grid() -> None:
    assert lay_grid(fitted(), by_the_clock("heat_source")) is None


def test_without_a_gain_there_is_no_best() -> None:
    grid = lay_grid(fitted(), by_the_clock())
    assert grid is not None
    silent = type(grid)(grid.clock, np.zeros_like(grid.g), grid.G, 1.0)
    assert silent.best(3) == []


def test_a_heat_that_is_nearly_always_on_does_not_stand_before_one_that_is() -> None:
    """Instants have no slope, so their choice has a price of its own."""
    truth = plant(sources={"pump": {"kind": "heat_source", "into": {"column": 1}, "power": "60 W"}})
    case = Case(plant(), tuple(recorded(truth, ladder, i) for i, ladder in enumerate(LADDERS)))
    h = fit_hypothesis(case, case.machine)
    proposed = candidates(h.machine, case.drivers, runs=case.runs)
    timed, steady = (
        next(c for c in proposed if c.kind.kind == kind and c.places == ("column",) and "running" not in c.name)
        for kind in ("timed_source", "heat_source")
    )
    on = {p.path: {"period": 1200.0, "duration": 1180.0, "phase": 300.0}.get(p.attribute, 60.0) for p in timed.own}
    fits = [
        fit_hypothesis(case, c.machine, (c,), c.own, h.values | numbers)
        for c, numbers in ((timed, on), (steady, steady.usual))
    ]
    assert fits[0].chi == pytest.approx(fits[1].chi, rel=0.02)
    assert fits[0].price > 10 and fits[1].price == 0
    assert fits[0].evidence < fits[1].evidence - 6
