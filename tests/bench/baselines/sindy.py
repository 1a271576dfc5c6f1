"""PySINDy on the heat balances: which terms beyond those of the file does C dT/dt of a sensed part need?

Sparse regression (STLSQ: Brunton, Proctor & Kutz, PNAS 113 (2016) 3932) of each sensed part's heat on differences of
temperature and powers of the speed. The parts that no sensor touches, and lumps, are out of its reach.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from bench.baselines.given import Given, found, nothing
from scipy.signal import savgol_filter

from network import Machine, Recording
from network.catalogue.declaration.declare import Array
from network.engine.assembly import build

EVERY = 60.0
"""s between the samples that are regressed on."""
WINDOW = 21
"""Samples over which a temperature is smoothed by a parabola before it is differentiated."""
THRESHOLD, RIDGE = 0.1, 0.05
"""Least share of the rms heat that a term must carry to stay, and the ridge, on terms of rms 1."""
Term = tuple[str, frozenset[str]]


def by_sindy(given: Given) -> dict[str, Any]:
    """The term beyond the file's with the largest share in watts. Raises ImportError without pysindy."""
    import pysindy

    best: tuple[float, Term] | None = None
    for node in given.sensed:
        heat, terms = balance(given, node)
        scale = {term: rms(x) for term, x in terms.items() if rms(x) > 0}
        optimizer = pysindy.STLSQ(threshold=THRESHOLD, alpha=RIDGE)
        optimizer.fit(np.stack([terms[t] / s for t, s in scale.items()], axis=1), heat[:, None] / rms(heat))
        own = {*terms_of(given.machine, node)}
        carried = [
            (abs(c) * rms(heat), t) for c, t in zip(optimizer.coef_[0], scale, strict=True) if t not in own and c
        ]
        best = max([*carried, *([best] if best else [])], key=lambda pair: pair[0], default=None)
    return nothing() if best is None else found(best[1][0], *sorted(best[1][1]))


def balance(given: Given, node: str) -> tuple[Array, dict[Term, Array]]:
    """Heat taken up by a part [W] and the terms of the library, over all recordings."""
    network = build(given.machine)
    capacity = float(network.capacity[network.parts[node]].sum())
    heats, runs = [], []
    for recording in given.recordings:
        t = np.arange(recording.t[0], recording.t[-1], EVERY)
        T = {n: smoothed(recording, sensor, t) for n, sensor in given.sensed.items()}
        rate = savgol_filter(measured(recording, given.sensed[node], t), WINDOW, 2, deriv=1, delta=EVERY)
        heats.append(capacity * rate)
        runs.append(dict(library(given.machine, recording, node, T, t)))
    return np.concatenate(heats), {term: np.concatenate([run[term] for run in runs]) for term in runs[0]}


def measured(recording: Recording, sensor: str, t: Array) -> Array:
    values = recording.columns[sensor].values
    good = np.isfinite(values)
    return np.interp(t, recording.t[good], values[good])


def smoothed(recording: Recording, sensor: str, t: Array) -> Array:
    return np.asarray(savgol_filter(measured(recording, sensor, t), WINDOW, 2))


def library(
    machine: Machine, recording: Recording, node: str, T: dict[str, Array], t: Array
) -> Iterator[tuple[Term, Array]]:  # fmt: skip
    """Terms by the kind and the places that they stand for."""
    here = frozenset([node])
    n = np.abs(recording.signal("speed").at(t)) if "speed" in machine.inputs else np.zeros(len(t))
    for other in T:
        if other != node:
            yield ("conduction", here | {other}), T[other] - T[node]
    for name, held in machine.nodes.items():
        if held.is_held:
            air = surroundings(held, recording, t)
            yield ("convection", here | {name}), air - T[node]
            yield ("forced_convection", here | {name}), n * (air - T[node])
    yield ("heat_source", here), np.ones(len(t))
    for kind, exponent in (("bearing_friction", 1), ("motor_loss", 2), ("windage", 3)):
        yield (kind, here), n**exponent


def surroundings(held: Any, recording: Recording, t: Array) -> Array:
    """Temperature of a held node, an input's or its own."""
    T = held.temperature
    return recording.signal(T).at(t) if isinstance(T, str) else np.full(len(t), float(T))


def terms_of(machine: Machine, node: str) -> Iterator[Term]:
    """Those that the file has at a part, whatever law they follow in detail."""
    for link in machine.links.values():
        ends = frozenset(place.node for place in getattr(link, "between", ()))
        if node in ends and len(ends) == 2:
            yield ("convection" if any(machine.nodes[n].is_held for n in ends) else "conduction"), ends
    for source in machine.sources.values():
        if any(place.node == node for place, _ in source.into):
            yield source.kind, frozenset([node])


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
