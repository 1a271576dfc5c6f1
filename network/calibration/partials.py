"""How heat flows depend on a parameter: the further heat that one unit of θ brings, over a run, at its temperatures.

A parameter of a link or source stands in the stacked law of its class; an imaginary step there gives the exact
derivative of its heat. A heat capacity acts like a heat −∂C/∂θ dT/dt. Whatever else a number may do (geometry, materials,
sensors) is left to differences of whole runs.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from network.balance import relay_slices
from network.calibration.course import Course, Push
from network.calibration.parameters import Parameter
from network.declare import Array, Declared, Indices
from network.graph import Flows, Heats, Network
from network.mechanisms.base import STEP, Source, Stream
from network.solvers.plan import Plan

CAPACITY_KEYS = ("heat_capacity", "extra_heat_capacity")


def inputs_at_ends(plan: Plan) -> dict[str, Array]:
    """Inputs just after, then just before the edges: (2 K, 1)."""
    begin, end = plan.just_inside
    return {name: np.concatenate([begin[name], end[name]]) for name in begin}


def push_of(parameter: Parameter, course: Course, theta: float) -> Push | None:
    """The further heat for one unit of θ; None where the parameter acts otherwise than by heat."""
    network = course.problem.plan.network
    section, _, name = parameter.entry.partition(".")
    slope = parameter.slope(parameter.value(theta))
    if section == "nodes" and parameter.attribute in CAPACITY_KEYS and not name.endswith(".melts"):
        return _of_capacity(network, course, name, slope)
    if section not in ("links", "sources"):
        return None
    found = list(_members(network, parameter.entry, parameter.attribute))
    if not found:
        return None
    T, u = np.concatenate(course.T), inputs_at_ends(course.problem.plan)
    heat = np.zeros((len(T), network.size))
    for group, members in found:
        heat += _by_parameter(course, group, members, parameter.attribute, T, u)
    lumps = np.flatnonzero(heat.any(axis=0))
    K = len(T) // 2
    return Push(lumps, slope * heat[:K, lumps], slope * heat[K:, lumps])


def _members(network: Network, entry: str, attribute: str) -> Iterator[tuple[Flows | Heats[Source], Indices]]:
    """The groups in which an entry stands, and where in them; nothing where the number also shapes the network."""
    if entry not in network.mechanisms:
        return
    index = network.mechanisms.index(entry)
    for group in network.groups:
        members = np.flatnonzero(group.entry == index)
        if len(members) and _is_stacked(group.law, attribute):
            yield group, members


def _is_stacked(law: Declared, attribute: str) -> bool:
    """Whether the number stands in the law as an array and shapes nothing else (a stream's makes cells)."""
    return not isinstance(law, Stream) and not getattr(law, "moves", False) and isinstance(
        law.__dict__[attribute], np.ndarray
    )


def _restricted(law: Declared, members: Indices, **exchanged: Array) -> Declared:
    """The law of some members only."""
    arrays = {n: law.__dict__[n] for n in (*law.params(), *law.derived)}
    own = {n: a[members] for n, a in arrays.items() if isinstance(a, np.ndarray) and a.ndim == 1}
    return law.replaced(**own).replaced(**exchanged)


def _by_parameter(
    course: Course, group: Flows | Heats[Source], members: Indices, attribute: str, T: Array, u: dict[str, Array]
) -> Array:
    """∂(heat into the lumps)/∂value, (2 K, N)."""
    stepped = group.law.__dict__[attribute][members] + 1j * STEP
    law = _restricted(group.law, members, **{attribute: stepped})
    if isinstance(group, Flows):
        a, b = group.a[members], group.b[members]
        Q = np.imag(law.heat_flow(T[:, a], T[:, b], u)) / STEP * group.w[members]  # type: ignore[attr-defined]
        return np.asarray(Q @ group.spread[members])
    readings = [T @ R[members].T for R in group.reads]
    q = np.imag(law.heat(u, *readings) * np.ones(len(members))) / STEP  # type: ignore[attr-defined]
    modes = relay_modes(course.problem.plan, group)
    return np.asarray((q if modes is None else q * modes[:, members]) @ group.into[:, members].T)


def relay_modes(plan: Plan, group: Heats[Source]) -> Array | None:
    """Modes of a group of relays at both ends of the intervals (2 K, n); None for other sources."""
    for relays, part in relay_slices(plan.network):
        if relays is group:
            assert plan.modes is not None
            return np.concatenate([plan.modes[:, part]] * 2)
    return None


def _of_capacity(network: Network, course: Course, name: str, slope: float) -> Push:
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

    @property
    def suffice(self) -> bool:
        """Whether every parameter is a number of some law, or a heat capacity."""
        return all(self._has(p) for p in self.parameters)

    def _has(self, p: Parameter) -> bool:
        section, _, name = p.entry.partition(".")
        if section == "nodes":
            return p.attribute in CAPACITY_KEYS and name in self.network.parts
        return section in ("links", "sources") and any(True for _ in _members(self.network, p.entry, p.attribute))

    def at(self, values: dict[str, float]) -> Network:
        """The network with other values (of all parameters)."""
        from dataclasses import replace

        capacity, groups = self.network.capacity.copy(), {id(g): g for g in self.network.groups}
        for p in self.parameters:
            value = values[p.path]
            if p.entry.startswith("nodes."):
                part = self.network.parts[p.entry.removeprefix("nodes.")]
                own = self.network.machine.nodes[p.entry.removeprefix("nodes.")]
                more = value - float(own.__dict__[p.attribute] or 0.0)
                capacity[part] += more / (part.stop - part.start)
                continue
            for group, members in _members(self.network, p.entry, p.attribute):
                law = groups[id(group)].law
                array = law.__dict__[p.attribute].copy()
                array[members] = value
                groups[id(group)] = replace(groups[id(group)], law=law.replaced(**{p.attribute: array}))
        flows, heats, relays = (tuple(groups[id(g)] for g in own) for own in
                                (self.network.flows, self.network.heats, self.network.relays))  # fmt: skip
        return replace(self.network, capacity=capacity, flows=flows, heats=heats, relays=relays)
