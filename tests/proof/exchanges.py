"""Heat by laws that are no straight lines: radiation, buoyancy, doors, joints that follow their temperature.

A path between two places is a path between every pair of their cells by its share, w_i w_j Q(T_i, T_j).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from proof.system import Array, Exchange

SIGMA = 5.670374419e-8
"""W/(m² K⁴): Stefan and Boltzmann."""
KELVIN = 273.15
Flow = Callable[[Array, Array], Array]
"""Heat [W] from the first to the second of two temperatures [°C]."""
Windows = Sequence[tuple[float, float]]


def radiation(area: float) -> Flow:
    """Grey bodies: emissivity times area [m²]."""

    def flow(a: Array, b: Array) -> Array:
        x, y = a + KELVIN, b + KELVIN
        return np.asarray(area * SIGMA * (x * x + y * y) * (x + y) * (a - b))

    return flow


def buoyancy(size: float) -> Flow:
    """Natural convection with the power 1.25: coefficient times area [W/K^1.25]."""
    return lambda a, b: size * np.sqrt(np.sqrt(np.abs(a - b))) * (a - b)


def tightening(conductance: float, cold: float, steepness: float) -> Flow:
    """A joint of G exp(s (T − cold)), T the mean of its sides: no straight line in temperature, and never negative."""
    return lambda a, b: conductance * (np.exp(np.clip(steepness * ((a + b) / 2 - cold), -4, 4)) - 1) * (a - b)


def to_air(weights: Array, flow: Flow) -> Exchange:
    """From a place to the air."""
    return Exchange(lambda t, rpm, air, T: -weights * flow(T, np.float64(air)))


def to_held(weights: Array, held: float, flow: Flow) -> Exchange:
    """From a place to a temperature that is held [°C]."""
    return Exchange(lambda t, rpm, air, T: -weights * flow(T, np.float64(held)))


def between(a: Array, b: Array, flow: Flow) -> Exchange:
    """From one place to another."""
    i, j = np.flatnonzero(a), np.flatnonzero(b)
    share = np.outer(a[i], b[j])

    def heat(t: float, rpm: float, air: float, T: Array) -> Array:
        each, q = share * flow(T[i][:, None], T[j][None, :]), np.zeros_like(T)
        q[i] -= each.sum(axis=1)
        q[j] += each.sum(axis=0)
        return q

    return Exchange(heat)


def opened(weights: Array, conductance: float, windows: Windows) -> Exchange:
    """A conductance [W/K] to the air that is there in some windows [s] only."""

    def heat(t: float, rpm: float, air: float, T: Array) -> Array:
        inside = any(begin - 1e-6 <= t < end - 1e-6 for begin, end in windows)
        return np.asarray(-weights * conductance * (T - air) * inside)

    return Exchange(heat, tuple(edge for window in windows for edge in window))
