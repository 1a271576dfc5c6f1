"""The contract every proposal of the catalogue keeps: it loads, adds, says where its strength is, and is believable."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from catalogue import TYPES, arguments, each_kind, each_machine, evaluated, machine, surroundings

from network.balance import heat_balance
from network.declare import Array, Effect
from network.expansions.base import Expansion
from network.fields import ParamField
from network.graph import build
from network.machine import Machine
from network.mechanisms.base import Source
from network.patch import merged, set_value
from network.proposals import bodies
from network.refusal import Spot
from network.sensors.base import SensorEffect
from network.units import Number
from network.yamlfile import tree_of

SHIPPED = Path(__file__).parents[1] / "machines"


def proposals(cls: type[Effect], on: Machine) -> list[Mapping[str, Any]]:
    return list(cls.proposes(on))


@each_kind
@each_machine
def test_proposals_load_and_keep_what_they_do_not_change(cls: type[Effect], name: str) -> None:
    bare = machine(name)
    before = dict(bare.entries())
    for patch in proposals(cls, bare):
        patched = bare.patched(patch)
        after = dict(patched.entries())
        touched = {path for path, _ in bodies(patch)}
        assert touched <= set(after)
        assert all(after[path] == before[path] for path in set(before) - touched)
        assert len(cls.told(patched, patch)) > 10
        path = cls.path_to(cls.strength, patch)
        assert path.rpartition(".")[0] in touched


@pytest.mark.parametrize("file", sorted(SHIPPED.glob("*.yaml")), ids=lambda file: file.stem)
def test_proposals_load_on_every_machine_of_the_project(file: Path) -> None:
    bare = Machine.load(file)
    for cls in TYPES:
        for patch in proposals(cls, bare):
            assert cls.told(bare.patched(patch), patch)


@each_kind
def test_every_kind_is_proposed_for_a_machine_that_has_everything(cls: type[Effect]) -> None:
    assert proposals(cls, machine())


@each_kind
def test_a_second_proposal_does_not_overwrite_the_first(cls: type[Effect]) -> None:
    if cls.replaces or cls.kind == "lumping":
        return
    first = proposals(cls, machine())[0]
    once = machine().patched(first)
    added = {path for path, _ in bodies(first)} - {path for path, _ in machine().entries()}
    for patch in proposals(cls, once):
        twice = dict(once.patched(patch).entries())
        assert added <= set(twice)
        assert {path for path, _ in bodies(patch)}.isdisjoint({p for p in added if not p.startswith("sensors.")})


def heats(on: Machine, temperatures: Mapping[str, float], u: Mapping[str, Array]) -> dict[str, float]:
    """Heat into every part at given mean temperatures, relays on."""
    network = build(on)
    T = np.full(network.size, 35.0)
    for name, value in temperatures.items():
        if name in network.parts:
            T[network.parts[name]] = value
    relays = sum(group.into.shape[1] for group in network.relays)
    into = heat_balance(network, T, u, np.ones(relays)).into
    return {name: float(into[part].sum()) for name, part in network.parts.items() if on.nodes[name].is_part}


def movements(on: Machine, seed: int, u: Mapping[str, Array]) -> dict[str, float]:
    total = {}
    for axis, entries in on.tcp.items():
        total[axis] = sum(float(e.movement(u, *arguments(e, seed))) for e in entries.values())
    return total


@each_kind
@each_machine
def test_strength_zero_changes_nothing(cls: type[Effect], name: str) -> None:
    """At strength 0 a patched machine heats and moves as it did before, also where one kind takes another's place."""
    strength = cls.fields[cls.strength]
    if not isinstance(strength, ParamField) or strength.positive:
        pytest.skip(f"{cls.strength} cannot be zero: nothing is its limit")
    bare = machine(name)
    rng = np.random.default_rng(1)
    temperatures = dict(zip(bare.nodes, rng.uniform(15, 60, len(bare.nodes)), strict=True))
    for patch in proposals(cls, bare):
        tree = merged(bare.tree, tree_of(patch, Spot("patch")))
        zero = Machine.read(set_value(tree, f"{cls.path_to(cls.strength, patch)}={strength.write(Number(0.0))}"), name)
        for seed in range(3):
            u = surroundings(seed)
            before, after = heats(bare, temperatures, u), heats(zero, temperatures, u)
            assert {part: after[part] for part in before} == pytest.approx(before, rel=1e-12, abs=1e-9)
            assert movements(zero, seed, u) == pytest.approx(movements(bare, seed, u), rel=1e-12, abs=1e-18)
        for sensor in zero.sensors.values():
            for effect in sensor.effects if issubclass(cls, SensorEffect) else ():
                truth = np.array(31.0)
                assert effect.kind != cls.kind or effect.reading(truth, truth, u) == truth


@each_kind
def test_typical_strengths_are_believable(cls: type[Effect]) -> None:
    """At 6000 rpm, 10 m/min and 2 kW, 10 K beside each other: watts to kilowatts, tenths of a µm to tenths of a mm."""
    noon = {"time": np.array(100.0 + 3 * 3600), "speed": np.array(628.0)}
    u = {**noon, "feed": np.array(1 / 6), "cutting_power": np.array(2000.0), "position": np.array(0.3)}
    for patch in proposals(cls, machine()):
        patched = machine().patched(patch)
        entries = dict(patched.entries())
        for path, body in bodies(patch):
            entry = entries[path]
            if body.get("kind") != cls.kind or isinstance(entry, SensorEffect):
                continue
            if isinstance(entry, Expansion):
                size = abs(float(entry.movement(u, *(np.array(10.0 * (i == 0)) for i in range(len(entry.readings()))))))
                assert 1e-7 < size < 5e-4, f"{path}: {size}"
            elif isinstance(entry, Source):
                pulse = {**u, "time": np.array(100.0)} if entry.kind == "timed_source" else u
                size = abs(float(evaluated(entry, pulse, *(np.array(22.0) for _ in entry.readings()))))
                assert 1 < size < 2000, f"{path}: {size}"
            else:
                size = abs(float(evaluated(entry, u, np.array(32.0), np.array(22.0))))
                assert 1 < size < 2000, f"{path}: {size}"
