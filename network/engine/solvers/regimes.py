"""Regimes: the sets of conductances that a linear network goes through as its inputs change."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.catalogue.mechanisms.mechanism import Mechanism
from network.engine.balance import evaluate_driven_conductances
from network.engine.network import Network

MOST_NUMBERS = 2_000_000
"""Regimes times lumps squared up to which each is diagonalised and kept: some 0.3 GB and seconds."""


def matrix_inputs(network: Network) -> list[str]:
    """Inputs that conductances depend on: their values make the regime."""
    laws: list[Mechanism] = [flows.law for flows in network.flows]
    laws += [heats.law for heats in network.heats if heats.reads]
    return sorted({name for law in laws for name in law.needs()})


def regimes(
    network: Network, left: Mapping[str, Array], about: Array | None = None
) -> tuple[Indices, Indices]:  # fmt: skip
    """One interval of each regime, and the regime of each interval, from the inputs held in every interval; about:
    temperatures of all lumps at which laws that are not straight are told apart.

    A regime is a set of conductances, not of inputs: a joint that moves within a lump stays in one.
    """
    keys = matrix_inputs(network)
    if not keys:
        return np.zeros(1, int), np.zeros(len(left["time"]), int)
    first, at = _list_different(np.stack([left[name] for name in keys], axis=1))
    G = evaluate_driven_conductances(network, {name: held[first, None] for name, held in left.items()}, about)
    _, again, regime = np.unique(G, axis=0, return_index=True, return_inverse=True)
    return first[again], np.asarray(regime.ravel()[at])


def _list_different(values: Array) -> tuple[Indices, Indices]:
    """One row of each that differs, and which of these every row is: rows that stay are compared once."""
    begins = np.flatnonzero(np.append(True, (values[1:] != values[:-1]).any(axis=1)))
    _, first, at = np.unique(values[begins], axis=0, return_index=True, return_inverse=True)
    return begins[first], np.repeat(at.ravel(), np.diff(np.append(begins, len(values))))


def too_many(network: Network, left: Mapping[str, Array]) -> str:
    """Says so where a run has more regimes than are worth their modes; empty where it has not."""
    if not matrix_inputs(network):
        return ""
    count = len(regimes(network, left)[0])
    if count * network.size**2 <= MOST_NUMBERS:
        return ""
    inputs = " and ".join(f"'{name}'" for name in matrix_inputs(network))
    return f"{inputs} makes {count} sets of conductances, too many to find the modes of each"
