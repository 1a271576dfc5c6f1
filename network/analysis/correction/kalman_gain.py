"""The constant gain of the filter: how far a reading is believed against the model.

What the model does not know is taken as heat: every source is off by the ± of the file (20 % where it has none) and the
temperature of every held node by 1 K, both wandering within an hour, so that over times longer than that they are white
with the density 2 σ² τ. Readings have the noise of the file. The gain is that of the steady filter (discrete Riccati).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.linalg import solve_discrete_are

from network.analysis.correction.input_table import InputTable
from network.analysis.correction.linear_model import LinearModel
from network.catalogue.declaration.declare import Array
from network.engine.balance import source_heat
from network.platform.quantities.units import unit

WANDERS = 3600.0
"""s"""
USUAL, ROOM = 0.2, 1.0
"""Share that a source is off by where the file gives no ±; K that a held temperature is off by."""
UNEVEN = 2.0
"""K: how far parts lie from their mean at a start."""


def density(model: LinearModel, tables: tuple[InputTable, ...]) -> Array:
    """Spectral density of the drive of all free lumps [K²/s], (n, n)."""
    columns = [model.F_heat @ heat for heat in _unsure_heats(model, tables)]
    columns += [column * ROOM for column in model.F_held.T]
    G = np.stack(columns, axis=1) if columns else np.zeros((len(model.A), 1))
    return np.asarray(2 * WANDERS * G @ G.T)


def _unsure_heats(model: LinearModel, tables: tuple[InputTable, ...]) -> Iterator[Array]:
    """1σ of every source as heat into the lumps, at the largest values of the inputs tabulated [W]."""
    tops = {t.name: np.array(unit(t.unit).scale * t.step * (len(t.above) - 1)) for t in tables}
    u = {**model.u, **tops}
    for heats in model.network.heats:
        if heats.is_heat:
            q = source_heat(heats, model.point, u)
            for column, entry in enumerate(heats.entry.tolist()):
                name = model.network.mechanisms[entry].partition(".")[2]
                yield heats.into[:, column] * q[column] * _share(model, name)


def _share(model: LinearModel, source: str) -> float:
    """What its numbers are off by, relatively."""
    shares = [n.spread if n.prior == "log" else n.spread / max(abs(n.value), 1e-12)
              for n in model.machine.sources[source].uncertain().values() if n.prior != "unknown"]  # fmt: skip
    return float(min(np.hypot.reduce(shares), 1.0)) if shares else USUAL


def steady_gain(Phi: Array, S: Array, Q: Array, noise: Array) -> Array:
    """Gain of the steady filter. Q: of one step; noise: 1σ of the readings."""
    if not len(S):
        return np.zeros((len(Phi), 0))
    R = np.diag(noise**2)
    P = solve_discrete_are(Phi.T, S.T, Q + 1e-12 * np.trace(Q) / len(Q) * np.eye(len(Q)), R)
    return np.asarray(P @ S.T @ np.linalg.inv(S @ P @ S.T + R))


def first_gain(project: Array, S: Array, noise: Array) -> Array:
    """Gain of the first readings: parts lie about their mean by UNEVEN, each by itself."""
    if not len(S):
        return np.zeros((len(project), 0))
    P = UNEVEN**2 * project @ project.T
    return np.asarray(P @ S.T @ np.linalg.inv(S @ P @ S.T + np.diag(noise**2)))
