"""Recordings as a fit weighs them: means over cells, and what they are uncertain by besides the parameters."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from network.analysis.comparison.common_start import START
from network.catalogue.declaration.declare import Array, Mask
from network.engine.assembly import build
from network.engine.network import Network
from network.engine.response.intervals import first_from
from network.engine.response.knots import Knots, make_knots, on_knots
from network.engine.response.linear_run import LinearRun, Push
from network.engine.response.model import Run
from network.engine.response.nuisance_pushes import edge_pushes, start_pushes
from network.engine.simulation import schedule_for
from network.engine.start import start_temperatures
from network.machine.machine import Machine
from network.platform.printing import Brief
from network.recordings.counted_readings import drop_uncounted
from network.recordings.hygiene.data_quality import Channel, look_at
from network.recordings.inputs import Schedule, Start
from network.recordings.recording import Recording

OFFSET = {"degC": 0.1, "um": 0.25e-6, "urad": 0.25e-6}
"""Prior 1σ of a channel's constant error, by its unit (SI)."""
OFFSET_LIMIT = 3.0
"""Prior σ that a constant error may be taken to: beyond, it is a fault of the sensor and no nuisance."""
START_ANYWHERE = 1.0
"""K: the same where neither tells it and the part is no solid one but a capacity, like a tank."""
START_SHARE = 0.5
"""Of the spread of the first readings, in addition, for parts without a sensor."""
LONE, MOST_JUMPS = 3.0, 40
"""Samples from the next jump at which one stands alone; more of them than this in a run are an input that flutters."""
EDGE = 12**-0.5
"""1σ of an instant that lies anywhere in an interval, in its length."""
LOOKED = 512
"""Channels of recordings of which it is remembered what they tell by themselves."""
LAID_OUT = 64
"""Recordings that are kept laid out: fits of rivals lay the same ones out alike."""


@dataclass(frozen=True)
class Nuisance:
    """What a run is uncertain by besides the parameters: one column each, with a normal prior."""

    name: str
    mean: float
    spread: float


@dataclass(frozen=True)
class RunPoint:
    """Where a run is linear about: temperatures of parts at its start [°C], constants that drive it [SI], by name."""

    start: Mapping[str, float] = field(default_factory=dict)
    inputs: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, repr=False)
class Measured(Brief):
    """One recording ready for a fit. means: of its cells, channel after channel; counts: samples in each; variance of
    each mean by white noise; sigma: 1σ of a sample that each channel counts with, declared: as in the file."""

    run: Run
    recording: Recording
    channels: Mapping[str, Channel]
    means: Array
    counts: Array
    sigma: Mapping[str, float]
    declared: Mapping[str, float]
    starts: tuple[Nuisance, ...]
    edges: tuple[Nuisance, ...]
    inputs: tuple[Nuisance, ...]

    @property
    def own(self) -> tuple[Nuisance, ...]:
        """What is uncertain about this run alone."""
        return (*self.starts, *self.edges, *self.inputs)

    @property
    def known(self) -> Array:
        return np.asarray(self.counts > 0)

    def move_start(self, by: Array) -> dict[str, float]:
        """Temperatures of the parts at the start, moved by as much as a fit says [K]."""
        return {n.name: self.run.start[n.name] + float(x) for n, x in zip(self.starts, by, strict=True)}

    @property
    def point(self) -> RunPoint:
        """What it is linear about."""
        signals = self.run.schedule.signals
        return RunPoint(self.run.start, {n.name: signals[n.name].value for n in self.inputs})

    def about(self, point: RunPoint) -> Measured:
        """The same about other constants of the run."""
        return self.with_start(point.start).with_inputs(point.inputs)

    def with_start(self, start: Mapping[str, float]) -> Measured:
        """The same about other temperatures of the parts at the start, of which as much is supposed as before."""
        own = {n.name: self.run.start[n.name] for n in self.starts}
        moved = {n: start.get(n, t) for n, t in own.items()}
        starts = tuple(replace(n, mean=n.mean + own[n.name] - moved[n.name]) for n in self.starts)
        run = self.run.begun({**self.run.start, **moved}, self.run.schedule.start)
        return replace(self, run=run, starts=starts)

    def with_inputs(self, values: Mapping[str, float]) -> Measured:
        """The same about other values of the constants that drive the run [SI], supposed to lie where they did."""
        if not self.inputs:
            return self
        signals = dict(self.run.schedule.signals)
        moved = []
        for n in self.inputs:
            by = values.get(n.name, signals[n.name].value) - signals[n.name].value
            signals[n.name] = signals[n.name].shift(by)
            moved.append(replace(n, mean=n.mean - by))
        schedule = replace(self.run.schedule, signals=signals)
        return replace(self, run=self.run.driven_by(schedule), inputs=tuple(moved))

    def move_inputs(self, by: Array) -> dict[str, float]:
        """Values of the uncertain inputs, moved by as much as a fit says [SI]."""
        signals = self.run.schedule.signals
        return {n.name: signals[n.name].value + float(x) for n, x in zip(self.inputs, by, strict=True)}

    @property
    def variance(self) -> Array:
        """White variance of each cell's mean."""
        sigma = np.repeat([self.sigma[n] for n in self.run.channels], self.run.knots.cells)
        return np.asarray(sigma**2 / np.maximum(self.counts, 1))

    @property
    def centres(self) -> Array:
        """Mean instant of each cell [s]."""
        knots = self.run.knots
        total = np.bincount(knots.cell_of, knots.samples, knots.cells)
        return np.asarray(total / np.maximum(np.bincount(knots.cell_of, minlength=knots.cells), 1))

    def ends_before(self, share: float) -> Mask:
        """Which cells of its channels end before a share of its length."""
        knots = self.run.knots
        until = knots.t[0] + share * (knots.t[-1] - knots.t[0]) + 1e-6
        return np.tile(knots.t[knots.cell_ends] <= until, len(self.run.channels))

    def pushes(self, course: LinearRun) -> list[Push]:
        """What the starts, then the edges do to a run."""
        jumps = edge_pushes(course, instants_of(self.run, self.recording)) if self.edges else []
        return [*start_pushes(course, [n.name for n in self.starts]), *jumps]


def weigh_recording(
    machine: Machine, recording: Recording, start: Start | None = None, also: Sequence[str] = (),
    network: Network | None = None, unread: Iterable[str] = (),
) -> Measured:  # fmt: skip
    """A recording laid out for fits of a machine; `also`: inputs that it does not read but a rival may; network: of the
    machine, if it is there; unread: inputs whose noise matters less, to this machine and all its rivals. Raises Refused
    where it lacks an input."""
    schedule = schedule_for(machine, recording, start)
    recording = drop_uncounted(machine, recording)
    more = {name: recording.signal(name) for name in also if name not in schedule.signals}
    schedule = replace(schedule, signals={**schedule.signals, **more})
    network = build(machine) if network is None else network
    T0 = start_temperatures(network, schedule, recording)
    parts = {name: float(T0[part].mean()) for name, part in network.parts.items()}
    known = [] if schedule.start else [float(T0[i]) for i in network.held]
    channels = tuple((n, sensor.sigma) for n, sensor in machine.sensors.items() if n in recording.columns)
    inputs, switches = frozenset(schedule.signals), frozenset(machine.switches)
    laid = _lay_out(recording, inputs, inputs & {*unread}, switches, channels)
    run = laid.run.begun(parts, schedule.start)
    looked = laid.channels
    declared = {n: machine.sensors[n].sigma for n in looked}
    sigma = {n: max(declared[n], c.noise, c.quantum * EDGE) for n, c in looked.items()}
    return Measured(
        run, recording, looked, laid.means, laid.counts, sigma, declared,
        tuple(_starts(machine, parts, recording, known)), tuple(_edges(run, recording)),
        tuple(_inputs(machine, schedule)),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _LaidOut:
    """What of a recording is the same for all machines that read the same of it."""

    run: Run
    channels: Mapping[str, Channel]
    means: Array
    counts: Array


@lru_cache(maxsize=LAID_OUT)
def _lay_out(
    recording: Recording, inputs: frozenset[str], unread: frozenset[str], switches: frozenset[str],
    channels: tuple[tuple[str, float], ...],
) -> _LaidOut:  # fmt: skip
    """Channels (with their declared σ) on the knots of some inputs; unread: those whose noise matters less."""
    signals = {name: recording.signal(name, is_switch=name in switches) for name in sorted(inputs - {*recording.modes})}
    schedule = Schedule(recording.name, recording.file, recording.t, signals, recording.start)
    knots = make_knots(schedule, unread=unread)
    looked = {n: _look_at_column(recording, n, sigma) for n, sigma in channels}
    looked = {n: c for n, c in looked.items() if c.used.any()}
    driven = on_knots(schedule, knots, unread)
    driven = replace(driven, signals={**driven.signals, **{n: m.signal for n, m in recording.modes.items()}})
    run = Run(recording.name, driven, knots, {}, {n: c.used for n, c in looked.items()})
    means, counts = zip(*(_means(run, c) for c in looked.values()), strict=True)
    return _LaidOut(run, looked, np.concatenate(means), np.concatenate(counts))


@lru_cache(maxsize=LOOKED)
def _look_at_column(recording: Recording, name: str, declared: float) -> Channel:
    return look_at(name, recording.columns[name].values, declared)


def _means(run: Run, channel: Channel) -> tuple[Array, Array]:
    used = channel.used
    cell, cells = run.knots.cell_of[used], run.knots.cells
    counts = np.bincount(cell, minlength=cells)
    return np.bincount(cell, channel.values[used], cells) / np.maximum(counts, 1), counts.astype(float)


def _starts(
    machine: Machine, parts: Mapping[str, float], recording: Recording, beside: Sequence[float]
) -> Iterator[Nuisance]:
    """The start of every part, unless the recording says that it is as read; a part without a sensor may lie anywhere
    among those with one and, where no start is given, what is held `beside` them [°C]."""
    if not recording.starts:
        return
    own = [n for n, node in machine.nodes.items() if node.is_part]
    sensed = {s.place.node for name, s in machine.sensors.items() if s.place and name in recording.columns}
    told = [parts[n] for n in own if n in sensed]
    spread = float(np.ptp([*told, *beside])) if told else 0.0
    for name in own:
        unseen = START if machine.nodes[name].length is not None else START_ANYWHERE
        yield Nuisance(name, 0.0, START if name in sensed else unseen + START_SHARE * spread)


def lone_jumps(knots: Knots) -> Array:
    """Jumps whose instant can be told: in a ramp of many steps it is not the instants that are uncertain."""
    t = knots.jumps
    if len(t) < 2:
        return t
    gap = np.diff(np.concatenate([[-np.inf], t, [np.inf]]))
    interval = float(np.median(np.diff(knots.samples)))
    lone = t[np.minimum(gap[:-1], gap[1:]) > LONE * interval]
    return lone if len(lone) <= MOST_JUMPS else lone[:0]


def instants_of(run: Run, recording: Recording) -> Array:
    """Instants of jumps that are not known exactly: of inputs, then of relays whose modes are read."""
    return np.concatenate([lone_jumps(run.knots), *(mode.t[1:] for mode in recording.modes.values())])


def _edges(run: Run, recording: Recording) -> Iterator[Nuisance]:
    """How much later than recorded an input jumped: at most a sample earlier; and a relay switched."""
    samples = recording.t
    for t in lone_jumps(run.knots):
        k = int(first_from(samples, t))
        h = float(samples[k] - samples[k - 1]) if k else 0.0
        yield Nuisance(f"jump at {t:.6g} s", -h / 2, max(h * EDGE, 1e-3))
    for mode in recording.modes.values():
        for t, spread in zip(mode.t[1:], mode.spread, strict=True):
            yield Nuisance(f"{mode.name} at {t:.6g} s", 0.0, float(spread))


def _inputs(machine: Machine, schedule: Schedule) -> Iterator[Nuisance]:
    """How far constants that drive the machine are from what was stated."""
    for name in machine.inputs:
        if schedule.signals[name].std > 0:
            yield Nuisance(name, 0.0, schedule.signals[name].std)
