"""Many runs of one linear machine at once, with numbers that differ: its modes, courses and movement side by side.

Only for machines in which a number changes nothing but a conductance, a heat, a heat capacity or a movement: linear,
one set of conductances, no junctions, no streams, output evenly spaced. Whether it serves is tried: two points are run
one by one too, and where they differ by more than rounding, all are.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from network.analysis.sweep.sample_blocks import SampleBlocks
from network.analysis.sweep.sample_runs import SampleJob, run_one
from network.catalogue.declaration.declare import Array, Declared, Indices
from network.catalogue.mechanisms.mechanism import Inputs
from network.catalogue.nodes import CAPACITIES
from network.engine.assembly import build
from network.engine.channels import Readouts, readouts
from network.engine.network import Network
from network.engine.simulation import schedule_for
from network.engine.solvers.method_choice import make_plan
from network.engine.solvers.plan import Plan
from network.engine.solvers.regimes import matrix_inputs
from network.engine.start import start_temperatures
from network.platform.threads import on_one_thread
from network.recordings.inputs import Schedule
from network.recordings.recording import Recording

AT_ONCE = 32
"""Runs side by side: their courses stay in the cache."""
ROUNDING = 1e-9
"""Of the largest value, and in kelvin times 10 µm."""
SLOW = 1e-3
"""Rate times duration below which a mode hardly moves, and the closed form used here would cancel."""
MOST_LUMPS = 120
_LAST: dict[int, tuple[SampleJob, Batch | None]] = {}


def run_sample(shared: SampleJob, values: Array) -> Array:
    """Runs at some points, (points, numbers) [SI] → (points, axes × extremes) [SI]. Raises Failed with the numbers."""
    batch = batch_of(shared)
    return batch.run(values) if batch is not None else np.stack([run_one(shared, point) for point in values])


def batch_of(shared: SampleJob) -> Batch | None:
    """What runs its points side by side; None where they are to be run one by one. Kept for the next parcel."""
    if id(shared) not in _LAST or _LAST[id(shared)][0] is not shared:
        _LAST.clear()
        _LAST[id(shared)] = shared, _try_batch(shared)
    return _LAST[id(shared)][1]


@on_one_thread
def _try_batch(shared: SampleJob) -> Batch | None:
    batch = _make_batch(shared)
    if batch is None:
        return None
    points = np.stack([d.at(np.array([0.15, 0.8])) for d in shared.drawn], axis=1)
    found, right = batch.run(points), np.stack([run_one(shared, point) for point in points])
    allowed = ROUNDING * (np.abs(right) + 1e-5)
    return batch if bool((np.abs(found - right) <= allowed).all()) else None


def _make_batch(shared: SampleJob) -> Batch | None:
    job = shared.job
    if job.method not in ("auto", "modal") or (isinstance(job.source, Recording) and job.source.cuts):
        return None
    schedule, network = schedule_for(job.machine, job.source, job.start), build(job.machine)
    T0 = start_temperatures(network, schedule, job.source if isinstance(job.source, Recording) else None)
    plan = make_plan(network, schedule, T0)
    able = plan.method == "modal" and plan.spacing > 0 and network.size <= MOST_LUMPS
    odd = len(network.massless) or matrix_inputs(network) or any(f.one_way or f.reads for f in network.flows)
    reads = any(h.reads or h.law.follows_time for h in network.heats)
    if not able or odd or reads or not _starts_alike(schedule, job.source) or not all(map(_is_own, shared.drawn)):
        return None
    if any(r.how == "heat" for e in job.machine.expansions.values() for r in e.readings()):
        return None
    return Batch(shared, schedule, network, plan, readouts(network, parts=False))


def _starts_alike(schedule: Schedule, source: object) -> bool:
    """A start that does not depend on the numbers that are drawn."""
    return not isinstance(source, Recording) and not (schedule.start is not None and schedule.start.steady)


def _is_own(drawn: Any) -> bool:
    """A number that its own entry alone reads."""
    section, attribute = drawn.parameter.entry.section, drawn.parameter.attribute
    return section in ("links", "sources", "tcp") or (section == "nodes" and attribute in CAPACITIES)


class Batch:
    """A machine, a plan, and how its numbers enter."""

    def __init__(self, shared: SampleJob, schedule: Schedule, network: Network, plan: Plan, outputs: Readouts) -> None:
        self.shared, self.network, self.plan = shared, network, plan
        read = {key: at for key, at in outputs.where.items() if key[0] == "reading"}
        used = sorted({row for row, _ in read.values()})
        self.rows = outputs.rows[used]
        self.where = {key: (used.index(row), shift) for key, (row, shift) in read.items()}
        self.blocks, self.steps = SampleBlocks.of(plan), plan.steps
        self.u = plan.inputs_at_samples()
        for name, signal in schedule.signals.items():
            self.u[name][-1] = signal.at(plan.t[-1:])[0]
        N = network.size
        self.spread = [_matrix_of(flows.a, flows.b, N) for flows in network.flows]
        self.held = plan.evaluate_held(plan.left), plan.evaluate_held(plan.right)

    @on_one_thread
    def run(self, values: Array) -> Array:
        """Points (points, numbers) [SI] → (points, axes × extremes) [SI]; those that fail here one by one."""
        parts = [self._run(some) for some in np.array_split(values, max(1, -(-len(values) // AT_ONCE)))]
        found = np.concatenate(parts)
        for i in np.flatnonzero(~np.isfinite(found).all(axis=1)):
            found[i] = run_one(self.shared, values[i])
        return found

    def _run(self, values: Array) -> Array:
        A, C = self._conductances(values), self._capacities(values)
        free, bound = self.network.free, self.network.bound
        root = np.sqrt(C)
        S = -A[:, free][:, :, free] / (root[:, :, None] * root[:, None, :])
        rates, U = np.linalg.eigh(S)
        V = U / root[:, :, None]
        duration = float(self.plan.t[-1] - self.plan.t[0])
        if not bool((rates * duration > SLOW).all()):
            return np.full((len(values), len(self.shared.columns())), np.nan)
        into_held = np.swapaxes(A[:, free][:, :, bound], 1, 2) @ V
        p0, p1 = (h @ into_held for h in self.held)
        for q0, q1, into in self._heats(values):
            by = into[free].T @ V
            heat = q0 @ by
            p0, p1 = p0 + heat, p1 + (heat if q1 is q0 else q1 @ by)
        start = np.einsum("sji,sj->si", V, C * self.plan.T0[free])
        return self._movement(values, self._readings(rates, V, p0, (p1 - p0) / self.steps[:, None], start))

    def _conductances(self, values: Array) -> Array:
        """K of every point (points, N, N)."""
        N, u = self.network.size, {name: given[0] for name, given in self.plan.left.items()}
        K = np.zeros((len(values), N * N))
        for flows, spread in zip(self.network.flows, self.spread, strict=True):
            law = flows.law.replaced(**self._changed(flows.law, flows.entry, values))
            slope = law.let_pass(law.slopes(np.zeros(len(flows.a)), np.zeros(len(flows.a)), u)[0], u)
            K += np.broadcast_to(flows.w * slope, (len(values), len(flows.a))) @ spread
        return K.reshape(-1, N, N)

    def _capacities(self, values: Array) -> Array:
        C = np.tile(self.network.capacity, (len(values), 1))
        for k, drawn in enumerate(self.shared.drawn):
            path, attribute = drawn.parameter.entry, drawn.parameter.attribute
            if path.section == "nodes":
                part, given = self.network.parts[path.name], self.network.machine.nodes[path.name].__dict__[attribute]
                C[:, part] += (values[:, k, None] - float(given)) / (part.stop - part.start)
        return C[:, self.network.free]

    def _heats(self, values: Array) -> Iterator[tuple[Array, Array, Array]]:
        """Heat of every group just after and just before the edges (points or 1, K, sources), and where it goes."""
        begin, end = self.plan.just_inside
        shape = (len(self.steps), 1)
        for heats in self.network.heats:
            changed = {n: a[:, None] for n, a in self._changed(heats.law, heats.entry, values).items()}
            law: Any = heats.law.replaced(**changed)
            one = np.ones((*shape[:1], heats.into.shape[1]))
            first = np.asarray(law.let_pass(law.heat(begin), begin) * one)
            ramped = self.plan.is_ramped(heats.law)
            yield first, np.asarray(law.let_pass(law.heat(end), end) * one) if ramped else first, heats.into

    def _changed(self, law: Declared, entry: Indices, values: Array) -> dict[str, Array]:
        """Numbers of a stacked law that are drawn: (points, entries) each."""
        changed: dict[str, Array] = {}
        for k, drawn in enumerate(self.shared.drawn):
            path, name = drawn.parameter.entry, drawn.parameter.attribute
            mine = [self.network.mechanisms[i] == f"{path.section}.{path.name}" for i in entry.tolist()]
            if any(mine):
                given = np.broadcast_to(law.__dict__[name], (len(values), len(mine)))
                changed[name] = np.where(mine, values[:, k, None], changed.get(name, given))
        return changed

    def _readings(self, rates: Array, V: Array, p: Array, r: Array, m: Array) -> Array:
        """Base readings over the instants of output (points, rows, t)."""
        lam, is_ramped = rates[:, None], bool(r.any())
        drift = r / lam if is_ramped else np.zeros((1, 1, rates.shape[1]))
        settled = (p - drift) / lam
        away = self._march(lam, settled, drift, m)
        over, at, blocks = self.rows[:, self.network.free] @ V, self.blocks.interval, self.blocks
        moving = away.take(at, axis=1)
        moving *= np.exp(-lam * blocks.since[:, None])
        shown = over[..., None] * np.exp(-rates[:, :, None] * blocks.within)[:, None]
        y = moving[:, None] @ shown
        level = (over @ np.swapaxes(settled, 1, 2))[:, :, at]
        if is_ramped:
            climb = (over @ np.swapaxes(drift, 1, 2))[:, :, at]
            level += climb * blocks.since
            y += climb[..., None] * blocks.within
        y += level[..., None]
        y = y.reshape(len(V), len(over[0]), -1).take(blocks.at, axis=2)
        return y if self.direct is None else np.asarray(y + self.direct)

    def _march(self, lam: Array, settled: Array, drift: Array, m: Array) -> Array:
        """How far the modes are from where they settle, just after every edge (points, K, modes)."""
        away = np.empty_like(settled)
        decay, jump = np.exp(-lam * self.steps[:-1, None]), settled[:, :-1] - settled[:, 1:]
        if drift.any():
            jump += (drift * self.steps[:, None])[:, :-1]
        away[:, 0] = m - settled[:, 0]
        for k in range(len(self.steps) - 1):
            np.multiply(decay[:, k], away[:, k], out=away[:, k + 1])
            away[:, k + 1] += jump[:, k]
        return away

    @cached_property
    def direct(self) -> Array | None:
        """What readings see of held nodes (rows, t); None where they see nothing."""
        by_held = self.rows[:, self.network.bound]
        if not by_held.any():
            return None
        k = self.plan.interval_of
        share = ((self.plan.t - self.plan.edges[k]) / self.steps[k])[:, None]
        return np.asarray(by_held @ (self.held[0][k] + share * (self.held[1] - self.held[0])[k]).T)

    def _movement(self, values: Array, y: Array) -> Array:
        """Largest, smallest and last value of every axis."""
        found = np.empty((len(values), len(self.shared.columns())))
        for i, (axis, entries) in enumerate(self.network.machine.tcp.items()):
            total = np.zeros((len(values), y.shape[2]))
            for name, entry in entries.items():
                readings = (self._reading(y, axis, name, n) for n in range(len(entry.readings())))
                total += entry.replaced(**self._own(axis, name, values)).movement(_side_by_side(self.u), *readings)
            found[:, 3 * i : 3 * i + 3] = np.stack([total.max(axis=1), total.min(axis=1), total[:, -1]], axis=1)
        return found

    def _reading(self, y: Array, axis: str, name: str, n: int) -> Array:
        row, offset = self.where["reading", axis, name, str(n)]
        return np.asarray(y[:, row] + offset)

    def _own(self, axis: str, name: str, values: Array) -> Mapping[str, Array]:
        paths = ((k, d.parameter) for k, d in enumerate(self.shared.drawn))
        return {p.attribute: values[:, k, None] for k, p in paths
                if (p.entry.section, p.entry.axis, p.entry.name) == ("tcp", axis, name)}  # fmt: skip


def _side_by_side(u: Mapping[str, Array]) -> Inputs:
    return {name: values[None] for name, values in u.items()}


def _matrix_of(a: Indices, b: Indices, N: int) -> Array:
    """What a conductance of each flow is in K, flattened: (flows, N²)."""
    matrix, e = np.zeros((len(a), N * N)), np.arange(len(a))
    for where, sign in ((b * N + a, 1.0), (b * N + b, -1.0), (a * N + b, 1.0), (a * N + a, -1.0)):
        np.add.at(matrix, (e, where), sign)
    return matrix
