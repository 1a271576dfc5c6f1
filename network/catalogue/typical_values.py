"""What a proposal takes from the machine it is made for: its size, its surroundings, its speed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Declared, typical_body
from network.catalogue.declaration.fields import InputField
from network.catalogue.declaration.machine_protocol import MachineLike
from network.platform.quantities.units import split_number, unit

SPEED = "speed"
"""The input that what turns is read by, unless an entry says otherwise."""
SCALED = ("W", "W/K", "m^2")
"""Units of what is typically ten times as large on a machine that loses ten times as much."""
USUAL_LOSS = 100.0
"""W/K: what the machine tool of the typical values loses to everything that is held."""
FULL = {"rpm": 10_000.0, "m/min": 10.0, "W": 1000.0, "%": 100.0, "m": 1.0, "A": 10.0, "V": 10.0}
"""What an input reads at full load, in a unit of its kind."""
EXCESS = 10.0
"""K over the reference at which a loss is taken."""


def size_body(cls: type[Declared], machine: MachineLike, **given: Any) -> dict[str, Any]:
    """The YAML of a typical entry, heats, conductances and areas in proportion to what this machine loses."""
    body = typical_body(cls, **usual_input(cls, machine))
    for name, field in cls.params().items():
        if field.unit in SCALED and field.key in body:
            body[field.key] = field.write(size_value(cls, name, machine))
    return body | given


def size_value(cls: type[Declared], name: str, machine: MachineLike) -> float:
    """The typical value of a parameter in SI, in proportion to what this machine loses."""
    field = cls.params()[name]
    return min(float(f"{field.proposal() * size_of(machine):.2g}"), field.high)


def size_of(machine: MachineLike) -> float:
    """What it loses per kelvin, in shares of a usual machine tool; 1 where nothing is held."""
    loss = sum(_losses(machine))
    return loss / USUAL_LOSS if loss > 0 else 1.0


def _losses(machine: MachineLike) -> Iterator[float]:
    """Conductance between parts and held nodes [W/K], at rest, and the capacity flow of what is fed in."""
    u = {name: np.zeros(()) for name in ("time", *machine.inputs)}
    cold, warm = np.array(machine.reference), np.array(machine.reference + EXCESS)
    for link in machine.links.values():
        is_held = [machine.nodes[place.node].is_held for place in link.places[:2]]
        if is_held[0] != is_held[1]:
            T_a, T_b = (cold if held else warm for held in is_held)
            own = (cold for _ in link.readings())
            yield abs(float(link.slopes(T_a, T_b, u, *own)[0]))


def usual_surroundings(machine: MachineLike, besides: str = "") -> str | None:
    """The held node that most links lead to; None where there is no other."""
    held = [name for name, node in machine.nodes.items() if node.is_held and name != besides]
    return max(held, key=lambda name: links_to(machine, name), default=None)


def links_to(machine: MachineLike, name: str) -> int:
    """How often links and streams name a node."""
    return sum(place.node == name for link in machine.links.values() for place in link.places)


def usual_input(cls: type[Declared], machine: MachineLike) -> dict[str, str]:
    """The `input` of a proposal on a machine without the input that its kind reads by default, where entries of that
    machine read another in its place; empty where none does."""
    field = cls.fields.get("input")
    other = name_input(str(field.default), machine) if isinstance(field, InputField) and field.default else None
    return {"input": other} if other is not None and isinstance(field, InputField) and other != field.default else {}


def name_input(default: str, machine: MachineLike) -> str | None:
    """What a machine calls the input of that name: so, or as its entries that would read it say; None where it has
    none."""
    if default in machine.inputs:
        return default
    for _, entry in machine.entries():
        field = entry.fields.get("input")
        if isinstance(field, InputField) and field.default == default:
            return str(getattr(entry, field.attribute))
    return None


def usual_speed(machine: MachineLike) -> dict[str, Any]:
    """The reference speed that the machine's own entries use, as the key of a proposal; empty where none does."""
    for entry in (*machine.sources.values(), *machine.links.values()):
        if "reference_speed" in entry.fields:
            return {"reference_speed": entry.to_plain()["reference_speed"].partition(" ±")[0]}
    return {}


def list_full_inputs(machine: MachineLike) -> dict[str, tuple[float, str]]:
    """What every input that is no temperature reads at full load, with the unit: as an entry that follows it says, or
    usual for its kind. Inputs of other kinds are left out."""
    told = dict(_full_by_entries(machine))
    usual = {unit(text).dimension: (value, text) for text, value in FULL.items()}
    speed = usual_speed(machine).get("reference_speed", "")
    usual |= {unit("rpm").dimension: split_number(speed)} if speed else {}
    found = {name: told.get(name) or usual.get(unit(text).dimension) for name, text in machine.inputs.items() if text}
    return {name: full for name, full in found.items() if full}


def _full_by_entries(machine: MachineLike) -> Iterator[tuple[str, tuple[float, str]]]:
    """(input, value and unit) of every entry that says at which value it gives what it gives."""
    for entry in (*machine.sources.values(), *machine.links.values()):
        body = entry.to_plain()
        if "at" in body and "with" in body:
            value, text = split_number(body["at"])
            yield body["with"], (value, text or "1")
