"""What the tests of the catalogue share: every kind of the registry, some machines, entries drawn at random."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

import numpy as np
import pytest
import yaml

from network.catalogue.declaration.declare import Array, Declared, Effect
from network.catalogue.declaration.discovery import kinds
from network.catalogue.declaration.fields import (
    REQUIRED,
    Field,
    Nested,
    ParamField,
    PlaceField,
    PlacesField,
    SharesField,
    WholeField,
    WordField,
)
from network.catalogue.expansions.base import Expansion
from network.catalogue.mechanisms.base import Source
from network.catalogue.mechanisms.mechanism import Mechanism
from network.catalogue.sensors.base import SensorEffect
from network.catalogue.suspects.base import Suspect
from network.machine.machine import Machine
from network.platform.quantities.units import show
from network.platform.refusal import Refused, Spot
from network.platform.yaml.document import Branch, tree_of

SECTIONS = ("links", "sources", "tcp", "effects", "suspects")
KINDS = [(section, kind) for section in SECTIONS for kind in kinds(section)]
TYPES: list[type[Effect]] = [kinds(section)[kind] for section, kind in KINDS]
FLOWS = [cls for cls in TYPES if issubclass(cls, Mechanism)]
LAWS = [cls for cls in TYPES if not issubclass(cls, Suspect)]

NAMED = {kind for _, kind in KINDS}
"""Every kind there is: no other is named to users."""

STEEL = "material: steel, area: 100 cm^2, length"
HEAD = "machine: test\nreference: 22 degC\n"
AIR = "  air: {temperature: ambient}\n"
MACHINES = {
    "spindle": f"""{HEAD}
nodes:
  shaft: {{{STEEL}: 620 mm, rotates: true}}
  housing: {{{STEEL}: 580 mm, extra_heat_capacity: 1 kJ/K ± 20 %}}
  column: {{heat_capacity: 30 kJ/K}}
  seat: {{}}
{AIR}  coolant: {{temperature: 21 degC}}
links:
  bearing: {{kind: conduction, between: [shaft, housing], conductance: 20 W/K ± 30 %}}
  joint: {{kind: conduction, between: [housing, seat], conductance: 20 W/K}}
  foot: {{kind: conduction, between: [seat, column], conductance: 20 W/K}}
  skin: {{kind: convection, between: [housing, air], coefficient: 5 W/(m^2 K) ± 20 %, area: 0.5 m^2}}
  wall: {{kind: convection, between: [column, air], geometry: vertical_plate, length: 0.5 m, area: 0.5 m^2}}
  jacket: {{kind: convection, between: [housing, coolant], conductance: 20 W/K}}
  rinse: {{kind: advection, through: [coolant, column], capacity_flow: 8 W/K}}
sources:
  friction: {{kind: bearing_friction, into: {{shaft: 0.5, housing: 0.5}}, torque: 520 N mm ± 40 %}}
  motor: {{kind: motor_loss, into: {{shaft: 1}}, copper: 100 W ± 40 %, iron: 250 W, reference_speed: 8000 rpm}}
  pump: {{kind: heat_source, into: {{column: 1}}, power: 10 W ± 20 %, with: running}}
tcp:
  z: {{housing grows: {{kind: stretching, of: housing@0.1..0.77, direction: -1}}}}
  y: {{ram grows: {{kind: stretching, of: housing, fixed: 0.05, at: 40 mm + position, direction: 1}}}}
  a: {{head tilts: {{kind: tilt, between: [shaft, housing], distance: 300 mm, direction: 1}}}}
sensors:
  T: {{measures: housing, noise: 0.05 K}}
  T2: {{measures: column, noise: 0.05 K}}
  dz: {{measures: tcp.z, noise: 0.3 um}}
""",
    "one mass": HEAD + "nodes:\n  block: {heat_capacity: 2 J/K}\n" + AIR + """
links: {skin: {kind: convection, between: [block, air], conductance: 10 mW/K}}
sensors: {T: {measures: block, noise: 0.3 K}}
""",
    "alone": HEAD + "nodes: {block: {heat_capacity: 2 kJ/K}}\n"
    "sources: {heater: {kind: heat_source, into: {block: 1}, power: 5 W}}\n",
    "no metal": HEAD + "nodes:\n  a: {heat_capacity: 2 kJ/K}\n  b: {heat_capacity: 3 kJ/K}\n" + AIR + """
links:
  ab: {kind: conduction, between: [a, b], conductance: 3 W/K}
  skin: {kind: radiation, between: [b, air], emissivity_area: 0.2 m^2}
sources: {bearing: {kind: bearing_friction, into: {a: 1}, torque: 0.1 N m}}
tcp: {x: {grows: {kind: stretching, of: a, length: 300 mm, expansion: 1.1e-5 1/K, direction: 1}}}
sensors: {dx: {measures: tcp.x, noise: 0.3 um}}
""",
    "coolant": HEAD + f"nodes:\n  jacket: {{{STEEL}: 300 mm, lumps: 4}}\n" + AIR + """
  supply: {temperature: 20 degC}
links:
  stream: {kind: advection, through: [supply, jacket], capacity_flow: 200 W/K}
  skin: {kind: convection, between: [jacket, air], conductance: 4 W/K}
sources: {screw: {kind: screw_friction, into: {jacket@0.5: 1}, power_per_feed: 10 W/(m/min)}}
tcp: {y: {grows: {kind: stretching, of: jacket, direction: 1}}}
sensors: {T: {measures: jacket, noise: 0.05 K, effects: [{kind: sensor_offset, offset: 0.1 K}]}}
""",
}  # fmt: skip


@cache
def machine(name: str = "spindle") -> Machine:
    return Machine.read(read_text(MACHINES[name]), name)


def read_text(text: str) -> Branch:
    tree = tree_of(yaml.load(text, Loader=yaml.BaseLoader), Spot("test"))
    assert isinstance(tree, Branch)
    return tree


def names(value: object) -> str:
    return value.kind if isinstance(value, type) and issubclass(value, Declared) else str(value)


each_kind = pytest.mark.parametrize("cls", TYPES, ids=names)
each_law = pytest.mark.parametrize("cls", LAWS, ids=names)
each_flow = pytest.mark.parametrize("cls", FLOWS, ids=names)
each_machine = pytest.mark.parametrize("name", MACHINES)


class Draw:
    """Random admissible bodies of a class: numbers near the typical ones, or anywhere within the bounds (`wide`)."""

    def __init__(self, cls: type[Declared], seed: int, wide: bool = False) -> None:
        self.cls, self.rng, self.wide = cls, np.random.default_rng(seed), wide

    def body(self, spread: str = "") -> dict[str, Any]:
        forms = self.cls.one_of or ((),)
        form = forms[self.rng.integers(len(forms))]
        other = {name for group in forms for name in group} - set(form)
        body: dict[str, Any] = {"kind": self.cls.kind}
        for name, field in self.cls.fields.items():
            wanted = name in form or field.default is REQUIRED or self.rng.random() < 0.5
            if wanted and name not in other and (value := self._value(field, spread)) is not None:
                body[field.key] = value
        return body

    def _value(self, field: Field, spread: str) -> Any:
        if isinstance(field, ParamField):
            text = show(self.number(field), field.unit, 15)
            uncertain = spread and self.rng.random() < 0.5 and not text.startswith("0 ")
            return text + (f" ± {spread}" if uncertain and "degC" not in text else "")
        if isinstance(field, Nested):
            return field.sample
        if isinstance(field, PlaceField):
            return ("shaft", "housing@0.1..0.7")[self.rng.integers(2)]
        if isinstance(field, PlacesField):
            return [str(p) for p in self.rng.permutation(["shaft", "housing@0.2..0.9"])]
        if isinstance(field, SharesField):
            return {"shaft": 0.25, "housing@0.5": 0.75}
        if isinstance(field, WholeField):
            return field.allowed[self.rng.integers(len(field.allowed))] if field.allowed else field.low
        if isinstance(field, WordField) and not field.options and field.default is REQUIRED:
            return "T2" if "sensor" in field.meaning else "feed"
        options = field.options if isinstance(field, WordField) else ()
        return options[self.rng.integers(len(options))] if options else None

    def number(self, field: ParamField) -> float:
        if not self.wide:
            value = field.proposal() * self.rng.uniform(0.5, 1.5)
            return float(np.clip(value, field.low, field.high))
        low, high = field.low, field.high
        if low < 0:
            return float(self.rng.uniform(low, high))
        return float(np.exp(self.rng.uniform(np.log(max(low, high * 1e-9)), np.log(high))))


def patch_of(cls: type[Effect], body: Mapping[str, Any], axis: str = "z") -> dict[str, Any]:
    """The patch that adds one entry of that body to the machine 'spindle'."""
    if cls.section == "tcp":
        return {"tcp": {axis: {"it": body}}}
    if cls.section == "effects":
        return {"sensors": {"T": {"measures": "housing", "noise": "0.05 K", "effects": [body]}}}
    return {cls.section: {"it": body}}


def entry_in(cls: type[Effect], found: Machine, axis: str = "z") -> Any:
    if cls.section == "tcp":
        return found.tcp[axis]["it"]
    return found.sensors["T"].effects[0] if cls.section == "effects" else getattr(found, cls.section)["it"]


def drawn(cls: type[Effect], count: int, axis: str = "z") -> Iterator[Any]:
    """Entries with random typical numbers, resolved on the machine 'spindle'. Bodies that contradict themselves (a
    lever arm on an angular axis) are drawn again."""
    found, seed = 0, 0
    while found < count:
        seed += 1
        assert seed < 50 * count, f"{cls.kind}: hardly any body is admissible"
        try:
            patched = machine().patched(patch_of(cls, Draw(cls, seed).body(), axis))
        except Refused:
            continue
        found += 1
        yield entry_in(cls, patched, axis)


def surroundings(seed: int) -> dict[str, Array]:
    """Inputs at a random instant."""
    rng = np.random.default_rng(seed)
    return {
        "time": np.array(rng.uniform(0, 1e5)), "speed": np.array(rng.uniform(-1000, 1000)),
        "feed": np.array(rng.uniform(-0.5, 0.5)), "cutting_power": np.array(rng.uniform(0, 5000)),
        "position": np.array(rng.uniform(0, 0.5)), "ambient": np.array(rng.uniform(15, 30)),
        "current": np.array(rng.uniform(0, 5)),
    }  # fmt: skip


def arguments(entry: Any, seed: int) -> tuple[Array, ...]:
    """What its equation takes besides inputs: temperatures, readings, or truth and state."""
    rng = np.random.default_rng(1000 + seed)
    if isinstance(entry, Expansion):
        scale = {"mean": 20.0, "gradient": 50.0, "heat": 1e5}
        return tuple(np.array(scale[r.how] * rng.uniform(-1, 1)) for r in entry.readings())
    count = 0 if isinstance(entry, Source) else 2
    count += len(entry.readings()) if isinstance(entry, Mechanism) else 0
    return tuple(np.array(x) for x in rng.uniform(15, 60, count))


def own_arguments(entry: Mechanism, seed: int) -> tuple[Array, ...]:
    """The temperatures and states of its `readings`."""
    return arguments(entry, seed)[0 if isinstance(entry, Source) else 2 :]


def evaluated(entry: Any, u: Mapping[str, Array], *x: Array) -> Array:
    """Heat flow, heat, displacement or reading."""
    if isinstance(entry, Source):
        return np.asarray(entry.heat(u, *x))
    if isinstance(entry, Expansion):
        return np.asarray(entry.movement(u, *x))
    if isinstance(entry, SensorEffect):
        return np.asarray(entry.reading(*x, u))
    return np.asarray(entry.heat_flow(*x[:2], u, *x[2:]))
