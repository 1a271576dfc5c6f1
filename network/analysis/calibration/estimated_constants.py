"""The constants of a run as a machine with known numbers would have them: start, uncertain inputs, sensors' offsets."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from network.analysis.calibration.expansion_point import move_points
from network.analysis.calibration.gauss_newton import Problem, linearise, make_problem
from network.analysis.calibration.growing_horizon import FEWEST, has_relays
from network.analysis.calibration.linearised import Linearised
from network.analysis.calibration.measured_means import (
    OFFSET_LIMIT,
    START_ANYWHERE,
    Measured,
    RunPoint,
    weigh_recording,
)
from network.analysis.calibration.misfit import ChannelMisfit, channel_misfits, stated_misfits
from network.analysis.comparison.common_start import share_start_rule
from network.analysis.comparison.compare import Comparison, RecordingResidual, compare
from network.analysis.comparison.run_constants import InputConstant, RunConstants, find_scored_from
from network.catalogue.declaration.declare import Array
from network.engine.response.parameters import Parameter, at_values, values_at
from network.machine.machine import Machine
from network.platform.quantities.units import unit
from network.platform.refusal import Failed
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.runs import runs_of

ROUNDS, CLOSE = 4, 1.0
"""How often a run is linearised about its constants, and the least that another time must better the cost J."""
SHARES = (1 / 16, 1 / 8, 1 / 4, 1 / 2)
"""Of a run, from which the constants of one that switches are led to all of it."""
ROUGH, ROUGHEST = 2e-4, 1e-5
"""1/K: tolerance of a step, relative, over the least noise of a thermometer, and at most: it leaves some thousandths of
the noise (described_spindle along 8 h at 20 s: 0.001 σ)."""
TRIED = (0.0, -0.7, 0.7)
"""K by which parts that may start anywhere are moved before, where something switches or melts: else a run is all
but linear in its constants, and one beginning leads where all do."""


@dataclass(frozen=True, eq=False)
class Numbers:
    """What runs are compared with. machine: with its numbers in it; original, parameters, theta: where they came from
    (a start depends on its sensors only); misfit: of each channel in the runs that they came from; points: constants of
    these runs as the fit has them, by file."""

    machine: Machine
    original: Machine
    parameters: tuple[Parameter, ...]
    theta: Array
    start: Start | None = None
    misfit: Mapping[str, ChannelMisfit] | None = None
    points: Mapping[str, RunPoint] = field(default_factory=dict)

    @classmethod
    def of(cls, machine: Machine, start: Start | None = None) -> Numbers:
        """A machine as it is."""
        return cls(machine, machine, (), np.empty(0), start)


def estimate_constants(of: Numbers, recording: Recording, held_out: bool = False) -> RunConstants:
    """The most probable constants of a run, the machine's numbers being known; of a held-out one from its beginning.

    Each channel counts by the misfit of the fit that the numbers came from, or else of this run itself, so that
    constants mend nothing that the machine lacks, and no badly told channel bends those that the others tell.
    """
    scored_from = find_scored_from(recording) if held_out else -np.inf
    seen = recording.before(scored_from) if held_out else recording
    if not _tells(of.machine, seen):
        return stated_constants(of, recording)
    fixed = at_values(of.original, values_at(of.parameters, of.theta))
    data = weigh_recording(fixed, seen, of.start)
    begins = [*_list_begins(fixed, data, of.start)]
    best = _settle_best(partial(_about, fixed, _reweigh(data, of.misfit or {}, not held_out)), begins)
    if best is not None and of.misfit is None:
        best = _settle_best(partial(_about, fixed, _reweigh(data, channel_misfits(best), not held_out)), begins) or best
    if best is None:
        return replace(stated_constants(of, recording), scored_from=scored_from)
    return _read_constants(best, scored_from)


def _list_begins(fixed: Machine, data: Measured, start: Start | None) -> Iterator[RunPoint]:
    """What the search for constants of a run begins from: as stated; where something switches or melts, parts that may
    start anywhere also a little colder and warmer; where it switches what ever longer pieces of the run lead to, for
    over many cycles it slips."""
    switches, melts = has_relays(fixed), any(node.stored is not None for node in fixed.nodes.values())
    anywhere = [n.name for n in data.starts if n.spread >= START_ANYWHERE and (switches or melts)]
    for shift in TRIED if anywhere else (0.0,):
        yield RunPoint({n: data.run.start[n] + shift for n in anywhere})
    point = RunPoint()
    long_enough = [share for share in SHARES if share * len(data.recording.t) >= FEWEST]
    for share in long_enough if switches else ():
        piece = weigh_recording(fixed, data.recording.until(share), start)
        told = _settle(partial(_about, fixed, piece), point)
        point = point if told is None else move_points(told)[0]
    if point.start:
        yield point


def _tells(machine: Machine, recording: Recording) -> bool:
    """Whether there is a channel with two readings to find constants from."""
    columns = (recording.columns[n].values for n in machine.sensors if n in recording.columns)
    return len(recording.t) > 1 and any(np.isfinite(values).sum() > 1 for values in columns)


def stated_constants(of: Numbers, recording: Recording) -> RunConstants:
    """What is stated of a run, all of it scored."""
    data = weigh_recording(of.machine, recording, of.start)
    return RunConstants({n.name: data.run.start[n.name] for n in data.starts})


def _reweigh(data: Measured, misfit: Mapping[str, ChannelMisfit], is_whole: bool) -> Measured:
    """The run with the noise of its channels as large as they are told."""
    factors = {n: misfit[n].factor(is_whole) if n in misfit else 1.0 for n in data.sigma}
    return replace(data, sigma={n: sigma * factors[n] for n, sigma in data.sigma.items()})


def _about(machine: Machine, data: Measured, point: RunPoint) -> Problem:
    """The run about other constants."""
    return make_problem(machine, (), [data.about(point)])


def _settle_best(problem: Callable[[RunPoint], Problem], begins: Iterable[RunPoint]) -> Linearised | None:
    """The best of what several beginnings lead to; None where all break down."""
    found = [_settle(problem, point) for point in begins]
    return min((f for f in found if f is not None), key=lambda at: at.cost, default=None)


def _settle(problem: Callable[[RunPoint], Problem], point: RunPoint) -> Linearised | None:
    """The run at the constants at which it stays when it is linearised about them; None where it breaks down."""
    best: Linearised | None = None
    for _ in range(ROUNDS):
        try:
            fit = linearise(problem(point), np.empty(0))
        except Failed:
            break
        if best is not None and fit.cost > best.cost - CLOSE:
            break
        best, point = fit, move_points(fit)[0]
    return best


def _offsets_of(fit: Linearised) -> dict[str, float]:
    """Constant errors of sensors that a fit finds, as far as they are nuisances."""
    pairs = zip(fit.problem.offsets, fit.eta, strict=False)
    within = [(n.name, np.clip(x, -OFFSET_LIMIT * n.spread, OFFSET_LIMIT * n.spread)) for n, x in pairs]
    return {name: float(x) for name, x in within}


def _read_constants(fit: Linearised, scored_from: float, at: RunPoint | None = None) -> RunConstants:
    """As a fit finds them; at: those that it was made about, of which only the offsets are found."""
    (data,), (point,) = fit.problem.data, move_points(fit) if at is None else (at,)
    signals = data.run.schedule.signals
    std = np.sqrt(np.diag(fit.covariance))[len(fit.eta) - len(data.inputs) :]
    told = {n: InputConstant(x, float(s), signals[n].unit) for (n, x), s in zip(point.inputs.items(), std, strict=True)}
    return RunConstants(point.start, told, _offsets_of(fit), scored_from, _share_absorbed(fit))


def _share_absorbed(fit: Linearised) -> float:
    """Share of the squared residual that inputs and offsets take away."""
    data, count = fit.problem.data, len(fit.problem.offsets)
    without, mean, first = fit.eta.copy(), fit.rows.mean, count
    without[:count] = mean[:count]
    for d in data:
        first += len(d.own)
        without[first - len(d.inputs) : first] = mean[first - len(d.inputs) : first]
    left, whole = (float(r @ r) for r in (fit.left, fit.residual - fit.rows.slopes.apply(without)))
    return max(0.0, 1 - left / whole) if whole > 0 else 0.0


def compare_estimated(of: Numbers, recording: Recording, held_out: bool = False) -> RecordingResidual:
    """Residuals of a run with its constants estimated; where something switches, or with those that keep it in step in
    the fit that the numbers came from, whichever leave less: no straight step leads from the one to the other."""
    told = compare_with_constants(of.machine, recording, estimate_constants(of, recording, held_out))
    known = None if held_out else _constants_in_step(of, recording)
    if known is None:
        return told
    try:
        other = compare_with_constants(of.machine, recording, known)
    except Failed:
        return told
    return min(told, other, key=lambda each: each.rmse_in_noise)


def _constants_in_step(of: Numbers, recording: Recording) -> RunConstants | None:
    """Of a run that the fit saw, as it has them; None of other runs, and where nothing switches."""
    point = of.points.get(recording.file)
    if point is None or not has_relays(of.machine):
        return None
    fixed = at_values(of.original, values_at(of.parameters, of.theta))
    try:
        fit = linearise(_about(fixed, weigh_recording(fixed, recording, of.start), point), np.empty(0))
    except Failed:
        return None
    return _read_constants(fit, -np.inf, point)


def compare_with_constants(machine: Machine, recording: Recording, constants: RunConstants) -> RecordingResidual:
    """Residuals of a run with its constants as found."""
    start, rtol = Start(nodes=constants.start), _tolerance(machine)
    told = compare(machine, constants.drive(recording), start=start, rtol=rtol).recordings[0]
    channels = {name: constants.correct(channel) for name, channel in told.channels.items()}
    return replace(told, channels=channels, constants=constants)


def _tolerance(machine: Machine) -> float:
    """With which what is solved step by step is compared with readings."""
    least = min((s.sigma for s in machine.sensors.values() if unit(s.unit).is_temperature), default=ROUGHEST / ROUGH)
    return min(ROUGH * least, ROUGHEST)


def compare_all_estimated(of: Numbers, recordings: Iterable[Recording], held_out: bool = False) -> Comparison | None:
    """The same of several; None without recordings."""
    each = tuple(compare_estimated(of, r, held_out) for r in recordings)
    return Comparison(of.machine, each) if each else None


def compare_estimating(machine: Machine, recordings: Iterable[Recording], held_out: bool = False) -> Comparison:
    """Residuals of recordings of a machine as it is, the constants of each estimated from the whole of it, which tells
    itself how far each channel is off; held_out: from its beginning, which is then not scored, and by what the file
    says of that."""
    runs = share_start_rule(machine, runs_of(machine, recordings))
    of = replace(Numbers.of(machine), misfit=stated_misfits(machine.calibrated) if held_out else None)
    return Comparison(machine, tuple(compare_estimated(of, r, held_out) for r in runs))
