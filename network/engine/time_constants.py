"""How fast a machine settles: the time constants of its network at rest."""

from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.balance import jacobian
from network.engine.network import Network


def time_constants(network: Network) -> Array:
    """Time constants of a linear network at rest [s], increasing; inf for what never settles or grows."""
    u = {name: np.zeros(()) for name in (*network.machine.inputs, "time")}
    modes = np.zeros(network.relay_count)
    K = jacobian(network, np.full(network.size, network.machine.reference), u, modes)
    free, massless = network.free, network.massless
    inner = K[np.ix_(free, free)]
    if len(massless):
        into, out = K[np.ix_(free, massless)], K[np.ix_(massless, free)]
        inner = inner - into @ np.linalg.pinv(K[np.ix_(massless, massless)]) @ out
    rates = -np.real(np.linalg.eigvals(inner / network.capacity[free, None]))
    settling = rates > 1e-9 * np.abs(rates).max(initial=1e-300)
    return np.sort(np.where(settling, 1 / np.where(settling, rates, 1.0), np.inf))
