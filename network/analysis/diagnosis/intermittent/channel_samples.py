"""A channel of a run at its samples: what is read, what a fit says, and what an effect of the sensor would add."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from network.analysis.calibration.expansion_point import move_inputs
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.catalogue.declaration.declare import Array
from network.catalogue.sensors.base import SensorEffect
from network.engine.response.model import Prediction
from network.engine.response.parameters import at_values
from network.machine.machine import Machine
from network.recordings.recording import Recording


def truth_at_samples(prediction: Prediction, recording: Recording, channel: str) -> Array:
    """What a fit says of a channel, at the samples."""
    values = prediction.values[prediction.run.channels.index(channel)]
    edges, K = prediction.course.problem.plan.edges, values.shape[-1] // 2
    return np.asarray(np.interp(recording.t, edges, np.append(values[:K], values[-1])))


def at_share(c: Candidate, share: float) -> Machine:
    """The machine with a candidate at a share of full strength."""
    return at_values(c.machine, {c.own[0].path: share})


def effect_of(machine: Machine, c: Candidate) -> SensorEffect:
    """The effect that a candidate puts on its channel."""
    return next(e for e in machine.sensors[c.channels[0]].effects if isinstance(e, c.kind))


def change_of(full: SensorEffect, recording: Recording, truth: Array) -> Array:
    """What an effect adds to a reading."""
    return np.asarray(full.reading(truth, np.zeros_like(truth), list_inputs(full, recording)) - truth)


def list_inputs(effect: SensorEffect, recording: Recording) -> Mapping[str, Array]:
    """What an effect reads beside its channel, at the samples."""
    return {"time": recording.t, **{name: recording.signal(name).at(recording.t) for name in effect.needs()}}


def list_as_fitted(recordings: Iterable[Recording], h: Hypothesis) -> tuple[Recording, ...]:
    """Recordings of a case with the constants that drive them as a fit finds them: a room may be stated wrongly."""
    return tuple(_state_anew(r, found) for r, found in zip(recordings, move_inputs(h.fit), strict=True))


def _state_anew(r: Recording, found: Mapping[str, float]) -> Recording:
    moved = {name: r.constants[name].shift(x - r.constants[name].value) for name, x in found.items()}
    return replace(r, constants={**r.constants, **moved})


def excess_of(h: Hypothesis, channels: Iterable[str], runs: Iterable[int]) -> float:
    """χ² − 1 of some channels in some runs; 0 where they have none of them."""
    fit, names, left = h.linearised, [*channels], [np.empty(0)]
    for i in runs:
        data, (rows, _) = fit.problem.data[i], fit.rows.slopes.blocks[i]
        of = np.repeat(data.run.channels, data.run.knots.cells)[data.known]
        left.append(fit.left[rows][np.isin(of, names)])
    own = np.concatenate(left)
    return float(np.mean(own**2)) - 1 if len(own) else 0.0
