"""JSON Schema of machine files, made from the declarations: editors complete and check with it while one writes.

It says what may stand where. What only the whole machine shows (names that lead nowhere, shares that add up to 1) and
the dimension of a unit are for the reader.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from network.catalogue.declaration.declare import Declared
from network.catalogue.declaration.discovery import kinds
from network.catalogue.declaration.entry_reading import Nested
from network.catalogue.declaration.field import REQUIRED, Field
from network.catalogue.declaration.number_fields import ParamField
from network.catalogue.expansions.base import AXES
from network.catalogue.materials import Material
from network.catalogue.nodes import Node
from network.catalogue.sensors.sensor import Sensor
from network.machine.reader import ROLES
from network.machine.validity import FIRST_READINGS, KEYS, START

DIALECT = "https://json-schema.org/draft/2020-12/schema"
Schema = dict[str, Any]


def schema() -> Schema:
    """The schema of a machine file, or of a patch in its form."""
    patch = _sections()
    single = {"machine": _text("name of the machine"), "reference": _text("temperature of zero displacement: 22 degC")}
    top = {**single, "extends": _text("another machine file, from this file's folder"),
           "calibrated": _calibrated(), **patch}  # fmt: skip
    return {
        "$schema": DIALECT,
        "title": "Machine file of lptn",
        **_object(top | {"levels": _describe_entries({"$ref": "#/$defs/level"})}),
        "anyOf": [{"required": ["machine", "reference", "nodes"]}, {"required": ["extends"]}],
        "$defs": {**_definitions(), "level": _object({**single, **patch, **_level_keys()})},
    }


def _calibrated() -> Schema:
    """What `lptn calibrate` writes of itself."""
    row = {"type": "array", "items": {"type": "number"}, "minItems": 1}
    held = ({"type": "string"}, {"type": "string"}, row | {"minItems": 2, "maxItems": 2}, row)
    inside = {key: {"type": "object", "additionalProperties": each} for key, each in zip(KEYS, held, strict=True)}
    start = {"const": FIRST_READINGS, "description": "where runs begin that do not say it themselves"}
    about = "written by lptn calibrate: where the machine holds, what it leaves, how its numbers are tied"
    return {"description": about, **_object({START: start, **inside}), "type": ["object", "null"]}


def _sections() -> Schema:
    """Every section of entries, as it may stand in a file, a level or a patch."""
    axis = _describe_entries(_one_of_kinds("tcp"))
    return {
        "closed_form": _object(dict.fromkeys(ROLES, _text("the part that plays this role in the closed formulas"))),
        **{cls.section: _describe_entries(_entry(cls)) for cls in (Material, Node, Sensor)},
        **{section: _describe_entries(_one_of_kinds(section)) for section in ("links", "sources")},
        "tcp": _object(dict.fromkeys(AXES, axis)),
    }


def _level_keys() -> Schema:
    count = {"type": "integer", "minimum": 1}
    members = {"type": "array", "items": {"type": "string"}, "minItems": 2, "uniqueItems": True}
    merge = {"type": "object", "additionalProperties": members, "description": "new name: parts that become one"}
    by_node = {"type": "object", "additionalProperties": count}
    lumps = {"oneOf": [count, by_node], "description": "lumps of every bar, or by node"}
    return {"lumps": lumps, "merge": merge}


def _definitions() -> Schema:
    """Every kind that a file can hold, by section and name."""
    written = ("links", "sources", "tcp", "effects")
    return {f"{section}.{kind}": _entry(cls) for section in written for kind, cls in kinds(section).items()}


def _one_of_kinds(section: str) -> Schema:
    return {"oneOf": [_reference(cls) for cls in kinds(section).values()]}


def _describe_entries(entry: Schema) -> Schema:
    """Entries by name; null takes one out of what is extended."""
    return {"type": ["object", "null"], "additionalProperties": {"oneOf": [entry, {"type": "null"}]}}


def _object(properties: Schema, **more: Any) -> Schema:
    return {"type": "object", "properties": properties, "additionalProperties": False, **more}


def _text(description: str) -> Schema:
    return {"type": ["string", "number"], "description": description}


def _entry(cls: type[Declared]) -> Schema:
    kind = {"kind": {"const": cls.kind}} if cls.kind else {}
    in_forms = {attribute for form in cls.one_of for attribute in form}
    fields = {field.key: _field(field) for field in cls.fields.values()}
    needed = [f.key for a, f in cls.fields.items() if f.default is REQUIRED and a not in in_forms]
    forms = {"oneOf": [_form(cls, form, in_forms) for form in cls.one_of]} if cls.one_of else {}
    about = {"description": (cls.__doc__ or "").partition("\n")[0]}
    return {**about, **_object(kind | fields, required=[*kind, *needed], **forms)}


def _form(cls: type[Declared], form: tuple[str, ...], in_forms: set[str]) -> Schema:
    """One group of fields, whole, and none of the other groups."""
    others = [{"required": [cls.fields[a].key]} for a in cls.fields if a in in_forms and a not in form]
    return {"required": [cls.fields[a].key for a in form], **({"not": {"anyOf": others}} if others else {})}


def _field(field: Field) -> Schema:
    default = {} if field.initial in (None, ()) else {"default": field.write(field.initial)}
    return {**_describe_nested(field), "description": meaning(field), **default}


def _describe_nested(field: Field) -> Schema:
    if not isinstance(field, Nested):
        return field.schema()
    if not field.many:
        return _entry(field.of())
    each: Mapping[str, type[Declared]] = field.of()
    return {"type": "array", "items": {"oneOf": [_reference(cls) for cls in each.values()]}}


def _reference(cls: type[Declared]) -> Schema:
    return {"$ref": f"#/$defs/{cls.section}.{cls.kind}"}


def meaning(field: Field) -> str:
    """What a field says of itself, with its unit and bounds."""
    return f"{field.meaning} ({field.range})" if isinstance(field, ParamField) else field.meaning
