"""Which recordings a calibration takes, and what it says against them before anything is fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from network.analysis.calibration.measured_means import Measured, weigh_recording
from network.analysis.comparison.compare import check_fit
from network.catalogue.declaration.declare import Array
from network.engine.assembly import build
from network.engine.response.parameters import Parameter, at_values, centres, values_at
from network.engine.time_constants import time_constants
from network.machine.machine import Machine
from network.platform.quantities.text_table import span
from network.platform.refusal import Complaints, Refused, Spot
from network.recordings.columns import Column
from network.recordings.counted_readings import drop_uncounted
from network.recordings.inputs import Start
from network.recordings.recording import Recording

MOVES = 4.0
"""Of the noise of a mean: what a channel has to move by to tell anything."""
STUCK, STUCK_SHARE, REPEATS = 60, 0.1, 0.5
"""Equal readings in a row (and share of all) that mean a hanging sensor, where fewer than REPEATS repeat elsewhere."""


@dataclass(frozen=True)
class Admitted:
    """What a fit works on: recordings laid out, and warnings about them."""

    data: tuple[Measured, ...]
    warnings: tuple[str, ...]


def check_parameters(machine: Machine, parameters: Sequence[Parameter]) -> None:
    """Raises Refused where there is nothing to calibrate."""
    if not parameters:
        complaints = Complaints()
        right = "write ± behind those that are uncertain, as in `28 W/K ± 30 %`, or `unknown`"
        complaints.refuse(
            Spot(machine.file), "every number of the machine is fixed, so there is nothing to calibrate", right
        )
        complaints.raise_if_any()


def check_apart(recordings: Sequence[Recording], holdout: Sequence[Recording]) -> None:
    """Raises Refused for recordings given twice, and for held-out ones that are also calibrated on."""
    complaints = Complaints()
    for i, one in enumerate(recordings):
        if any(_is_same(one, other) for other in recordings[:i]):
            complaints.refuse(Spot(one.file), "is given twice, and would count twice", "give it once")
    for one in holdout:
        twin = next((other for other in recordings if _is_same(one, other)), None)
        if twin is not None:
            what = "the same file" if _path(one) == _path(twin) else f"the same readings as {twin.file}"
            wrong = f"is held out and calibrated on ({what}), so it would show nothing"
            complaints.refuse(Spot(one.file), wrong, "hold out a recording that is not among the others")
    complaints.raise_if_any()


def _path(recording: Recording) -> Path:
    return Path(recording.source or recording.file).resolve()


def _is_same(a: Recording, b: Recording) -> bool:
    """One file, or all the same columns; a mapping that cuts another piece out of one file is another recording."""
    if len(a.t) != len(b.t) or not np.array_equal(a.t, b.t) or a.columns.keys() != b.columns.keys():
        return False
    return all(np.array_equal(c.values, b.columns[n].values, equal_nan=True) for n, c in a.columns.items())


def admit(
    machine: Machine, parameters: Sequence[Parameter], recordings: Sequence[Recording], start: Start | None
) -> Admitted:
    """Raises Refused with all that makes the recordings useless to this machine."""
    complaints, warnings, data = Complaints(), list[str](), list[Measured]()
    known = at_values(machine, values_at(parameters, centres(parameters)))
    for recording in recordings:
        try:
            check_fit(known, recording)
            mended, doubts = without_stuck(machine, drop_uncounted(machine, recording))
            one = weigh_recording(known, mended, start)
        except Refused as refused:
            complaints.absorb(refused)
            continue
        warnings += doubts
        data.append(one)
    complaints.raise_if_any()
    _check_length(known, data, complaints)
    _check_movement(data, complaints)
    complaints.raise_if_any()
    return Admitted(tuple(data), (*warnings, *_counts(data, parameters)))


def without_stuck(machine: Machine, recording: Recording) -> tuple[Recording, list[str]]:
    """The recording without channels that never change, and without the stretches in which one hangs."""
    doubts, columns = [], dict(recording.columns)
    names = [n for n in machine.sensors if n in recording.columns]
    for name in names:
        values = recording.columns[name].values
        hangs = hanging(values)
        finite = np.isfinite(values)
        if not finite.any() or not hangs.any():
            continue
        unit_text = recording.columns[name].unit
        columns[name] = Column(name, unit_text, np.where(hangs, np.nan, values))
        if hangs[finite].all():
            doubts.append(f"{recording.file}: {name} reads the same at all times; it is left out")
        else:
            first, last = (float(recording.t[k]) for k in np.flatnonzero(hangs)[[0, -1]])
            when = f"from {span(first)} to {span(last)}"
            doubts.append(f"{recording.file}: {name} is stuck {when}; that stretch is left out")
    if all(not np.isfinite(columns[n].values).any() for n in names):
        complaints = Complaints()
        wrong = "every channel reads the same at all times, or nothing"
        complaints.refuse(Spot(recording.file), wrong, "check the sensors' wiring, and record again")
        complaints.raise_if_any()
    return replace(recording, columns=columns), doubts


def hanging(values: Array) -> Array:
    """Where a channel stands still as no working sensor does: always, or long in a row while it else rarely repeats."""
    finite = np.flatnonzero(np.isfinite(values))
    out = np.zeros(len(values), bool)
    if len(finite) < 2:
        return out
    same = np.diff(values[finite]) == 0
    if same.all():
        out[finite] = True
        return out
    edges = np.flatnonzero(np.diff(np.concatenate([[0], same.astype(int), [0]])))
    for first, last in edges.reshape(-1, 2):
        count = last - first + 1
        elsewhere = np.concatenate([same[:first], same[last:]])
        if count >= max(STUCK, STUCK_SHARE * len(finite)) and len(elsewhere) and elsewhere.mean() < REPEATS:
            out[finite[first + 1 : last + 1]] = True
    return out


def _check_length(machine: Machine, data: Sequence[Measured], complaints: Complaints) -> None:
    taus = time_constants(build(machine))
    fastest = float(taus[0]) if len(taus) else np.inf
    for one in data:
        lasts = float(one.recording.t[-1] - one.recording.t[0])
        if np.isfinite(fastest) and lasts < fastest:
            wrong = f"lasts {span(lasts)}, shorter than the machine's fastest time constant of {span(fastest)}"
            complaints.refuse(Spot(one.recording.file), wrong, f"record at least {span(3 * fastest)}, better hours")


def _check_movement(data: Sequence[Measured], complaints: Complaints) -> None:
    """Refuses where no channel of any recording moves beyond its noise."""
    if not any(moves(one, name) for one in data for name in one.run.channels):
        wrong = "nothing moves beyond its noise, so no number can be found"
        right = "record a change: a warm-up, a cool-down, a step of speed"
        complaints.refuse(Spot(", ".join(one.recording.file for one in data)), wrong, right)


def moves(data: Measured, name: str) -> bool:
    """Whether the means of a channel differ by more than their noise."""
    i, cells = data.run.channels.index(name), data.run.knots.cells
    own = slice(i * cells, (i + 1) * cells)
    known = data.known[own]
    means, sigma = data.means[own][known], np.sqrt(data.variance[own][known])
    if len(means) < 2:
        return False
    middle = float(np.median(means))
    return bool((np.abs(means - middle) > MOVES * sigma).mean() > 0.02) and bool(
        np.ptp(means) > 2 * MOVES * sigma.min()
    )


def _counts(data: Sequence[Measured], parameters: Sequence[Parameter]) -> list[str]:
    """What is told about readings set aside, and about too few of them."""
    sentences = []
    for one in data:
        apart = {n: int(c.apart.sum()) for n, c in one.channels.items() if c.apart.any()}
        if apart:
            shown = ", ".join(f"{count} of {n}" for n, count in apart.items())
            what = "readings far from their neighbours are set aside (the residuals shown still count them)"
            sentences.append(f"{one.recording.file}: {what}: {shown}")
    readings = sum(int(one.known.sum()) for one in data)
    if readings <= len(parameters):
        sentences.append(
            f"{len(parameters)} numbers are to be found from {readings} independent readings: their priors decide"
        )
    return sentences
