"""Which recordings a diagnosis takes: those that a calibration would take, and held-out ones that fit the machine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from network.analysis.calibration.measured_means import Measured
from network.analysis.calibration.recording_admission import admit, check_apart
from network.analysis.comparison.common_start import doubt_starts, share_starts
from network.analysis.comparison.compare import check_fit
from network.engine.response.parameters import at_prior_centres, free_parameters
from network.machine.machine import Machine
from network.platform.refusal import Complaints, Refused
from network.recordings.channel_match import overheard
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.runs import runs_of, tell_excluded


@dataclass(frozen=True)
class Intake:
    """Recordings without the stretches in which a channel hangs, those held out, the former laid out for fits of the
    machine, and warnings about them."""

    recordings: tuple[Recording, ...]
    holdout: tuple[Recording, ...]
    data: tuple[Measured, ...]
    warnings: tuple[str, ...]


def admit_runs(
    machine: Machine, recordings: Sequence[Recording], holdout: Sequence[Recording], start: Start | None
) -> Intake:
    """Raises Refused with all that makes the recordings useless to this machine, before anything is fitted."""
    check_apart(recordings, holdout)
    runs, held_out = (runs_of(machine, some, keeps_departures=True) for some in (recordings, holdout))
    check_apart(runs, held_out)
    parameters = free_parameters(machine)
    _check_held_out(at_prior_centres(machine, parameters), held_out)
    train, held = share_starts(machine, runs, held_out, start)
    let_in = admit(machine, parameters, train, start)
    doubts = doubt_starts(machine, (*train, *held), start)
    warnings = (*overheard(machine, recordings, holdout), *doubts, *let_in.warnings, *tell_excluded(held))
    return Intake(tuple(d.recording for d in let_in.data), tuple(held), let_in.data, warnings)


def _check_held_out(machine: Machine, holdout: Sequence[Recording]) -> None:
    complaints = Complaints()
    for recording in holdout:
        try:
            check_fit(machine, recording)
        except Refused as refused:
            complaints.absorb(refused)
    complaints.raise_if_any()
