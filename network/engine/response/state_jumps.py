"""Pushes that only kick: modes that decay from jump to jump, followed from piece to piece."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.response.linear_run import LinearRun
from network.engine.response.segments import Push, Segment


class Kicks:
    """Some pushes in the order of their first kicks; a piece lies between kicks, in one stretch."""

    def __init__(self, course: LinearRun, pushes: Sequence[Push]) -> None:
        begins = np.array([_first_kick(push) for push in pushes])
        self.order = np.argsort(begins, kind="stable")
        self.course, self.first, self.fresh = course, begins[self.order], frozenset(course.restarts)
        ordered, at = [pushes[j] for j in self.order], dict[int, list[tuple[list[int], Array]]]()
        for i, push in enumerate(ordered):
            for k, jump in push.kicks:
                at.setdefault(k, []).append(([i], jump[None]))
        for k, own in _share_jumps(ordered):
            at.setdefault(k, []).append(own)
        self.at = {k: _add_up(own) for k, own in at.items()}

    def in_order(self, values: Array) -> Array:
        """Values of the pushes as they were given."""
        if (np.diff(self.order) > 0).all():
            return values
        out = np.empty_like(values)
        out[self.order] = values
        return out

    def pieces(self, s: Segment, x: Array) -> Iterator[tuple[int, int, Array]]:
        """First and last interval of every piece of a stretch, and modal states (active pushes, n) at its beginning;
        x: modal states of all at the beginning of the stretch, carried to its end."""
        cuts = self.cuts(s)
        active = np.searchsorted(self.first, cuts[:-1], side="right").tolist()
        decays = np.exp(np.multiply.outer(-np.diff(self.edges[cuts]), s.modes.rates))
        for (a, b), count, decay in zip(pairwise(cuts), active, decays, strict=True):
            if a in self.fresh:
                x[:] = 0.0
            if a in self.at:
                pushes, jumps = self.at[a]
                x[pushes] += jumps @ s.modes.W.T
            if count:
                yield a, b, x[:count]
                x[:count] *= decay

    def cuts(self, s: Segment) -> list[int]:
        """Where the pieces of a stretch begin, and its end."""
        return [s.first, *sorted(k for k in self.fresh.union(self.at) if s.first < k < s.last), s.last]

    def decays(self, s: Segment) -> Array:
        """How the modes have decayed since the beginning of their piece, at that of every interval (k, n)."""
        cuts = np.array(self.cuts(s))
        begins = np.repeat(self.edges[cuts[:-1]], np.diff(cuts))
        return np.asarray(np.exp(np.multiply.outer(begins - self.edges[s.first : s.last], s.modes.rates)))

    @property
    def edges(self) -> Array:
        return self.course.problem.plan.edges

    def states(self, intervals: Sequence[int]) -> Array:
        """States at the beginnings of some intervals, before the kicks there: (pushes, intervals, n)."""
        out = np.zeros((len(self.first), len(intervals), self.course.problem.order))
        wanted, x = np.asarray(intervals), np.zeros((len(self.first), self.course.problem.order))
        for s in self.course.segments:
            m, decays = (x @ s.modes.W.T), self.decays(s)
            for a, b, states in self.pieces(s, m):
                for j in np.flatnonzero((wanted > a) & (wanted <= b)):
                    k = int(wanted[j])
                    gone = decays[k - s.first] if k < b else decays[b - 1 - s.first] * s.gain[b - 1 - s.first]
                    out[: len(states), j] = np.real((states * gone) @ s.modes.V.T)
            x = np.real(m @ s.modes.V.T)
        return self.in_order(out)


def _first_kick(push: Push) -> int:
    first = [k for k, _ in push.kicks]
    return min(first) if push.jumps is None else min([*first, int(push.jumps[0].min())])


def _add_up(parts: Sequence[tuple[list[int], Array]]) -> tuple[Indices, Array]:
    """Pushes that jump at one instant, each once, and by how much (pushes, n)."""
    pushes, jumps = np.concatenate([i for i, _ in parts]), np.concatenate([j for _, j in parts])
    if len({*pushes.tolist()}) == len(pushes):
        return pushes, jumps
    each, of = np.unique(pushes, return_inverse=True)
    total = np.zeros((len(each), jumps.shape[1]))
    np.add.at(total, of, jumps)
    return each, total


def _share_jumps(pushes: Sequence[Push]) -> Iterator[tuple[int, tuple[list[int], Array]]]:
    """Interval by interval: the pushes that jump there, and by how much (pushes, n)."""
    together: dict[bytes, list[int]] = {}
    for i, push in enumerate(pushes):
        if push.jumps is not None:
            together.setdefault(push.jumps[0].tobytes(), []).append(i)
    for mine in together.values():
        jumps = [push.jumps for push in (pushes[i] for i in mine) if push.jumps is not None]
        by = np.stack([own for _, own in jumps], axis=1)
        yield from ((k, (mine, by[e])) for e, k in enumerate(jumps[0][0].tolist()))


def states_at(course: LinearRun, pushes: Sequence[Push], intervals: Sequence[int]) -> Array:
    """Changes of the states at the beginnings of some intervals, before the kicks there: (pushes, intervals, n)."""
    out = np.zeros((len(pushes), len(intervals), course.problem.order))
    heats = [i for i, push in enumerate(pushes) if push.is_heat]
    if heats:
        out[heats] += _march_heat(course, [pushes[i] for i in heats], np.asarray(intervals))
    kicked = [i for i, push in enumerate(pushes) if push.is_kicked]
    if kicked:
        out[kicked] += Kicks(course, [pushes[i] for i in kicked]).states(intervals)
    return out


def _march_heat(course: LinearRun, pushes: Sequence[Push], intervals: Array) -> Array:
    n = course.problem.order
    out, x = np.zeros((len(pushes), len(intervals), n)), np.zeros((len(pushes), n))
    for s in course.segments:
        m, end = s.march_forced(*s.force_modes(pushes), x @ s.modes.W.T)
        x = np.real(end @ s.modes.V.T)
        mine = np.flatnonzero((intervals >= s.first) & (intervals < s.last))
        out[:, mine] = np.real(m[intervals[mine] - s.first] @ s.modes.V.T).transpose(1, 0, 2)
    return out
