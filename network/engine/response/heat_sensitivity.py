"""How heat flows depend on a parameter: the further heat that one unit of θ brings, over a run, at its temperatures.

A parameter of a link or source stands in the stacked law of its class; an imaginary step there gives the exact
derivative of its heat. A heat capacity acts like a heat −∂C/∂θ dT/dt. Whatever else a number may do (geometry,
materials, sensors) is left to differences of whole runs.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array, Declared, Indices
from network.catalogue.mechanisms.base import STEP, Stream
from network.catalogue.mechanisms.mechanism import Mechanism
from network.engine.balance import relay_slices
from network.engine.entry_groups import Flows, Heats
from network.engine.network import Network
from network.engine.response.linear_run import LinearRun, Push
from network.engine.response.parameters import Parameter
from network.engine.solvers.plan import Plan

GROUPS = ("flows", "heats", "relays")
FEW = 4
"""So many times as many flows are in a group as one number changes, and these are looked at alone."""
CAPACITY_KEYS = ("heat_capacity", "extra_heat_capacity")


def inputs_at_ends(plan: Plan) -> dict[str, Array]:
    """Inputs just after, then just before the edges: (2 K, 1)."""
    begin, end = plan.just_inside
    return {name: np.concatenate([begin[name], end[name]]) for name in begin}


Found = tuple[tuple[int, Indices], ...]
"""Where an entry stands: groups of a network, and members of each."""


@dataclass(frozen=True, eq=False)
class Stand:
    """Where a number stands and what its heat reaches: the lumps, and how the heat of each member spreads over these
    (members, lumps). among: in each group, the members whose same number is looked at with it."""

    found: Found
    lumps: Indices
    spread: Array
    among: tuple[Indices, ...]


def push_of(parameter: Parameter, course: LinearRun, theta: float, known: Stand | None = None) -> Push | None:
    """The further heat for one unit of θ; None where the parameter acts otherwise than by heat. known: where it stands,
    from `stand_of`."""
    network = course.problem.plan.network
    entry, slope = parameter.entry, parameter.slope(parameter.value(theta))
    if entry.section == "nodes" and parameter.attribute in CAPACITY_KEYS and not entry.inner:
        return _of_capacity(network, course, entry.name, slope)
    if entry.section not in ("links", "sources"):
        return None
    stand = stand_of(network, place_of(network, parameter)) if known is None else known
    if not stand.found:
        return None
    parts = [_by_parameter(course, g, members, parameter.attribute, among)
             for (g, members), among in zip(stand.found, stand.among, strict=True)]  # fmt: skip
    return _build_push(stand, slope, parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1))


def stand_of(network: Network, found: Found, among: Mapping[int, Indices] | None = None) -> Stand:
    """What the heat of a number reaches; held lumps take none up. among: by group, members that are looked at too."""
    none = np.zeros((0, network.size))
    spread = np.concatenate([none, *(_spread_of(network.groups[g], members) for g, members in found)])
    spread = np.where(np.isinf(network.capacity), 0.0, spread)
    lumps = np.flatnonzero(spread.any(axis=0))
    return Stand(found, lumps, spread[:, lumps], tuple((among or {}).get(g, members) for g, members in found))


def _spread_of(group: Flows | Heats[Mechanism], members: Indices) -> Array:
    return group.spread[members] if isinstance(group, Flows) else group.into[:, members].T


def _build_push(stand: Stand, slope: float, heat: Array) -> Push:
    """One push of some series of heat (2 K, members) times slope."""
    K, spread = len(heat) // 2, slope * stand.spread
    if len(spread) <= len(stand.lumps):
        return Push(stand.lumps, heat[:K], heat[K:], (), spread)
    heat = heat @ spread
    return Push(stand.lumps, heat[:K], heat[K:])


def is_capacity(p: Parameter, network: Network) -> bool:
    """Whether a number is the heat capacity of a part."""
    own = p.entry.section == "nodes" and p.attribute in CAPACITY_KEYS
    return own and not p.entry.inner and p.entry.name in network.parts


def place_of(network: Network, p: Parameter) -> Found:
    """The groups in which a number stands, and where in them; nothing where it also shapes the network."""
    name = str(p.entry)
    if name not in network.mechanisms or p.entry.section == "nodes":
        return ()
    if _shapes_cells(network.machine.by_path[p.entry], p.attribute):
        return ()
    index = network.mechanisms.index(name)
    members = ((g, np.flatnonzero(group.entry == index)) for g, group in enumerate(network.groups))
    return tuple((g, m) for g, m in members if len(m) and _is_stacked(network.groups[g].law, p.attribute))


def _shapes_cells(entry: Declared, attribute: str) -> bool:
    """Whether a number makes cells of fluid on the way, which only a stream with a delay has."""
    if not isinstance(entry, Stream):
        return False
    delay, _ = entry.replaced(**{attribute: entry.__dict__[attribute] + 1.0}).transport()
    return delay > 0


def _is_stacked(law: Declared, attribute: str) -> bool:
    """Whether the number stands in the law as an array and shapes nothing else."""
    return not getattr(law, "moves", False) and isinstance(law.__dict__.get(attribute), np.ndarray)


def _by_parameter(course: LinearRun, g: int, members: Indices, attribute: str, among: Indices) -> Array:
    """∂heat/∂value of members of a group (2 K, members); of a few flows for those `among` them alone, else of all."""
    group = course.problem.plan.network.groups[g]
    if isinstance(group, Flows) and len(among) * FEW <= len(group.entry):
        key, members = (g, attribute, among.tobytes()), among.searchsorted(members)
        if key not in course.derived:
            course.derived[key] = _derivatives(course, group.some(among), attribute)
        return course.derived[key][:, members]
    key = (g, attribute, b"")
    if key not in course.derived:
        course.derived[key] = _derivatives(course, group, attribute)
    return course.derived[key][:, members]


def _derivatives(course: LinearRun, group: Flows | Heats[Mechanism], attribute: str) -> Array:
    """∂heat/∂value of all members of a group, each by its own number: one imaginary step for all at once."""
    T, u = course.T_ends, course.inputs
    law: Any = group.law.replaced(**{attribute: group.law.__dict__[attribute] + 1j * STEP})
    if isinstance(group, Flows):
        return np.asarray(np.imag(replace(group, law=law).heat_flow(T, u)) / STEP * group.w)
    q = replace(group, law=law).heat(u, *(T @ R.T for R in group.reads)) * np.ones((len(T), len(group.entry)))
    modes = relay_modes(course.problem.plan, group)
    return np.asarray(np.imag(q if modes is None else q * modes) / STEP)


def relay_modes(plan: Plan, group: Heats[Mechanism]) -> Array | None:
    """Modes of a group of relays at both ends of the intervals (2 K, n); None for other sources."""
    for relays, part in relay_slices(plan.network):
        if relays is group:
            assert plan.modes is not None
            return np.concatenate([plan.modes[:, part]] * 2)
    return None


def _of_capacity(network: Network, course: LinearRun, name: str, slope: float) -> Push:
    """Heat that a larger capacity, spread evenly over its part, withholds."""
    part = network.parts[name]
    lumps = np.arange(part.start, part.stop)
    at = np.searchsorted(network.free, lumps)
    q0, q1 = (-slope / len(lumps) * rate[:, at] for rate in course.rates)
    return Push(lumps, q0, q1)


@dataclass(frozen=True)
class Slots:
    """Where each parameter stands in a network, so that values are exchanged without building it again."""

    network: Network
    parameters: tuple[Parameter, ...]

    @cached_property
    def suffice(self) -> bool:
        """Whether every parameter is a number of some law, or a heat capacity."""
        return len(self.acting) == len(self.parameters)

    @cached_property
    def acting(self) -> frozenset[Parameter]:
        """Those that stand in some law, or are a heat capacity."""
        return frozenset(p for p, found in self.places if found or is_capacity(p, self.network))

    def at(self, values: dict[str, float]) -> Network:
        """The network with other values (of all parameters)."""
        capacity, groups = self.network.capacity.copy(), list(self.network.groups)
        for p, laws in self.places:
            if p.entry.section == "nodes":
                part = self.network.parts[p.entry.name]
                node = self.network.machine.nodes[p.entry.name]
                more = values[p.path] - float(node.__dict__[p.attribute] or 0.0)
                capacity[part] += more / (part.stop - part.start)
            for g, members in laws:
                array = groups[g].law.__dict__[p.attribute].copy()
                array[members] = values[p.path]
                law: Any = groups[g].law.replaced(**{p.attribute: array})
                groups[g] = replace(groups[g], law=law)
        left = iter(groups)
        exchanged: dict[str, Any] = {name: tuple(next(left) for _ in getattr(self.network, name)) for name in GROUPS}
        return replace(self.network, capacity=capacity, **exchanged)

    @cached_property
    def places(self) -> tuple[tuple[Parameter, Found], ...]:
        """Every parameter with where it stands."""
        laws = ("links", "sources")
        return tuple((p, place_of(self.network, p) if p.entry.section in laws else ()) for p in self.parameters)

    @cached_property
    def stands(self) -> dict[Parameter, Stand]:
        """The same with what the heat of each reaches."""
        together: dict[str, dict[int, Indices]] = {}
        for p, found in self.places:
            mine = together.setdefault(p.attribute, {})
            mine.update({g: np.union1d(mine.get(g, members), members) for g, members in found})
        return {p: stand_of(self.network, found, together[p.attribute]) for p, found in self.places}
