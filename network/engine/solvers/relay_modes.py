"""Relays along a solution: their modes, which of them are about to switch, and when one is to within a step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.mechanisms.mechanism import Inputs
from network.engine.balance import relay_slices
from network.engine.solvers.plan import Plan
from network.platform.refusal import Failed

LONGEST = 30.0
"""s: longest distance at which guards are looked at, so that two crossings in one step are not missed."""
FEWEST, INSTANT = 4, 1e-9
"""Pieces of a step at least, and how exactly a crossing is found [s]."""
CROSSED, EXACT = -1e-9, 1e-12
"""A guard above the first has been crossed; one as close to zero as the second is at its crossing [K]."""
MOST_SWITCHES = 100_000
"""Of a run: some minute of computing."""
MOST_UNSEEN = 10_000
"""Between two instants of output: a relay that switches every ten seconds of a day. More are a jump in time."""
Seen = Callable[[Array], tuple[Array, Inputs]]
"""Temperatures of all lumps (M, N) and inputs (M, 1) at shares of a step."""


@dataclass
class RelayModes:
    """on: 1 or 0 for each relay; pending: when those that are about to switch do; switches: (instant, relay, mode);
    most: how many of them may be."""

    plan: Plan
    most: int = MOST_SWITCHES
    on: Array = field(init=False)
    pending: dict[int, float] = field(default_factory=dict)
    switches: list[tuple[float, int, int]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.groups = list(relay_slices(self.plan.network))
        pauses = [np.broadcast_to(g.law.pause(), g.into.shape[1]) for g, _ in self.groups]
        self.pauses = np.concatenate([np.zeros(0), *pauses])
        self.on = np.zeros(len(self.pauses))

    def __len__(self) -> int:
        return len(self.on)

    def guards(self, T: Array, u: Inputs) -> Array:
        """Above zero: time to switch. (…, relays)"""
        values = [
            np.broadcast_to(group.law.guard(self.on[part], u, *(T @ R.T for R in group.reads)),
                            (*T.shape[:-1], part.stop - part.start))
            for group, part in self.groups
        ]  # fmt: skip
        return np.concatenate([np.zeros((*T.shape[:-1], 0)), *values], axis=-1)

    def begin(self, T: Array, u: Inputs) -> None:
        """On where the guard says so at the start."""
        self.on = (self.guards(T, u) > 0).astype(float)

    def note(self, t: float, T: Array, u: Inputs) -> None:
        """Relays whose guard is crossed will switch after their pause."""
        for j in np.flatnonzero(self.guards(T, u) >= CROSSED).tolist():
            self.pending.setdefault(j, t + float(self.pauses[j]))

    def switch_due(self, t: float) -> bool:
        """Whether any switched. Raises Failed where they do so without end."""
        due = [j for j, at in self.pending.items() if at <= t + INSTANT]
        for j in due:
            self.on = self.on.copy()
            self.on[j] = 1.0 - self.on[j]
            self.switches.append((t, j, int(self.on[j])))
            del self.pending[j]
        self._check_count()
        return bool(due)

    def _check_count(self) -> None:
        switches, t = self.switches, self.plan.t
        if len(switches) > self.most:
            at = f"{self.most} times by {switches[-1][0]:.4g} s"
            raise Failed(f"a relay switched {at}; give it a wider hysteresis or a delay")
        if len(switches) > MOST_UNSEEN:
            since, now = switches[-MOST_UNSEEN - 1][0], switches[-1][0]
            k = int(np.searchsorted(t, since, side="right"))
            if k < len(t) and not t[k] <= now:
                between = f"between {float(t[max(k - 1, 0)]):.10g} s and {t[k]:.10g} s"
                raise Failed(
                    f"a relay switches more than {MOST_UNSEEN} times {between}, two instants of the run with nothing "
                    "in between; look for a jump in time, or give it a wider hysteresis"
                )

    def next_due(self, t: float, end: float) -> float:
        """The next instant at which one switches, or the end."""
        return min([end, *(at for at in self.pending.values() if at > t)])

    def first_crossing(self, seen: Seen, h: float) -> tuple[float, int] | None:
        """The share of a step of length h at which a guard first rises above zero, and which."""
        pieces = max(FEWEST, int(np.ceil(h / LONGEST)))
        s = np.arange(pieces + 1) / pieces
        values = self._values(seen, s)
        tops = _tops(values)
        if tops.any() and not (values > 0).any():
            i = int(np.flatnonzero(tops.any(axis=1))[0])
            s = np.linspace(s[i], s[i + 2], 2 * FEWEST + 1)
            values = self._values(seen, s)
        rising = np.flatnonzero((values[1:] > 0).any(axis=0)).tolist()
        return min((self._refine(seen, j, s, values[:, j], h) for j in rising), default=None)

    def _values(self, seen: Seen, s: Array) -> Array:
        values = np.array(self.guards(*seen(s)))
        values[:, list(self.pending)] = -np.inf
        return values

    def _refine(self, seen: Seen, j: int, s: Array, values: Array, h: float) -> tuple[float, int]:
        """Where guard j first rises above zero: by false position, with both ends moving (Illinois)."""
        i = int((values[1:] > 0).argmax())
        low, high, below, above = float(s[i]), float(s[i + 1]), float(values[i]), float(values[i + 1])
        last = 0
        while (high - low) * h > INSTANT and below < 0:
            at = high - above * (high - low) / (above - below)
            value = float(self._values(seen, np.array([at]))[0, j])
            if value > 0:
                high, above, below, last = at, value, below / 2 if last == 1 else below, 1
            else:
                low, below, above, last = at, value, above / 2 if last == -1 else above, -1
            if abs(value) < EXACT:
                return at, j
        return high, j


def _tops(values: Array) -> Array:
    """Where a parabola through three neighbours rises above zero between them, though none of them does."""
    left, middle, right = values[:-2], values[1:-1], values[2:]
    with np.errstate(invalid="ignore", divide="ignore"):
        bend = left - 2 * middle + right
        top = middle - (right - left) ** 2 / (8 * bend)
        inside = (bend < 0) & (np.abs(right - left) < -2 * bend)
    return np.asarray(inside & (top > 0))
