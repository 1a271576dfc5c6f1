"""The modes of an affine network, in which it is solved exactly.

Each regime is diagonalised once: A = V (−Λ) V⁻¹, symmetric after scaling with √C where nothing flows one way. A mode
with rate λ and forcing p + r τ moves as x(τ) = e^(−λτ) x₀ + τ φ₁(−λτ) p + τ² φ₂(−λτ) r, so the only error is rounding.
Source of the φ functions: Hochbruck & Ostermann, Acta Numerica 19 (2010) 209, eq. 2.10.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.solvers.elimination import Regime

WORST_CONDITION = 1e6
"""Of the eigenvectors: beyond it the rounding would exceed 1e-9 K and the exponential path takes over."""
FEW_STEPS = 32
"""Steps of a scan that are worth no blocks."""
PHI_SERIES = (1 / np.cumprod(np.arange(1.0, 16.0))[2:]).tolist()
"""1/(k+3)! of φ₃."""
SLOW = 1e-3


@dataclass(frozen=True)
class Modes:
    """x = V m, m = W x; decay rates λ [1/s]; condition: of V at most."""

    rates: Array
    V: Array
    W: Array
    condition: float

    @cached_property
    def is_real(self) -> bool:
        return not np.iscomplexobj(self.rates)


def modes_of(regime: Regime, scale: Array) -> Modes:
    """The modes of one regime."""
    B = scale[:, None] * regime.A / scale
    if regime.is_symmetric:
        values, U = np.linalg.eigh((B + B.T) / 2)
        return Modes(_without_rounding(-values), U / scale[:, None], U.T * scale, 1.0)
    values, U = np.linalg.eig(B)
    try:
        inverse = np.linalg.inv(U)
    except np.linalg.LinAlgError:
        return Modes(-values, U / scale[:, None], np.zeros_like(U) * scale, np.inf)
    most = float(np.linalg.norm(U) * np.linalg.norm(inverse))
    condition = most if most < WORST_CONDITION else float(np.linalg.cond(U))
    return Modes(-values, U / scale[:, None], inverse * scale, condition)


def _without_rounding(rates: Array) -> Array:
    """A machine that nothing cools has a mode of rate 0, which rounding (N ε of the largest) makes a slow growth; what
    grows faster than that does grow: heat that rises with its own temperature."""
    noise = len(rates) * np.finfo(float).eps * np.abs(rates).max(initial=0.0)
    return np.where(np.abs(rates) <= noise, 0.0, rates)


def phi(z: Array) -> tuple[Array, Array, Array]:
    """φ₁, φ₂, φ₃ at z: (eᶻ − 1)/z, (φ₁ − 1)/z, (φ₂ − ½)/z, by the series of φ₃ where these cancel."""
    small = np.abs(z) < 0.5
    safe = np.where(small, 1.0, z)
    one = np.expm1(z) / safe
    two = (one - 1) / safe
    three = (two - 0.5) / safe
    if small.any():
        near = z[small]
        third = np.full_like(near, PHI_SERIES[-1])
        for coefficient in PHI_SERIES[-2::-1]:
            third = third * near + coefficient
        second = 0.5 + near * third
        one[small], two[small], three[small] = 1 + near * second, second, third
    return one, two, three


def scan(gain: Array, push: Array, start: Array) -> tuple[Array, Array]:
    """x[0] = start, x[k+1] = gain[k] x[k] + push[k]: all x[k] before each step, and the last one.

    Blocks of √K steps run side by side, so the interpreter takes 2√K steps instead of K; a few go one by one.
    """
    count, width = push.shape
    if count <= FEW_STEPS:
        return _one_by_one(gain, push, start.astype(push.dtype))
    block = max(1, int(np.sqrt(count)))
    blocks = -(-count // block)
    pad = blocks * block - count
    g = np.concatenate([gain, np.ones((pad, width))]).reshape(blocks, block, width)
    f = np.concatenate([push, np.zeros((pad, width))]).reshape(blocks, block, width)
    product, total = np.empty_like(g), np.empty_like(f)
    running, carried = np.ones((blocks, width), g.dtype), np.zeros((blocks, width), f.dtype)
    for i in range(block):
        product[:, i], total[:, i] = running, carried
        running, carried = running * g[:, i], carried * g[:, i] + f[:, i]
    x, heads = start.astype(f.dtype), np.empty((blocks, width), f.dtype)
    for b in range(blocks):
        heads[b] = x
        x = running[b] * x + carried[b]
    states = (product * heads[:, None] + total).reshape(-1, width)[:count]
    return states, x


def _one_by_one(gain: Array, push: Array, x: Array) -> tuple[Array, Array]:
    states = np.empty_like(push)
    for k in range(len(push)):
        states[k] = x
        x = gain[k] * x + push[k]
    return states, x
