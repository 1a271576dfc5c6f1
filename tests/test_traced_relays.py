"""Relays whose switching a mismatch shows, though nothing reads what they watch."""

from __future__ import annotations

import numpy as np
import pytest
from build import machine
from test_diagnosis import LADDERS, LINKS, NODES, SENSORS, SOURCES, plant, recorded
from test_relay_search import COOLER, FAN, null

from network.analysis.diagnosis.candidates.candidate import Candidate, candidate
from network.analysis.diagnosis.candidates.candidates import candidates, lay_over
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.compact_fit import fit_or_none
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.latent_heat.location import Location
from network.analysis.diagnosis.latent_heat.switched_heat import trace_switched
from network.analysis.diagnosis.switching.affine_surrogate import straighten
from network.analysis.diagnosis.switching.carried_relays import carry_in_step
from network.analysis.diagnosis.switching.certain_levels import is_drawn
from network.analysis.diagnosis.switching.followed_search import search_traced_relays
from network.analysis.diagnosis.switching.prior_samples import Space
from network.analysis.diagnosis.switching.relay_levels import _Course, _match_levels
from network.analysis.diagnosis.switching.traced_relays import _find_place, _write, trace_relays
from network.engine.response.followed_relays import follow_relays
from network.machine.machine import Machine
from network.platform.refusal import Spot, refuse
from network.recordings.relay_mode import RelayMode

HELD = {**NODES, "water": {"temperature": "20 degC"}}
TANK = {**NODES, "water": {"heat_capacity": "60 kJ/K"}}
WATER = {"jacket": {"kind": "convection", "between": ["housing", "water"], "conductance": "50 W/K ± 30 %"},
         "lid": {"kind": "convection", "between": ["water", "air"], "conductance": "15 W/K"}}  # fmt: skip
CHILLED = {**SOURCES, "chiller": {**COOLER, "into": {"water": 1}, "watches": "water", "set": "20 degC",
                                  "hysteresis": "1 K", "power": "900 W"}}  # fmt: skip
MADE = ((HELD, SOURCES), (TANK, CHILLED))


def long_plant(lumps: int, **more: dict[str, object]) -> Machine:
    """The plant with a housing that is a bar of some lumps."""
    bar = {"material": "cast_iron", "length": "600 mm", "area": "0.02 m^2", "lumps": lumps}
    return machine({**NODES, "housing": bar}, links=LINKS, sources={**SOURCES, **more}, sensors=SENSORS)


@pytest.fixture(scope="module")
def cooled() -> Hypothesis:
    """A machine without the cooler that its recordings have."""
    return null(plant(), plant(sources={"cooler": COOLER}))


def switched(h: Hypothesis) -> list[Candidate]:
    return [c for c in candidates(h.machine, h.case.drivers) if c.switches]


def test_when_a_heat_was_on_and_how_large_it_is_are_told_of_all_channels(cooled: Hypothesis) -> None:
    heat, _ = trace_switched(cooled.linearised, Location(("housing",)))
    assert heat.worth > 1000 and min(len(heat.list_switchings(run)) for run in range(2)) >= 4
    other, _ = trace_switched(cooled.linearised, Location(("column",)))
    assert heat.gain > 1.5 * other.gain


def test_a_cooler_is_traced_and_keeps_step(cooled: Hypothesis) -> None:
    found = search_traced_relays(cooled.case, cooled, switched(cooled), 1, 1)
    assert found[0].found[-1].places == ("housing",) and found[0].chi < 1.1
    told = {path.rpartition(".")[2]: value for path, value in found[0].own_values.items() if "cooling" in path}
    assert told["set"] == pytest.approx(24, abs=0.1) and told["power"] == pytest.approx(250, rel=0.05)


def test_a_heater_is_traced_and_is_no_cooler() -> None:
    """Heat that comes is not cold that goes: what is constant between them other numbers would have to take up."""
    boiler = {**COOLER, "kind": "thermostat_heating", "set": "30 degC"}
    h = null(plant(), plant(sources={"boiler": boiler}))
    found = search_traced_relays(h.case, h, switched(h), 1, 1)
    c, own = found[0].found[-1], found[0].own_values
    assert (c.kind.kind, c.places) == ("thermostat_heating", ("housing",)) and found[0].chi < 1.1
    told = {path.rpartition(".")[2]: value for path, value in own.items() if "heating" in path}
    assert told["set"] == pytest.approx(30, abs=0.1) and told["power"] == pytest.approx(250, rel=0.05)
    assert {is_drawn(c) for c in switched(h) if c.kind is found[0].found[-1].kind} == {False}


@pytest.mark.proof
def test_a_cooler_of_a_tank_that_was_held_is_traced_beside_the_numbers_of_the_tank() -> None:
    h = null(*(machine(nodes, links=LINKS | WATER, sources=more, sensors=SENSORS) for nodes, more in MADE))
    found = search_traced_relays(h.case, h, switched(h), 1, 1)
    assert "water" in found[0].found[-1].places and found[0].chi < 1.1
    told = {path.rpartition(".")[2]: value for path, value in found[0].own_values.items()}
    assert told["set"] == pytest.approx(20, abs=0.3) and told["heat_capacity"] == pytest.approx(60e3, rel=0.2)
    assert told["power"] == pytest.approx(900, rel=0.2)


@pytest.fixture(scope="module")
def chilled() -> Hypothesis:
    """A bar of three lumps cooled by a relay, told on two."""
    runs = tuple(recorded(long_plant(3, cooler=COOLER), ladder, i) for i, ladder in enumerate(LADDERS))
    return fit_hypothesis(Case(long_plant(2), runs), long_plant(2))


def test_a_relay_that_keeps_step_on_coarse_lumps_is_carried_to_finer_ones(chilled: Hypothesis) -> None:
    coarse = search_traced_relays(chilled.case, chilled, switched(chilled), 1, 1)[0]
    over = lay_over(long_plant(3), coarse.found)
    assert over is not None
    fine = carry_in_step(chilled.case, long_plant(3), over[1], coarse, is_quick=False)
    assert fine is not None and fine.chi < 1.1
    assert any(path.endswith("set") and value == pytest.approx(24, abs=0.2) for path, value in fine.own_values.items())


def test_the_tank_beside_which_is_traced_again_keeps_its_numbers() -> None:
    known = machine(HELD, links=LINKS | WATER, sources=SOURCES, sensors=SENSORS)
    chiller = next(c for c in candidates(known, ["speed", "ambient"]) if c.switches and "water" in c.places)
    of = _find_place(chiller)
    assert of is not None
    told = {p.path: 1.3 * p.value(p.centre) for p in of.followed.own}
    held = _write(of.followed, told)
    assert held is not None and not held.own
    followed = follow_relays(held.machine, {of.mode(np.array([0.0, 60.0])).name})
    assert followed.nodes["water"].heat_capacity == pytest.approx(told["nodes.water.heat_capacity"], rel=1e-9)
    assert _write(of.followed, {"nodes.water.heat_capacity": -1.0}) is None


def test_what_comes_with_a_relay_is_brought_again_beside_laws_that_became_straight() -> None:
    links = LINKS | WATER | {"shine": FAN["shine"]}
    known, truth = (machine(nodes, links=links, sources=more, sensors=SENSORS) for nodes, more in MADE)
    h = null(known, truth)
    chiller = next(c for c in switched(h) if "water" in c.places)
    beside = fit_or_none(h.case, (chiller,), chiller.own, h.values | chiller.usual, 0)
    plain = straighten(beside, chiller) if beside is not None else None
    assert plain is not None and not plain.machine.nodes["water"].is_part
    again = candidate(plain.machine, chiller.kind, chiller.patch)
    assert again is not None and Space(again).parts == Space(chiller).parts == ("water",)


def test_what_brings_no_relay_is_not_carried(cooled: Hypothesis) -> None:
    source = next(c for c in candidates(cooled.machine, cooled.case.drivers) if not c.switches and c.own)
    assert carry_in_step(cooled.case, cooled.root, [source], cooled, is_quick=False) is None


def test_nothing_is_traced_where_nothing_is_missing() -> None:
    innocent = null(plant(), plant())
    assert trace_relays(innocent, switched(innocent), 1) == []


def test_levels_are_those_that_are_wrong_for_the_shortest_time() -> None:
    edges, watched = np.arange(0, 1000, 10.0), 22 + 2 * np.sin(np.arange(99) / 6)
    on = np.empty(99)
    now = False
    for k, T in enumerate(watched):
        on[k] = now = T >= 21.5 if now else T > 23.0
    on[40] = 1 - on[40]
    pair = _match_levels([_Course(edges, watched, on)], 1.0)
    assert pair is not None
    np.testing.assert_allclose(pair, (23.0, 21.5), atol=0.3)


@pytest.mark.parametrize(
    ("watched", "on", "levels"),
    [
        ([20.0, 24.0, 26.0, 25.0], [0, 0, 1, 1], (26.0, 23.0)),
        ([20.0, 24.0, 26.0, 22.0], [0, 0, 1, 1], (26.0, 20.0)),
        ([26.0, 24.0, 20.0, 25.0], [1, 1, 0, 0], (27.0, 20.0)),
        ([26.0, 24.0, 20.0, 21.0], [1, 1, 0, 0], (23.0, 20.0)),
        ([20.0, 24.0, 26.0, 22.0], [0, 0, 0, 0], None),
    ],
)
def test_a_relay_that_only_goes_on_or_off_has_a_level_that_it_did_not_meet(
    watched: list[float], on: list[int], levels: tuple[float, float] | None
) -> None:
    course = _Course(np.arange(5) * 60.0, np.array(watched), np.array(on))
    assert _match_levels([course], 2.0) == levels


def test_instants_that_pass_each_other_go() -> None:
    mode = RelayMode("m", np.array([0.0, 100.0, 200.0, 300.0, 400.0]), np.full(4, 60.0), 0.0)
    moved = mode.shift(np.array([10.0, 130.0, 5.0, -20.0]), 500.0)
    assert moved.t.tolist() == [0.0, 110.0, 380.0] and moved.first == 0.0
    np.testing.assert_array_equal(mode.shift(np.zeros(4), 500.0).t, mode.t)


@pytest.mark.parametrize("first", [0.0, 1.0])
def test_what_passes_the_start_is_as_it_was_after_and_what_passes_the_end_goes(first: float) -> None:
    mode = RelayMode("m", np.array([0.0, 30.0, 200.0, 400.0]), np.full(3, 60.0), first)
    moved = mode.shift(np.array([-50.0, 0.0, 150.0]), 500.0)
    assert moved.t.tolist() == [0.0, 200.0] and moved.first == 1 - first


def test_what_a_fit_cannot_simulate_is_not_looked_for(cooled: Hypothesis, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuses(network: object) -> None:
        raise refuse(Spot("m.yaml"), "it melts", "take the relay out")

    monkeypatch.setattr("network.analysis.diagnosis.switching.followed_search.check_followed", refuses)
    assert search_traced_relays(cooled.case, cooled, switched(cooled), 1, 1) == []
