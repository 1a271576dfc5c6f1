"""A fit whose misfit counts as noise that lasts, channel by channel, so that what begins and ends stands out from it.

What a machine is off by goes on from one cell to the next. Taken as a process of first order of each channel, with the
χ and ρ that its residuals show, rows are weighed as (xₖ − ρ xₖ₋₁)/(χ √(1 − ρ²)) and parameters refitted under that:
generalised least squares. Source: Prais & Winsten 1954, Cowles Commission discussion paper 383; unverified.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np

from network.analysis.calibration.linearised import Linearised
from network.analysis.calibration.misfit import ChannelMisfit, channel_misfits
from network.catalogue.declaration.declare import Array


class LastingFit:
    """at: the fit; misfits: of its channels, by default its own; residual: of every run, what is left beside a full
    step of all numbers, so weighed."""

    def __init__(self, at: Linearised, misfits: Mapping[str, ChannelMisfit] | None = None) -> None:
        self.at, self._misfits = at, {**channel_misfits(at), **(misfits or {})}
        self._rows = [rows for rows, _ in at.rows.slopes.blocks]
        self._slopes = [self._weigh(i, at.slopes[:, rows]) for i, rows in enumerate(self._rows)]
        left = [self._weigh(i, at.left[rows]) for i, rows in enumerate(self._rows)]
        mean, spread = at.stated_prior
        self._precision = np.diag(spread**-2.0) + sum(S @ S.T for S in self._slopes)
        pull = (mean - np.concatenate([at.theta, at.eta])) / spread**2
        pull = pull + sum(S @ r for S, r in zip(self._slopes, left, strict=True))
        step = np.linalg.solve(self._precision, pull)
        self.residual = [r - step @ S for S, r in zip(self._slopes, left, strict=True)]

    @cached_property
    def chi(self) -> float:
        """What is still left, in that noise."""
        return max(1.0, float(np.sqrt(np.mean(np.concatenate(self.residual) ** 2))))

    def weigh(self, run: int, changes: Array) -> tuple[Array, Array]:
        """Of changes D of the cells' means of a run (·, cells): D r, and D M Dᵀ with what all numbers can take up
        projected out; in units of what is left."""
        own = self._weigh(run, self.at.problem.whiteners[run](changes))
        along = own @ self._slopes[run].T
        among = own @ own.T - along @ np.linalg.solve(self._precision, along.T)
        return own @ self.residual[run] / self.chi**2, among / self.chi**2

    def _weigh(self, run: int, whitened: Array) -> Array:
        """Whitened rows of a run (…, rows) under the noise that lasts."""
        out, data = np.array(whitened), self.at.problem.data[run]
        for name, (rows, _) in zip(data.run.channels, self.at.problem.whiteners[run].blocks, strict=True):
            out[..., rows] = _weigh_channel(self._misfits[name], whitened[..., rows])
        return out


def _weigh_channel(misfit: ChannelMisfit, x: Array) -> Array:
    out = np.array(x)
    out[..., 1:] = (x[..., 1:] - misfit.rho * x[..., :-1]) / np.sqrt(1 - misfit.rho**2)
    return np.asarray(out / max(1.0, misfit.chi))
