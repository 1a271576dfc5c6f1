"""The first instant at which one of several guards rises above zero, however short it stays there.

Guards are looked at in POINTS pieces. A bound c on their curvature clears a piece (over h a guard rises above the
larger of its ends by h² c/8 at most) or shows that a guard crosses zero in it just once (its ends differ by more than
h² c/2); any other piece is cut again. Such a crossing is then found by inverse interpolation.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from network.catalogue.declaration.declare import Array, Mask

POINTS = 16
"""Pieces that an interval is cut into at each refinement."""
INSTANT = 1e-9
"""s: how exactly a crossing is found; POINTS of it are the shortest piece that is still searched."""
NEVER = -1e300
"""The guard of a relay that is about to switch."""
EVEN = np.arange(POINTS + 1) / POINTS
EIGHTHS, ABOUT = np.arange(1, 8) / 8, np.array([-4.0, 0.0, 4.0])


class Guards(Protocol):
    """Guards over an interval: (instants, guards) at instants [s] that ascend."""

    def values(self, tau: Array) -> Array: ...

    def curvature(self, tau: Array) -> Array:
        """Bounds on the curvature from each instant on [1/s²]."""


def first_crossing(guards: Guards, a: float, b: float, curvature: Array) -> float | None:
    """The first instant from a to b at which a guard is above zero, None if there is none; curvature: bounds there."""
    h, tau = (b - a) / POINTS, a + (b - a) * EVEN
    values = guards.values(tau)
    if (values[0] > 0).any():
        return a
    may, once = _bound_guards(values, h * h * curvature)
    if (may & ~once).any():
        may, once = _bound_guards(values, h * h * guards.curvature(tau[:-1]))
    for j in np.flatnonzero(may.any(axis=1)).tolist():
        first = None
        if (once[j] | ~may[j]).all() or h <= INSTANT * POINTS:
            rising = np.flatnonzero(values[j + 1] > 0).tolist()
            first = min((_crossing(guards, i, tau, values[:, i]) for i in rising), default=None)
        else:
            first = first_crossing(guards, float(tau[j]), float(tau[j + 1]), guards.curvature(tau[j : j + 1])[0])
        if first is not None:
            return first
    return None


def _bound_guards(values: Array, bend: Array) -> tuple[Mask, Mask]:
    """Of all pieces: where a guard may rise above zero, and where it surely does so once; bend: h² c of the pieces."""
    left, right = values[:-1], values[1:]
    return np.maximum(left, right) + bend / 8 > 0, (right > 0) & (right - left > bend / 2)


def _crossing(guards: Guards, i: int, tau: Array, y: Array) -> float:
    """Where guard i, with values y at tau, first rises above zero."""
    while True:
        j = int((y > 0).argmax()) - 1
        low, high, near = float(tau[j]), float(tau[j + 1]), slice(max(j - 2, 0), j + 4)
        x, error = _interpolate_root(tau[near].tolist(), y[near].tolist(), low, high)
        if error <= INSTANT:
            return x
        inner = np.concatenate([low + (high - low) * EIGHTHS, x + error * ABOUT])
        inner = np.sort(inner[(inner > low) & (inner < high)])
        y = np.concatenate([y[j : j + 1], guards.values(inner)[:, i], y[j + 1 : j + 2]])
        tau = np.concatenate([tau[j : j + 1], inner, tau[j + 1 : j + 2]])


def _interpolate_root(x: list[float], y: list[float], low: float, high: float) -> tuple[float, float]:
    """x at y = 0 on the polynomial x(y), and how far it lies from the one with a point less; the middle of low and
    high where it does not lie between them."""
    found, before = _at_zero(x, y), _at_zero(x[:-1], y[:-1])
    if low <= found <= high and high - low > INSTANT:
        return found, abs(found - before)
    return (low + high) / 2, (high - low) / 2


def _at_zero(x: list[float], y: list[float]) -> float:
    points, total = dict(zip(y, x, strict=True)), 0.0
    for value, part in points.items():
        for other in points:
            if other != value:
                part *= other / (other - value)
        total += part
    return total
