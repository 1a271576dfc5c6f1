"""How far a machine file is from recordings, by simulation alone: temperatures at each start estimated from the run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from network import Failed, Machine, Recording, Refused
from network.analysis.calibration.estimated_constants import compare_estimating
from network.analysis.comparison.compare import RecordingResidual
from network.catalogue.declaration.declare import Array, Mask
from network.engine.response.parameters import at_values, centres, free_parameters, values_at
from network.platform.quantities.units import difference, unit
from network.recordings.hygiene.data_quality import look_at


@dataclass(frozen=True)
class Size:
    """Rms of what is left of a channel over runs: in its unit (K or µm), and in units of declared noise."""

    rms: float
    unit: str
    noise: float
    n: int


@dataclass(frozen=True)
class Figures:
    """All channels of a set of runs; noise: pooled, in units of declared noise."""

    noise: float
    channels: Mapping[str, Size]


def figures(machine: Path, recordings: Sequence[Path], counts: Mapping[str, str]) -> Figures | None:
    """None where the machine cannot be simulated along them. counts: channel → input that must not be zero."""
    try:
        runs = [Recording.load(path) for path in recordings]
        compared = compare_estimating(at_its_centres(Machine.load(machine)), runs)
    except (Failed, Refused):
        return None
    return pooled([left for run in compared.recordings for left in lefts(run, counts)])


def at_its_centres(machine: Machine) -> Machine:
    """With what is unknown in the middle of what it may be."""
    parameters = free_parameters(machine)
    return at_values(machine, values_at(parameters, centres(parameters)))


@dataclass(frozen=True)
class Left:
    """What is left of a channel along one run. values: in its unit; sigma: declared noise in that unit."""

    name: str
    unit: str
    values: Array
    sigma: float


def lefts(run: RecordingResidual, counts: Mapping[str, str]) -> Iterator[Left]:
    """Without readings that lie far from their neighbours (false trips of a probe), and without those of standstill."""
    for channel in run.channels.values():
        kept = counted(run.recording, channel.name, counts)
        kept &= look_at(channel.name, channel.measured, channel.sigma).used
        if kept.any():
            yield left(channel.name, channel.unit, channel.sigma, channel.residual[kept])


def left(name: str, shown: str, sigma: float, values: Array) -> Left:
    """From SI, as the unit of the sensor shows it."""
    of = unit(shown)
    text = "K" if of.is_temperature else "µm" if shown == "um" else shown
    return Left(name, text, values / difference(of).scale, sigma / difference(of).scale)


def counted(recording: Recording, channel: str, counts: Mapping[str, str]) -> Mask:
    """Samples at which a channel's readings count."""
    driver = recording.columns.get(counts.get(channel, ""))
    return driver.values != 0 if driver else np.ones(len(recording.t), bool)


def pooled(some: Sequence[Left]) -> Figures:
    names = dict.fromkeys(one.name for one in some)
    sizes = {name: size([one for one in some if one.name == name]) for name in names}
    return Figures(rms(np.concatenate([one.values / one.sigma for one in some])), sizes)


def size(some: Sequence[Left]) -> Size:
    values = np.concatenate([one.values for one in some])
    return Size(rms(values), some[0].unit, rms(values) / some[0].sigma, len(values))


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
