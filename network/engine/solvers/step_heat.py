"""Heat into the lumps that a run solves for, and its slopes, as a step by step solution asks for them.

What is linear in temperature, with inputs that hold in every interval, is one matrix and one heat series; only the
other laws are evaluated, with the catalogue's own slopes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.catalogue.mechanisms.mechanism import Inputs, Mechanism
from network.engine.balance import affine_heat, affine_matrix, flow_heat, relay_slices, source_heat, source_series
from network.engine.entry_groups import Flows, Heats
from network.engine.solvers.plan import Plan
from network.engine.solvers.regimes import matrix_inputs

HAIR, BETWEEN, STRAIGHT = 1e-12, (0.25, 0.5), 1e-10
"""Shares of an interval at which a heat is looked at, and how close to straight it has to go (of the largest)."""
FULL = 100
"""Lumps up to which a matrix is kept with its zeros."""
Members = tuple[Indices, Indices, Array]
"""Members of a group, in their order where they are read; lumps, and shares."""
Entries = tuple[Indices, Indices, Indices, Array]
"""Rows, columns, members of a group, and factors: what the slope of each member adds where."""


@dataclass(frozen=True)
class Bent:
    """A group of laws that is evaluated at every stage. into: lumps solved for, by its members; part: of the relays, if
    it is one of these; entries: of each of its slopes."""

    group: Flows | Heats[Mechanism]
    into: Any
    part: slice | None
    entries: tuple[Entries, ...]

    def heat(self, T: Array, u: Inputs, modes: Array) -> Array:
        if isinstance(self.group, Flows):
            return np.asarray(self.into @ flow_heat(self.group, T, u, modes))
        return np.asarray(self.into @ source_heat(self.group, T, u, None if self.part is None else modes[self.part]))

    def slopes(self, T: Array, u: Inputs, modes: Array) -> Iterator[Array]:
        """Of every member by each of its temperatures."""
        g = self.group
        if isinstance(g, Flows):
            weight = g.w if g.relay is None else g.w * modes[g.relay]
            yield from (weight * slope for slope in g.slopes(T, u))
            return
        weight = np.ones(g.into.shape[1]) if self.part is None else modes[self.part]
        yield from (weight * slope for slope in g.slopes(u, *(R @ T for R in g.reads)))


class StepHeat:
    """Of a plan, interval by interval."""

    def __init__(self, plan: Plan) -> None:
        self.plan, self.network = plan, plan.network
        network, self.solved = plan.network, np.flatnonzero(np.isfinite(plan.network.capacity))
        self.place = np.full(network.size, -1)
        self.place[self.solved] = np.arange(len(self.solved))
        flows = [f for f in network.flows if self._is_straight(f.law)]
        heats = [h for h in network.heats if self._is_straight(h.law)]
        straight_relays = all(self._is_straight(r.law) for r in network.relays)
        relays = network.relays if straight_relays else ()
        self.straight = replace(network, flows=tuple(flows), heats=tuple(heats), relays=relays)
        along = [h for h in network.heats if not self._is_among(h, heats) and self._goes_straight(h)]
        bent: list[tuple[Flows | Heats[Mechanism], slice | None]] = []
        bent += [(f, None) for f in network.flows if not self._is_among(f, flows)]
        bent += [(h, None) for h in network.heats if not self._is_among(h, [*heats, *along])]
        bent += [] if straight_relays else list(relay_slices(network))
        self.bent = [self._bend(group, part) for group, part in bent]
        self.follows_time = any(group.law.follows_time for group, _ in bent)
        self.keys, self.matrices = matrix_inputs(self.straight), dict[Any, tuple[Any, Array, Array]]()
        self._lay_heat(along)
        self.h0, self.h1 = plan.evaluate_held(plan.left), plan.evaluate_held(plan.right)

    @staticmethod
    def _is_among(group: object, groups: Any) -> bool:
        return any(group is other for other in groups)

    def _is_straight(self, law: Mechanism) -> bool:
        """Affine, with inputs that hold within every interval: one matrix and one heat each."""
        return law.is_affine() and not self.plan.is_ramped(law)

    def _goes_straight(self, heats: Heats[Mechanism]) -> bool:
        """Heat that depends on no temperature, and goes straight from the begin to the end of every interval."""
        plan, law = self.plan, heats.law
        if heats.reads or law.follows_time or not law.is_affine():
            return False
        alone = replace(self.network, flows=(), heats=(heats,), relays=())
        q0, q1, *between = (
            affine_heat(alone, {n: (a + s * (plan.right[n] - a))[:, None] for n, a in plan.left.items()}, np.zeros(0),
                        len(plan.steps))
            for s in (HAIR, 1 - HAIR, *BETWEEN)
        )  # fmt: skip
        close = STRAIGHT * float(np.abs(q1).max(initial=np.abs(q0).max(initial=0.0)))
        bends = (np.abs(q - q0 - s * (q1 - q0)).max(initial=0.0) for s, q in zip(BETWEEN, between, strict=True))
        return all(bend <= close for bend in bends)

    def _lay_heat(self, along: list[Heats[Mechanism]]) -> None:
        """Heat series of what goes straight, and of relays while they are on, over all intervals."""
        plan, count = self.plan, len(self.plan.steps)
        given = replace(self.straight, heats=(*self.straight.heats, *along), relays=())
        self.q0, self.q1 = (affine_heat(given, u, np.zeros(0), count)[:, self.solved] for u in plan.just_inside)
        relays = self.straight.relays
        self.switched = np.hstack([np.zeros((len(self.solved), 0)), *(r.into[self.solved] for r in relays)])
        self.r0, self.r1 = (
            np.hstack([np.zeros((count, 0)), *(source_series(r, u, None, count) for r in relays)])
            for u in plan.just_inside
        )

    # -- what slopes there can be -------------------------------------------------------------------------------------
    def _bend(self, group: Flows | Heats[Mechanism], part: slice | None) -> Bent:
        members, lumps, shares = _list_given(group)
        count = len(group.a) if isinstance(group, Flows) else group.into.shape[1]
        here = self.place[lumps] >= 0
        into = _lay(shares[here], self.place[lumps[here]], members[here], (len(self.solved), count))
        return Bent(group, into, part, tuple(self._entries(group)))

    def _entries(self, group: Flows | Heats[Mechanism]) -> Iterator[Entries]:
        given = _list_given(group)
        if isinstance(group, Flows):
            members = np.arange(len(group.a))
            for ends in (group.a, group.b):
                yield self._cross(given, (members, ends, np.ones(len(members))))
        for R in group.reads:
            members, lumps = np.nonzero(R)
            yield self._cross(given, (members, lumps, R[members, lumps]))

    def _cross(self, given: Members, read: Members) -> Entries:
        """∂(heat into lump i)/∂T_j by the members that go into i and read j."""
        first, last = (np.searchsorted(read[0], given[0], side) for side in ("left", "right"))
        count = last - first
        one = np.repeat(np.arange(len(count)), count)
        other = np.repeat(first - (np.cumsum(count) - count), count) + np.arange(len(one))
        i, j = self.place[given[1][one]], self.place[read[1][other]]
        here = (i >= 0) & (j >= 0)
        return i[here], j[here], given[0][one][here], (given[2][one] * read[2][other])[here]

    def pattern(self) -> tuple[Indices, Indices]:
        """Rows and columns at which a slope may stand, of all laws."""
        own: Indices = np.arange(len(self.solved))
        rows, columns = [own], [own]
        for group in self.network.groups:
            for i, j, _, _ in self._entries(group):
                rows.append(i)
                columns.append(j)
        return np.concatenate(rows), np.concatenate(columns)

    # -- in an interval -----------------------------------------------------------------------------------------------
    def enter(self, k: int, modes: Array) -> None:
        """Prepares interval k with relays in some modes."""
        plan, self.k, self.modes = self.plan, k, modes
        self.begin, self.length = float(plan.edges[k]), float(plan.steps[k])
        self.u0 = u = {name: values[k] for name, values in plan.left.items()}
        self.grows = {name: plan.right[name][k] - value for name, value in u.items()}
        self.held, self.held_grows = self.h0[k], self.h1[k] - self.h0[k]
        self.key = (*(float(u[name]) for name in self.keys), modes.tobytes())
        if self.key not in self.matrices:
            K = affine_matrix(self.straight, u, modes)[self.solved]
            self.matrices[self.key] = _thin(K[:, self.solved]), K[:, self.solved], K[:, self.network.bound]
        self.K, _, by_held = self.matrices[self.key]
        on = modes if self.r0.shape[1] else modes[:0]
        self.base = self.q0[k] + by_held @ self.held + self.switched @ (self.r0[k] * on)
        end = self.q1[k] + by_held @ self.h1[k] + self.switched @ (self.r1[k] * on)
        self.base_grows = end - self.base
        self.is_ramped = any(bool(v) for n, v in self.grows.items() if n != "time")
        self.is_steady = not (self.is_ramped or self.held_grows.any() or self.base_grows.any() or self.follows_time)

    @property
    def matrix(self) -> Array:
        """∂(heat into)/∂T of what is straight."""
        return self.matrices[self.key][1]

    def inputs(self, t: float) -> Inputs:
        if not self.is_ramped and not self.follows_time:
            return self.u0
        share = (t - self.begin) / self.length
        return {name: value + share * self.grows[name] for name, value in self.u0.items()}

    def lumps(self, t: float, solved: Array) -> Array:
        """All lumps from the temperatures of those solved for."""
        T = np.empty(self.network.size)
        T[self.network.bound] = self.held + (t - self.begin) / self.length * self.held_grows
        T[self.solved] = solved
        return T

    def into(self, t: float, solved: Array) -> Array:
        """Heat into the solved lumps at their temperatures [W]."""
        heat = self.K @ solved + self.base
        if not self.is_steady:
            heat += (t - self.begin) / self.length * self.base_grows
        if self.bent:
            T, u = self.lumps(t, solved), self.inputs(t)
            for bent in self.bent:
                heat += bent.heat(T, u, self.modes)
        return np.asarray(heat)

    def bent_slopes(self, t: float, solved: Array) -> list[Array]:
        """Slopes of every entry of `bent`, one after the other."""
        if not self.bent:
            return []
        T, u = self.lumps(t, solved), self.inputs(t)
        return [
            factors * (slope[members] if np.ndim(slope) and len(slope) > 1 else slope)
            for bent in self.bent
            for (_, _, members, factors), slope in zip(bent.entries, bent.slopes(T, u, self.modes), strict=True)
        ]


def _list_given(group: Flows | Heats[Mechanism]) -> Members:
    """What a watt of each member does to lumps: −1 where a flow begins (0 for a stream), +1 where it ends."""
    if not isinstance(group, Flows):
        lumps, members = np.nonzero(group.into)
        return members, lumps, group.into[lumps, members]
    members, ends = np.arange(len(group.a)), [group.b, *(() if group.one_way else (group.a,))]
    shares = np.repeat([1.0, -1.0][: len(ends)], len(members))
    return np.tile(members, len(ends)), np.concatenate(ends), shares


def _lay(values: Array, i: Indices, j: Indices, shape: tuple[int, int]) -> Any:
    """A matrix, a large one without its zeros."""
    if max(shape) > FULL:
        from scipy.sparse import csr_matrix

        return csr_matrix((values, (i, j)), shape)
    matrix = np.zeros(shape)
    matrix[i, j] = values
    return matrix


def _thin(matrix: Array) -> Any:
    """A large matrix without its zeros."""
    if max(matrix.shape) <= FULL:
        return np.ascontiguousarray(matrix)
    from scipy.sparse import csr_matrix

    return csr_matrix(matrix)
