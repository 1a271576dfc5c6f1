"""What a candidate would change in the channels, at a strength of engineering size, before anything is refitted.

Where it leaves the parts as they are, the further heat at the temperatures of the run is answered by the network as it
stands, at most beside new nodes of given temperature: one answer a candidate. Where it brings a part, a lag or a relay,
the whole run is computed again.
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from functools import partial

import numpy as np

from network.analysis.calibration.measured_means import Measured
from network.analysis.diagnosis.candidates import Candidate
from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.entry_path import EntryPath, NumberPath
from network.engine.assembly import build
from network.engine.balance import heat_balance
from network.engine.channels import readouts, states_of
from network.engine.network import Network
from network.engine.response.linear_run import LinearRun, Push
from network.engine.response.model import Model, Prediction, channels_of
from network.engine.response.nonlinear_laws import Group, heat_of, spread_of
from network.engine.response.parameters import at_values
from network.machine.machine import Machine
from network.platform.parallel import run_all
from network.platform.refusal import Failed

UNREAD = ("links", "sources", "nodes")
"""Sections of entries that leave alone what is read where."""
AT_ONCE = 64
"""Candidates that are answered together."""
NOTHING = 1e-9
"""W below which a lump gets no further heat."""


Heat = tuple[Push | None, Array]
"""A further heat on one run, and what is read otherwise beside its answer."""


def respond_to_candidates(
    tried: Sequence[tuple[Candidate, Mapping[str, float]]], data: Sequence[Measured], predictions: Sequence[Prediction],
    jobs: int = 1,
) -> list[Array | None]:  # fmt: skip
    """Changes of the cells' means of all runs that candidates bring, each at the numbers beside it (those at which the
    predictions were made, and its own); None where they cannot be computed."""
    portions = [tried[first : first + AT_ONCE] for first in range(0, len(tried), AT_ONCE)]
    told = run_all(partial(_together, data, predictions), portions, jobs)
    return [d for portion in told for d in portion]


def _together(
    data: Sequence[Measured], predictions: Sequence[Prediction], tried: Sequence[tuple[Candidate, Mapping[str, float]]]
) -> list[Array | None]:  # fmt: skip
    """The same of a few, whose heats are answered at once."""
    known = [_respond_directly(c, values, data, predictions) for c, values in tried]
    answers = [_answers([h[r] for h in known if isinstance(h, list)], p) for r, p in enumerate(predictions)]
    heats = iter(np.hstack(answers))
    return [next(heats) if isinstance(h, list) else h for h in known]


def _respond_directly(
    candidate: Candidate, values: Mapping[str, float], data: Sequence[Measured], predictions: Sequence[Prediction]
) -> list[Heat] | Array | None:
    """The further heat of every run, where that is all; the change itself, where it is not."""
    try:
        heats = _heats(candidate, values, predictions)
        if heats is not None:
            return heats
        machine = _at(candidate.machine, values)
        moved = Model(machine, (), [d.run for d in data]).predict(np.empty(0))
        return np.concatenate([m.means(m.values) - p.means(p.values) for m, p in zip(moved, predictions, strict=True)])
    except (Failed, np.linalg.LinAlgError, FloatingPointError):
        return None


def _answers(heats: Sequence[Heat], prediction: Prediction) -> Array:
    """Changes of the cells' means of one run (heats, ·)."""
    out = np.array([seen for _, seen in heats]).reshape(len(heats), len(prediction.cells))
    warm = [i for i, (push, _) in enumerate(heats) if push is not None]
    out[warm] += prediction.respond_to([push for push, _ in heats if push is not None])
    return out


def _at(machine: Machine, values: Mapping[str, float], only: Container[EntryPath] | None = None) -> Machine:
    """The machine at the values that are its own, or those of some entries; a kind that takes the place of another may
    lack numbers of that."""
    only = machine.by_path if only is None else only
    known = {text: NumberPath.parse(text, machine.paths) for text in values}
    own = [text for text, p in known.items() if p is not None and p.entry in only and _has(machine, p)]
    return at_values(machine, {text: values[text] for text in own})


def _has(machine: Machine, number: NumberPath) -> bool:
    return any(f.key == number.key for f in machine.by_path[number.entry].params().values())


def _heats(
    candidate: Candidate, values: Mapping[str, float], predictions: Sequence[Prediction]
) -> list[Heat] | None:  # fmt: skip
    """The heat of the entries that are new or other; None where that is not all there is to it."""
    if any(name in candidate.base.nodes for name in candidate.patch.get("nodes", ())):
        return None
    paths = [path for path, _ in candidate.patch.entries()]
    changed = [str(path) for path in paths]
    machine = _at(candidate.machine, values, paths)
    now = build(machine, only=changed)
    states = len(states_of(now))
    if now.relays or not all(_is_alike(now, p) and states == p.course.readouts.states for p in predictions):
        return None
    reads = any(path.section not in UNREAD for path in paths)
    seen = machine if reads else None
    return [(_further(now, changed, p), _change_readings(seen, now, p)) for p in predictions]


def _is_alike(network: Network, prediction: Prediction) -> bool:
    """Whether the lumps are those of the run, but for nodes whose temperature is given."""
    own = prediction.course.problem.plan.network
    lumps = all(network.parts.get(name) == part for name, part in own.parts.items())
    held = all(network.held.get(i) == one for i, one in own.held.items())
    return lumps and held and network.size - own.size == len(network.held) - len(own.held)


def _further(now: Network, changed: Sequence[str], prediction: Prediction) -> Push | None:
    """The heat of the changed entries that flows now and did not before; None where that is none."""
    course = prediction.course
    before, K = course.problem.plan.network, len(course.x0)
    T = np.hstack([course.T_ends, _stack_new_held(now, before, course)])
    into = heat_balance(now, T, course.inputs, np.zeros((2 * K, 0))).into[:, : before.size]
    heat = into - _heat_before(course, changed)
    lumps = np.flatnonzero(np.abs(heat).max(axis=0) > NOTHING)
    lumps = lumps[np.isin(lumps, np.concatenate([before.free, before.massless]))]
    return Push(lumps, heat[:K, lumps], heat[K:, lumps]) if len(lumps) else None


def _stack_new_held(now: Network, own: Network, course: LinearRun) -> Array:
    """Temperatures of held nodes that were not there before (2 K, ·)."""
    columns = [held.at(course.inputs) for i, held in now.held.items() if i >= own.size]
    return np.hstack([np.empty((2 * len(course.x0), 0)), *columns])


def _heat_before(course: LinearRun, entries: Sequence[str]) -> Array:
    """Heat into the lumps (2 K, N) that some entries bring along a run, as far as they are there."""
    network = course.problem.plan.network
    total = np.zeros_like(course.T_ends)
    index = [network.mechanisms.index(e) for e in entries if e in network.mechanisms]
    groups: tuple[Group, ...] = (*network.flows, *network.heats)
    for g, group in enumerate(groups):
        members = np.flatnonzero(np.isin(group.entry, index))
        if len(members):
            if (g, "") not in course.derived:
                course.derived[g, ""] = heat_of(group, course.T_ends, course.inputs)
            total = total + course.derived[g, ""][:, members] @ spread_of(group)[members]
    return total


def _change_readings(machine: Machine | None, network: Network, prediction: Prediction) -> Array:
    """Changes of the cells' means because the same temperatures are read otherwise; none without a machine."""
    if machine is None:
        return np.zeros_like(prediction.cells)
    outputs, course = readouts(network, parts=False), prediction.course
    rows = np.vstack(
        [outputs.rows[:, : course.T_ends.shape[1]] @ course.T_ends.T, course.readings[len(course.readouts.rows) :]]
    )
    seen = channels_of(machine, outputs, rows, prediction.inputs, prediction.run.channels)
    return prediction.means(seen - prediction.values)
