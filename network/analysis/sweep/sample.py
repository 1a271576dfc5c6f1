"""Sweeps over numbers drawn at random: how sure the movement of the tool centre point is, and what makes it unsure."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from network.analysis.sweep.batched_runs import run_sample
from network.analysis.sweep.first_order import FEWEST, Scatter, first_order_shares
from network.analysis.sweep.journal import Journal
from network.analysis.sweep.level_runs import Job
from network.analysis.sweep.sample_runs import SampleJob
from network.analysis.sweep.sampling import MOST_SAMPLES, Drawn, choose_drawn, latin_hypercube
from network.catalogue.declaration.declare import Array, Indices
from network.engine.simulation import schedule_for
from network.engine.trajectory import axis_unit
from network.machine.machine import Machine
from network.platform.parallel import Told, run_all
from network.platform.printing import summarise, tell
from network.platform.quantities.unit_values import in_difference_unit
from network.platform.refusal import Spot, refuse
from network.recordings.call_arguments import expect, expect_run
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario

PARCEL, ROUND = 250, 16
"""Runs that go to a process at a time, and such parcels after which a journal is written."""


@dataclass(frozen=True, eq=False)
class Sample:
    """numbers: (runs, drawn) [SI]; values: (runs, columns) [SI]; columns: (axis, max, min or final)."""

    machine: Machine
    source: str
    drawn: tuple[Drawn, ...]
    columns: tuple[tuple[str, str], ...]
    numbers: Array
    values: Array
    seed: int

    @cached_property
    def shown(self) -> dict[tuple[str, str], Array]:
        """Every value over the runs, in µm or µrad."""
        return {(a, w): in_difference_unit(self.values[:, k], axis_unit(a)) for k, (a, w) in enumerate(self.columns)}

    @cached_property
    def scatter(self) -> dict[tuple[str, str], Scatter]:
        return {key: Scatter.of(values) for key, values in self.shown.items()}

    @cached_property
    def shares(self) -> dict[tuple[str, str], dict[str, float]]:
        """Of every value: number → share of its variance; empty below FEWEST runs."""
        if len(self.numbers) < FEWEST:
            return {}
        paths = [d.path for d in self.drawn]
        return {key: dict(zip(paths, first_order_shares(self.numbers, values).tolist(), strict=True))
                for key, values in self.shown.items()}  # fmt: skip

    def summary(self) -> dict[str, Any]:
        """What sweep.json holds and --json prints."""
        return summarise(self)

    def __str__(self) -> str:
        return tell(self)


def sample(
    machine: Machine, source: Scenario | Recording, count: int, *, vary: Sequence[str] = (), seed: int = 0,
    start: Start | None = None, method: str = "auto", jobs: int = 1, cluster: str | None = None,
    resume: str | Path | None = None, progress: Told | None = None,
) -> Sample:  # fmt: skip
    """Runs a machine many times, with its numbers drawn from their ± or from ranges.

    count: runs; vary: 'path=lo..hi unit', several; without, all numbers with ±; seed: of the draw; resume: a file that
    keeps what is done, and from which a stopped sweep goes on; the others as in `sweep`. Raises Refused, and Failed
    where a run breaks down.
    """
    expect_run(machine, source, start)
    expect("count", count, int, np.integer)
    if not 2 <= count <= MOST_SAMPLES:
        raise refuse(Spot("--sample"), f"asks for {count} runs", f"give 2 to {MOST_SAMPLES}")
    if not machine.expansions:
        right = "add entries below `tcp:`, or use lptn simulate"
        raise refuse(Spot(machine.file), "the machine moves no tool centre point, which a sweep looks at", right)
    schedule_for(machine, source, start)
    drawn = choose_drawn(machine, [vary] if isinstance(vary, str) else vary)
    quantiles = latin_hypercube(count, len(drawn), seed)
    numbers = np.stack([d.at(quantiles[:, i]) for i, d in enumerate(drawn)], axis=1)
    shared = SampleJob(Job(machine, source, start, method), drawn)
    values = _run(shared, numbers, _how(jobs, cluster), resume, progress)
    return Sample(machine, source.name, drawn, tuple(shared.columns()), numbers, values, seed)


Over = Callable[[Callable[[Array], Array], Sequence[Array], Told | None], list[Array]]


def _how(jobs: int, cluster: str | None) -> Over:
    return lambda work, items, tell: run_all(work, items, jobs, tell, cluster)


def _run(shared: SampleJob, numbers: Array, over: Over, resume: str | Path | None, progress: Told | None) -> Array:
    """All runs, in parcels; with a journal, in rounds after each of which it is written."""
    work, width = partial(run_sample, shared), len(shared.columns())
    if resume is None:
        parcels = np.array_split(numbers, max(1, len(numbers) // PARCEL))
        return np.concatenate(over(work, parcels, progress))
    journal = Journal.open(Path(resume), shared.job, [d.path for d in shared.drawn], numbers, width)

    def run(rows: Indices) -> Array:
        parcels = np.array_split(rows, max(1, len(rows) // PARCEL))
        return np.concatenate(over(work, [numbers[some] for some in parcels], None))

    return journal.run_missing(run, ROUND * PARCEL, progress)
