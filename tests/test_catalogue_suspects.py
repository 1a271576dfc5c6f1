"""What the suspects put into a machine, and which parts turn."""

from __future__ import annotations

import pytest
from catalogue import machine

from network.analysis.diagnosis.lump_refinement import list_finer_machines
from network.catalogue.mechanisms.friction import turning
from network.catalogue.suspects.coolant_tank import CoolantTank
from network.catalogue.suspects.foundation import Foundation
from network.catalogue.suspects.hidden_mass import HiddenMass

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
