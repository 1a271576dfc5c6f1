"""Paths of entries and numbers, and patches as a class, over every machine of the project."""

from __future__ import annotations

from pathlib import Path

import pytest
from build import machine

from network.analysis.diagnosis.candidates.candidates import candidates
from network.catalogue.declaration.discovery import kinds
from network.catalogue.declaration.entry_path import NESTED, EntryPath, NumberPath, axis_of, displacement
from network.catalogue.declaration.fields import Nested
from network.catalogue.declaration.patch import Patch
from network.catalogue.declaration.sections import section
from network.catalogue.nodes import Node
from network.catalogue.sensors.sensor import Sensor
from network.engine.response.parameters import at_values, free_parameters
from network.machine.lumps import level_patch
from network.machine.machine import Machine
from network.platform.refusal import Spot
from network.platform.yaml.document import Branch, plain

SHIPPED = sorted((Path(__file__).parents[1] / "machines").glob("*.yaml"))
each_machine = pytest.mark.parametrize("file", SHIPPED, ids=lambda file: file.stem)
SPOT = Spot("test")
GROWS = {"kind": "stretching", "of": "d'axe", "length": "300 mm", "expansion": "1.1e-5 1/K", "direction": 1}
LAG = {"kind": "sensor_lag", "lag": "20 s ± 10 %"}


def oddly_named() -> Machine:
    """Names with dots, quotes and words of the file format in them, and entries inside of others."""
    wax = {"at": "28 degC", "over": "2 K", "latent_heat": "180 kJ ± 20 %"}
    return machine(
        {"d'axe": {"heat_capacity": "4 kJ/K ± 10 %", "melts": wax}, "x.melts": {"heat_capacity": "2 kJ/K ± 10 %"},
         "air": {"temperature": "ambient"}},
        links={"d'axe to x": {"kind": "conduction", "between": ["d'axe", "x.melts"], "conductance": "9 W/K ± 5 %"},
               "skin": {"kind": "convection", "between": ["x.melts", "air"], "conductance": "5 W/K ± 30 %"}},
        tcp={"z": {"d'axe grows": GROWS}},
        sensors={"T": {"measures": "d'axe", "noise": "0.1 K", "effects": [LAG]}, "T.2": {"measures": "x.melts", "noise":
                 "0.1 K", "effects": [LAG, {"kind": "sensor_offset", "offset": "0.1 K ± 0.2 K"}]}},
    )  # fmt: skip


@each_machine
def test_a_path_reads_back_from_its_text(file: Path) -> None:
    m = Machine.load(file)
    assert list(m.by_path) == list(dict(m.entries()))
    for path, entry in m.entries():
        assert EntryPath.parse(str(path)) == m.paths[str(path)] == path
        for field in entry.params().values():
            number = NumberPath(path, field.key)
            assert NumberPath.parse(str(number), m.paths) == number


def test_paths_inside_of_entries_and_along_axes_read_back() -> None:
    texts = ["nodes.d'axe.melts", "sensors.T.effects.0", "sensors.T.2.effects.1", "tcp.z.d'axe grows", "links.skin"]
    paths = oddly_named().paths
    for text in texts:
        assert str(paths[text]) == text and EntryPath.parse(text) == paths[text]
    assert paths["sensors.T.2.effects.1"] == EntryPath("sensors", "", "T.2", ("effects", 1))
    assert paths["tcp.z.d'axe grows"].keys == ("tcp", "z", "d'axe grows")
    assert paths["nodes.x.melts"] == EntryPath("nodes", "", "x.melts")
    assert NumberPath.parse("links.gone.conductance", paths) is None


@pytest.mark.parametrize("text", ["", "links", "links.", "tcp.z", "tcp.z."])
def test_what_is_no_path_is_told(text: str) -> None:
    with pytest.raises(ValueError, match="is no path of an entry"):
        EntryPath.parse(text)


def test_what_entries_hold_is_what_their_fields_declare() -> None:
    declared: dict[str, dict[str, bool]] = {}
    for cls in (Node, *kinds("links").values(), *kinds("sources").values(), Sensor):
        if own := {name: field.many for name, field in cls.fields.items() if isinstance(field, Nested)}:
            declared.setdefault(cls.section, {}).update(own)
    assert declared == {name: dict(held) for name, held in NESTED.items()}


def test_a_displacement_is_told_from_a_part() -> None:
    assert axis_of(displacement("z")) == "z" and axis_of("tcp") is None and axis_of("spindle") is None


def test_every_number_is_exchanged_where_it_stands() -> None:
    m = oddly_named()
    values = {p.path: p.value(p.centre) * 1.5 for p in free_parameters(m)}
    assert {"nodes.d'axe.melts.latent_heat", "sensors.T.2.effects.1.offset", "nodes.x.melts.heat_capacity"} <= {*values}
    changed = at_values(m, values)
    for text, value in values.items():
        number = NumberPath.parse(text, m.paths)
        assert number is not None and changed.by_path[number.entry].__dict__[number.key] == value
    with pytest.raises(KeyError):
        at_values(m, {"links.gone.conductance": 1.0})


# -- patches --------------------------------------------------------------------------------------------------------
@each_machine
def test_a_difference_laid_over_gives_the_other_machine(file: Path) -> None:
    m = Machine.load(file)
    levels = section(m.tree, "levels").items
    others = [level_patch(m, name) for name, level in levels.items() if isinstance(level, Branch)]
    proposed = {c.kind: c.machine.tree for c in candidates(m, {*m.inputs, "speed", "feed"})}
    for other in (*others, *proposed.values()):
        for a, b in ((m.tree, other), (other, m.tree)):
            assert without_empty(plain(Patch.difference(a, b).over(a, SPOT))) == without_empty(plain(b))
    assert not Patch.difference(m.tree, m.tree)


def without_empty(sections: dict[str, object]) -> dict[str, object]:
    """Axes and sections in which nothing is left count as gone."""
    tcp = {axis: own for axis, own in (sections.get("tcp") or {}).items() if own}  # type: ignore[attr-defined]
    return {key: own for key, own in {**sections, "tcp": tcp}.items() if own}


@each_machine
def test_a_patch_of_all_entries_is_the_machine(file: Path) -> None:
    m = Machine.load(file)
    whole = Patch.of((path, entry.to_plain()) for path, entry in m.entries() if not path.inner)
    assert dict(m.patched(whole).entries()) == dict(m.entries())
    assert [path for path, _ in whole.entries()] == [path for path, _ in m.entries()]
    for path, body in whole.entries():
        assert whole.at(path) == body
        assert {key for key in body if not isinstance(body[key], dict | list)} == {
            number.key for number, _ in whole.numbers() if number.entry == path
        }


def test_a_value_is_written_where_its_path_leads() -> None:
    patch = Patch({"sensors": {"T.2": {"effects": [LAG, {"kind": "sensor_offset"}]}}, "links": {"skin": None}})
    path = EntryPath("sensors", "", "T.2", ("effects", 1))
    more = patch.with_value(NumberPath(path, "offset"), "0.2 K")
    assert more.at(path) == {"kind": "sensor_offset", "offset": "0.2 K"} and patch.at(path) == {"kind": "sensor_offset"}
    assert [path.name for path, _ in more.by_name()] == ["T.2", "skin"] and len([*more.entries()]) == 3


def test_only_places_are_moved() -> None:
    body = {"kind": "windage", "into": {"windage": 0.5, "air": 0.5}, "reads": "windage"}
    patch = Patch({"nodes": {"windage": {"lumps": 2}}, "sources": {"windage": body}, "links": {"windage": None}})
    moved = patch.move_place("windage", "windage@0..0.5")
    into = {"windage@0..0.5": 0.5, "air": 0.5}
    assert moved["sources"] == {"windage": {"kind": "windage", "into": into, "reads": "windage@0..0.5"}}
    assert moved["nodes"] == patch["nodes"] and moved["links"] == patch["links"]
