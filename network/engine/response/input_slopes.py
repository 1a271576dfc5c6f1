"""How a run answers to an input that is constant and not known exactly: the room, a pump's flow, a supply's level."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.balance import heat_into
from network.engine.response.linear_run import LinearRun, Push
from network.engine.response.measured_run import Run
from network.engine.response.output_jacobian import channels_of
from network.engine.response.prediction import Prediction, answer_together
from network.engine.response.run_plan import plan_of
from network.engine.response.switchings import SwitchedCourse, build_switched_course
from network.engine.response.waveform import course_of
from network.engine.solvers.plan import Plan

STEP = 0.05
"""Of an input's 1σ: the difference is exact where the machine is linear, and near enough a slope where it is not."""


def input_slopes(predictions: Sequence[Prediction], spreads: Sequence[Mapping[str, float]]) -> list[Array]:
    """∂(cells' means)/∂u of some constant inputs of every run, (inputs, channels · cells) each: by the heat that these
    bring, or where they act otherwise by a difference of whole runs; spreads: 1σ of every input [SI], by run."""
    steps = [{name: STEP * spread for name, spread in own.items()} for own in spreads]
    if all(
        acts_by_heat(p, name, step) for p, own in zip(predictions, steps, strict=True) for name, step in own.items()
    ):
        pushes = [[_push_of(p.course, name, step) for name, step in own.items()]
                  for p, own in zip(predictions, steps, strict=True)]  # fmt: skip
        return answer_together(predictions, pushes)
    return [np.array([_difference(p, name, step) for name, step in own.items()]).reshape(len(own), -1)
            if own else np.empty((0, len(p.run.present) * p.run.knots.cells))
            for p, own in zip(predictions, steps, strict=True)]  # fmt: skip


def acts_by_heat(prediction: Prediction, name: str, step: float) -> bool:
    """Whether an input does nothing but bring heat: no relay and no sensor feels what it holds, none begins at what it
    makes of a junction without mass, and no channel reads it."""
    network, readouts = prediction.course.problem.plan.network, prediction.course.readouts
    begins = readouts.states and len(network.massless)
    if network.melting or begins or readouts.rows[:, network.bound].any():
        return False
    if network.relays and _is_felt_by_relays(prediction.course, name, step):
        return False
    moved = {**prediction.inputs, name: prediction.inputs[name] + step}
    seen = channels_of(prediction.machine, readouts, prediction.course.readings, moved, prediction.run.channels)
    return np.array_equal(seen, prediction.values)


def _is_felt_by_relays(course: LinearRun, name: str, step: float) -> bool:
    return not isinstance(course, SwitchedCourse) or course.is_guarded_by(name, step)


def _push_of(course: LinearRun, name: str, step: float) -> Push:
    """The further heat by one unit of an input along a run."""
    plan, T = course.problem.plan, course.T_ends
    network, K = plan.network, len(plan.steps)
    u = {**course.inputs, name: course.inputs[name] + step}
    sides = ({**of, name: of[name] + step} for of in (plan.left, plan.right))
    there = T.copy()
    there[:, network.bound] = np.concatenate([plan.evaluate_held(side) for side in sides])
    on = np.zeros((K, 0)) if plan.modes is None else plan.modes
    modes = np.concatenate([on, on])
    heat = (heat_into(network, there, u, modes) - heat_into(network, T, course.inputs, modes)) / step
    heat[:, network.bound] = 0.0
    lumps = np.flatnonzero(heat.any(axis=0))
    return Push(lumps, heat[:K, lumps], heat[K:, lumps])


def _difference(prediction: Prediction, name: str, step: float) -> Array:
    signals = prediction.run.schedule.signals
    schedule = replace(prediction.run.schedule, signals={**signals, name: signals[name].shift(step)})
    run = prediction.run.driven_by(schedule)
    own = prediction.course.problem.plan
    plan = replace(plan_of(own.network, run, prediction.begun), about=own.about)
    return np.asarray((_predict(prediction, run, plan).cells - prediction.cells) / step)


def _predict(beside: Prediction, run: Run, plan: Plan) -> Prediction:
    """The run under other inputs, with the modes of what stays as it is."""
    outputs, near = beside.course.readouts, beside.course
    known = {regime.A.tobytes(): own for regime, own in zip(near.problem.regimes, near.modes, strict=True)}
    solve = build_switched_course if plan.network.relays else course_of
    course = solve(plan, outputs, known=known)
    return Prediction(run, beside.machine, course, run.resampled(course.problem.plan.edges), beside.known)
