"""The contract every proposal of the catalogue keeps: it loads, adds, says where its strength is, and is believable."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from catalogue import MACHINES, TYPES, arguments, each_kind, each_machine, evaluated, machine, surroundings

from network.catalogue.declaration.declare import Array, Effect
from network.catalogue.declaration.discovery import kinds
from network.catalogue.declaration.fields import ParamField
from network.catalogue.declaration.patch import Patch
from network.catalogue.expansions.base import Expansion
from network.catalogue.mechanisms.advection import Advection
from network.catalogue.mechanisms.base import Source
from network.catalogue.mechanisms.bearing_friction import BearingFriction
from network.catalogue.mechanisms.convection import Convection
from network.catalogue.mechanisms.friction import turning
from network.catalogue.mechanisms.guide_friction import GuideFriction
from network.catalogue.sensors.base import SensorEffect
from network.catalogue.typical_values import size_of
from network.engine.assembly import build
from network.engine.balance import heat_balance
from network.machine.machine import Machine
from network.machine.overrides import set_value
from network.platform.quantities.units import Number
from network.platform.refusal import Spot

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
        touched = {path for path, _ in Patch(patch).entries()}
        assert touched <= set(after)
        assert all(after[path] == before[path] for path in set(before) - touched)
        assert len(cls.told(patched, patch)) > 10
        assert cls.path_to(cls.strength, patch).entry in touched


@pytest.mark.parametrize("file", sorted(SHIPPED.glob("*.yaml")), ids=lambda file: file.stem)
def test_proposals_load_on_every_machine_of_the_project(file: Path) -> None:
    bare = Machine.load(file)
    for cls in TYPES:
        for patch in proposals(cls, bare):
            assert cls.told(bare.patched(patch), patch)


@each_kind
def test_every_kind_is_proposed_for_a_machine_that_has_everything(cls: type[Effect]) -> None:
    assert proposals(cls, machine())


def with_links(folder: Path, links: str) -> Machine:
    """The gantry mill with other links."""
    file = folder / "machine.yaml"
    file.write_text(f"extends: {SHIPPED / 'gantry_spindle.yaml'}\nlinks:\n{links}")
    return Machine.load(file)


@pytest.mark.parametrize(("surface", "is_left"), [("table", False), ("table@0.75..1", True), ("table@0.5", True)])
def test_a_surface_that_is_covered_in_part_has_a_rest(tmp_path: Path, surface: str, is_left: bool) -> None:
    skin = f"{{kind: convection, between: ['{surface}', ambient], conductance: 9 W/K}}"
    bare = with_links(tmp_path, f"  table top skin: null\n  table foot skin: null\n  skin: {skin}\n")
    named = {name for patch in proposals(Convection, bare) for name in patch["links"]}
    assert ("convection table ambient" in named) == is_left


@pytest.mark.parametrize(("kind", "pairs"), [
    (BearingFriction, {("shaft@0.1..0.22", "housing@0.04..0.2"), ("shaft@0.84..0.9", "housing@0.86..0.94"),
                       ("shaft@0.38..0.66", "stator")}),
    (GuideFriction, {("shaft@0.1..0.22", "housing@0.04..0.2"), ("headstock@0.7..1", "beam@0.3..0.5")}),
])  # fmt: skip
def test_what_rubs_in_a_joint_heats_both_of_its_parts(kind: type[Source], pairs: set[tuple[str, str]]) -> None:
    bare = Machine.load(SHIPPED / "gantry_spindle.yaml")
    shares = [body["into"] for patch in proposals(kind, bare) for body in patch["sources"].values()]
    halves = {tuple(into) for into in shares if len(into) == 2}
    assert halves >= pairs and all({*into.values()} == {0.5} for into in shares if len(into) == 2)
    assert (halves == pairs) == (kind is BearingFriction), "bearings sit where one of two parts turns"


def test_a_stream_comes_from_what_feeds_one(tmp_path: Path) -> None:
    """From other held nodes into a single part it is the law of convection, and would only be fitted twice."""
    assert not proposals(Advection, Machine.load(SHIPPED / "gantry_spindle.yaml"))
    bare = with_links(tmp_path, "  hose: {kind: advection, through: [coolant, housing], capacity_flow: 9 W/K}\n")
    streams = [body for patch in proposals(Advection, bare) for body in patch["links"].values()]
    ends = {tuple(body["through"]) for body in streams}
    assert ends == {("coolant", part) for part, node in bare.nodes.items() if node.is_part and part != "housing"}


@each_kind
def test_a_second_proposal_does_not_overwrite_the_first(cls: type[Effect]) -> None:
    if cls.replaces or cls.kind == "lumping":
        return
    first = proposals(cls, machine())[0]
    once = machine().patched(first)
    added = {path for path, _ in Patch(first).entries()} - {path for path, _ in machine().entries()}
    for patch in proposals(cls, once):
        twice = dict(once.patched(patch).entries())
        assert added <= set(twice)
        assert {path for path, _ in Patch(patch).entries()}.isdisjoint({p for p in added if p.section != "sensors"})


def heats(on: Machine, temperatures: Mapping[str, float], u: Mapping[str, Array]) -> dict[str, float]:
    """Heat into every part at given mean temperatures, relays on."""
    network = build(on)
    T = np.full(network.size, 35.0)
    for name, value in temperatures.items():
        if name in network.parts:
            T[network.parts[name]] = value
    relays = sum(group.into.shape[1] for group in network.relays)
    into = heat_balance(network, T, u, np.ones(relays)).into
    return {name: float(into[part].sum()) for name, part in network.bodies.items() if on.nodes[name].is_part}


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
        tree = Patch(patch).over(bare.tree, Spot("patch"))
        path = cls.path_to(cls.strength, patch)
        own = bare.patched(patch).by_path[path.entry]
        field = next(own.field_of(attribute) for attribute, one in own.fields.items() if one.key == path.key)
        zero = Machine.read(set_value(tree, f"{path}={field.write(Number(0.0))}"), name)
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
    """At 6000 rpm, 10 m/min, 2 kW, 3 A, 10 K beside each other: watts to kilowatts, tenths of a µm or of a mm."""
    noon = {"time": np.array(100.0 + 3 * 3600), "speed": np.array(628.0)}
    u = {**noon, "feed": np.array(1 / 6), "cutting_power": np.array(2000.0), "position": np.array(0.3)}
    u["current"] = np.array(3.0)
    for patch in proposals(cls, machine()):
        patched = machine().patched(patch)
        entries = dict(patched.entries())
        for path, body in Patch(patch).entries():
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
                own = (np.array(22.0) for _ in entry.readings())
                size = abs(float(evaluated(entry, u, np.array(32.0), np.array(22.0), *own)))
                assert 1 < size < 2000, f"{path}: {size}"


# -- what a fit frees -----------------------------------------------------------------------------------------------
def loosened(field: ParamField, value: float) -> str:
    """The number as it stands, made uncertain."""
    wide = 0.1 * abs(value) or 0.01 * (field.high - field.low)
    return str(field.write(Number(value, "normal", wide) if field.may_be_negative else Number(value, "log", 0.2)))


@each_kind
def test_strength_and_shapes_are_numbers_that_can_be_freed(cls: type[Effect]) -> None:
    params = cls.params()
    assert cls.strength not in cls.shapes and set(cls.shapes) <= set(params)
    if cls.strength not in params:
        assert not cls.shapes
        return
    for name in MACHINES:
        for patch in proposals(cls, machine(name)):
            tree, paths = Patch(patch).over(machine(name).tree, Spot("patch")), set()
            entries = dict(Machine.read(tree, name).entries())
            for parameter in (cls.strength, *cls.shapes):
                path = cls.path_to(parameter, patch)
                held, key = entries[path.entry], path.key
                value = float(next(held.__dict__[a] for a, f in held.fields.items() if f.key == key))
                if not value:
                    continue  # none of it is known with no ±; a search gives it its own
                field = held.field_of(next(a for a, f in held.params().items() if f.key == key))
                tree = set_value(tree, f"{path}={loosened(field, value)}")
                paths.add(str(path))
            assert paths <= set(Machine.read(tree, name).uncertain)


def sigma(entry: Any, parameter: str) -> float:
    """1σ of a number in its unit, 0 for a known one."""
    number = entry.numbers.get(parameter, Number(0.0))
    return number.spread * (number.value if number.prior == "log" else 1)


@each_kind
@each_machine
def test_what_is_taken_over_keeps_its_spread(cls: type[Effect], name: str) -> None:
    bare = machine(name)
    before = dict(bare.entries())
    for patch in proposals(cls, bare) if cls.replaces else ():
        after = dict(bare.patched(patch).entries())
        for path, body in Patch(patch).entries():
            taken = before.get(path)
            if taken is None or body.get("kind") != cls.kind or isinstance(taken, Convection):
                continue
            for theirs, ours in cls.replaces[taken.kind].items():
                assert sigma(after[path], ours) == pytest.approx(sigma(taken, theirs)), path


def test_a_convection_of_coefficient_and_area_keeps_the_spread_of_both() -> None:
    skin = {"kind": "convection", "between": ["housing", "air"], "coefficient": "5 W/(m^2 K) ± 30 %"}
    uncertain = machine().patched({"links": {"skin": {**skin, "area": "0.5 m^2 ± 40 %"}}})
    for patch in kinds("links")["forced_convection"].proposes(uncertain):
        if "skin" in patch["links"]:
            number = uncertain.patched(patch).links["skin"].numbers["conductance"]
            assert (number.value, number.spread) == pytest.approx((2.5, 0.5))
            return
    raise AssertionError("no proposal for the skin")


# -- where and how large --------------------------------------------------------------------------------------------
LAYOUTS = ("gantry_spindle", "vertical_mill", "belt_lathe", "ball_screw_axis")


def places(kind: str, on: Machine) -> list[Mapping[str, Any]]:
    """The bodies of that kind in its proposals."""
    cls = next(cls for cls in TYPES if cls.kind == kind and cls.section != "suspects")
    return [body for patch in proposals(cls, on) for _, body in Patch(patch).entries() if body.get("kind") == kind]


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_place_is_asked(layout: str) -> None:
    on = Machine.load(SHIPPED / f"{layout}.yaml")
    parts = [name for name, node in on.nodes.items() if node.is_part]
    inner = [name for name, node in on.nodes.items() if not node.is_held]
    turns = {*turning(on)}
    sensed = [name for name, sensor in on.sensors.items() if sensor.place is not None]

    drivers = {"always", "running"} if "speed" in on.inputs else {"always"}
    assert len(places("heat_source", on)) == len(parts) * len(drivers)
    heated = {(*body["into"], body["with"]) for body in places("heat_source", on)}
    assert heated == {(part, driver) for part in parts for driver in drivers}
    assert {next(iter(body["into"])) for body in places("thermostat_cooling", on)} == set(parts)
    assert {next(iter(body["into"])) for body in places("windage", on)} == turns and turns <= set(parts)
    joined = {frozenset(p.node for p in link.between) for link in on.links.values() if "between" in link.fields}
    apart = {frozenset((a, b)) for i, a in enumerate(inner) for b in inner[i + 1 :]} - joined
    assert {frozenset(body["between"]) for body in places("conduction", on)} == apart
    films = [e for e in on.links.values() if e.kind == "convection" and e.total is not None]
    assert len(places("forced_convection", on)) == len(films)
    for kind in ("sensor_lag", "sensor_fault"):
        assert len(places(kind, on)) == len(sensed)
    for kind, hosts in (("hidden_mass", set(parts)), ("foundation", set(parts) - turns)):
        assert {str(suspect.host) for suspect in kinds("suspects")[kind].suspected(on)} == hosts


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("cls", [cls for cls in TYPES if issubclass(cls, Expansion)], ids=lambda cls: cls.kind)
def test_a_displacement_is_proposed_both_ways(cls: type[Effect], layout: str) -> None:
    """Strengths have no sign: what is proposed along an axis is proposed against it too."""
    on = Machine.load(SHIPPED / f"{layout}.yaml")
    ways: dict[str, set[int]] = {}
    for patch in proposals(cls, on):
        for path, body in Patch(patch).entries():
            ways.setdefault(path, set()).add(body["direction"])
            sign = "+" if body["direction"] > 0 else "-"
            assert f"along {sign}{path.axis}" in cls.told(on.patched(patch), patch)
    assert all(directions == {1, -1} for directions in ways.values())


def test_parts_joined_over_a_massless_seat_are_neighbours() -> None:
    bends, tilts = (
        {tuple(body["between"]) for body in places(kind, machine()) if "between" in body}
        for kind in ("bending", "tilt")
    )
    assert bends == {("shaft", "housing"), ("housing", "column")} == tilts - {("shaft", "column")}


def test_a_screw_rubs_in_its_nut_and_its_bearings() -> None:
    """The bar that a nut moves along is the screw; what arises between both goes into the massless node there."""
    joints = {
        tuple(body["into"].items()) for body in places("screw_friction", Machine.load(SHIPPED / "ball_screw_axis.yaml"))
    }
    bearing = (("fixed bearing", 0.5), ("screw@0..0.05", 0.5))
    assert {joint for joint in joints if len(joint) > 1} == {bearing} and (("balls", 1.0),) in joints


def test_a_bar_that_is_cut_along_its_height_may_bend() -> None:
    """One lump has one temperature: nothing bends it."""
    on = Machine.load(SHIPPED / "gantry_spindle.yaml")
    bars = {body["of"]: set(body) for body in places("bending", on) if "of" in body}
    assert bars == {"table": {"kind", "of", "length", "direction"}}
    assert set(bars) == {name for name, node in on.nodes.items() if node.lumps > 1}


def test_proposals_are_as_large_as_the_machine() -> None:
    """A rig on a board loses some 30 mW/K: a thousandth of the heat that a machine tool is asked about."""
    rig, mill = (Machine.load(SHIPPED / f"{name}.yaml") for name in ("two_heater_rig", "gantry_spindle"))
    loss = 2 * (10 * 10e-4 + 9e-4 * 4 * 5.67e-8 * 304.15**3)
    assert size_of(rig) == pytest.approx(loss / 100, rel=1e-3)
    assert size_of(mill) == pytest.approx((29 + 1.4 + 2.8 + 12 + 52 + 21 + 9) / 100, rel=1e-9)
    heats = [[body["power"] for body in places("heat_source", on)] for on in (rig, mill)]
    assert heats == [["0.031 W"] * 2, ["130 W"] * 12]
    assert size_of(machine("alone")) == 1


def test_any_two_parts_may_tilt_what_they_carry_and_joined_ones_bend() -> None:
    of = Machine.load(SHIPPED / "gantry_spindle.yaml")
    parts = [name for name, node in of.nodes.items() if node.is_part]
    told = [frozenset(body["between"]) for body in places("tilt", of)]
    assert {*told} == {frozenset(pair) for pair in combinations(parts, 2)}
    assert {frozenset(body["between"]) for body in places("bending", of) if "between" in body} < {*told}
