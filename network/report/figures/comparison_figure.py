"""Measured over simulated, channel by channel, and what is left in units of noise."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.platform.quantities.number_format import number, pretty
from network.platform.quantities.unit_values import in_own_unit
from network.platform.quantities.units import unit
from network.recordings.inputs import Signal
from network.report.figures.canvas import (
    FONT,
    GREY,
    INK,
    PALETTE,
    add_axes,
    gap_unit,
    headline,
    label_y,
    name_text,
    new_figure,
    write_title,
)
from network.report.figures.lines import alone, clock, outline, set_clock, thin, with_gaps
from network.report.figures.run_figure import is_speed
from network.report.figures.shown_inputs import choose_inputs
from network.report.words.recording_names import title_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from network.analysis.comparison.channel_residual import ChannelResidual
    from network.analysis.comparison.compare import RecordingResidual

LEFT, RIGHT = (0.75, 5.35), (6.85, 2.95)
"""Columns of channels and residuals: (left edge, width) in inches."""
POINTS = 2000
SIMULATED, RESIDUAL, BAND = PALETTE[0], PALETTE[1], PALETTE[2]
TIGHT = 8
"""More channels than this get lower rows."""


def comparison_figure(residual: RecordingResidual) -> Figure:
    """One row for each channel: measured (grey) over simulated (blue), beside it the residual with its ±2 σ band."""
    run, channels = residual.trajectory, list(residual.channels.values())
    row, gap, drivers = (1.15 if len(channels) <= TIGHT else 0.85), 0.36, choose_inputs(residual)
    figure = new_figure(0.62 + len(channels) * (row + gap) + (0.7 + gap) * len(drivers) + 0.25)
    high, panels = figure.get_size_inches()[1] - 0.62, []
    for channel in channels:
        high -= row + gap
        pair = [add_axes(figure, left, high, width, row) for left, width in (LEFT, RIGHT)]
        _draw_values(pair[0], channel, run.t)
        _draw_residual(pair[1], channel, run.t)
        panels += pair
    for driver in drivers:
        high -= 0.7 + gap
        pair = [add_axes(figure, left, high + gap * 0.3, width, 0.7) for left, width in (LEFT, RIGHT)]
        for axes in pair:
            draw_driver(axes, driver, run.t)
        panels += pair
    set_clock(panels, run.t, panels[-2:])
    what = "measured grey, simulated blue, residual in units of noise with ±2 σ shaded"
    told = f"{what}; all channels: rmse {residual.rmse_in_noise:.3g} σ"
    write_title(figure, f"{run.machine.name}: {title_of(residual.recording)}", told)
    return figure


def draw_driver(axes: Axes, signal: Signal, t: Array) -> None:
    shown = "rpm" if is_speed(signal) else signal.unit
    times, values = outline(signal, t)
    axes.plot(times / clock(t)[1], in_own_unit(values, shown), color=INK, linewidth=0.9)
    axes.margins(y=0.12)
    headline(axes, name_text(signal.name), GREY)
    label_y(axes, "", shown)


def _draw_values(axes: Axes, channel: ChannelResidual, t: Array) -> None:
    given = unit(channel.unit)
    draw_measured(axes, channel.t, in_own_unit(channel.measured, given), GREY, 0.9, clock(t)[1])
    times, values = thin(channel.t, in_own_unit(channel.simulated, given), POINTS)
    axes.plot(times / clock(t)[1], values, color=SIMULATED, linewidth=1.3)
    axes.margins(y=0.08)
    headline(axes, _describe_misfit(channel))
    label_y(axes, "", channel.unit)


def _describe_misfit(channel: ChannelResidual) -> str:
    name = name_text(channel.name)
    if not channel.n:
        return f"{name}: no readings"
    told = channel.summary()
    return f"{name}: rmse {channel.rmse_in_noise:.3g} σ ({number(told['rmse'], told['unit'], 3)})"


def draw_measured(axes: Axes, t: Array, values: Array, colour: str, width: float, length: float) -> None:
    """A line with its gaps; samples that stand alone as points."""
    times, readings = with_gaps(t, values)
    single = alone(readings)
    if single.any():
        points = thin(times[single], readings[single], POINTS)
        dots: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 1.8, "markeredgewidth": 0}
        axes.plot(points[0] / length, points[1], color=colour, **dots)
    if (np.isfinite(readings) & ~single).any():
        times, readings = thin(times, readings, POINTS)
        axes.plot(times / length, readings, color=colour, linewidth=width)


def _draw_residual(axes: Axes, channel: ChannelResidual, t: Array) -> None:
    axes.axhspan(-2, 2, color=BAND, alpha=0.18, linewidth=0)
    axes.axhline(0, color=GREY, linewidth=0.6)
    draw_measured(axes, channel.t, channel.in_noise, RESIDUAL, 0.7, clock(t)[1])
    ends = channel.in_noise[channel.finite] if channel.n else np.zeros(1)
    axes.set_ylim(min(float(ends.min()) * 1.08, -4.0), max(float(ends.max()) * 1.08, 4.0))
    noise = gap_unit(channel.unit)
    headline(axes, f"measured − simulated; σ = {noise.from_si(channel.sigma):.3g} {pretty(noise.text)}", GREY)
    axes.set_ylabel("[σ]", fontsize=FONT)
    axes.yaxis.set_label_coords(-0.42 / RIGHT[1], 0.5)
