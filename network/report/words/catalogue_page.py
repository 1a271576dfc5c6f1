"""The catalogue as text: all kinds by section, or one kind with its equation, its parameters and an example."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Iterator
from textwrap import fill
from typing import Any

from network.catalogue.declaration.declare import Declared, Effect
from network.catalogue.declaration.discovery import kinds, open_rooms
from network.catalogue.declaration.field import REQUIRED, Field
from network.catalogue.declaration.input_field import InputField
from network.catalogue.declaration.number_fields import ParamField
from network.catalogue.declaration.places import PlaceField, PlacesField, SharesField
from network.catalogue.declaration.registry import sections
from network.catalogue.materials import BUILT_IN
from network.catalogue.mechanisms.mechanism import Mechanism, Relay
from network.platform.refusal import Spot, likely, refuse, short
from network.platform.yaml.document import dump
from network.report.words.material_page import material_page

WIDTH = 110
HEADINGS = {
    "links": "links: heat between parts",
    "sources": "sources: heat into parts",
    "tcp": "tcp: how rising temperatures move the tool centre point",
    "effects": "effects of a sensor: what it does to the truth",
    "suspects": "suspects: missing physics of more than one entry, named by a diagnosis only",
}

MATERIALS = "materials"
POINTER = "materials: `lptn catalogue materials` lists what is built in, with numbers and sources"


def catalogue_page(kind: str | None = None) -> str:
    """All kinds by section, or the page of one; `materials`, or one of them. Raises Refused for an unknown name."""
    open_rooms()
    if kind is None:
        return "\n\n".join([*(_table(section) for section in sorted(sections(), key=_place_of)), POINTER])
    if kind == MATERIALS or kind in BUILT_IN:
        return material_page(BUILT_IN if kind == MATERIALS else [kind])
    ordered = sorted(sections(), key=_place_of)
    found = [kinds(section)[kind] for section in ordered if kind in kinds(section)]
    if not found:
        known = dict.fromkeys(name for section in ordered for name in kinds(section))
        names = [*known, MATERIALS, *BUILT_IN]
        raise refuse(Spot(f"catalogue {short(kind)}"), "there is no such kind", likely(kind, names))
    return "\n\n\n".join(map(_page, found))


def _place_of(section: str) -> int:
    order = list(HEADINGS)
    return order.index(section) if section in order else len(order)


def _table(section: str) -> str:
    rows = [(kind, _first_sentence(cls)) for kind, cls in kinds(section).items()]
    return "\n".join([HEADINGS.get(section, section), *_columns(rows)])


def _first_sentence(cls: type[Declared]) -> str:
    first = inspect.cleandoc(cls.__doc__ or "").partition("\n\n")[0]
    return " ".join(first.split())


# -- one kind -------------------------------------------------------------------------------------------------------
def _page(cls: type[Declared]) -> str:
    parts = [
        f"{cls.kind} ({HEADINGS.get(cls.section, cls.section)})",
        inspect.cleandoc(cls.__doc__ or ""),
        _list_rows("Places", [(f.key, f.meaning + _default(cls, f)) for f in cls.fields.values() if _is_place(f)]),
        _list_rows("Parameters", [_parameter(cls, f) for f in cls.fields.values() if not _is_place(f)]),
        _list_rows("States of its own", list(_states(cls))),
        _choice(cls),
        "\n".join(_remarks(cls)),
        f"Example\n{break_lines(f'  name: {example_line(cls)}')}" if cls.section != "suspects" else "",
    ]
    return "\n\n".join(part for part in parts if part)


def _states(cls: type[Declared]) -> Iterator[tuple[str, str]]:
    for name, state in cls.states.items() if issubclass(cls, Mechanism) else ():
        yield f"{name} [{state.unit}]", state.meaning


def _is_place(field: Field) -> bool:
    return isinstance(field, PlaceField | PlacesField | SharesField)


def _parameter(cls: type[Declared], field: Field) -> tuple[str, str]:
    """Its name with the unit, and what it is."""
    unit = f" [{field.unit}]" if isinstance(field, ParamField) and field.unit != "1" else ""
    bounds = f"; {_bounds(field)}" if isinstance(field, ParamField) else ""
    words = f"; one of {', '.join(getattr(field, 'options', ()))}" if getattr(field, "options", ()) else ""
    return f"{field.key}{unit}", f"{field.meaning}{bounds}{words}{_default(cls, field)}"


def _bounds(field: ParamField) -> str:
    return f"above 0, up to {field.range.rpartition(' to ')[2]}" if field.positive else field.range


def _default(cls: type[Declared], field: Field) -> str:
    if field.initial not in (None, ()):
        return f"; default {field.write(field.initial)}"
    needed = field.default is REQUIRED or any(field.attribute in form for form in cls.one_of)
    return "" if needed or "default" in field.meaning else "; may be left out"


def _choice(cls: type[Declared]) -> str:
    forms = (" + ".join(cls.fields[a].key for a in form) for form in cls.one_of)
    return "Exactly one of: " + " | ".join(forms) if cls.one_of else ""


def _remarks(cls: type[Declared]) -> Iterator[str]:
    if cls.strength:
        strength = cls.fields[cls.strength]
        without = "at 0 it is not there" if isinstance(strength, ParamField) else "no number to fit"
        yield f"Strength: {strength.key}; {without}."
    read = [f for f in cls.fields.values() if isinstance(f, InputField) and f.default is not None]
    if read:
        yield "Reads the input " + " and ".join(f"{f.default} [{f.unit}]" for f in read) + "."
    if issubclass(cls, Relay):
        yield "Switches on and off by itself."
    if issubclass(cls, Effect) and not (cls.is_searched() or cls.shows_in_readings):
        yield "A diagnosis does not look for it."
    if cls.replaces:
        yield f"Can take the place of: {', '.join(cls.replaces)}."


def _list_rows(title: str, rows: list[tuple[str, str]]) -> str:
    return "\n".join([title, *_columns(rows)]) if rows else ""


def _columns(rows: list[tuple[str, str]]) -> Iterable[str]:
    left = max(len(name) for name, _ in rows) + 4
    for name, text in rows:
        yield fill(text, WIDTH, initial_indent=f"  {name}".ljust(left), subsequent_indent=" " * left)


# -- an example -----------------------------------------------------------------------------------------------------
def example(cls: type[Declared]) -> dict[str, Any]:
    """An entry with what it cannot do without, and typical numbers."""
    first = set(cls.one_of[0]) if cls.one_of else set()
    in_forms = {attribute for form in cls.one_of for attribute in form}
    needed = {a for a, f in cls.fields.items() if f.default is REQUIRED and a not in in_forms} | first
    kind = {"kind": cls.kind} if cls.kind else {}
    return kind | {field.key: field.sample for attribute, field in cls.fields.items() if attribute in needed}


def example_line(cls: type[Declared]) -> str:
    """That entry as it stands in a file."""
    return " ".join(dump({"name": example(cls)}).removeprefix("name: ").split())


def break_lines(entry: str, most: int = 118) -> str:
    """An entry on lines of its file, broken between its keys."""
    lines = [""]
    for key in re.split(r"(?<=,) ", entry):
        joined = f"{lines[-1]} {key}" if lines[-1] else key
        lines = [*lines[:-1], joined] if len(joined) <= most else [*lines, f"         {key}"]
    return "\n".join(lines)
