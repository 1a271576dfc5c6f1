"""Entries of a machine file from parts, their sizes and the paths of displacement; every number with its ±."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from network.analysis.drafting.channel_names import fresh_name, name_part
from network.analysis.drafting.displacement_paths import STEEL, Path
from network.analysis.drafting.heat_scale import POWER, Sizes
from network.analysis.drafting.identification import Identified
from network.analysis.drafting.lag_bench import ALWAYS
from network.analysis.drafting.part_models import PartModel
from network.platform.quantities.units import show, unit

SURE, VAGUE = "± 50 %", "± 100 %"
"""What stands behind a number whose scale a power in W told, and one of which only ratios are told."""
METERED = "± 20 %"
"""Behind the share of a recorded power that becomes heat where it is measured."""
DEFAULT_INPUT = {"rpm": "speed", "m/min": "feed"}


@dataclass(frozen=True)
class Names:
    """Nodes: ambient's, those of held inputs, by name of the input, and of parts, in their order."""

    ambient: str
    held: Mapping[str, str]
    parts: tuple[str, ...]

    def node(self, key: int | str) -> str:
        """Of a part by its index, of a held input by its name."""
        return self.parts[key] if isinstance(key, int) else self.held[key]


def behind(part: str) -> str:
    """The name of what is behind a part."""
    return f"behind {part}"


def name_nodes(found: Identified) -> Names:
    """No two alike."""
    ambient = fresh_name(found.roles.ambient or "ambient", ())
    taken = [ambient]
    held = dict[str, str]()
    for name in found.roles.held:
        held[name] = fresh_name(name_part([name], taken), taken)
        taken.append(held[name])
    parts = list[str]()
    for model in found.models:
        parts.append(name_part(model.group.sensors, [*taken, *parts]))
    return Names(ambient, held, tuple(parts))


def sections_of(
    found: Identified, sizes: Sequence[Sizes], paths: Sequence[Path], names: Names
) -> dict[str, dict[str, Any]]:
    """nodes, links, sources, tcp and sensors."""
    sections: dict[str, dict[str, Any]] = {
        "nodes": dict(_nodes(found, sizes, names)),
        "links": dict(_links(found, sizes, names)),
        "sources": dict(_sources(found, sizes, names)),
        "tcp": {path.axis: dict(_stretches(path, names)) for path in paths if path.slopes},
        "sensors": dict(_sensors(found, paths, names)),
    }
    return {key: entries for key, entries in sections.items() if entries}


def _nodes(found: Identified, sizes: Sequence[Sizes], names: Names) -> Iterator[tuple[str, Any]]:
    for name, size in zip(names.parts, sizes, strict=True):
        spread = SURE if size.is_known else VAGUE
        yield name, {"heat_capacity": f"{amount_of(size.capacity, 'J/K')} {spread}"}
        if size.behind:
            yield behind(name), {"heat_capacity": f"{amount_of(size.behind[0], 'J/K')} {spread}"}
    held = found.roles.ambient or f"{show(found.level, 'degC', 4)} ± {show(found.spread, 'K', 2)}"
    yield names.ambient, {"temperature": held}
    for column, name in names.held.items():
        yield name, {"temperature": column}


def _links(found: Identified, sizes: Sequence[Sizes], names: Names) -> Iterator[tuple[str, Any]]:
    for k, (model, size) in enumerate(zip(found.models, sizes, strict=True)):
        spread, own = SURE if size.is_known else VAGUE, names.parts[k]
        yield f"{own} skin", _link("convection", own, names.ambient, size.around, spread)
        if size.behind:
            yield f"{own} to {behind(own)}", _link("conduction", own, behind(own), size.behind[1], spread)
        if model.parent is not None and size.to_parent:
            other = names.parts[model.parent]
            yield f"{other} to {own}", _link("conduction", other, own, size.to_parent, spread)
        for column, conductance in size.to_held.items():
            other = names.held[column]
            yield f"{other} to {own}", _link("conduction", other, own, conductance, spread)


def _link(kind: str, a: str, b: str, conductance: float, spread: str) -> dict[str, Any]:
    return {"kind": kind, "between": [a, b], "conductance": f"{amount_of(conductance, 'W/K')} {spread}"}


def _sources(found: Identified, sizes: Sequence[Sizes], names: Names) -> Iterator[tuple[str, Any]]:
    for part, size in zip(names.parts, sizes, strict=True):
        for name, heat in size.heats.items():
            title = f"{part} always" if name == ALWAYS else f"{part} by {name}"
            yield title, {**_source(found, name, heat, size.is_known), "into": {part: 1}}


def _source(found: Identified, name: str, heat: float, is_known: bool) -> dict[str, Any]:
    """heat: [W] at the largest value of the input."""
    spread = SURE if is_known else VAGUE
    if name == ALWAYS:
        return {"kind": "heat_source", "power": _power(heat, spread)}
    dimension, largest = unit(found.units[name]).dimension, found.largest[name]
    for text, kind, key, given in (
        ("rpm", "bearing_friction", "torque", "N mm"),
        ("m/min", "guide_friction", "power_per_feed", "W/(m/min)"),
    ):
        if dimension == unit(text).dimension:
            own = {} if name == DEFAULT_INPUT[text] else {"input": name}
            return {"kind": kind, key: f"{show(heat / largest, given, 3)} {spread}", **own}
    at, share = _full(found.units[name], largest)
    more = {"exponent": 2} if found.goes_squared(name) else {}
    if dimension == POWER:
        spread = METERED
    return {"kind": "heat_source", "power": _power(heat * share, spread), "with": name, "at": at, **more}


def _full(unit_text: str, largest: float) -> tuple[str, float]:
    """The value of an input at which its heat is told, and that over the largest recorded one: a whole unit of power,
    100 %, else the largest."""
    given = unit(unit_text)
    if given.dimension == POWER or unit_text == "%":
        number = 1 if given.dimension == POWER else 100
        return f"{number} {unit_text}", given.to_si(number) / largest
    at = show(largest, unit_text, 4)
    return at, 1.0


def _power(heat: float, spread: str) -> str:
    """A power that may be negative has its ± in W."""
    share = float(spread.strip("± %")) / 100
    return f"{amount_of(heat, 'W')} ± {amount_of(abs(heat) * share, 'W')}"


def _stretches(path: Path, names: Names) -> Iterator[tuple[str, Any]]:
    for key, slope in path.slopes.items():
        node = names.node(key)
        body = {"kind": "stretching", "of": node, "length": f"{show(abs(slope) / STEEL, 'mm', 3)} {VAGUE}"}
        yield f"{node} moves {path.axis}", {**body, "expansion": f"{STEEL:g} 1/K", "direction": 1 if slope > 0 else -1}


def _sensors(found: Identified, paths: Sequence[Path], names: Names) -> Iterator[tuple[str, Any]]:
    for name, model in zip(names.parts, found.models, strict=True):
        for sensor in model.group.sensors:
            lags = model.fit.lags
            late = (
                [{"kind": "sensor_lag", "lag": f"{show(lags.short, 's', 3)} {VAGUE}"}] if lags and lags.is_late else []
            )
            body = {"measures": name, "noise": show(noise_of(found, model, sensor), "K", 2)}
            yield sensor, body | ({"effects": late} if late else {})
    for path in paths:
        if path.slopes:
            gate = {"while": path.gate} if path.gate else {}
            noise = show(max(path.noise, path.left), "um", 2)
            yield path.channel, {"measures": f"tcp.{path.axis}", "noise": noise, "zero": "start", **gate}


def noise_of(found: Identified, model: PartModel, sensor: str) -> float:
    """How true a part of one temperature is to a sensor on it [K], where its readings are no rougher than that; a fit
    that is told the readings' own noise bends every number to what the structure lacks."""
    return max(found.noise[sensor], float(np.hypot(model.fit.rms, model.group.apart)))


def amount_of(value: float, unit_text: str) -> str:
    """Three digits, with the prefix that reads best: 38.2 kJ/K, 4.1 W/K."""
    for prefix, scale in (("M", 1e6), ("k", 1e3)):
        if abs(value) >= scale:
            return f"{value / scale:.3g} {prefix}{unit_text}"
    return f"{value:.3g} {unit_text}"
