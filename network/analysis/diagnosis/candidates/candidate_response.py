"""What a candidate would change in the channels, at a strength of engineering size, before anything is refitted.

Where it leaves the parts as they are, the further heat at the temperatures of the run is answered by the network as it
stands, at most beside new nodes of given temperature: one answer a candidate. Where it brings a part, a lag or a relay,
the whole run is computed again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from network.analysis.calibration.measured_means import Measured
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.catalogue.declaration.declare import Array, Indices
from network.catalogue.declaration.entry_path import EntryPath, NumberPath
from network.engine.assembly import build
from network.engine.balance import heat_into
from network.engine.channels import Readouts, readouts, states_of
from network.engine.network import Network
from network.engine.response.heat_sensitivity import Slots
from network.engine.response.joint_means import JointMeans
from network.engine.response.linear_run import LinearRun, Push
from network.engine.response.model import Model, Prediction, channels_of
from network.engine.response.nonlinear_laws import Group, heat_of, spread_of
from network.engine.response.output_jacobian import Slopes
from network.engine.response.parameters import at_values
from network.engine.response.prediction import joint_of
from network.engine.response.seen_differences import sees
from network.machine.machine import Machine
from network.platform.parallel import run_all
from network.platform.refusal import Failed

UNREAD = ("links", "sources", "nodes")
"""Sections of entries that leave alone what is read where."""
AT_ONCE = 64
"""Candidates that are answered together."""
INSTANTS = (np.arange(8) + 0.5) / 8
"""Shares of an interval at which heat by the clock is looked at: its edges count to an eighth of a sample."""
NOTHING = 1e-9
"""W below which a lump gets no further heat."""


@dataclass(frozen=True, eq=False)
class _Runs:
    """The runs of a fit. joint: all of them as one, where they were found so; courses: of that, or of each."""

    data: Sequence[Measured]
    predictions: Sequence[Prediction]
    joint: JointMeans | None
    slopes: Slopes | None
    courses: Sequence[LinearRun]

    @classmethod
    def of(cls, data: Sequence[Measured], predictions: Sequence[Prediction]) -> _Runs:
        joint, slopes = joint_of(predictions)
        return cls(data, predictions, joint, slopes, [joint.course] if joint else [p.course for p in predictions])

    def answer(self, heats: Sequence[_Heat]) -> Array:
        """Changes of the cells' means of all runs, one after the other (heats, ·)."""
        out = np.array([h.seen for h in heats]).reshape(len(heats), sum(len(p.cells) for p in self.predictions))
        ends = np.cumsum([0, *(len(p.cells) for p in self.predictions)])
        if self.joint is not None and self.slopes is not None:
            warm = [i for i, h in enumerate(heats) if h.pushes[0] is not None]
            out[warm] += np.hstack(self.joint.respond_to([p for h in heats for p in h.pushes if p], self.slopes))
            return out
        for r, prediction in enumerate(self.predictions):
            warm = [i for i, h in enumerate(heats) if h.pushes[r] is not None]
            out[warm, ends[r] : ends[r + 1]] += prediction.respond_to([p for h in heats if (p := h.pushes[r])])
        return out


@dataclass(frozen=True, eq=False)
class _Heat:
    """A further heat on every course, and what is read otherwise beside its answer (cells of all runs)."""

    pushes: Sequence[Push | None]
    seen: Array


@dataclass(frozen=True, eq=False)
class _Entries:
    """The entries that a candidate changes as a network of their own, at some of its numbers; machine: with these;
    read: those of them by which it reads otherwise; slots: where its numbers stand, if they can be exchanged."""

    changed: tuple[str, ...]
    network: Network
    machine: Machine
    read: tuple[EntryPath, ...]
    slots: Slots | None

    @classmethod
    def of(cls, c: Candidate, values: Mapping[str, float]) -> _Entries:
        paths = [path for path, _ in c.patch.entries()]
        machine, changed = _at(c.machine, values, paths), tuple(str(path) for path in paths)
        network = build(machine, only=changed)
        slots, read = Slots(network, c.own), tuple(path for path in paths if path.section not in UNREAD)
        return cls(changed, network, machine, read, slots if not read and slots.suffice else None)


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
    runs, known = _Runs.of(data, predictions), dict[int, _Entries]()
    found = [_respond_directly(c, values, runs, known) for c, values in tried]
    heats = iter(runs.answer([h for h in found if isinstance(h, _Heat)]))
    return [next(heats) if isinstance(h, _Heat) else h for h in found]


def _respond_directly(
    candidate: Candidate, values: Mapping[str, float], runs: _Runs, known: dict[int, _Entries]
) -> _Heat | Array | None:
    """The further heat, where that is all; the change itself, where it is not. known: entries of candidates whose
    numbers can be exchanged."""
    try:
        heat = _find_heat(candidate, values, runs, known)
        if heat is not None:
            return heat
        machine = _at(candidate.machine, values)
        moved = Model(machine, (), [d.run for d in runs.data]).predict(np.empty(0))
        pairs = zip(moved, runs.predictions, strict=True)
        return np.concatenate([m.means(m.values) - p.means(p.values) for m, p in pairs])
    except (Failed, np.linalg.LinAlgError, FloatingPointError):
        return None


def _at(machine: Machine, values: Mapping[str, float], only: Sequence[EntryPath] | None = None) -> Machine:
    """The machine at the values that are its own, or those of some entries; a kind that takes the place of another may
    lack numbers of that."""
    paths = machine.paths if only is None else {str(path): path for path in only}
    known = {text: NumberPath.parse(text, paths) for text in values}
    own = [text for text, p in known.items() if p is not None and p.entry in machine.by_path and _has(machine, p)]
    return at_values(machine, {text: values[text] for text in own})


def _has(machine: Machine, number: NumberPath) -> bool:
    return any(f.key == number.key for f in machine.by_path[number.entry].params().values())


def _find_heat(
    candidate: Candidate, values: Mapping[str, float], runs: _Runs, known: dict[int, _Entries]
) -> _Heat | None:
    """The heat of the entries that are new or other; None where that is not all there is to it."""
    if any(name in candidate.base.nodes for name in candidate.patch.get("nodes", ())):
        return None
    entries = known.get(id(candidate))
    if entries is not None and entries.slots is not None:
        now = entries.slots.at({p.path: values[p.path] for p in candidate.own})
    else:
        entries = known[id(candidate)] = _Entries.of(candidate, values)
        now = entries.network
    states = len(states_of(now))
    if now.relays or not all(_is_alike(now, c) and states == c.readouts.states for c in runs.courses):
        return None
    outputs = readouts(now, parts=False) if entries.read else None
    seen = np.concatenate([_change_readings(entries, outputs, p) for p in runs.predictions])
    instants = INSTANTS.tolist() if candidate.is_timed else []
    return _Heat([_further(now, entries.changed, c, instants) for c in runs.courses], seen)


def _is_alike(network: Network, course: LinearRun) -> bool:
    """Whether the lumps are those of the run, but for nodes whose temperature is given: what these have in the run is
    in its temperatures."""
    own = course.problem.plan.network
    lumps = all(network.parts.get(name) == part for name, part in own.parts.items())
    held = network.held.keys() >= own.held.keys()
    return lumps and held and network.size - own.size == len(network.held) - len(own.held)


def _further(now: Network, changed: Sequence[str], course: LinearRun, instants: Sequence[float]) -> Push | None:
    """The heat of the changed entries that flows now and did not before; None where that is none. instants: within
    each interval, for heat that goes on and off between its ends and counts by its mean; else it goes straight."""
    K, before = len(course.x0), _list_standing(course, changed)
    lumps = _list_reached(now, before, course)
    told = _heat_at(now, course, lumps, instants) if instants else _heat_at_ends(now, course, lumps)
    heat = told - sum((each @ spread[:, lumps] for each, spread in before), np.zeros(len(lumps)))
    shows = np.abs(heat).max(axis=0) > NOTHING
    lumps, heat = lumps[shows], heat[:, shows]
    return Push(lumps, heat[:K], heat[K:]) if len(lumps) else None


def _list_reached(now: Network, before: Sequence[tuple[Array, Array]], course: LinearRun) -> Indices:
    """The lumps of a run that entries heat, as they are now or as they stand there."""
    own = course.problem.plan.network
    groups: tuple[Group, ...] = (*now.flows, *now.heats)
    spreads = [*map(spread_of, groups), *(spread for _, spread in before)]
    reached = [spread[:, : own.size].any(axis=0) for spread in spreads]
    return np.flatnonzero(np.any([np.zeros(own.size, bool), *reached], axis=0) & ~np.isinf(own.capacity))


def _heat_at_ends(now: Network, course: LinearRun, lumps: Indices) -> Array:
    """Heat into some lumps of another network at the temperatures of a run, at both ends of its intervals (2 K, ·)."""
    T, inputs = course.T_ends, course.inputs
    held = [at.at(inputs) for i, at in now.held.items() if i >= T.shape[1]]
    return heat_into(now, np.hstack([T, *held]) if held else T, inputs, np.zeros((len(T), 0)), lumps)


def _heat_at(now: Network, course: LinearRun, lumps: Indices, shares: Sequence[float]) -> Array:
    """The same at the mean over some instants within each interval, where no node is new."""
    count = len(shares)
    T, inputs = _list_within(course, shares)
    into = heat_into(now, T, inputs, np.zeros((len(T), 0)), lumps)
    return np.asarray(into.reshape(count, len(course.T_ends), len(lumps)).mean(axis=0))


def _list_within(course: LinearRun, shares: Sequence[float]) -> tuple[Array, dict[str, Array]]:
    """Temperatures and inputs of a run at some instants within each interval, laid out once."""
    key = ("within", *shares)
    if key not in course.derived:
        (start, end), count = np.split(course.inputs["time"], 2), len(shares)
        inputs = {name: np.tile(u, (count, 1)) for name, u in course.inputs.items()}
        inputs["time"] = np.concatenate([start + share * (end - start) for share in np.repeat(shares, 2)])
        course.derived[key] = np.tile(course.T_ends, (count, 1))
        course.derived.update({(*key, name): u for name, u in inputs.items()})
    return course.derived[key], {name: course.derived[*key, name] for name in course.inputs}


def _list_standing(course: LinearRun, entries: Sequence[str]) -> list[tuple[Array, Array]]:
    """Heat that some entries give along a run (2 K, members) as far as they are there, and what a watt of each brings
    into its lumps (members, N)."""
    network = course.problem.plan.network
    index = [network.mechanisms.index(e) for e in entries if e in network.mechanisms]
    groups: tuple[Group, ...] = (*network.flows, *network.heats) if index else ()
    found = []
    for g, group in enumerate(groups):
        members = np.flatnonzero(np.isin(group.entry, index))
        if len(members):
            if (g, "") not in course.derived:
                course.derived[g, ""] = heat_of(group, course.T_ends, course.inputs)
            found.append((course.derived[g, ""][:, members], spread_of(group)[members]))
    return found


def _change_readings(entries: _Entries, outputs: Readouts | None, prediction: Prediction) -> Array:
    """Changes of the cells' means because the same temperatures are read otherwise, by channels that see what a
    candidate changes; none without outputs."""
    machine, names, course = entries.machine, prediction.run.channels, prediction.course
    own = [i for i, name in enumerate(names) if any(sees(machine, name, path) for path in entries.read)]
    if outputs is None or not own:
        return np.zeros_like(prediction.cells)
    axes = {machine.sensors[names[i]].axis for i in own}
    machine = replace(machine, tcp={axis: moved for axis, moved in machine.tcp.items() if axis in axes})
    rows = np.vstack(
        [outputs.rows[:, : course.T_ends.shape[1]] @ course.T_ends.T, course.readings[len(course.readouts.rows) :]]
    )
    seen = channels_of(machine, outputs, rows, prediction.inputs, [names[i] for i in own])
    out = np.zeros((len(names), prediction.averages.cells))
    out[own] = prediction.averages.of(seen - prediction.values[own], own)
    return out.reshape(-1)
