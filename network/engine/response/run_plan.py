"""The plan of a run that is fitted: restarts at every knot."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.network import Network
from network.engine.response.measured_run import Run
from network.engine.solvers.plan import Plan, interval_edges, merge_instants, spans

PIECES = 4
"""Of the distance between knots where a part melts: its heat capacity changes manifold while it warms by a kelvin."""


def plan_of(network: Network, run: Run, start: Mapping[str, float]) -> Plan:
    """The plan of a run: restarts at every knot and wherever a law says so; PIECES between them where a part melts."""
    edges = merge_instants(interval_edges(network, run.schedule), run.knots.t)
    if network.melting:
        shares = np.arange(len(edges) * PIECES - PIECES + 1) / PIECES
        edges = np.interp(shares, np.arange(len(edges)), edges)
    left, right = spans(run.schedule, edges)
    T0 = start_of(network, start, left)
    return Plan(network, run.schedule.t, edges, left, right, T0, "modal", "on the knots of a fit")


def start_of(network: Network, start: Mapping[str, float], inputs: Mapping[str, Array]) -> Array:
    """Temperatures of all lumps at the start."""
    T0 = np.full(network.size, network.machine.reference)
    for name, part in network.parts.items():
        T0[part] = start.get(name, network.machine.reference)
    first = {name: values[0] for name, values in inputs.items()}
    for i, held in network.held.items():
        T0[i] = held.at(first)
    return T0
