"""One step of TR-BDF2 as a diagonally implicit method of three stages: second order, L-stable, one matrix for both.

k₁ = f(t, T), k₂ = f(t + γh, T + h d (k₁ + k₂)), k₃ = f(t + h, T₁), T₁ = T + h (w k₁ + w k₂ + d k₃), with γ = 2 − √2,
d = γ/2, w = √2/4 (Bank et al. 1985). For C k = q − L (T* + h d k): k = M (q − L T*), M = (C + h d L)⁻¹.
"""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt

import numpy as np

from proof.system import Array, System

Air = Callable[[float], float]

GAMMA = 2 - sqrt(2)
D, W = GAMMA / 2, sqrt(2) / 4
ROUNDS, ENOUGH = 5, 1e-8
"""Fixed-point rounds on heat that depends on temperature, each of which gains a factor of h d q′/C, below 0.05, and K
over a step that are enough."""


class Regime:
    """A speed and a position of every switch: constant matrices, and the rate of temperature in them."""

    def __init__(self, system: System, rpm: float, on: tuple[bool, ...], t: float, air: Air, feed: float = 0.0) -> None:
        self.system, self.rpm, self.air = system, rpm, air
        self.L, self.drive = system.conductance(rpm, on), system.drive(rpm)
        self.heat = system.heat(rpm, on, t, feed)
        self.into = np.array([law.into for law in system.laws]).T
        self.reads = np.array([law.reads for law in system.laws])

    def lawful(self, t: float, T: Array) -> Array:
        """Heat [W] of every law that reads a temperature."""
        read = self.reads @ T
        return np.array([law.power(t, self.rpm, x) for law, x in zip(self.system.laws, read, strict=True)])

    def exchanged(self, t: float, T: Array) -> Array:
        """Heat [W] of every cell by the laws that are no straight lines."""
        air = self.air(t)
        return np.asarray(sum(each.heat(t, self.rpm, air, T) for each in self.system.exchanges))

    def rate(self, t: float, T: Array) -> Array:
        """dT/dt [K/s]."""
        q = self.heat + self.drive * self.air(t) - self.L @ T
        if self.system.laws:
            q = q + self.into @ self.lawful(t, T)
        if self.system.exchanges:
            q = q + self.exchanged(t, T)
        return np.asarray(q / self.system.C)


class Stepper:
    """Steps of one length h [s] in one regime: T and its rate at t → T and its rate at t + h."""

    def __init__(self, regime: Regime, h: float) -> None:
        self.regime, self.h = regime, h
        M = np.linalg.inv(np.diag(regime.system.C) + h * D * regime.L)
        self.back = M @ regime.L
        self.heat, self.drive = M @ regime.heat, M @ regime.drive
        self.into = M @ regime.into if regime.system.laws else None
        self.M = M if regime.system.exchanges else None

    def stage(self, t: float, T: Array, guess: Array) -> Array:
        """The rate k [K/s] that solves its own stage."""
        known = self.heat + self.drive * self.regime.air(t) - self.back @ T
        if self.into is None and self.M is None:
            return np.asarray(known)
        k = guess
        for _ in range(ROUNDS):
            before, k = k, known + self.bent(t, T + self.h * D * k)
            if self.h * np.abs(k - before).max() < ENOUGH:
                break
        return k

    def bent(self, t: float, T: Array) -> Array:
        """What heat that depends on temperature in other ways than L adds to the rate [K/s]."""
        k = np.zeros_like(T) if self.into is None else self.into @ self.regime.lawful(t, T)
        return k if self.M is None else np.asarray(k + self.M @ self.regime.exchanged(t, T))

    def step(self, t: float, T: Array, k1: Array) -> tuple[Array, Array]:
        h = self.h
        k2 = self.stage(t + GAMMA * h, T + h * D * k1, k1)
        base = T + h * W * (k1 + k2)
        k3 = self.stage(t + h, base, k2)
        return base + h * D * k3, k3
