"""Where a run begins: given temperatures, equilibrium, or first readings with steady interpolation in between."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from network.catalogue.declaration.declare import Array, Mask
from network.catalogue.declaration.fields import Place
from network.catalogue.mechanisms.base import Inputs
from network.engine.balance import heat_balance, jacobian
from network.engine.network import Network, Rates
from network.platform.refusal import Failed, Spot, likely, refuse
from network.recordings.counted_readings import drop_uncounted
from network.recordings.inputs import Schedule, Start
from network.recordings.recording import Recording

NEAR_REFERENCE = 0.5
"""K: first readings this close to the reference mean a cold start."""
FIRST_READINGS = 60.0
"""s: the stretch whose mean is a first reading."""
NEWTON_STEPS = 100


def start_temperatures(network: Network, schedule: Schedule, recording: Recording | None = None) -> Array:
    """Temperatures of all lumps at the start [°C]. Raises Refused for nodes that are not there."""
    T = np.full(network.size, network.machine.reference)
    u = first_inputs(schedule)
    _hold(network, T, u)
    start = schedule.start
    if start is not None and start.steady:
        return steady_state(network, T, u)
    if start is not None:
        T = _set_given(network, start, T, schedule.file)
    elif recording is not None:
        T = from_first_readings(network, recording, T, u)
    return _begin_states(network, T, u)


def _begin_states(network: Network, T: Array, u: Inputs) -> Array:
    """The temperatures of a start, with what the states of entries begin with."""
    for rates in network.heats:
        if isinstance(rates, Rates):
            lumps, first = rates.first(u, T)
            T[lumps] = first
    return T


def first_inputs(schedule: Schedule) -> Inputs:
    """The inputs just after the start."""
    t0 = schedule.t[:1]
    return {"time": t0[0]} | {name: signal.at(t0)[0] for name, signal in schedule.signals.items()}


def _hold(network: Network, T: Array, u: Inputs) -> None:
    for i, held in network.held.items():
        T[i] = held.at(u)


def _set_given(network: Network, start: Start, T: Array, file: str) -> Array:
    parts = np.isfinite(network.capacity)
    if start.others is not None:
        T[parts] = start.others
    for name, value in (start.nodes or {}).items():
        node = network.machine.nodes.get(name)
        if node is None:
            raise refuse(Spot(file), f"start names '{name}', which is no node", likely(name, network.machine.nodes))
        if node.is_held:
            raise refuse(Spot(file), f"start gives a temperature to '{name}', which is held", "give it in the inputs")
        T[network.parts[name]] = value
    return T


def steady_state(network: Network, T: Array, u: Inputs) -> Array:
    """Temperatures at which every part and junction gets no heat, at the inputs u; relays are off. Newton."""
    inner = np.flatnonzero(np.isfinite(network.capacity))
    off = np.zeros(sum(relays.into.shape[1] for relays in network.relays))
    for _ in range(NEWTON_STEPS):
        left_over = heat_balance(network, T, u, off).into[inner]
        J = jacobian(network, T, u, off)[np.ix_(inner, inner)]
        if np.linalg.cond(J) > 1e13:
            raise Failed("there is no steady state: a part has no path to a held node; give `start:` temperatures")
        step = np.linalg.solve(J, left_over)
        T[inner] -= step
        if np.abs(step).max() < 1e-10 * (1 + np.abs(T[inner]).max()):
            return T
    raise Failed("the steady state was not found; give `start:` temperatures")


def from_first_readings(network: Network, recording: Recording, T: Array, u: Inputs) -> Array:
    """The reference if all channels begin near it; else sensed lumps at their first readings, the others where
    conduction and convection between sensed and held lumps would settle without any source.

    A part that warms at once leaves the reference within the minute that a first reading is the mean of, and one noisy
    sample may lie off: it is enough that either lies near.
    """
    readings = list(_first_readings(network, recording))
    reference = network.machine.reference
    if all(min(abs(first - reference), abs(mean - reference)) <= NEAR_REFERENCE for _, first, mean in readings):
        return T
    known = np.zeros(network.size, bool)
    known[network.bound] = True
    for place, _, mean in readings:
        sensed = network.row(place) > 0
        T[sensed], known[sensed] = mean, True
    return interpolate_start(network, T, known, u)


def _first_readings(network: Network, recording: Recording) -> Iterator[tuple[Place, float, float]]:
    """Of every temperature channel: its place, its first sample, the mean of its first minute [°C]."""
    recording = drop_uncounted(network.machine, recording)
    early = recording.t <= recording.t[0] + FIRST_READINGS
    for name, sensor in network.machine.sensors.items():
        if sensor.place is not None and name in recording.columns:
            values = recording.columns[name].values[early]
            finite = values[np.isfinite(values)]
            if len(finite):
                yield sensor.place, float(finite[0]), float(finite.mean())


def interpolate_start(network: Network, T: Array, known: Mask, u: Inputs) -> Array:
    """Unknown lumps settle between the known ones, by links alone, linearised at the mean of what is known."""
    unknown = np.flatnonzero(~known & ~network.is_state)
    if not len(unknown):
        return T
    T[unknown] = T[known].mean()
    K = np.zeros((network.size, network.size))
    for flows in network.flows:
        if flows.relay is not None:
            continue
        at = T[flows.a] + 1e-3, T[flows.b] - 1e-3
        G = flows.w * np.abs(flows.law.slopes(*at, u, *(R @ T for R in flows.reads))[0])
        if not flows.one_way:
            np.add.at(K, (flows.a, flows.b), G)
            np.add.at(K, (flows.b, flows.a), G)
    K -= np.diag(K.sum(axis=1))
    inner = K[np.ix_(unknown, unknown)] - 1e-12 * np.abs(K).max() * np.eye(len(unknown))
    pull = 1e-12 * np.abs(K).max() * T[unknown]
    T[unknown] = np.linalg.solve(inner, -(K[np.ix_(unknown, np.flatnonzero(known))] @ T[known]) - pull)
    return T
