"""What the suspects put into a machine, and which parts turn."""

from __future__ import annotations

import pytest
from catalogue import machine

from network.analysis.diagnosis.lumps.lump_refinement import list_finer_machines
from network.catalogue.declaration.discovery import kinds
from network.catalogue.declaration.fields import Place
from network.catalogue.mechanisms.friction import turning
from network.catalogue.suspects.coolant_tank import CoolantTank
from network.catalogue.suspects.foundation import Foundation
from network.catalogue.suspects.hidden_mass import HiddenMass
from network.catalogue.suspects.interposed_mass import InterposedMass
from network.catalogue.suspects.post import Post

REFERENCE = 22.0


def test_a_hidden_mass_is_sized_after_its_host() -> None:
    for patch in HiddenMass.proposes(machine()):
        name, link = next(iter(patch["links"].items()))
        patched, host = machine().patched(patch), link["between"][0]
        assert patched.nodes[name].capacity == pytest.approx(0.3 * machine().nodes[host].capacity)
        assert patched.nodes[name].capacity / float(patched.links[name].conductance) == pytest.approx(900)


def test_a_foundation_is_held_at_the_reference() -> None:
    patch = next(Foundation.proposes(machine()))
    patched = machine().patched(patch)
    assert patched.nodes["foundation"].temperature == REFERENCE
    twice = patched.patched(next(Foundation.proposes(patched)))
    assert "foundation 2" in twice.nodes


def test_only_a_coolant_of_constant_temperature_becomes_a_tank() -> None:
    (patch,) = CoolantTank.proposes(machine())
    patched = machine().patched(patch)
    cooler = patched.sources["coolant cooler"]
    assert patched.nodes["coolant"].is_part and not patched.nodes["coolant"].is_held
    assert str(cooler.watches) == "coolant" and float(cooler.set) == 21
    assert str(patched.links["coolant to surroundings"].between[1]) == "air"
    assert not list(CoolantTank.proposes(machine("one mass")))


def test_the_only_surroundings_do_not_become_a_tank() -> None:
    constant = machine("one mass").patched({"nodes": {"air": {"temperature": "20 degC"}}})
    assert not list(CoolantTank.proposes(constant))


def test_a_stream_from_a_tank_is_led_back_into_it() -> None:
    (patch,) = CoolantTank.proposes(machine("coolant"))
    stream = machine("coolant").patched(patch).links["stream"]
    assert [str(place) for place in stream.through] == ["supply", "jacket", "supply"]


def test_bars_are_refined_again_and_again() -> None:
    once, twice, *_ = list_finer_machines(machine())
    assert {name: node.lumps for name, node in once.nodes.items() if node.is_bar} == {"shaft": 10, "housing": 10}
    assert twice.nodes["shaft"].lumps == 20
    assert "± 20 %" in str(once.to_plain()["nodes"]["housing"]), "numbers keep their uncertainty"
    assert not list(list_finer_machines(machine("alone")))


def test_what_turns_is_told_by_friction_or_by_its_mark() -> None:
    assert list(turning(machine())) == ["shaft"]
    assert list(turning(machine("no metal"))) == ["a"]
    unmarked = machine("no metal").patched({"nodes": {"a": {"heat_capacity": "2 kJ/K", "rotates": "false"}}})
    assert list(turning(unmarked)) == []


STEADY = {"kind": "heat_source", "power": "50 W", "with": "always"}


def test_a_part_comes_between_one_source_or_all_of_a_part() -> None:
    """The friction heats two places: it is led elsewhere only as far as it heats the part that is named."""
    named = {str(suspect.of): suspect for suspect in InterposedMass.suspected(machine())}
    assert set(named) == {"motor", "pump", "shaft"}
    steady = machine().patched({"sources": {name: {**STEADY, "into": {"shaft": 1}} for name in ("motor", "pump")}})
    assert {str(suspect.of) for suspect in InterposedMass.suspected(steady)} == {"shaft"}, "friction is not steady"
    alone = steady.patched({"sources": {"friction": {**STEADY, "into": {"shaft": 1}}}})
    assert not [*InterposedMass.suspected(alone)], "what never changes shows no delay"
    for of, sources in (("motor", {"motor": {1.0}}), ("shaft", {"motor": {1.0}, "friction": {0.5}})):
        patch = named[of].patch(machine())
        patched = machine().patched(patch)
        new = f"part between {of}"
        shares = {name: {s for p, s in patched.sources[name].into if p.node == new} for name in patch["sources"]}
        assert shares == sources
        assert [str(place) for place in patched.links[new].between] == ["shaft", new]
        assert InterposedMass.from_patch(patched, patch).to_plain() == named[of].to_plain()
    assert {str(p): s for p, s in patched.sources["friction"].into} == {new: 0.5, "housing": 0.5}


@pytest.mark.parametrize(
    ("of", "told"), [("friction", "heats several places; name the part"), ("column skin", "is no source, and no part")]
)
def test_what_is_not_heated_from_one_place_has_no_part_in_between(of: str, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        InterposedMass.typical(of=Place(of)).patch(machine())


def test_a_post_is_read_back_with_all_that_it_is() -> None:
    for suspect in Post.suspected(machine()):
        patch = suspect.patch(machine())
        again = Post.from_patch(machine().patched(patch), patch)
        assert again.to_plain() == suspect.to_plain()
    near = {(str(s.near), str(s.surroundings), s.moves, s.direction) for s in Post.suspected(machine())}
    parts = ("shaft", "housing", "column", "air", "coolant")
    assert {(n, m, d) for n, _, m, d in near} == {(n, f"tcp.{a}", d) for n in parts for a in "zy" for d in (1, -1)}
    assert ("coolant", "air", "tcp.z", 1) in near and ("air", "coolant", "tcp.z", 1) in near


def test_proposals_read_the_speed_by_the_name_that_the_machine_has() -> None:
    friction = {"kind": "bearing_friction", "into": {"a": 1}, "torque": "0.1 N m", "input": "n_main"}
    renamed = machine("no metal").patched({"sources": {"bearing": friction}})
    assert set(renamed.inputs) == {"ambient", "n_main"}
    for section, kind in (("sources", "windage"), ("sources", "seal_friction"), ("tcp", "centrifugal_growth")):
        for patch in kinds(section)[kind].proposes(renamed):
            assert set(renamed.patched(patch).inputs) == {"ambient", "n_main"}
    drivers = [s["with"] for p in kinds("sources")["heat_source"].proposes(renamed) for s in p["sources"].values()]
    assert drivers == ["always"] * 2 + ["running"] * 2
    assert not list(kinds("tcp")["centrifugal_growth"].proposes(machine("coolant")))
