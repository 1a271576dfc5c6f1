"""Stops scored about a fit: of each run and driver every stretch between two of its steps.

With D what a stretch changes, r the residual and M what takes out all that numbers take up, standing at full strength
gains g − κ/2 [nats], g = Dᵀ M r, κ = Dᵀ M D, and at the best strength a = g/κ it gains g²/2κ. D is a difference of
sums over steps, so that all K²/2 stretches cost the products of K rows.

How long a stretch is can make up for what its strength is not. So the stretch that explains most at any strength has to
stand nearer to full strength than to none, and than to twice that; and where numbers are off, the best at full strength
is too short by as much as that one is too long, so that a stop is taken to begin and to end half-way between them.
Source: as of `screen`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised
from network.analysis.calibration.misfit import ChannelMisfit
from network.analysis.diagnosis.standstill.absent_heat import Absence, find_absence
from network.analysis.diagnosis.standstill.driver import Driver
from network.analysis.diagnosis.standstill.lasting_fit import LastingFit
from network.catalogue.declaration.declare import Array, Indices

SEEN = 1e-6
"""κ below which nothing of a stretch can be told."""
FULL = (0.5, 1.5)
"""Strengths that are nearer to full than to none, and than to twice that."""


@dataclass(frozen=True, eq=False)
class Stretch:
    """A stop of a driver in a run from begin to end [s]. gain [nats]: at full strength; strength: of the stretch that
    explains most at any; width: of the steps at its ends [s]; tried: how many stretches it was chosen from."""

    driver: Driver
    run: int
    begin: float
    end: float
    gain: float
    strength: float
    width: float
    tried: int

    @property
    def is_strong(self) -> bool:
        """Nearer to full strength than to none. Numbers that were fitted to stops are too small: it may seem more."""
        return self.strength > FULL[0]

    @property
    def is_full(self) -> bool:
        """About numbers that were not."""
        return FULL[0] < self.strength < FULL[1]


def scan_stretches(
    at: Linearised, drivers: Iterable[Driver], runs: Iterable[int] | None = None,
    misfits: Mapping[str, ChannelMisfit] | None = None,
) -> list[Stretch]:  # fmt: skip
    """The best stretch of each driver and run, the best first; misfits: of the channels, by default those of the
    fit."""
    fit, runs = LastingFit(at, misfits), [*(range(len(at.predictions)) if runs is None else runs)]
    found = [s for driver in drivers for run in runs for s in _scan_run(fit, driver, run)]
    return sorted(found, key=lambda s: -s.gain)


def _scan_run(fit: LastingFit, driver: Driver, run: int) -> Iterator[Stretch]:
    absence = find_absence(fit.at.predictions[run], driver)
    if absence is None:
        return
    i, j = _list_stretches(absence)
    if not len(i):
        return
    g, kappa = _gather(*fit.weigh(run, absence.changes), i, j)
    gain, free = g - kappa / 2, np.where(g > 0, g**2 / (2 * kappa), 0.0)
    best, freest = int(gain.argmax()), int(free.argmax())
    strength, t = float(g[freest] / kappa[freest]), absence.edges
    ways = [best, freest] if strength > FULL[0] else [best, best]
    begin, end = float(t[i[ways]].mean()), float(t[j[ways]].mean())
    width = max(t[i[best] + 1] - t[i[best]], t[j[best]] - t[j[best] - 1])
    yield Stretch(driver, run, begin, end, float(gain[best]), strength, float(width), len(i))


def _list_stretches(absence: Absence) -> tuple[Indices, Indices]:
    """Steps at which a stretch may begin, and edges at which it may end: where the driver ran before it, and would run
    at its beginning and its end."""
    moves = absence.moves
    i, j = np.triu_indices(len(moves) + 1, 1)
    told = moves[np.minimum(i, len(moves) - 1)] & moves[j - 1] & (i > moves.argmax())
    return i[told], j[told]


def _gather(g: Array, kappa: Array, i: Indices, j: Indices) -> tuple[Array, Array]:
    """g and κ of stretches from those of all that lies before their edges."""
    own = np.diag(kappa)
    return g[j] - g[i], np.maximum(own[i] + own[j] - 2 * kappa[i, j], SEEN)
