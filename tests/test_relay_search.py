"""The search for a relay on machines whose other laws bend, follow an input or switch."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from test_diagnosis import LADDERS, LINKS, plant, recorded

from network.analysis.diagnosis.candidates.candidate import Candidate, candidate
from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.compact_fit import fit_or_none
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.screening.screening import Screening
from network.analysis.diagnosis.strategies import CUT_SHORT, UNRECORDED, list_unsearched, strategy_of
from network.analysis.diagnosis.switching import relay_search
from network.analysis.diagnosis.switching.affine_surrogate import straighten
from network.analysis.diagnosis.switching.certain_levels import is_drawn
from network.analysis.diagnosis.switching.prior_samples import Space
from network.analysis.diagnosis.switching.relay_fits import _keep_promising
from network.analysis.diagnosis.switching.relay_samples import draw_over_whole, find_onset
from network.analysis.diagnosis.switching.relay_search import search_relays, tell_unsearched
from network.analysis.diagnosis.switching.written_numbers import write_own
from network.machine.machine import Machine

FAN = {"housing skin": {"kind": "forced_convection", "between": ["housing", "air"], "conductance": "6 W/K ± 30 %",
                        "gain": 2, "reference_speed": "8000 rpm"},
       "shine": {"kind": "radiation", "between": ["column", "air"], "emissivity_area": "0.4 m^2"}}  # fmt: skip
COOLER = {"kind": "thermostat_cooling", "into": {"housing": 1}, "watches": "housing", "set": "24 degC",
          "hysteresis": "0.6 K", "power": "250 W"}  # fmt: skip
OWN = {**COOLER, "into": {"column": 1}, "watches": "column", "set": "23 degC", "power": "120 W"}


def null(known: Machine, truth: Machine) -> Hypothesis:
    case = Case(known, tuple(recorded(truth, ladder, i) for i, ladder in enumerate(LADDERS)))
    return fit_hypothesis(case, known)


def relays(h: Hypothesis) -> list[Candidate]:
    able = (c for c in candidates(h.machine, h.case.drivers) if c.switches and is_drawn(c))
    return [c for c in able if c.places == ("housing",)]


def test_bent_laws_become_straight_and_what_that_lacks_is_told() -> None:
    h = null(plant(links=FAN, sources={"own": OWN}), plant(links=FAN, sources={"own": OWN}))
    plain = straighten(h)
    assert plain is not None and plain.machine.links["shine"].kind == plain.machine.links["housing skin"].kind
    assert "own" not in plain.machine.sources
    left = plain.linearised.residual, h.linearised.residual
    np.testing.assert_allclose(left[0], left[1], atol=1e-6 * np.abs(left[1]).max())
    assert straighten(plain) is plain
    assert all(Space(c).serves for c in relays(plain)) and not any(Space(c).serves for c in relays(h))
    assert tell_unsearched(h, relays(h)) == ""


def test_numbers_of_what_was_found_stay_where_laws_become_straight() -> None:
    h = null(plant(links=FAN), plant(links=FAN))
    found = [c for c in candidates(h.machine, h.case.drivers) if c.kind.kind in ("heat_source", "radiation")]
    for kind in ("heat_source", "radiation"):
        c = next(c for c in found if c.kind.kind == kind)
        beside = fit_or_none(h.case, (c,), c.own, h.values | {path: 2.5 * x for path, x in c.usual.items()}, 0)
        plain = straighten(beside) if beside is not None else None
        assert plain is not None and beside is not None
        relay = next(c for c in relays(plain) if Space(c).serves)
        laid = candidate(plain.machine, relay.kind, relay.patch)
        assert laid is not None
        entry = laid.machine.by_path[c.own[0].entry]
        is_kept = entry.__dict__.get(c.own[0].field.attribute) == pytest.approx(beside.values[c.own[0].path], rel=1e-9)
        assert is_kept == (kind == "heat_source")


def test_a_relay_is_drawn_beside_the_numbers_of_what_was_found() -> None:
    h = null(plant(), plant())
    c = next(c for c in candidates(h.machine, h.case.drivers) if c.kind.kind == "heat_source")
    beside = fit_or_none(h.case, (c,), c.own, h.values | {path: 2.5 * x for path, x in c.usual.items()}, 0)
    assert beside is not None and straighten(beside) is beside
    laid = candidate(write_own(beside), relays(beside)[0].kind, relays(beside)[0].patch)
    assert laid is not None
    power = laid.machine.by_path[c.own[0].entry].__dict__[c.own[0].field.attribute]
    assert power == pytest.approx(beside.values[c.own[0].path], rel=1e-12)


@pytest.mark.parametrize(
    "more",
    [pytest.param({}, id="fan and radiation"),
     pytest.param({"own": OWN}, id="beside a relay of its own", marks=pytest.mark.proof)],
)  # fmt: skip
def test_a_cooler_is_found_beside_laws_that_bend(more: dict[str, object]) -> None:
    h = null(plant(links=FAN, sources=more), plant(links=FAN, sources={**more, "cooler": COOLER}))
    found = search_relays(h.case, h, relays(h), seed=1, jobs=1)
    assert found and found[0].chi < 0.5 * h.chi and found[0].chi < 1.6
    told = {path.rpartition(".")[2]: value for path, value in found[0].own_values.items()}
    assert told["set"] == pytest.approx(24, abs=0.3) and told["power"] == pytest.approx(250, rel=0.2)


@pytest.mark.parametrize(("at", "power"), [(27.0, 250.0), (30.0, 200.0)], ids=["after 49 %", "after 84 %"])
def test_a_cooler_is_found_that_a_machine_warms_up_to(at: float, power: float) -> None:
    truth = plant(sources={"cooler": {**COOLER, "set": f"{at} degC", "power": f"{power} W"}})
    case = Case(plant(), (recorded(truth, (0, 1000, 1000, 8000, 6000, 8000, 5000, 8000), 0),))
    h = fit_hypothesis(case, plant())
    housing = case.recordings[0].columns["T_housing"].values
    started = int(np.argmax(housing > at + 0.6)) / len(housing)
    assert 0.3 < find_onset([h.linearised]) < started + 0.1
    found = search_relays(h.case, h, relays(h), seed=1, jobs=1)
    told = {path.rpartition(".")[2]: value for path, value in found[0].own_values.items()}
    assert told["set"] == pytest.approx(at, abs=0.1) and told["power"] == pytest.approx(power, rel=0.05)
    assert found[0].chi < 1.05


def test_what_holds_a_part_at_its_set_point_is_drawn_over_whole_runs() -> None:
    h = null(plant(), plant(sources={"cooler": COOLER}))
    drawn = draw_over_whole([h.linearised], relays(h), {}, 1, 1)
    assert drawn[0].misfit < 0.5 * h.chi**2 * len(h.linearised.residual)
    (c,) = relays(h)
    near = np.array([np.log(250.0), 24.0, np.log(0.6)])
    np.testing.assert_array_equal(Space(c).draw(3, 1, near)[0], near)
    assert draw_over_whole([null(plant(), plant()).linearised], relays(h), {}, 1, 1) == []


def test_draws_of_what_is_another_candidate_on_straight_laws_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    h = null(plant(), plant(sources={"cooler": COOLER}))
    stray = SimpleNamespace(judge=SimpleNamespace(space=SimpleNamespace(candidate=SimpleNamespace(key=("other",)))))
    monkeypatch.setattr(relay_search, "draw_samples", lambda *_: [stray])
    monkeypatch.setattr(relay_search, "draw_over_whole", lambda *_: [])
    assert search_relays(h.case, h, relays(h), seed=1, jobs=1) == []


def test_fits_of_a_relay_that_are_the_same_go_on_once() -> None:
    h = null(plant(), plant(sources={"cooler": COOLER}))
    (c,) = relays(h)
    near, same, away = ({**h.values, **c.usual, c.own[0].path: power} for power in (250.0, 250.1, 400.0))
    fits = [fit_or_none(h.case, (c,), c.own, start, 0) for start in (near, same, away)]
    told = sorted((fit for fit in fits if fit is not None), key=lambda fit: fit.chi)
    assert len(told) == 3 and len(_keep_promising(told, np.inf)) < 3
    assert _keep_promising(told, np.inf)[0] is told[0]
    assert not _keep_promising(told, told[0].chi)


def test_links_that_are_plain_stay_as_they_are() -> None:
    h = null(plant(), plant())
    assert straighten(h) is h and set(h.machine.links) == set(LINKS)


def test_what_cannot_be_looked_for_is_told() -> None:
    melting = plant().patched({"nodes": {"column": {"heat_capacity": "90 kJ/K", "melts": {
        "at": "40 degC", "over": "2 K", "latent_heat": "100 kJ"}}}})  # fmt: skip
    h = null(melting, melting)
    seen = Screening(h, tuple(relays(h)))
    (told,) = list_unsearched(seen, "", ())
    assert told.strategy == "switching" and "thermostat_cooling" in told.kinds and "melts" in told.why
    assert not list_unsearched(Screening(null(plant(), plant()), tuple(relays(null(plant(), plant())))), "", ())
    assert {type(strategy_of(c)).__name__ for c in candidates(plant(), ("speed", "ambient"))} == {
        "Switching", "Timed", "Linear"}  # fmt: skip


@pytest.mark.parametrize("ended", CUT_SHORT)
def test_what_was_tried_before_a_search_ended_counts_as_looked_for(ended: str) -> None:
    h = null(plant(), plant())
    seen = Screening(h, tuple(c for c in candidates(h.machine, h.case.drivers) if not c.is_timed))
    every, one = (list_unsearched(seen, ended, tried) for tried in ((), ("heat_source",)))
    assert {*every[0].kinds} - {*one[0].kinds} == {"heat_source"} and one[0].why == CUT_SHORT[ended]
    assert not list_unsearched(seen, ended, every[0].kinds)
    assert [u.kinds for u in list_unsearched(Screening(h), ended, ())] == [()]


def test_relays_are_not_looked_for_where_surroundings_that_nobody_recorded_hide_them() -> None:
    """And that is told; nothing is where a machine could have none."""
    seen = Screening(null(plant(), plant()), tuple(relays(null(plant(), plant()))))
    (told,) = list_unsearched(seen, "", (), is_unrecorded=True)
    assert told.strategy == "switching" and "thermostat_cooling" in told.kinds and told.why == UNRECORDED
    assert not list_unsearched(Screening(seen.before), "", (), is_unrecorded=True)
