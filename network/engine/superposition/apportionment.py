"""The movement of one entry, apportioned to what moved it: exact for any smooth law of movement.

With readings r_i = Σ_s r_is of the causes s, m(r) − m(0) = Σ_i r_i ∫₀¹ ∂m/∂r_i(λ r) dλ, so each cause gets r_is times
that integral (Aumann & Shapley, Values of Non-Atomic Games, 1974). For a law that is linear in its readings that is
its slope times r_is. Three Gauss points integrate polynomials up to the fifth degree exactly.
"""

from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.expansions.base import Expansion
from network.catalogue.mechanisms.mechanism import Inputs

NODES, WEIGHTS = np.polynomial.legendre.leggauss(3)


def mean_slopes(entry: Expansion, u: Inputs, readings: tuple[Array, ...]) -> tuple[Array, ...]:
    """∫₀¹ ∂m/∂r_i(λ r) dλ for every reading, over time."""
    total = [np.zeros(np.shape(u["time"])) for _ in readings]
    for node, weight in zip((NODES + 1) / 2, WEIGHTS / 2, strict=True):
        for sum_, slope in zip(total, entry.slopes(u, *(node * r for r in readings)), strict=True):
            sum_ += weight * slope
    return tuple(total)


def move_at_once(entry: Expansion, u: Inputs) -> Array:
    """What it moves without any rise: by speed, or a step."""
    none = (np.zeros(np.shape(u["time"])) for _ in entry.readings())
    return np.asarray(entry.movement(u, *none) * np.ones(np.shape(u["time"])))
