"""Parts that melt, in a fit: their heat capacity changes along a run, by windows and within a window as a heat.

C(T) dT/dt = Q is, with the capacity C_w of a window, C_w dT/dt = Q + (C_w/C(T) − 1) Q. The last is a heat over time
that follows the run as those of bent laws do, and windows are laid so that C_w/C(T) stays near 1. Source: apparent heat
capacity (catalogue.nodes.Melting), by the waveform relaxation of engine.response.waveform.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.catalogue.mechanisms.base import STEP, add_imaginary_step
from network.engine.channels import Readouts
from network.engine.network import Network
from network.engine.response.nonlinear_correction import Bends
from network.engine.solvers.elimination import Regime, regime_from


@dataclass(frozen=True, eq=False)
class Latent:
    """The lumps of a network that melt (m of them)."""

    network: Network
    lumps: Indices

    @classmethod
    def of(cls, network: Network) -> Latent:
        parts = [network.parts[name] for name in network.melting]
        return cls(network, np.array([i for part in parts for i in range(part.start, part.stop)], int))

    @property
    def spread(self) -> Array:
        """What a watt into each of them brings into the lumps (m, N)."""
        return np.eye(self.network.size)[self.lumps]

    def stretch(self, T: Array) -> Array:
        """C(T)/C of each, at the temperatures of all lumps: (…, N) → (…, m)."""
        columns = []
        for name in self.network.melting:
            part, melts = self.network.parts[name], self.network.machine.nodes[name].stored
            assert melts is not None
            columns.append(1 + melts.apparent_capacity(T[..., part]) / self.network.capacity[part].sum())
        return np.concatenate([*columns, np.zeros((*T.shape[:-1], 0))], axis=-1)

    def slope(self, T: Array) -> Array:
        """Its derivative by the temperature of each [1/K]."""
        return np.asarray(np.imag(self.stretch(add_imaginary_step(T, 1j * STEP))) / STEP)

    def find_regime(self, stretch: Array, K: Array, readouts: Readouts) -> Regime:
        """The regime of a window whose capacities are so many times the usual ones (m)."""
        if not len(self.lumps):
            return regime_from(self.network, K, readouts)
        capacity = self.network.capacity.copy()
        capacity[self.lumps] *= stretch
        return replace(regime_from(replace(self.network, capacity=capacity), K, readouts), is_symmetric=False)

    def heat(self, T: Array, into: Array, stretch: Array) -> Array:
        """The further heat (·, m) at temperatures T where `into` goes into all lumps, beside windows so stretched."""
        return np.asarray(self.gain(T, stretch) * into[..., self.lumps])

    def bends(self, T: Array, into: Array, stretch: Array, regimes: Sequence[Regime], of: Indices) -> Bends:
        """How that heat answers to temperatures along a run (2 K, ·); of: the regime of each of the 2 K ends."""
        N, gain = self.network.size, self.gain(T, stretch)
        curved = -(gain + 1) * self.slope(T) / self.stretch(T) * into[:, self.lumps]
        reads, series, slopes = list[int](), list[int](), list[Array]()
        for m, i in enumerate(self.lumps.tolist()):
            rows = np.array([regime.K[i] for regime in regimes])
            for j in np.flatnonzero(np.isfinite(self.network.capacity) & (rows.any(axis=0) | (np.arange(N) == i))):
                reads.append(int(j))
                series.append(m)
                slopes.append(gain[:, m] * rows[of, j] + (curved[:, m] if j == i else 0.0))
        return Bends(np.eye(N), np.array(reads, int), np.array(series, int), np.array(slopes), self.spread)

    def gain(self, T: Array, stretch: Array) -> Array:
        """What more a watt counts than in the windows (·, m)."""
        return np.asarray(stretch / self.stretch(T) - 1)
