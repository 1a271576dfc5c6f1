"""How a run answers to an input that is constant and not known exactly: the room, a pump's flow, a supply's level."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.response.measured_run import Run
from network.engine.response.prediction import Prediction
from network.engine.response.run_plan import plan_of
from network.engine.response.switchings import build_switched_course
from network.engine.response.waveform import course_of
from network.engine.solvers.plan import Plan

STEP = 0.05
"""Of an input's 1σ: the difference is exact where the machine is linear, and near enough a slope where it is not."""


def input_slopes(predictions: Sequence[Prediction], spreads: Sequence[Mapping[str, float]]) -> list[Array]:
    """∂(cells' means)/∂u of some constant inputs of every run, (inputs, channels · cells) each, by a difference of
    whole runs; spreads: 1σ of every input [SI], by run."""
    return [np.array([_difference(p, name, STEP * spread) for name, spread in own.items()]).reshape(len(own), -1)
            if own else np.empty((0, len(p.run.present) * p.run.knots.cells))
            for p, own in zip(predictions, spreads, strict=True)]  # fmt: skip


def _difference(prediction: Prediction, name: str, step: float) -> Array:
    signals = prediction.run.schedule.signals
    schedule = replace(prediction.run.schedule, signals={**signals, name: signals[name].shift(step)})
    run = prediction.run.driven_by(schedule)
    plan = plan_of(prediction.course.problem.plan.network, run, prediction.begun)
    return np.asarray((_predict(prediction, run, plan).cells - prediction.cells) / step)


def _predict(beside: Prediction, run: Run, plan: Plan) -> Prediction:
    """The run under other inputs, with the modes of what stays as it is."""
    outputs, near = beside.course.readouts, beside.course
    known = {regime.A.tobytes(): own for regime, own in zip(near.problem.regimes, near.modes, strict=True)}
    solve = build_switched_course if plan.network.relays else course_of
    course = solve(plan, outputs, known=known)
    return Prediction(run, beside.machine, course, run.resampled(course.problem.plan.edges), beside.known)
