"""The contract every entry of the catalogue keeps: its class, its reading and writing, its sentence.

The tests loop over the registry: a new file is covered as it is.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any

import pytest
from catalogue import KINDS, LAWS, NAMED, Draw, drawn, each_kind, each_law

from network.catalogue.declaration.declare import Declared, Effect
from network.catalogue.declaration.discovery import kinds
from network.catalogue.declaration.fields import REQUIRED, ParamField
from network.catalogue.expansions.base import Expansion
from network.platform.quantities.units import show, unit
from network.platform.refusal import Complaints, Spot
from network.platform.yaml.document import tree_of


def test_the_catalogue_holds_what_the_machine_file_promises() -> None:
    built = {kind for _, kind in KINDS}
    for snippet in ("contact", "forced_convection", "windage", "timed_source", "preload_friction", "hidden_mass"):
        assert snippet in built


@each_kind
def test_a_class_is_final_and_says_what_it_is(cls: type[Effect]) -> None:
    assert not cls.__subclasses__()
    assert len(cls.__dict__.get("__doc__") or "") > 100
    assert re.search(r"[=∝√]", cls.__doc__ or ""), "an equation"
    assert cls.strength in cls.fields
    assert cls.sentence
    assert {*cls.replaces} <= NAMED
    lines = (cls.__doc__ or "").splitlines()
    assert lines[0].rstrip().endswith(("|ω|", ".", ",", ":", ";")) or len(lines) > 1


@each_kind
def test_parameters_say_unit_bounds_meaning_and_a_typical_value(cls: type[Effect]) -> None:
    for name, field in cls.params().items():
        assert unit(field.unit)
        assert field.low < field.high, name
        assert len(field.meaning) > 3, name
        assert field.low <= field.proposal() <= field.high, name
        if field.default is REQUIRED or field.default is None:
            assert field._typical is not None or field.default is None, f"{cls.kind}.{name} has no typical value"


@each_kind
def test_replaced_kinds_have_the_numbers_that_are_kept(cls: type[Effect]) -> None:
    for kind, numbers in cls.replaces.items():
        theirs = kinds(cls.section)[kind]
        for their, our in numbers.items():
            given, kept = theirs.params()[their], cls.params()[our]
            assert unit(given.unit).dimension == unit(kept.unit).dimension
            assert kept.high >= given.high


def read(cls: type[Declared], body: Mapping[str, Any]) -> tuple[Any, list[str]]:
    complaints = Complaints()
    entry = cls.read("it", tree_of(dict(body), Spot("test", 7)), complaints)
    return entry, [str(refusal) for refusal in complaints.refusals]


@each_law
@pytest.mark.parametrize("spread", ["", "30 %"])
def test_what_is_written_reads_back_equal(cls: type[Effect], spread: str) -> None:
    tried = 0
    for seed in range(60):
        entry, refusals = read(cls, Draw(cls, seed, wide=True).body(spread))
        if refusals:
            continue
        tried += 1
        again, faults = read(cls, entry.to_plain())
        assert not faults
        assert again == entry and again.structure() == entry.structure()
        for name, number in entry.numbers.items():
            assert again.numbers[name].value == pytest.approx(number.value, rel=1e-12)
            assert again.numbers[name].prior == number.prior
            assert again.numbers[name].spread == pytest.approx(number.spread, rel=1e-9)
    assert tried > 3


def bounds() -> Iterator[Any]:
    for cls in LAWS:
        for name, field in cls.params().items():
            for end in ("low", "high"):
                yield pytest.param(cls, field, end, id=f"{cls.kind}.{name}.{end}")


@pytest.mark.parametrize(("cls", "field", "end"), list(bounds()))
def test_just_outside_a_bound_is_refused(cls: type[Effect], field: ParamField, end: str) -> None:
    form = next((form for form in cls.one_of if field.attribute in form), cls.one_of[0] if cls.one_of else ())
    other = {name for group in cls.one_of for name in group} - set(form)
    draw = Draw(cls, 1)
    body: dict[str, Any] = {"kind": cls.kind}
    for name, own in cls.fields.items():
        if (name in form or own.default is REQUIRED) and name not in other:
            body[own.key] = draw._value(own, "")
    step = 1e-6 * (field.high - field.low)
    outside = field.low - step if end == "low" else field.high + step
    at_bound = 0.0 if field.positive and end == "low" else outside
    for value in {outside, at_bound}:
        _, refusals = read(cls, body | {field.key: show(value, field.unit, 12)})
        about = [text for text in refusals if f": {field.key} '" in text]
        assert len(about) == 1, refusals
        assert about[0].startswith("test:7: ") and "; " in about[0]


@each_law
def test_every_required_key_is_asked_for(cls: type[Effect]) -> None:
    body = Draw(cls, 3).body()
    for field in cls.fields.values():
        if field.default is REQUIRED and not any(field.attribute in form for form in cls.one_of):
            _, refusals = read(cls, {key: value for key, value in body.items() if key != field.key})
            assert any(f"lacks '{field.key}'" in text and field.meaning in text for text in refusals), refusals
    if cls.one_of:
        keys = {cls.fields[name].key for form in cls.one_of for name in form}
        _, refusals = read(cls, {key: value for key, value in body.items() if key not in keys})
        assert any("exactly one of" in text for text in refusals)


@each_law
def test_every_form_is_read_and_two_at_once_are_refused(cls: type[Effect]) -> None:
    draw = Draw(cls, 5)
    groups = [{cls.fields[n].key: draw._value(cls.fields[n], "") for n in form} for form in cls.one_of]
    base = {key: value for key, value in draw.body().items() if not any(key in group for group in groups)}
    for group in groups:
        _, refusals = read(cls, base | group)
        assert not any("exactly one of" in text for text in refusals), refusals
    for first, second in pairwise(groups):
        _, refusals = read(cls, base | first | second)
        assert any("exactly one of" in text for text in refusals)


@each_law
def test_a_sentence_names_places_and_numbers(cls: type[Effect]) -> None:
    for axis in ("z", "a") if issubclass(cls, Expansion) and "a" in cls.axes else ("z",):
        for entry in drawn(cls, 3, axis):
            sentence = entry.said(channel="T")
            assert len(sentence) > 10
            assert not re.search(r"[{}]|None|Place\(|\bNumber\b|array", sentence), sentence
