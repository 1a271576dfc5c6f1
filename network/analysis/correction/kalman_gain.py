"""The constant gain of the filter: how far a reading is believed against the model.

What the model does not know is taken as heat: every source is off by the ± of the file (20 % where it has none) at its
largest, and the temperature of every held node by 1 K, each by itself and wandering within an hour. Conductances and
heat capacities count as known: calibrate before. They are states of
the filter beside those of the machine, d ← e^(−step/hour) d + noise of unit variance in all, as many directions of them
as there are sensors to tell them by. The gain is that of the steady filter (discrete Riccati equation; Anderson &
Moore, Optimal Filtering, 1979, ch. 4 and 11).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_discrete_are, solve_discrete_lyapunov

from network.analysis.correction.input_table import InputTable
from network.analysis.correction.linear_model import LinearModel
from network.catalogue.declaration.declare import Array, Declared
from network.engine.balance import source_heat
from network.platform.quantities.units import unit

WANDERS = 3600.0
"""s"""
USUAL, ROOM = 0.2, 1.0
"""Share that a source is off by where the file gives no ±; K that a held temperature is off by."""
FORGETS = 1 - 1e-6
"""Of every step, where there is no sensor."""
TINY = 1e-10
"""Variance that the states of the machine gain in a step by rounding and by what is held over it."""
UNEVEN = 2.0
"""K: how far parts lie from their mean at a start."""


def unsure_drives(model: LinearModel, tables: tuple[InputTable, ...]) -> tuple[dict[str, Array], dict[str, float]]:
    """1σ of every source as heat into the lumps [W], and of every held node [K], by name."""
    held = [next(n for n, part in model.network.parts.items() if part.start == i) for i in model.network.bound.tolist()]
    return dict(_unsure_heats(model, tables)), dict.fromkeys(held, ROOM)


def main_directions(drives: Array, names: Sequence[str], most: int) -> tuple[Array, tuple[str, ...]]:
    """Sums of several independent drives of one σ each (their weights in columns) that do most, the largest first, at
    most so many, and none below a hundredth of the largest; each with the drive most like it, with its sign."""
    _, values, Vt = np.linalg.svd(drives, full_matrices=False)
    count = min(int(np.sum(values > 0.01 * values[0])), most)
    main = [int(np.argmax(np.abs(row))) for row in Vt[:count]]
    signs = np.sign([row[k] for row, k in zip(Vt, main, strict=False)])
    return np.asarray(Vt[:count].T * signs), tuple(names[k] for k in main)


def _unsure_heats(model: LinearModel, tables: tuple[InputTable, ...]) -> Iterator[tuple[str, Array]]:
    """1σ of every source as heat into the lumps, at the largest values of the inputs tabulated [W]."""
    tops = {t.name: np.array(unit(t.unit).scale * t.step * (len(t.above) - 1)) for t in tables}
    u = {**model.u, **tops}
    for heats in model.network.heats:
        if heats.is_heat:
            q = source_heat(heats, model.point, u)
            for column, entry in enumerate(heats.entry.tolist()):
                name = model.network.mechanisms[entry].partition(".")[2]
                yield name, heats.into[:, column] * q[column] * _share(model, name)


def _share(model: LinearModel, source: str) -> float:
    """What the numbers of a source are off by, relatively."""
    entry = model.machine.sources[source]
    return _relative(entry) if entry.uncertain() else USUAL


def _relative(entry: Declared) -> float:
    """What its uncertain numbers are off by, relatively, together; all of it at most."""
    shares = [n.spread if n.prior == "log" else n.spread / max(abs(n.value), 1e-12)
              for n in entry.uncertain().values() if n.prior != "unknown"]  # fmt: skip
    return float(min(np.hypot.reduce(shares), 1.0)) if shares else 0.0


@dataclass(frozen=True)
class SteadyFilter:
    """gain (r, sensors); states: covariance of the states once corrected (r, r); missed: 1σ of what readings miss."""

    gain: Array
    states: Array
    missed: Array


def settle(
    Phi: Array, M: Array, S: Array, unknown: Array, step: float, noise: Array
) -> tuple[Array, Array, SteadyFilter]:
    """Phi, and M over S, with the states of the unknown, and the steady filter. unknown: (r + axes + sensors, p), what
    one σ of each does to the states in a step and to the outputs at once; noise: 1σ of the readings."""
    r, p, remains = len(Phi), unknown.shape[1], np.exp(-step / WANDERS)
    Phi = np.block([[Phi, unknown[:r]], [np.zeros((p, r)), remains * np.eye(p)]])
    C = np.hstack([np.vstack([M, S]), unknown[r:]])
    Q = np.diag(np.concatenate([np.full(r, TINY), np.full(p, 1 - remains**2)]))
    seen = C[len(M) :]
    if not len(S):
        alone = solve_discrete_lyapunov(Phi * FORGETS, Q)
        return Phi, C, SteadyFilter(np.zeros((r + p, 0)), np.asarray(alone), np.zeros(0))
    R = np.diag(noise**2)
    P = solve_discrete_are(Phi.T, seen.T, Q, R)
    expected = seen @ P @ seen.T + R
    gain = P @ seen.T @ np.linalg.inv(expected)
    return Phi, C, SteadyFilter(np.asarray(gain), np.asarray(P - gain @ seen @ P), np.sqrt(np.diag(expected)))


def first_gain(project: Array, S: Array, noise: Array) -> Array:
    """Gain of the first readings, (r + p, sensors), S with the states of the unknown: parts lie about their mean by
    UNEVEN, each by itself, and what is unknown is off by its σ."""
    r, n = len(project), S.shape[1]
    P = np.eye(n)
    P[:r, :r] = UNEVEN**2 * project @ project.T
    if not len(S):
        return np.zeros((n, 0))
    return np.asarray(P @ S.T @ np.linalg.inv(S @ P @ S.T + np.diag(noise**2)))
