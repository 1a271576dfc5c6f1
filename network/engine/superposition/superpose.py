"""From a run to its superposition: every cause alone, in the same network, and what it moves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.expansions.base import Reading
from network.catalogue.mechanisms.mechanism import Inputs
from network.engine.channels import plain_readouts
from network.engine.energy import sum_stored_heat
from network.engine.network import Network
from network.engine.solvers.carry_out import Outcome, solve_schedule
from network.engine.solvers.plan import HAIR, SAME_INSTANT, merge_instants
from network.engine.superposition.apportionment import mean_slopes, move_at_once
from network.engine.superposition.causes import Cause, list_causes, mean_start
from network.engine.superposition.exact import answer_exactly
from network.engine.superposition.frozen_network import STAGES, FrozenRun, answer_frozen
from network.engine.superposition.superposition import Share, Superposition
from network.engine.trajectory import Trajectory
from network.platform.refusal import refuse
from network.platform.threads import on_one_thread
from network.recordings.call_arguments import expect

AT_ONCE = "at once"
"""The cause of what moves without any heat, with the speed or in a step."""
EXACTLY = "exact: the network is linear, so every cause was computed alone"
ALONG = "conductances and heats as they were along this run, every cause computed alone in them"
FINEST, MOST_STEPS, MOST_ANSWERS, FEWEST_STEPS = 8, 6000, 600_000, 200
"""Pieces that a step is cut into at most, and steps of a run at most: as many as make so many temperatures, some 20 s,
but for a few that the largest machine is given."""

MOST_PRODUCTS = 250_000_000
"""Causes times the square of states: some 40 s."""


@dataclass(frozen=True)
class _Reading:
    """One reading of an entry as a row over all lumps, of rises; C ΔT where it reads heat."""

    axis: str
    name: str
    index: int
    reading: Reading
    row: Array


@on_one_thread
def superpose(run: Trajectory) -> Superposition:
    """The movement of a run by part, heat source and kind of movement, over its time.

    Linear networks: exact superposition. Others: with conductances, heats and capacities as they were along the run
    (see `frozen_network`); the steps are halved until less is left than three digits tell, at most to an eighth.
    Rises count from the mean temperature at the start, so that the cause `start` holds what was displaced before the
    run, and how an uneven start evens out; held nodes count with their difference to it.

    Raises Refused for more causes than can each be computed alone.
    """
    expect("run", run, Trajectory)
    if not run.machine.expansions:
        return Superposition(run, (), {}, EXACTLY)
    if run.pieces:
        return _join(run, [superpose(piece) for piece in run.pieces])
    readings, causes = list(_readings(run.network)), list_causes(run.network)
    base = mean_start(run.network, run.T_start)
    outputs = plain_readouts(_rows(run.network, readings))
    plain = solve_schedule(run.network, run.schedule, run.T_start, outputs=outputs)
    _check_size(run, len(causes), plain)
    if plain.problem is not None and not any(heats.reads for heats in run.network.heats):
        answer = answer_exactly(plain.problem, causes, base)
        return _superposition(run, plain, readings, causes, answer, base, EXACTLY)
    pieces, found = 1, _superpose_frozen(run, readings, causes, base, plain, 1)
    while not found.is_told_whole and pieces < FINEST and pieces * len(run.t) < _most_steps(run.network.size):
        pieces *= 2
        found = _superpose_frozen(run, readings, causes, base, plain, pieces)
    return found


def _check_size(run: Trajectory, causes: int, plain: Outcome) -> None:
    """Each cause takes a product of every state with every other one, and there are as few states as were solved."""
    states = plain.problem.order if plain.problem is not None else run.network.size
    if not causes * states**2 <= MOST_PRODUCTS:
        wrong = f"the movement would be shared among {causes} causes in {states} lumps"
        right = f"at most {MOST_PRODUCTS // states**2} can be: give fewer sources, held nodes or lumps"
        raise refuse(run.machine.tree.key_spot("sources"), wrong, right)


def _readings(network: Network) -> Iterator[_Reading]:
    capacity = network.heat_capacity
    for (axis, name), entry in network.machine.expansions.items():
        for i, reading in enumerate(entry.readings()):
            is_heat = reading.how == "heat"
            row = network.heat_row(reading.place) * capacity if is_heat else network.reading_row(reading)
            yield _Reading(axis, name, i, reading, row)


def _rows(network: Network, readings: Sequence[_Reading]) -> Array:
    """The rows of all readings; one that reads nothing where there are none: a solver wants some."""
    return np.stack([r.row for r in readings] or [np.zeros(network.size)])


def _superpose_frozen(
    run: Trajectory, readings: Sequence[_Reading], causes: Sequence[Cause], base: float, plain: Outcome, pieces: int
) -> Superposition:
    frozen = freeze(run, _cut(plain, run.t, pieces, _most_steps(run.network.size)))
    answer = answer_frozen(frozen, causes, _rows_over_time(readings, frozen), base)
    return _superposition(run, plain, readings, causes, _sample(answer, frozen.edges, run.t), base, ALONG)


def _sample(answer: Array, edges: Array, t: Array) -> Array:
    """The answers at the instants of output, straight between the ends of steps where these are fewer."""
    k = np.clip(np.searchsorted(edges, t - SAME_INSTANT), 1, len(edges) - 1)
    share = np.clip((t - edges[k - 1]) / (edges[k] - edges[k - 1]), 0.0, 1.0)
    if np.isin(share, (0.0, 1.0)).all():
        return np.asarray(answer[:, :, np.where(share == 1.0, k, k - 1)])
    return np.asarray(answer[:, :, k - 1] * (1 - share) + answer[:, :, k] * share)


def _most_steps(lumps: int) -> int:
    return min(MOST_STEPS, max(MOST_ANSWERS // lumps, FEWEST_STEPS))


def _cut(plain: Outcome, t: Array, pieces: int, most: int) -> Array:
    """Ends of steps: every instant of output, input change and switching, and so many pieces in between; of more than
    `most` evenly chosen ones, and what that misses is in the remainder."""
    switched = np.array([instant for instant, *_ in plain.switches])
    coarse = merge_instants(merge_instants(plain.plan.edges, t), switched)
    coarse = np.append(coarse[: -1 : -(-len(coarse) // most)], coarse[-1])
    parts = coarse[:-1, None] + np.diff(coarse)[:, None] * np.arange(pieces) / pieces
    return np.append(parts.ravel(), coarse[-1])


def _rows_over_time(readings: Sequence[_Reading], frozen: FrozenRun) -> Array:
    """(edges, rows, N); the heat that a melting part holds, over C ΔT, is in the rows that read heat."""
    rows, network, T = _rows(frozen.network, readings), frozen.network, frozen.T[::2]
    if not network.melting:
        return np.broadcast_to(rows, (len(T), *rows.shape))
    cold = np.full(network.size, network.machine.reference)
    rise, capacity = T - cold, network.heat_capacity
    held = sum_stored_heat(network, T) - sum_stored_heat(network, cold)
    plain = capacity * rise
    ratio = np.where(plain != 0, held / np.where(plain != 0, plain, 1.0), 1.0)
    is_heat = np.array([r.reading.how == "heat" for r in readings] or [False])
    return np.asarray(rows * np.where(is_heat[None, :, None], ratio[:, None], 1.0))


def freeze(run: Trajectory, edges: Array) -> FrozenRun:
    """The run solved again, at the stages of steps between the edges."""
    steps = np.diff(edges)
    hair = np.minimum(HAIR, 1e-3 * steps)
    stages = np.stack([edges[:-1] + STAGES[0] * steps, edges[1:] - hair], axis=1).ravel()
    instants = np.concatenate([edges[:1], stages, edges[-1:]])
    everything = plain_readouts(np.eye(run.network.size))
    outcome = solve_schedule(run.network, replace(run.schedule, t=instants), run.T_start, outputs=everything)
    u = {name: values[:-1, None] for name, values in outcome.plan.inputs_at_samples().items()}
    return FrozenRun(run.network, edges, outcome.courses.all().T[:-1], u, _modes(run.network, outcome)[:-1])


def _modes(network: Network, outcome: Outcome) -> Array:
    """Of all relays at the instants of output: 0 off, 1 on."""
    if outcome.plan.modes is not None:
        return np.asarray(outcome.plan.modes[outcome.plan.interval_of])
    names = [network.mechanisms[i].partition(".")[2] for group in network.relays for i in group.entry]
    modes = np.zeros((len(outcome.plan.t), len(names)))
    for instant, name, is_on in outcome.switches:
        modes[outcome.plan.t >= instant, names.index(name)] = float(is_on)
    return modes


def _superposition(
    run: Trajectory, plain: Outcome, readings: Sequence[_Reading], causes: Sequence[Cause], answer: Array, base: float,
    how: str,
) -> Superposition:  # fmt: skip
    """Shares of what every cause brought to the readings, (causes, readings, instants), rises over `base`."""
    u = {**plain.plan.inputs_at_samples(), **run.inputs}
    start = next(i for i, cause in enumerate(causes) if cause.is_start)
    offset = base - run.machine.reference
    answer[start, : len(readings)] += offset * np.array([r.row.sum() for r in readings])[:, None]
    shares = [*_shares(run, u, readings, causes, answer)]
    remainder = {axis: values - sum((s.values for s in shares if s.axis == axis), np.zeros(len(run.t)))
                 for axis, values in run.tcp.items()}  # fmt: skip
    return Superposition(run, tuple(shares), remainder, how)


def _shares(
    run: Trajectory, u: Inputs, readings: Sequence[_Reading], causes: Sequence[Cause], rises: Array
) -> Iterator[Share]:
    for (axis, name), entry in run.machine.expansions.items():
        mine = [k for k, r in enumerate(readings) if (r.axis, r.name) == (axis, name)]
        at_once = move_at_once(entry, u)
        if at_once.any() or not mine:
            yield Share(axis, name, entry.kind, AT_ONCE, at_once)
        slopes = mean_slopes(entry, u, tuple(rises[:, k].sum(axis=0) for k in mine))
        for k, slope in zip(mine, slopes, strict=True):
            part = readings[k].reading.place.node
            for i, cause in enumerate(causes):
                yield Share(axis, part, entry.kind, cause.name, slope * rises[i, k])


def _join(run: Trajectory, pieces: Sequence[Superposition]) -> Superposition:
    """Pieces of a parted recording, one behind the other."""
    shares = tuple(
        replace(each[0], values=np.concatenate([share.values for share in each]))
        for each in zip(*(piece.shares for piece in pieces), strict=True)
    )
    remainder = {axis: np.concatenate([piece.remainder[axis] for piece in pieces]) for axis in run.tcp}
    return Superposition(run, shares, remainder, pieces[0].how)
