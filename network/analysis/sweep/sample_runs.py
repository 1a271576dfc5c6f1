"""One point of a sample, run: its extremes of the tool centre point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from network.analysis.sweep.level_runs import Job
from network.analysis.sweep.sampling import Drawn
from network.catalogue.declaration.declare import Array
from network.engine.response.parameters import at_values
from network.engine.simulation import simulate
from network.platform.refusal import Failed

EXTREMES = ("max", "min", "final")


@dataclass(frozen=True, eq=False)
class SampleJob:
    """What all runs of a sample have in common."""

    job: Job
    drawn: tuple[Drawn, ...]

    def columns(self) -> list[tuple[str, str]]:
        """(axis, max, min or final) of every value that a run gives."""
        return [(axis, what) for axis in self.job.machine.tcp for what in EXTREMES]


def run_one(shared: SampleJob, point: Array) -> Array:
    """One point (numbers) [SI] → (axes × extremes) [SI]. Raises Failed with the numbers."""
    job, numbers = shared.job, dict(zip((d.path for d in shared.drawn), point.tolist(), strict=True))
    try:
        run = simulate(at_values(job.machine, numbers), job.source, start=job.start, method=job.method, parts=False)
    except Failed as failed:
        told = ", ".join(f"{path}={value:.6g} (SI)" for path, value in numbers.items())
        raise Failed(f"{told}: {failed}") from None
    return np.array([end for values in run.tcp.values() for end in (values.max(), values.min(), values[-1])])
