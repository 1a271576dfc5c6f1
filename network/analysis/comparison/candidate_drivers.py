"""What residuals may follow: inputs and unused columns, as they are, their rate of change, and with a lag."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from network.analysis.comparison.lags import quick_length
from network.analysis.comparison.resample import Grid
from network.catalogue.declaration.declare import Array
from network.platform.quantities.text_table import span

LAGS = (180.0, 900.0, 4500.0)
"""Time constants of a part that warms behind what drives it [s]."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """values: a row on the grid, NaN in gaps; form: value, rate or lagged; lag: [s]; is_input: the machine reads it."""

    name: str
    form: str
    lag: float
    is_input: bool
    values: Array

    @property
    def words(self) -> str:
        if self.form == "rate":
            return f"the rate of change of {self.name}"
        return self.name if self.form == "value" else f"{self.name} with a lag of {span(self.lag)}"


def forms(name: str, values: Array, is_input: bool, grid: Grid) -> Iterator[Candidate]:
    """A row and what follows from it; nothing where it does not vary."""
    there = np.isfinite(values)
    if there.sum() < 3 or float(np.ptp(values[there])) <= 1e-12 * float(np.abs(values[there]).max()):
        return
    steps = np.arange(grid.n)
    whole = values if there.all() else np.interp(steps, steps[there], values[there])
    rows = [("value", 0.0, whole), ("rate", 0.0, np.gradient(whole) / grid.step)]
    usable = [lag for lag in LAGS if 3 * grid.step < lag < grid.n * grid.step / 4]
    rows += [("lagged", lag, row) for lag, row in zip(usable, lag_series(whole, grid.step, usable), strict=True)]
    for form, lag, row in rows:
        yield Candidate(name, form, lag, is_input, np.where(there, row, np.nan))


def lag_series(values: Array, step: float, lags: list[float]) -> list[Array]:
    """y with lag dy/dt = x − y, at rest at the start; the Fourier transform of x times 1/(1 + iω lag)."""
    n = len(values)
    length = quick_length(2 * n)
    transform = np.fft.rfft(values - values[0], length)
    omega = 2j * np.pi * np.fft.rfftfreq(length, step)
    return [np.fft.irfft(transform / (1 + omega * lag), length)[:n] + values[0] for lag in lags]


def without(rows: Array, candidates: list[Array], there: Array) -> Array:
    """Rows (0 in gaps) less what a straight line and the candidates explain of them, by least squares over what is
    there: what repeats although nothing drives it stays."""
    n = rows.shape[1]
    basis = np.stack([np.ones(n), np.linspace(-1, 1, n), *(normalise(row) for row in candidates)])
    left = np.empty_like(rows)
    for k, (row, mask) in enumerate(zip(rows, there, strict=True)):
        seen = basis if mask.all() else basis * mask
        weights = np.linalg.lstsq(seen @ seen.T, seen @ row, rcond=1e-9)[0]
        left[k] = row - weights @ seen
    return left


def normalise(row: Array) -> Array:
    return np.asarray((row - row.mean()) / (row.std() or 1.0))
