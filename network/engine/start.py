"""Where a run begins: given temperatures, equilibrium, or first readings with steady interpolation in between."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from network.catalogue.declaration.declare import Array, Mask
from network.catalogue.declaration.fields import Place
from network.catalogue.mechanisms.mechanism import Inputs
from network.engine.balance import heat_into, jacobian
from network.engine.entry_groups import Rates
from network.engine.network import Network
from network.platform.refusal import Failed, Spot, likely, refuse
from network.recordings.counted_readings import drop_uncounted
from network.recordings.inputs import Schedule, Start
from network.recordings.recording import Recording

NEAR_REFERENCE = 0.5
"""K: first readings this close to the reference mean a cold start."""
FIRST_READINGS = 60.0
"""s: the stretch that first readings are told from."""
FEWEST, CHANCE = 4, 1e-3
"""Readings that a line is laid through, and how often one that stands still is taken for one that moves."""
NEWTON_STEPS = 100


def start_temperatures(network: Network, schedule: Schedule, recording: Recording | None = None) -> Array:
    """Temperatures of all lumps at the start [°C]. Raises Refused for nodes that are not there."""
    T = np.full(network.size, network.machine.reference)
    u = first_inputs(schedule)
    _hold(network, T, u)
    start = schedule.start
    if start is not None and start.steady:
        return steady_state(network, T, u)
    if start is not None and not start.read:
        T = _set_given(network, start, T, schedule.file)
        if recording is not None and start.nodes and start.others is None:
            T = _settle_unnamed(network, recording, start.nodes, T, u)
    elif recording is not None:
        T = from_first_readings(network, recording, T, u, always=start is not None)
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


def _settle_unnamed(network: Network, recording: Recording, named: Mapping[str, float], T: Array, u: Inputs) -> Array:
    """Of a recording whose start names some parts: the rest at first readings, or settled among these and the named."""
    known = np.zeros(network.size, bool)
    known[network.bound] = True
    for name in named:
        known[network.parts[name]] = True
    for reading in first_readings(network, recording).values():
        sensed = (network.row(reading.place) > 0) & ~known
        T[sensed], known[sensed] = reading.begins, True
    return interpolate_start(network, T, known, u)


def steady_state(network: Network, T: Array, u: Inputs) -> Array:
    """Temperatures at which every part and junction gets no heat, at the inputs u; relays are off. Newton."""
    inner = np.flatnonzero(np.isfinite(network.capacity))
    off = np.zeros(network.relay_count)
    for _ in range(NEWTON_STEPS):
        left_over = heat_into(network, T, u, off)[inner]
        J = jacobian(network, T, u, off)[np.ix_(inner, inner)]
        if not np.linalg.cond(J) <= 1e13:
            raise Failed("there is no steady state: a part has no path to a held node; give `start:` temperatures")
        step = np.linalg.solve(J, left_over)
        T[inner] -= step
        if np.abs(step).max() < 1e-10 * (1 + np.abs(T[inner]).max()):
            return T
    raise Failed("the steady state was not found; give `start:` temperatures")


def from_first_readings(network: Network, recording: Recording, T: Array, u: Inputs, always: bool = False) -> Array:
    """The reference if all channels begin near it (unless `always`); else sensed lumps at their first readings, the
    others where conduction and convection between sensed and held lumps would settle without any source.

    A part that warms at once leaves the reference within the minute that a first reading is the mean of, and one noisy
    sample may lie off: it is enough that either lies near.
    """
    readings = list(first_readings(network, recording).values())
    if not always and _is_cold(network, readings):
        return T
    known = np.zeros(network.size, bool)
    known[network.bound] = True
    for reading in readings:
        sensed = network.row(reading.place) > 0
        T[sensed], known[sensed] = reading.begins, True
    return interpolate_start(network, T, known, u)


def begins_cold(network: Network, recording: Recording) -> bool:
    """Whether a recording that says nothing of its start begins at the reference, by what its channels read first."""
    return _is_cold(network, list(first_readings(network, recording).values()))


def _is_cold(network: Network, readings: Sequence[FirstReading]) -> bool:
    reference = network.machine.reference
    return all(min(abs(T - reference) for T in (r.first, r.mean, r.begins)) <= NEAR_REFERENCE for r in readings)


@dataclass(frozen=True)
class FirstReading:
    """Of a temperature channel [°C]: its first sample, the mean of its first minute, and where it begins: that mean, or
    where a line through the minute does, if it moves there; std: 1σ of that."""

    place: Place
    first: float
    mean: float
    begins: float
    std: float


def first_readings(network: Network, recording: Recording) -> dict[str, FirstReading]:
    """Of every temperature channel that reads something in the first minute."""
    recording = drop_uncounted(network.machine, recording)
    early, out = recording.t <= recording.t[0] + FIRST_READINGS, dict[str, FirstReading]()
    for name, sensor in network.machine.sensors.items():
        if sensor.place is not None and name in recording.columns:
            values = recording.columns[name].values[early]
            finite = np.isfinite(values)
            if finite.any():
                begins = _begin(recording.t[early][finite] - recording.t[0], values[finite], sensor.sigma)
                out[name] = FirstReading(sensor.place, float(values[finite][0]), float(values[finite].mean()), *begins)
    return out


def _begin(t: Array, values: Array, sigma: float) -> tuple[float, float]:
    """Where readings begin and its 1σ: the line through them at t = 0 where its slope is there (Student), else their
    mean."""
    from scipy.special import stdtrit

    n, mean = len(values), float(values.mean())
    spread = float(np.sum((t - t.mean()) ** 2))
    if n < FEWEST or spread <= 0:
        return mean, sigma / np.sqrt(n)
    slope = float((t - t.mean()) @ values) / spread
    scatter = max(float(np.sqrt(np.sum((values - mean - slope * (t - t.mean())) ** 2) / (n - 2))), sigma)
    if abs(slope) * np.sqrt(spread) < float(stdtrit(n - 2, 1 - CHANCE / 2)) * scatter:
        return mean, scatter / np.sqrt(n)
    return mean - slope * float(t.mean()), scatter * float(np.sqrt(1 / n + t.mean() ** 2 / spread))


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
        slope = flows.law.slopes(*at, u, *(R @ T for R in flows.reads))[0]
        G = flows.w * np.abs(flows.law.let_pass(slope, u))
        if not flows.one_way:
            np.add.at(K, (flows.a, flows.b), G)
            np.add.at(K, (flows.b, flows.a), G)
    K -= np.diag(K.sum(axis=1))
    inner = K[np.ix_(unknown, unknown)] - 1e-12 * np.abs(K).max() * np.eye(len(unknown))
    pull = 1e-12 * np.abs(K).max() * T[unknown]
    T[unknown] = np.linalg.solve(inner, -(K[np.ix_(unknown, np.flatnonzero(known))] @ T[known]) - pull)
    return T
