"""Charts of runs: a simulation, measured beside simulated, before and after."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import count
from typing import TYPE_CHECKING

import numpy as np

from network.catalogue.expansions.base import ANGULAR_AXES
from network.engine.trajectory import Trajectory, axis_unit
from network.platform.quantities.unit_values import in_own_unit
from network.platform.quantities.units import unit
from network.report.figures.canvas import GREY, PALETTE
from network.report.figures.lines import outline
from network.report.pages.chart import Chart, Line, Plot
from network.report.words.recording_names import title_of

if TYPE_CHECKING:
    from network.analysis.comparison.channel_residual import ChannelResidual
    from network.analysis.comparison.compare import Comparison, RecordingResidual
    from network.catalogue.declaration.declare import Array
    from network.recordings.inputs import Signal

DASHES = ("", "7 3", "2 2", "7 3 2 3")
BEFORE, AFTER = PALETTE[1], PALETTE[0]


def look(i: int) -> tuple[str, str]:
    """Colour and dash of the i-th line; the first 24 differ."""
    return PALETTE[i % len(PALETTE)], DASHES[(i // len(PALETTE)) % len(DASHES)]


def chart_run(run: Trajectory) -> Chart:
    """Temperatures, displacements and inputs of a simulation."""
    return Chart(run.schedule.name, [*_plot_run(run)])


def _plot_run(run: Trajectory) -> Iterator[Plot]:
    number = count()
    sensed = {name: v for name, v in run.sensors.items() if run.machine.sensors[name].quantity == "temperature"}
    rows = sensed or {name: v for name, v in run.parts.items() if name in run.machine.nodes}
    if rows:
        yield Plot("temperature", "degC", [*draw_rows(run.t, rows, "degC", number)], 230)
    for title, is_angle in (("tool centre point", False), ("tool centre point, angle", True)):
        axes = {f"tcp.{axis}": v for axis, v in run.tcp.items() if (axis in ANGULAR_AXES) == is_angle}
        if axes:
            shown = axis_unit("a" if is_angle else "z")
            yield Plot(title, shown, [*draw_rows(run.t, axes, shown, number)], 180)
    yield from plot_inputs([run.schedule.signals[name] for name in run.inputs], run.t, number)


def draw_rows(t: Array, rows: Mapping[str, Array], shown: str, number: Iterator[int]) -> Iterator[Line]:
    for name, values in rows.items():
        yield Line(name, name, t, in_own_unit(values, shown), *look(next(number)))


def plot_inputs(signals: Sequence[Signal], t: Array, number: Iterator[int]) -> Iterator[Plot]:
    """Inputs by unit, jumps upright."""
    by_unit: dict[str, list[Signal]] = {}
    for signal in signals:
        by_unit.setdefault(signal.unit, []).append(signal)
    for shown, own in by_unit.items():
        outlines = [(signal.name, *outline(signal, t)) for signal in own]
        lines = [Line(name, name, at, in_own_unit(v, shown), *look(next(number)), sampled=False)
                 for name, at, v in outlines]  # fmt: skip
        yield Plot(" and ".join(signal.name for signal in own), shown, lines, 80)


def chart_comparison(after: RecordingResidual, before: RecordingResidual | None = None, name: str = "") -> Chart:
    """A plot for each channel: measured, and simulated; with `before`, both."""
    plots = [
        _plot_channel(channel, after.trajectory.t, None if before is None else before.channels.get(key))
        for key, channel in after.channels.items()
    ]
    run = after.trajectory
    inputs = plot_inputs([run.schedule.signals[name] for name in run.inputs], run.t, count())
    return Chart(name or title_of(after.recording), [*plots, *inputs])


def chart_fits(
    sides: Iterable[tuple[str, Comparison | None, Comparison | None]], name_of: Callable[[RecordingResidual], str]
) -> Iterator[Chart]:
    """Of every recording, before and after; sides: what became of some, like held out, where there are any."""
    for word, before, after in sides:
        if before is not None and after is not None:
            for b, a in zip(before.recordings, after.recordings, strict=True):
                yield chart_comparison(a, b, f"{name_of(a)}, {word}")


def _plot_channel(channel: ChannelResidual, t: Array, before: ChannelResidual | None) -> Plot:
    shown = unit(channel.unit)
    lines = [Line(channel.name, f"{channel.name} measured", t, in_own_unit(channel.measured, shown), GREY, "", 2.2)]
    if before is not None and not np.array_equal(before.simulated, channel.simulated, equal_nan=True):
        lines.append(Line(channel.name, "before", t, in_own_unit(before.simulated, shown), BEFORE, "6 3"))
    word = "simulated" if before is None else "after"
    lines.append(Line(channel.name, word, t, in_own_unit(channel.simulated, shown), AFTER))
    return Plot(channel.name, channel.unit, lines, 130)
