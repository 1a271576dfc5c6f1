"""Which recordings a calibration takes, and what it says against them before anything is fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from network.analysis.calibration.measured_means import Measured, weigh_recording
from network.analysis.comparison.compare import check_fit
from network.engine.assembly import build
from network.engine.response.parameters import Parameter, at_prior_centres
from network.engine.time_constants import time_constants
from network.machine.machine import Machine
from network.platform.quantities.text_table import span
from network.platform.refusal import Complaints, Refused, Spot, refuse
from network.recordings.counted_readings import drop_uncounted
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.runs import tell_excluded
from network.recordings.twins import check_once, is_same

MOVES = 4.0
"""Of the noise of a mean: what a channel has to move by to tell anything."""


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
    check_once(recordings, complaints)
    for one in holdout:
        twin = next((other for other in recordings if is_same(one, other)), None)
        if twin is not None:
            what = "the same file" if _path(one) == _path(twin) else f"the same readings as {twin.file}"
            wrong = f"is held out and calibrated on ({what}), so it would show nothing"
            complaints.refuse(Spot(one.file), wrong, "hold out a recording that is not among the others")
    complaints.raise_if_any()


def _path(recording: Recording) -> Path:
    return Path(recording.source or recording.file).resolve()


def admit(
    machine: Machine, parameters: Sequence[Parameter], recordings: Sequence[Recording], start: Start | None
) -> Admitted:
    """Raises Refused with all that makes the recordings useless to this machine."""
    complaints, warnings, data = Complaints(), list[str](), list[Measured]()
    known = at_prior_centres(machine, parameters)
    for recording in recordings:
        try:
            check_fit(known, recording)
            _check_alive(machine, recording)
            one = weigh_recording(known, drop_uncounted(machine, recording), start)
        except Refused as refused:
            complaints.absorb(refused)
            continue
        warnings += tell_excluded([recording])
        data.append(one)
    complaints.raise_if_any()
    _check_length(known, data, complaints)
    _check_movement(data, complaints)
    complaints.raise_if_any()
    return Admitted(tuple(data), (*warnings, *_counts(data, parameters)))


def _check_alive(machine: Machine, recording: Recording) -> None:
    """Raises Refused where hygiene has left nothing of any channel."""
    names = [name for name in machine.sensors if name in recording.columns]
    if all(not np.isfinite(recording.columns[name].values).any() for name in names):
        wrong = "every channel reads the same at all times, or nothing"
        raise refuse(Spot(recording.file), wrong, "check the sensors' wiring, and record again")


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
