"""A recording made ready for fits, and the cells of it that a run's intervals are averaged to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from network.catalogue.declaration.declare import Array, Mask
from network.engine.response.cells import Averages, averages
from network.engine.response.knots import Knots
from network.recordings.inputs import Schedule


@dataclass(frozen=True, eq=False)
class Run:
    """A recording made ready for fits. schedule: inputs on the knots; T0: temperatures of all lumps at the start, by
    part; present: channel → which samples are used."""

    name: str
    schedule: Schedule
    knots: Knots
    start: Mapping[str, float]
    present: Mapping[str, Mask]

    @property
    def channels(self) -> tuple[str, ...]:
        return tuple(self.present)


@dataclass(frozen=True, eq=False)
class Resampled:
    """The cells of a run over the intervals between some edges, worked out when they are asked for."""

    run: Run
    edges: Array

    @cached_property
    def averages(self) -> Averages:
        return averages(self.run.knots, self.edges, list(self.run.present.values()))
