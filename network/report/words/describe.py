"""A machine in words: what it is made of, what is uncertain, how fast it is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from network.catalogue.mechanisms.base import Stream
from network.catalogue.nodes import Node
from network.engine.assembly import build
from network.engine.time_constants import time_constants
from network.machine.checks import places_of
from network.machine.machine import Machine
from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import digits, span, table
from network.platform.quantities.units import Number, difference, show, unit, unit_of_output
from network.report.figures.strokes import conductance
from network.report.words.entry_settings import settings_of

MOST_LUMPS = 300
"""Beyond, time constants cost more than they tell."""


def describe(machine: Machine) -> str:
    """Parts, links, sources, tool centre point, sensors, uncertain numbers and time constants, in short tables."""
    counts = (
        ("node", len(machine.nodes)), ("link", len(machine.links)), ("source", len(machine.sources)),
        ("sensor", len(machine.sensors)),
    )  # fmt: skip
    told = ", ".join(f"{count} {name}{'' if count == 1 else 's'}" for name, count in counts)
    blocks = [[f"{machine.name}: {told}; displacements are zero at {_celsius(machine.reference)}"]]
    blocks += [part(machine) for part in (_nodes, _links, _sources, _tcp, _sensors, _uncertain)]
    blocks += [[*_inputs(machine), _speed(machine)]]
    return "\n\n".join("\n".join(block) for block in blocks if block)


def _celsius(value: float) -> str:
    return show(value, "degC").replace("degC", "°C")


def _nodes(machine: Machine) -> list[str]:
    rows = [
        [name, _node_kind(node), _capacity(node), str(node.lumps) if node.is_part else ""]
        for name, node in machine.nodes.items()
    ]
    return table(["node", "kind", "heat capacity [kJ/K]", "lumps"], rows, ["heat capacity [kJ/K]", "lumps"])


def _node_kind(node: Node) -> str:
    if node.is_held:
        at = node.temperature if isinstance(node.temperature, str) else _celsius(float(node.temperature))
        return f"held at {at}" + (", drifts" if node.drifts is not None else "")
    kind = "massless junction" if node.is_massless else f"bar of {node.material}" if node.is_bar else "mass"
    return kind + (", rotates" if node.rotates else "") + (", melts" if node.melts is not None else "")


def _capacity(node: Node) -> str:
    return digits(node.capacity / 1e3) if node.is_part else ""


def _links(machine: Machine) -> list[str]:
    rows = []
    for name, link in machine.links.items():
        places = link.through if isinstance(link, Stream) else link.between
        value = link.transport()[1] if isinstance(link, Stream) else conductance(machine, link)
        joined = (" → " if isinstance(link, Stream) else " – ").join(map(str, places))
        rows.append([name, link.kind, joined, digits(value, 3), settings_of(link, ("conductance", "capacity_flow"))])
    streams = any(isinstance(link, Stream) for link in machine.links.values())
    header = ["link", "kind", "between", f"conductance{' or capacity flow' if streams else ''} [W/K]", "further"]
    return _table(header, rows, header[3:4])


def _sources(machine: Machine) -> list[str]:
    rows = []
    for name, source in machine.sources.items():
        into = ", ".join(f"{place} {share:.0%}" if share < 1 else str(place) for place, share in source.into)
        rows.append([name, source.kind, into, settings_of(source)])
    return _table(["source", "kind", "into", "with"], rows)


def _table(header: list[str], rows: list[list[str]], numbers: Sequence[str] = ()) -> list[str]:
    """A table; without rows none, and without its last column where that is empty."""
    if rows and not any(row[-1] for row in rows):
        header, rows = header[:-1], [row[:-1] for row in rows]
    return table(header, rows, numbers) if rows else []


def _tcp(machine: Machine) -> list[str]:
    rows = [
        [f"{axis}: {name}", entry.kind, ", ".join(str(place) for _, place in places_of(entry)), settings_of(entry)]
        for (axis, name), entry in machine.expansions.items()
    ]
    return _table(["tool centre point", "kind", "of", "with"], rows)


def _sensors(machine: Machine) -> list[str]:
    rows = []
    for name, sensor in machine.sensors.items():
        noise = difference(unit(sensor.noise.unit))
        effects = ", ".join(effect.kind for effect in sensor.effects)
        more = [f"with {effects}"] * bool(effects) + ["zeroed at the start"] * bool(sensor.zero)
        more += [f"while {sensor.gate} is not zero"] * bool(sensor.gate)
        what = ", ".join([str(sensor.measures), *more])
        rows.append([name, what, digits(noise.from_si(sensor.sigma), 2), pretty(noise.text)])
    return table(["sensor", "measures", "noise", "unit"], rows, ["noise"]) if rows else []


def _inputs(machine: Machine) -> Iterator[str]:
    if machine.inputs:
        named = (f"{name} [{unit}]" if unit else name for name, unit in machine.inputs.items())
        yield f"reads the inputs: {', '.join(named)}"


def _uncertain(machine: Machine) -> list[str]:
    rows = [
        _uncertain_row(f"{path}.{key}", getattr(entry.field_of(key), "unit", "degC"), number)
        for path, entry in machine.entries()
        for key, number in entry.uncertain().items()
    ]
    header = ["uncertain number", "value", "±", "unit"]
    return table(header, rows, header[1:3]) if rows else ["No number is uncertain: nothing to calibrate."]


def _uncertain_row(path: str, unit_text: str, number: Number) -> list[str]:
    given = unit_of_output(unit_text)
    if number.prior == "unknown":
        low, high = (digits(given.from_si(value), 3) for value in (number.low, number.high))
        return [path, "unknown", f"{low}..{high}", pretty(unit_text)]
    spread = f"{100 * number.spread:.3g} %" if number.prior == "log" else digits(number.spread / given.scale, 3)
    return [path, digits(given.from_si(number.value)), spread, pretty(unit_text)]


# -- time constants -------------------------------------------------------------------------------------------------
def _speed(machine: Machine) -> str:
    network = build(machine)
    if not network.is_affine():
        return "time constants: none, the network is not linear"
    if len(network.free) > MOST_LUMPS:
        return f"time constants: not looked for among {len(network.free)} lumps"
    taus = time_constants(network)
    if not len(taus):
        return "time constants: none"
    fastest = [f"fastest {span(taus[0])}"] if np.isfinite(taus[0]) else []
    endless = "it never settles: no path to a held node, or heat that grows as it warms"
    return f"time constants: {', '.join([*fastest, f'slowest {span(taus[-1])}' if np.isfinite(taus[-1]) else endless])}"
