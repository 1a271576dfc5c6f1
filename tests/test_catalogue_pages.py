"""The catalogue's pages and the JSON Schema say what the declarations say, and what they say can be read."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from test_refusals import BENCH

from network.catalogue.declaration.declare import Declared
from network.catalogue.declaration.discovery import kinds, open_rooms
from network.catalogue.declaration.fields import ParamField, read_kind
from network.catalogue.declaration.registry import sections
from network.catalogue.materials import BUILT_IN, SOURCES
from network.machine.machine import Machine
from network.machine.schema import schema
from network.platform.refusal import Complaints, Refused, Spot
from network.platform.yaml.document import dump, parse
from network.report.words.catalogue_page import catalogue_page, example_line

open_rooms()
KINDS = {f"{section}.{kind}": cls for section in sections() for kind, cls in kinds(section).items()}
WRITTEN = {path: cls for path, cls in KINDS.items() if cls.section != "suspects"}
SHIPPED = sorted((Path(__file__).parents[1] / "machines").glob("*.yaml"))


# -- pages ----------------------------------------------------------------------------------------------------------
def test_every_kind_stands_in_the_table_below_its_section() -> None:
    blocks = {block.partition(":")[0].split()[0]: block for block in catalogue_page().split("\n\n")}
    for cls in KINDS.values():
        assert re.search(rf"^  {cls.kind} +\S", blocks[cls.section], re.MULTILINE)


@pytest.mark.parametrize("path", KINDS)
def test_a_page_tells_what_is_declared(path: str) -> None:
    cls, page = KINDS[path], catalogue_page(path.partition(".")[2])
    for field in cls.fields.values():
        unit = f" [{field.unit}]" if isinstance(field, ParamField) and field.unit != "1" else ""
        assert f"\n  {field.key}{unit}  " in page
    for word in (*cls.replaces, *str(cls.__doc__).split()):
        assert word in page
    assert not cls.strength or f"Strength: {cls.fields[cls.strength].key};" in page
    assert max(map(len, page.splitlines())) <= 120


@pytest.mark.parametrize("path", WRITTEN)
def test_an_example_reads_back(path: str) -> None:
    line, complaints = example_line(WRITTEN[path]), Complaints()
    assert f"name: {line}" in " ".join(catalogue_page(path.partition(".")[2]).split())
    entry = read_kind(kinds(path.partition(".")[0]), path, parse(line, Spot("example")), complaints)
    assert not complaints.refusals
    assert entry is not None and entry.kind == WRITTEN[path].kind


def test_an_unknown_kind_is_answered_with_the_likely_one() -> None:
    with pytest.raises(Refused) as caught:
        catalogue_page("radiaton")
    assert str(caught.value) == "catalogue radiaton: there is no such kind; did you mean 'radiation'?"


def test_the_materials_are_listed_with_their_numbers_and_sources() -> None:
    page = catalogue_page("materials")
    rows = {line.split()[0]: line.split() for line in page.splitlines() if line.startswith("  ")}
    assert rows["steel"][1:5] == ["7850", "477", "50.66", "11.3"] and rows["material"][-1] == "source"
    for name, stuff in BUILT_IN.items():
        told = [float(x) for x in rows[name][1:5]]
        own = [stuff.density, stuff.specific_heat, stuff.conductivity, 1e6 * float(stuff.expansion)]
        assert told == pytest.approx([float(x) for x in own], rel=1e-3) and SOURCES[name] in page
    assert "cast_iron" in catalogue_page("cast_iron") and "invar" not in catalogue_page("cast_iron")
    assert "`lptn catalogue materials`" in catalogue_page()


def test_its_example_of_a_material_can_be_read(tmp_path: Path) -> None:
    file = tmp_path / "m.yaml"
    own = catalogue_page("materials").partition("materials:\n    ")[2]
    file.write_text(f"machine: m\nreference: 20 degC\nmaterials:\n  {own}\nnodes:\n"
                    "  bed: {material: nodular_iron, length: 1 m, area: 100 cm^2}\n"
                    "sources: {h: {kind: heat_source, into: {bed: 1}, power: 5 W}}\n", encoding="utf-8")  # fmt: skip
    assert Machine.load(file).nodes["bed"].capacity == pytest.approx(7100 * 515 * 0.01)


def test_an_unknown_material_is_answered_with_the_list(tmp_path: Path) -> None:
    file = tmp_path / "m.yaml"
    file.write_text("machine: m\nreference: 20 degC\nnodes: {a: {material: Guss, length: 1 m, area: 1 m^2}}\n"
                    "sources: {h: {kind: heat_source, into: {a: 1}, power: 5 W}}\n", encoding="utf-8")  # fmt: skip
    with pytest.raises(Refused, match=r"there is no material 'Guss'; .*`lptn catalogue materials` lists what is built"):
        Machine.load(file)


def test_examples_in_the_schema_are_short() -> None:
    assert not re.search(r"\d{5,}[1-9]|\.\d{6,}", json.dumps(SCHEMA))


# -- schema ---------------------------------------------------------------------------------------------------------
SCHEMA = schema()
TYPES = {"object": dict, "array": list, "string": str, "number": (int, float), "integer": int, "boolean": bool}


def faults(value: Any, rule: dict[str, Any], where: str = "") -> Iterator[str]:
    """What the part of JSON Schema that is used here has against a value."""
    if "$ref" in rule:
        yield from faults(value, SCHEMA["$defs"][rule["$ref"].removeprefix("#/$defs/")], where)
    allowed = [rule["type"]] if isinstance(rule.get("type"), str) else rule.get("type", [])
    if allowed and not any(value is None if t == "null" else isinstance(value, TYPES[t]) for t in allowed):
        yield f"{where}: type"
    if value != rule.get("const", value) or value not in rule.get("enum", [value]):
        yield f"{where}: choice"
    if isinstance(value, str) and not re.search(rule.get("pattern", ""), value):
        yield f"{where}: pattern"
    if isinstance(value, int | float) and not rule.get("minimum", value) <= value <= rule.get("maximum", value):
        yield f"{where}: bounds"
    for many, right in (("oneOf", (1,)), ("anyOf", range(1, 99))):
        if many in rule and sum(not any(faults(value, r)) for r in rule[many]) not in right:
            yield f"{where}: {many}"
    if "not" in rule and not any(faults(value, rule["not"])):
        yield f"{where}: not"
    if isinstance(value, list):
        if not rule.get("minItems", 0) <= len(value) <= rule.get("maxItems", len(value)):
            yield f"{where}: length"
        for i, child in enumerate(value):
            yield from faults(child, rule.get("items", {}), f"{where}.{i}")
    if isinstance(value, dict):
        yield from (f"{where}: lacks {key}" for key in rule.get("required", ()) if key not in value)
        for key, child in value.items():
            inside = rule.get("properties", {}).get(key, rule.get("additionalProperties", {}))
            yield from faults(child, inside, f"{where}.{key}") if inside is not False else [f"{where}: unknown {key}"]


def read(text: str) -> Any:
    """YAML as an editor sees it."""
    return yaml.safe_load(text)


def test_the_schema_is_json_and_names_every_kind_and_parameter() -> None:
    assert json.loads(json.dumps(SCHEMA)) == SCHEMA
    for path, cls in WRITTEN.items():
        properties = SCHEMA["$defs"][path]["properties"]
        assert set(properties) == {"kind", *(field.key for field in cls.fields.values())}
        assert all(properties[field.key]["description"].startswith(field.meaning) for field in cls.fields.values())


def test_every_reference_leads_somewhere() -> None:
    names = re.findall(r'"\$ref": "#/\$defs/([^"]+)"', json.dumps(SCHEMA))
    assert set(names) == set(SCHEMA["$defs"])


@pytest.mark.parametrize("path", WRITTEN)
def test_the_schema_takes_every_example(path: str) -> None:
    assert not list(faults(read(example_line(WRITTEN[path])), SCHEMA["$defs"][path]))


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_the_schema_takes_what_the_reader_takes(path: Path) -> None:
    assert not list(faults(read(path.read_text(encoding="utf-8")), SCHEMA))


def test_the_schema_takes_what_is_written_of_a_machine(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(BENCH + "levels: {one: {merge: {unit: [shaft, housing]}, lumps: {unit: 1}}}\n")
    machine = Machine.load(tmp_path / "m.yaml", sets=["links.skin.conductance=5 W/K ± 10 %"])
    assert not list(faults(read(dump(machine.to_plain())), SCHEMA))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("conductance: 5 W/K", "conductance: 5"),
        ("conductance: 5 W/K", "conductence: 5 W/K"),
        ("conductance: 5 W/K", "conductance: 5 W/K, area: 1 m^2"),
        ("kind: convection", "kind: convecton"),
        ("direction: 1", "direction: 2"),
        ("lumps: 2", "lumps: 2.5"),
        ("reference: 20 degC\n", ""),
        ("sources:", "sorces:"),
        ("housing@0.5", "housing@half"),
        ("  z:\n", "  w:\n"),
    ],
)
def test_the_schema_refuses_what_it_can_see(old: str, new: str) -> None:
    assert list(faults(read(BENCH.replace(old, new)), SCHEMA))


def test_a_patch_may_take_entries_out() -> None:
    assert not list(faults(read("extends: other.yaml\nlinks: {skin: null}\ntcp: {z: null, y: {more: null}}\n"), SCHEMA))
    assert list(faults(read("links: {skin: null}\n"), SCHEMA))


def test_defaults_are_those_of_the_declarations() -> None:
    for path, cls in WRITTEN.items():
        for field in cls.fields.values():
            default = SCHEMA["$defs"][path]["properties"][field.key].get("default")
            assert (default is None) == (field.initial in (None, ()))
            assert default is None or _same(cls, field.key, default)


def _same(cls: type[Declared], key: str, default: Any) -> bool:
    field = next(field for field in cls.fields.values() if field.key == key)
    leaf: Any = parse(str(default).lower() if isinstance(default, bool) else str(default), Spot("default"))
    value = field.parse(leaf)
    return bool(getattr(value, "value", value) == field.initial)
