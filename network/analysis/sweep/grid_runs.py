"""The grid of a sweep over varied numbers: every point run, and kept in a file from which a stopped sweep goes on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np

from network.analysis.sweep.journal import Journal
from network.analysis.sweep.level_runs import Job
from network.analysis.sweep.variations import Extremes, Variation, vary
from network.catalogue.declaration.declare import Array, Indices
from network.engine.simulation import simulate
from network.engine.trajectory import axis_unit
from network.platform.parallel import Told, run_all
from network.platform.refusal import Failed

ROUND = 16
"""Runs for each process after which a journal is written."""


@dataclass(frozen=True)
class VariedRun:
    """One point of the grid: the values, in the order of the variations, and the extremes of every TCP axis."""

    values: tuple[float, ...]
    tcp: Mapping[str, Extremes]
    solve_seconds: float

    @property
    def numbers(self) -> list[float]:
        """What it gave, in a row."""
        return [x for extremes in self.tcp.values() for x in extremes.numbers] + [self.solve_seconds]

    @classmethod
    def read(cls, values: tuple[float, ...], axes: Sequence[str], numbers: Sequence[float]) -> VariedRun:
        """From such a row."""
        ends = np.reshape(numbers[:-1], (len(axes), -1)).tolist()
        tcp = {axis: Extremes(high, low, final, axis_unit(axis))
               for axis, (high, low, final) in zip(axes, ends, strict=True)}  # fmt: skip
        return cls(values, tcp, numbers[-1])


def grid(variations: Sequence[Variation]) -> Iterator[tuple[float, ...]]:
    """All combinations; the last variation runs fastest."""
    return product(*(variation.values for variation in variations))


@dataclass(frozen=True, eq=False)
class GridJob:
    """What all runs of a grid have in common."""

    job: Job
    variations: tuple[Variation, ...]


def run_varied(shared: GridJob, values: tuple[float, ...]) -> VariedRun:
    """One point of the grid. Raises Refused, or Failed with the point's values."""
    job = shared.job
    try:
        machine = vary(job.machine, shared.variations, values)
        run = simulate(machine, job.source, start=job.start, method=job.method, parts=False)
    except Failed as failed:
        settings = zip(shared.variations, values, strict=True)
        raise Failed(f"{', '.join(v.setting(value) for v, value in settings)}: {failed}") from None
    extremes = {axis: Extremes.of(axis, values) for axis, values in run.tcp.items()}
    return VariedRun(values, extremes, run.solve_seconds)


def run_grid(
    shared: GridJob, jobs: int, cluster: str | None, resume: str | Path | None, tell: Told | None
) -> list[VariedRun]:  # fmt: skip
    """All points; jobs, cluster, resume: as in `sweep`. Raises Refused, and Failed with the values of a point that
    breaks down."""
    work, points, axes = partial(run_varied, shared), list(grid(shared.variations)), list(shared.job.machine.tcp)
    if resume is None:
        return run_all(work, points, jobs, tell, cluster)
    paths = [f"{v.path} [{v.unit}]" for v in shared.variations]
    width = len(axes) * len(Extremes.NUMBERS) + 1
    journal = Journal.open(Path(resume), shared.job, paths, np.array(points), width)

    def run(rows: Indices) -> Array:
        done = run_all(work, [points[i] for i in rows.tolist()], jobs, None, cluster)
        return np.array([run.numbers for run in done])

    kept = journal.run_missing(run, ROUND * jobs, tell).tolist()
    return [VariedRun.read(point, axes, row) for point, row in zip(points, kept, strict=True)]
