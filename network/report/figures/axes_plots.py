"""What `plot()` of a result draws, into axes of the user's own or new ones."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from network.engine.trajectory import axis_unit
from network.platform.quantities.number_format import pretty
from network.platform.quantities.unit_values import in_own_unit
from network.platform.refusal import Spot, UnknownName, likely, refuse
from network.report.figures.canvas import GREY, WIDTH, look, name_text
from network.report.figures.lines import clock
from network.report.words.recording_names import title_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from network.analysis.calibration.calibrate import Calibration
    from network.analysis.comparison.compare import Comparison
    from network.analysis.diagnosis.findings.result import Diagnosis
    from network.analysis.sweep.sweep import Sweep
    from network.catalogue.declaration.declare import Array
    from network.engine.superposition.superposition import Superposition
    from network.engine.trajectory import Trajectory
    from network.machine.machine import Machine


def new_axes(axes: Axes | None) -> Axes:
    """Those given, else the only ones of a figure that a notebook shows."""
    if axes is not None:
        return axes
    from matplotlib import pyplot

    return pyplot.subplots(figsize=(WIDTH * 0.8, 3.6), layout="constrained")[1]


def plot_run(run: Trajectory, names: Sequence[str], axes: Axes | None) -> Axes:
    """Channels of one unit over time; without names the axes of the tool centre point, else temperatures."""
    usual = [axis for axis in run.tcp if axis_unit(axis) == axis_unit(next(iter(run.tcp)))]
    temperatures = [name for name, s in run.machine.sensors.items() if s.quantity == "temperature"]
    found = [run.find_column(name) for name in names or usual or temperatures or [*run.parts]]
    units = dict.fromkeys(text for _, text, _ in found)
    if len(units) > 1:
        wrong = f"{', '.join(name for name, *_ in found)} are in {' and '.join(units)}"
        raise refuse(Spot("plot"), wrong, "plot channels of one unit, others into other axes")
    drawn = new_axes(axes)
    for k, (name, _, values) in enumerate(found):
        _draw(drawn, run.t, values, k, name)
    return _finish(drawn, run.t, next(iter(units)), f"{run.machine.name}: {run.schedule.name}")


def plot_shares(shares: Superposition, names: Sequence[str], axes: Axes | None) -> Axes:
    """What each cause moved an axis since the start, and their sum in grey."""
    axis = _choose(names, shares.run.tcp)
    drawn, text = new_axes(axes), axis_unit(axis)
    for k, ((cause,), values) in enumerate(shares.sum_by(axis, "cause").items()):
        _draw(drawn, shares.run.t, in_own_unit(values - values[0], text), k, cause)
    whole = shares.run.tcp[axis]
    drawn.plot(shares.run.t / clock(shares.run.t)[1], in_own_unit(whole - whole[0], text), color=GREY, label="all")
    return _finish(drawn, shares.run.t, text, f"{shares.run.machine.name}: where {axis} comes from")


def plot_comparison(comparison: Comparison, names: Sequence[str], axes: Axes | None) -> Axes:
    """Measured (grey) and simulated; without a name the channel that is furthest off, on the recording where it is."""
    every = [(r, c) for r in comparison.recordings for c in r.channels.values() if c.n]
    name = _choose(names, dict.fromkeys(c.name for _, c in sorted(every, key=lambda rc: -rc[1].rmse_in_noise)))
    residual, channel = max((rc for rc in every if rc[1].name == name), key=lambda rc: rc[1].rmse_in_noise)
    drawn, length = new_axes(axes), clock(channel.t)[1]
    measured, simulated = (in_own_unit(v, channel.unit) for v in (channel.measured, channel.simulated))
    drawn.plot(channel.t / length, measured, ".", color=GREY, markersize=2, label=f"{name} measured")
    _draw(drawn, channel.t, simulated, 0, f"{name} simulated")
    told = f"{comparison.machine.name}: {title_of(residual.recording)}, rmse {channel.rmse_in_noise:.3g} σ"
    return _finish(drawn, channel.t, channel.unit, told)


def plot_calibration(calibration: Calibration, names: Sequence[str], axes: Axes | None) -> Axes:
    """The calibrated machine beside what was held out, else beside what it was calibrated on."""
    return plot_comparison(calibration.after_holdout or calibration.after, names, axes)


def plot_diagnosis(diagnosis: Diagnosis, names: Sequence[str], axes: Axes | None) -> Axes:
    """The machine with what was found beside what was held out, else beside what it was diagnosed on."""
    return plot_comparison(diagnosis.fits.holdout_after or diagnosis.fits.train_after, names, axes)


def plot_sweep(sweep: Sweep, names: Sequence[str], axes: Axes | None) -> Axes:
    """An axis at every level over time; or its largest value over the number that was varied."""
    tcp = sweep.finest.tcp if sweep.levels else sweep.runs[0].tcp
    axis, drawn = _choose(names, tcp), new_axes(axes)
    text = axis_unit(axis)
    if sweep.levels:
        for k, run in enumerate(run for run in sweep.levels if axis in run.tcp):
            _draw(drawn, run.t, in_own_unit(run.tcp[axis], text), k, f"{run.level} ({run.lumps} lumps)")
        return _finish(drawn, sweep.finest.t, text, f"{sweep.machine.name}: {sweep.source}, TCP {axis}")
    first = sweep.variations[0]
    highest = [run.tcp[axis].highest for run in sweep.runs]
    drawn.plot([run.values[0] for run in sweep.runs], highest, "o", color=look(0)[0])
    drawn.set(xlabel=f"{first.path} [{pretty(first.unit or '1')}]", ylabel=f"TCP {axis} max [{pretty(text)}]")
    return drawn


def plot_machine(machine: Machine, names: Sequence[str], axes: Axes | None) -> Axes:
    """The network: parts, held nodes, links as wide as they conduct."""
    from network.report.figures.network_figure import Picture

    picture, drawn = Picture(machine, None), new_axes(axes)
    left, right, bottom, top = picture.extent()
    drawn.set(xlim=(left, right), ylim=(bottom, top), title=name_text(machine.name, 70))
    drawn.axis("off")
    picture.draw(drawn)
    return drawn


def _choose(names: Sequence[str], known: Iterable[str]) -> str:
    """The one that is asked for, else the first. Raises UnknownName."""
    there = [*known]
    if len(names) > 1:
        raise refuse(Spot("plot"), f"{', '.join(names)} are {len(names)} names", "plot one at a time")
    wanted = names[0].removeprefix("tcp.") if names else there[0]
    if wanted not in there:
        raise UnknownName(f"there is no '{wanted}' to plot; {likely(wanted, there)}")
    return wanted


def _draw(axes: Axes, t: Array, values: Array, k: int, label: str) -> None:
    colour, dashes = look(k)
    name = name_text(label)
    axes.plot(t / clock(t)[1], np.asarray(values), color=colour, linestyle=dashes, linewidth=1.3, label=name)


def _finish(axes: Axes, t: Array, unit_text: str, title: str) -> Axes:
    axes.set(xlabel=f"time [{clock(t)[0]}]", ylabel=f"[{pretty(unit_text)}]")
    axes.set_title(name_text(title, 80), loc="left", fontsize="medium")
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small", frameon=False)
    return axes
