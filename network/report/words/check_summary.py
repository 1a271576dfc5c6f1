"""What `lptn check` says of a machine as JSON, and of a scenario or recording in words."""

from __future__ import annotations

from typing import Any

import numpy as np

from network.catalogue.nodes import Node
from network.machine.machine import Machine
from network.platform.quantities.units import show
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario


def machine_summary(machine: Machine) -> dict[str, Any]:
    """What is in a machine, for machines."""
    return {
        "machine": machine.name,
        "nodes": {
            name: {
                "kind": _kind_of(node),
                "heat_capacity": {"value": node.capacity, "unit": "J/K"} if node.is_part else None,
                "lumps": node.lumps,
            }
            for name, node in machine.nodes.items()
        },
        "links": {name: link.kind for name, link in machine.links.items()},
        "sources": {name: source.kind for name, source in machine.sources.items()},
        "tcp": {axis: {name: e.kind for name, e in entries.items()} for axis, entries in machine.tcp.items()},
        "sensors": {name: str(sensor.measures) for name, sensor in machine.sensors.items()},
        "inputs": dict(machine.inputs),
        "uncertain": {
            path: {"value": n.value, "prior": n.prior, "spread": n.spread} for path, n in machine.uncertain.items()
        },
        "warnings": [str(warning) for warning in machine.warnings],
    }


def _kind_of(node: Node) -> str:
    return "held" if node.is_held else "massless" if node.is_massless else "bar" if node.is_bar else "mass"


def tell_source(machine: Machine, source: Scenario | Recording) -> str:
    """What a scenario or a recording brings to a machine it fits."""
    if isinstance(source, Scenario):
        extent = f"{source.duration / 3600:.4g} h, a sample every {source.output:g} s"
        return f"{source.schedule.file}: scenario '{source.name}', {extent}; fits"
    t = source.t
    lines = [f"{source.file}: recording '{source.name}', {(t[-1] - t[0]) / 3600:.4g} h, {len(t)} samples; fits"]
    lines += [f"  {remark}" for remark in source.remarks]
    for name in machine.sensors:
        if name in source.columns:
            lines.append(f"  {name}: {_extent(source.columns[name].values, machine.sensors[name].unit)}")
    missing = [name for name in machine.sensors if name not in source.columns]
    unused = [name for name in source.columns if name not in machine.sensors and name not in machine.inputs]
    if missing:
        lines.append(f"  not recorded: {', '.join(missing)}")
    if unused:
        lines.append(f"  not used by this machine: {', '.join(unused)}")
    return "\n".join(lines)


def _extent(values: np.ndarray[Any, np.dtype[np.float64]], unit_text: str) -> str:
    finite = values[np.isfinite(values)]
    if not len(finite):
        return "no value at all"
    gaps = len(values) - len(finite)
    ends = f"{show(float(finite.min()), unit_text)} to {show(float(finite.max()), unit_text)}"
    return ends + (f", {gaps} gaps" if gaps else "")
