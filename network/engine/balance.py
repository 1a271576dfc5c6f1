"""The heat balance: heat flows at given temperatures, their Jacobian, and the matrices of an affine network.

Signs: a link takes from a and gives to b; a stream only gives to b; a source gives by `into`. Held nodes take part as
columns; their own rows have no meaning.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from network.catalogue.declaration.declare import Array, Indices, Mask
from network.catalogue.mechanisms.mechanism import Inputs, Mechanism, Relay
from network.engine.entry_groups import Flows, Heats
from network.engine.network import Network
from network.platform.refusal import Failed

MOST_LUMPS = 4000
"""Of which every one is set against every other: 0.1 GB a matrix, of which some are needed at once."""


def flow_heat(flows: Flows, T: Array, u: Inputs, modes: Array | None = None) -> Array:
    """Heat of each elementary flow [W], (…, E); what a relay switches by its mode (0 off, 1 on)."""
    heat = flows.w * flows.heat_flow(T, u)
    return np.asarray(heat if flows.relay is None or modes is None else heat * modes[..., flows.relay])


def source_heat(heats: Heats[Mechanism], T: Array, u: Inputs, mode: Array | None = None) -> Array:
    """Heat of each source [W], (…, n); relays by their mode (0 off, 1 on)."""
    heat = heats.heat(u, *(T @ R.T for R in heats.reads)) * np.ones(heats.into.shape[1])
    return np.asarray(heat if mode is None else heat * mode)


@dataclass(frozen=True)
class Heat:
    """Heat into every lump [W], and by mechanism: brought into the parts (links inside: carried from a to b)."""

    into: Array
    by_mechanism: Array


def heat_balance(network: Network, T: Array, u: Inputs, modes: Array) -> Heat:
    """All heat flows at temperatures T [°C], inputs u and relay modes (one for each relay).

    One instant: T (N), inputs scalars. Many: T (M, N), inputs (M, 1).
    """
    by_mechanism = np.zeros((*T.shape[:-1], len(network.mechanisms)))
    bound, into = np.isinf(network.capacity), np.zeros(T.shape)
    for group, heat, spread in _list_heats(network, T, u, modes):
        into += heat @ spread
        if isinstance(group, Flows):
            _add_columns(by_mechanism, group.entry, heat * inward(group, bound))
        elif group.is_heat:
            _add_columns(by_mechanism, group.entry, heat)
    return Heat(into, by_mechanism)


def heat_into(network: Network, T: Array, u: Inputs, modes: Array, lumps: Indices | None = None) -> Array:
    """The same into every lump, or into some, alone [W]."""
    into = np.zeros(T.shape if lumps is None else (*T.shape[:-1], len(lumps)))
    for _, heat, spread in _list_heats(network, T, u, modes):
        into += heat @ (spread if lumps is None else spread[:, lumps])
    return into


def _list_heats(
    network: Network, T: Array, u: Inputs, modes: Array
) -> Iterator[tuple[Flows | Heats[Mechanism], Array, Array]]:
    """Heat of every group [W], (…, members), and what of it goes into which lump (members, N)."""
    for flows in network.flows:
        yield flows, flow_heat(flows, T, u, modes), flows.spread
    for heats, mode in with_modes(network, modes):
        yield heats, source_heat(heats, T, u, mode), heats.into.T


def _add_columns(total: Array, columns: Indices, values: Array) -> None:
    np.add.at(total.T, columns, values.T)


def inward(flows: Flows, bound: Mask) -> Array:
    """+1 where the flow runs into the parts or between them, −1 where it runs out to a held node, 0 past the parts."""
    if flows.one_way:
        return np.where(bound[flows.b], 0.0, 1.0)
    return np.where(bound[flows.b], np.where(bound[flows.a], 0.0, -1.0), 1.0)


def with_modes(network: Network, modes: Array) -> Iterator[tuple[Heats[Mechanism], Array | None]]:
    """Every group of sources, relays with their part of the modes (…, relays)."""
    yield from ((heats, None) for heats in network.heats)
    for relays, part in relay_slices(network):
        yield relays, modes[..., part]


def relay_slices(network: Network) -> Iterator[tuple[Heats[Relay], slice]]:
    first = 0
    for relays in network.relays:
        count = relays.into.shape[1]
        yield relays, slice(first, first + count)
        first += count


def jacobian(network: Network, T: Array, u: Inputs, modes: Array) -> Array:
    """∂(heat into lump i)/∂T_j [W/K], N×N."""
    N = network.size
    if not N <= MOST_LUMPS:
        right = f"take at most {MOST_LUMPS}, or only links and sources that are linear in temperature"
        raise Failed(f"{N} lumps are too many where every one is set against every other; {right}")
    J = np.zeros((N, N))
    for flows in network.flows:
        weight = flows.w if flows.relay is None else flows.w * modes[flows.relay]
        by_a, by_b, *by_own = (weight * slope for slope in flows.slopes(T, u))
        J += np.bincount(flows.b * N + flows.a, by_a, N * N).reshape(N, N)
        J += np.bincount(flows.b * N + flows.b, by_b, N * N).reshape(N, N)
        if not flows.one_way:
            J -= np.bincount(flows.a * N + flows.a, by_a, N * N).reshape(N, N)
            J -= np.bincount(flows.a * N + flows.b, by_b, N * N).reshape(N, N)
        for R, slope in zip(flows.reads, by_own, strict=True):
            J += flows.spread.T @ ((slope * np.ones(len(R)))[:, None] * R)
    for heats, mode in with_modes(network, modes):
        readings = [R @ T for R in heats.reads]
        scale = 1.0 if mode is None else mode
        for R, slope in zip(heats.reads, heats.slopes(u, *readings), strict=True):
            J += heats.into @ ((slope * scale * np.ones(len(R)))[:, None] * R)
    return J


def affine_matrix(network: Network, u: Inputs, modes: Array, about: Array | None = None) -> Array:
    """K [W/K] of an affine network: heat into the lumps = K T + q(u); of another one (a fit of radiation beside a
    relay), its slopes at some temperatures of all lumps, by default the reference."""
    if network.is_affine():
        about = np.zeros(network.size)
    elif about is None:
        about = np.full(network.size, network.machine.reference)
    return jacobian(network, about, u, modes)


def evaluate_driven_conductances(network: Network, u: Inputs, about: Array | None = None) -> Array:
    """The slopes [W/K] that depend on inputs, at many instants: (instants, 1) → (instants, ·); about: temperatures of
    all lumps, which count where laws are not straight."""
    T = np.zeros(network.size) if about is None else about
    slopes = [flows.w * s for flows in network.flows if flows.law.needs() for s in flows.slopes(T, u)]
    slopes += [s for heats in network.heats if heats.law.needs() for s in _slopes_of(heats, T, u)]
    instants = len(u["time"])
    return np.hstack([np.broadcast_to(s, (instants, np.shape(s)[-1])) for s in map(np.atleast_1d, slopes)])


def list_tangent_offsets(network: Network, T: Array, u: Inputs, held: Inputs) -> Iterator[tuple[Array, Array]]:
    """Of every group that is not straight at temperatures T (N), or that inputs u change beside those that its slopes
    are held at: what it brings less its slopes times T, and less what a source brings at readings of zero [W], (…,
    members), and how that spreads (members, N); all relays off."""
    for flows in network.flows:
        if flows.relay is None and (flows.law.needs() or not flows.law.is_affine()):
            by_a, by_b, *by_own = flows.slopes(T, held)
            along = by_a * T[flows.a] + by_b * T[flows.b] + _along(by_own, flows.reads, T)
            yield flow_heat(flows, T, u) - flows.w * along, flows.spread
    for heats in network.heats:
        if heats.reads and (heats.law.needs() or not heats.law.is_affine()):
            still = heats.heat(u, *(np.zeros(len(R)) for R in heats.reads))
            yield source_heat(heats, T, u) - still - _along(_slopes_of(heats, T, held), heats.reads, T), heats.into.T


def _along(slopes: Sequence[Array], reads: Sequence[Array], T: Array) -> Array:
    return sum((slope * (R @ T) for slope, R in zip(slopes, reads, strict=True)), np.zeros(1))


def _slopes_of(heats: Heats[Mechanism], T: Array, u: Inputs) -> tuple[Array, ...]:
    return heats.slopes(u, *(R @ T for R in heats.reads))


def affine_heat(network: Network, u: Inputs, modes: Array, instants: int) -> Array:
    """q(u) [W] of an affine network at many instants: inputs of shape (instants, 1) → (instants, N)."""
    q = np.zeros((instants, network.size))
    for heats, mode in with_modes(network, modes):
        q += source_series(heats, u, mode, instants) @ heats.into.T
    return q


def source_series(heats: Heats[Mechanism], u: Inputs, mode: Array | None, instants: int) -> Array:
    """Heat of each source at zero temperature readings (the constant part of an affine one), (instants, n)."""
    count = heats.into.shape[1]
    zeros = [np.zeros(count) for _ in heats.reads]
    heat = heats.heat(u, *zeros) * np.ones((instants, count))
    return np.asarray(heat if mode is None else heat * mode)
