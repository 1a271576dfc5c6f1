"""Faults of a reading from an instant on, scored about a fit: every run, channel, shape and instant in one pass.

A fault of unit size adds w to the whitened readings: of its run from the instant on, of the runs after it all the time
where it stays. With r the residual, S the slopes, P the precision and p = −½ of the gradient of J, all numbers refitted
beside it take up Sᵀ P⁻¹ S w. What is left, κ = wᵀw − (Sw)ᵀ P⁻¹ (Sw), tells the size a/κ, a = wᵀr − (Sw)ᵀ P⁻¹ p, with 1σ
of κ^-½, and the gain a²/2κ [nats], in units of the misfit. Source: the score test with nuisance parameters,
as in `screen`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised, chi_of
from network.analysis.calibration.measured_means import Measured
from network.analysis.diagnosis.intermittent.channel_samples import truth_at_samples
from network.analysis.diagnosis.intermittent.fault_shapes import FaultShape
from network.catalogue.declaration.declare import Array
from network.recordings.recording import Recording

LEAST_CELLS = 3
"""Cells before and after an instant, so that there is something to compare."""
SEEN = 1e-6
"""κ below which nothing of a fault can be told."""


@dataclass(frozen=True, eq=False)
class Onset:
    """A fault of a shape from an instant t0 [s] of a run on, and in the later runs where it stays; size and its 1σ;
    gain [nats]; width: of the cells about t0 [s]; since: what of the gain is due to its beginning there, not with the
    run [nats]."""

    shape: FaultShape
    run: int
    t0: float
    stays: bool
    size: float
    std: float
    gain: float
    width: float
    since: float

    def begins_in(self, run: int) -> float:
        """The instant from which it holds in a run [s]; never is infinite."""
        if run == self.run:
            return self.t0
        return -np.inf if run > self.run and self.stays else np.inf


ANYWHEN = (-np.inf, np.inf)


@dataclass(frozen=True, eq=False)
class _Columns:
    """Of one run and one shape: whitened unit faults that begin at each of its cells (instants, rows), with what they
    have in common with residual and slopes."""

    t0: Array
    whitened: Array
    along: Array
    shared: Array

    @cached_property
    def squares(self) -> Array:
        return np.asarray(np.einsum("kr,kr->k", self.whitened, self.whitened))


class OnsetScan:
    """All scores about some numbers. chi: misfit that counts as noise, default what is left; pull: what still draws the
    numbers from where they are, nothing where they were fitted to these readings."""

    def __init__(
        self, at: Linearised, shapes: Sequence[FaultShape], recordings: Sequence[Recording], chi: float | None = None
    ) -> None:
        self.shapes, self.recordings = shapes, recordings
        self.chi = max(1.0, chi_of(at) if chi is None else chi)
        self.at = at = at.temper(1.0, self.chi)
        self.covariance = at.covariance
        self.pull = at.pull

    def best(self) -> list[Onset]:
        """The best of every run, channel and shape, the best first."""
        found = [onset for shape in self.shapes for onset in self._of_shape(shape)]
        return sorted(found, key=lambda onset: -onset.gain)

    def again(self, known: Onset, reach: float = np.inf) -> Onset | None:
        """The best of the same shape, run and stay that begins within reach of it [s]."""
        columns = [self._columns(i, known.shape) for i in range(len(self.at.problem.data))]
        within = (known.t0 - reach, known.t0 + reach)
        return self._score(known.shape, columns, known.run, known.stays, within)

    def begun_at(self, run: int, channel: str, at: float, reach: float) -> Iterator[Onset]:
        """Of every shape that jumps the best that begins within reach of an instant of a run [s], over with the run and
        staying."""
        for shape in self.shapes:
            if shape.channel == channel and shape.may_jump:
                columns = [self._columns(i, shape) for i in range(len(self.at.problem.data))]
                yield from self._list_of_run(shape, columns, run, (at - reach, at + reach))

    def _of_shape(self, shape: FaultShape) -> Iterator[Onset]:
        columns = [self._columns(i, shape) for i in range(len(self.at.problem.data))]
        for run in range(len(columns)):
            yield from self._of_run(shape, columns, run)

    def _of_run(self, shape: FaultShape, columns: Sequence[_Columns | None], run: int) -> Iterator[Onset]:
        """The better of one that is over with the run and one that stays, if there is any."""
        known = [*self._list_of_run(shape, columns, run)]
        if known:
            yield max(known, key=lambda each: each.gain)

    def _list_of_run(
        self, shape: FaultShape, columns: Sequence[_Columns | None], run: int, within: tuple[float, float] = ANYWHEN
    ) -> Iterator[Onset]:
        """The best one that is over with the run and the best that stays, if there are any."""
        lasting = (False, True) if shape.may_stay and run < len(columns) - 1 else (False,)
        told = (self._score(shape, columns, run, stays, within) for stays in lasting)
        return (each for each in told if each is not None)

    def _columns(self, i: int, shape: FaultShape) -> _Columns | None:
        """None where the run lacks the channel."""
        problem, (rows, _) = self.at.problem, self.at.rows.slopes.blocks[i]
        data, cells = problem.data[i], problem.data[i].run.knots.cells
        if shape.channel not in data.run.channels or cells <= 2 * LEAST_CELLS:
            return None
        truth, centres = truth_at_samples(self.at.predictions[i], self.recordings[i], shape.channel), data.centres
        unit = np.interp(centres, self.recordings[i].t, shape.full(self.recordings[i], truth))
        t0 = np.concatenate([[-np.inf], _begins(data)[LEAST_CELLS : cells - LEAST_CELLS]])
        channel = data.run.channels.index(shape.channel)
        own, whitened = problem.whiteners[i].of_channel(channel, np.array([shape.last(centres, t, unit) for t in t0]))
        seen = slice(rows.start + own.start, rows.start + own.stop)
        return _Columns(t0, whitened, whitened @ self.at.left[seen], whitened @ self.at.slopes[:, seen].T)

    def _score(
        self, shape: FaultShape, columns: Sequence[_Columns | None], run: int, stays: bool,
        within: tuple[float, float] = ANYWHEN,
    ) -> Onset | None:  # fmt: skip
        here = columns[run]
        if here is None:
            return None
        later = [c for c in columns[run + 1 :] if c is not None] if stays else []
        along = here.along + sum(float(c.along[0]) for c in later)
        shared = here.shared + sum((c.shared[0] for c in later), np.zeros(here.shared.shape[1]))
        square = here.squares + sum(float(c.squares[0]) for c in later)
        taken = shared @ self.covariance
        along = along - taken @ self.pull
        kappa = square - np.einsum("kp,kp->k", taken, shared)
        gain = np.where(kappa > SEEN, along**2 / np.maximum(kappa, SEEN) / 2, 0.0) / self.chi**2
        is_in = (within[0] < here.t0) & (here.t0 < within[1]) & (np.arange(len(gain)) > 0)
        k = int(np.where(is_in, gain, -1.0).argmax())
        if not is_in[k] or kappa[k] <= SEEN:
            return None
        size, std = float(along[k] / kappa[k]), self.chi / float(np.sqrt(kappa[k]))
        width = float(np.diff(here.t0[1:])[max(k - 2, 0) : k].max(initial=0.0))
        return Onset(shape, run, float(here.t0[k]), stays, size, std, float(gain[k]), width, float(gain[k] - gain[0]))


def _begins(data: Measured) -> Array:
    """When each cell begins [s]."""
    knots = data.run.knots
    return np.append(knots.t[:1], knots.t[knots.cell_ends])[:-1]
