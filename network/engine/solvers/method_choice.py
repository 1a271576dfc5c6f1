"""Which solver serves a run, and why; the plan that follows."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.entry_groups import Guards
from network.engine.network import Network
from network.engine.solvers.plan import Plan, interval_edges, merge_instants, spans
from network.engine.solvers.ramps import straighten_ramps
from network.engine.solvers.regimes import matrix_inputs, too_many
from network.platform.refusal import Spot, likely, refuse
from network.recordings.inputs import Schedule

IVP_METHODS = ("LSODA", "BDF", "Radau", "RK45")
METHODS = ("auto", "modal", "krylov", "switched", "rosenbrock", "expm", *(f"solve_ivp:{name}" for name in IVP_METHODS))
EXACT = ("modal", "switched", "expm")
LINEAR = (*EXACT, "krylov")
"""Methods for what is linear in temperature."""
MANY = 400
"""Lumps from which a linear network is solved in a subspace."""


def make_plan(
    network: Network, schedule: Schedule, T0: Array, method: str = "auto", stop_at_samples: bool = False
) -> Plan:
    """The plan of a run; `stop_at_samples` makes every instant of output an edge.

    Raises Refused for a method that does not exist or cannot serve this network.
    """
    if method == "solve_ivp":
        method = "solve_ivp:LSODA"
    if method not in METHODS:
        raise refuse(Spot("--method"), f"there is no method '{method}'", likely(method, METHODS))
    edges = interval_edges(network, schedule)
    left, right = spans(schedule, edges)
    obstacle = why_not_exact(network, left, right)
    if method == "auto" and not (obstacle or network.relays):
        obstacle = too_many(network, left)
    asked, (method, why) = method, _choose_method(network, method, obstacle)
    if method == "modal" and asked == "auto" and not (stop_at_samples or why_not_krylov(network)):
        method, why = "krylov", f"the network is linear, and its {network.size} lumps follow few of their modes"
    if method in LINEAR:
        finer = straighten_ramps(network, schedule, edges, left, right)
        if stop_at_samples:
            finer = merge_instants(finer, schedule.t)
        if finer is not edges:
            edges, (left, right) = finer, spans(schedule, finer)
    return Plan(network, schedule.t, edges, left, right, T0, method, why)


def _choose_method(network: Network, method: str, obstacle: str) -> tuple[str, str]:
    """The method and the reason for it; `obstacle` is what keeps the run from the exact paths."""
    obstacle = obstacle or (_switches(network) if method in ("modal", "expm", "krylov") else "")
    if method in LINEAR and obstacle:
        raise refuse(Spot("--method"), f"{method} is for linear networks, and {obstacle}", "use --method auto")
    if method == "switched" and not network.relays:
        raise refuse(Spot("--method"), "switched needs a relay, and this machine has none", "use --method auto")
    if method != "auto":
        return method, "as asked"
    if obstacle:
        return "rosenbrock", obstacle
    if network.relays:
        return "switched", f"linear between switchings: exact in its modes, and {_switches(network)}"
    return "modal", "the network is linear: exact in its modes"


def why_not_krylov(network: Network) -> str:
    """What keeps a linear network from being reduced to a subspace; empty where nothing does."""
    if network.size < MANY:
        return f"{network.size} lumps are few"
    if any(flows.one_way or flows.reads for flows in network.flows) or any(heats.reads for heats in network.heats):
        return "its conductances are not symmetric"
    return ""


def _switches(network: Network) -> str:
    if not network.relays:
        return ""
    return f"{network.mechanisms[network.relays[0].entry[0]]} ({network.relays[0].law.kind}) switches"


def why_not_exact(network: Network, left: Mapping[str, Array], right: Mapping[str, Array]) -> str:
    """What keeps this run from the exact paths; empty where nothing does."""
    if network.melting:
        return network.tell_melting(network.melting[0])
    for group in network.groups:
        if not group.law.is_affine():
            return f"{network.mechanisms[group.entry[0]]} ({group.law.kind}) is not linear in temperature"
    for relays in network.relays:
        u = {name: values[0] for name, values in left.items()}
        slopes = relays.slopes(u, *(np.zeros(len(R)) for R in relays.reads))
        if isinstance(relays, Guards) or any(np.any(slope) for slope in slopes):
            return f"{network.mechanisms[relays.entry[0]]} ({relays.law.kind}) changes a conductance as it switches"
    for name in matrix_inputs(network):
        if not np.array_equal(left[name], right[name]):
            return f"the input '{name}' is ramped and changes a conductance"
    return ""
