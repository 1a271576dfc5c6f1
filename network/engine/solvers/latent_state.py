"""What a lump that melts is followed by: the heat in it over its heat capacity, a temperature while nothing melts.

So a narrow melting range cannot be stepped over, and no heat is lost in one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from network.catalogue.declaration.declare import Array
from network.engine.network import Network


class LatentState:
    """Of the lumps that are solved for."""

    def __init__(self, network: Network, solved: NDArray[np.bool_]) -> None:
        place = np.cumsum(solved) - 1
        self.melting = [
            (slice(int(place[part.start]), int(place[part.stop - 1]) + 1), stored, node.capacity)
            for name, node in network.machine.nodes.items() if (stored := node.stored) is not None
            for part in (network.parts[name],)
        ]  # fmt: skip

    def state(self, T: Array) -> Array:
        """From temperatures (…, solved lumps)."""
        if not self.melting:
            return T
        x = T.copy()
        for at, stored, capacity in self.melting:
            x[..., at] += stored.compute_latent_heat(T[..., at]) / capacity
        return x

    def temperature(self, x: Array) -> Array:
        """From states (…, solved lumps)."""
        if not self.melting:
            return x
        T = x.copy()
        for at, stored, capacity in self.melting:
            T[..., at] = stored.temperature(x[..., at], capacity)
        return T

    def softening(self, T: Array) -> Array | None:
        """∂T/∂state, less than 1 where heat goes into melting; None where nothing melts."""
        if not self.melting:
            return None
        slope = np.ones(T.shape)
        for at, stored, capacity in self.melting:
            slope[..., at] = capacity / (capacity + stored.apparent_capacity(T[..., at]))
        return slope
