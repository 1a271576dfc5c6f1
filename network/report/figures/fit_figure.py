"""Before and after a calibration: measured over simulated, and what is left in units of noise."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from network.catalogue.declaration.declare import Array
from network.platform.quantities.number_format import number, pretty
from network.platform.quantities.text_table import digits
from network.platform.quantities.unit_values import in_own_unit
from network.platform.quantities.units import unit
from network.report.figures.canvas import (
    FONT,
    GREY,
    PALETTE,
    Dashes,
    add_axes,
    gap_unit,
    headline,
    label_y,
    name_text,
    new_figure,
    write_title,
)
from network.report.figures.comparison_figure import draw_driver, draw_measured
from network.report.figures.lines import clock, set_clock, thin
from network.report.figures.shown_inputs import choose_inputs

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from network.analysis.comparison.channel_residual import ChannelResidual
    from network.analysis.comparison.compare import RecordingResidual

BEFORE, AFTER, BAND = PALETTE[1], PALETTE[0], PALETTE[2]
HEIGHTS = (1.75, 1.35, 1.1)
"""Of the rows of the two channels worst before, of the next two, of the others [in]."""
LARGER = 1.35
LEFT, RIGHT, GAP, DRIVER = (0.8, 5.3), (6.9, 2.9), 0.36, 0.6
"""Columns of values and residuals: (left edge, width); between rows; height of the input below [in]."""
LINEAR = 5.0
"""Residuals are drawn to the logarithm beyond this many σ where any exceeds four times as many."""
POINTS = 2000


def fit_figure(before: RecordingResidual, after: RecordingResidual, title: str, large: bool = False) -> Figure:
    """One row for each channel, the worst before first and highest: measured grey, simulated before (orange, dashed)
    and after (blue), beside it both residuals with the ±2 σ band. large: for the recording that was held out."""
    pairs = sorted(_pairs(before, after), key=lambda pair: -_size(pair[0]))
    heights = [_height(place) * (LARGER if large else 1.0) for place in range(len(pairs))]
    drivers = choose_inputs(before)
    figure = new_figure(0.62 + sum(heights) + GAP * len(pairs) + (DRIVER + GAP) * len(drivers) + 0.3)
    t, high = after.trajectory.t, figure.get_size_inches()[1] - 0.62
    panels: list[Axes] = []
    for pair, height in zip(pairs, heights, strict=True):
        high -= height + GAP
        panels += _row(figure, high, height, pair, t)
    for driver in drivers:
        high -= DRIVER + GAP
        for left, width in (LEFT, RIGHT):
            panels.append(add_axes(figure, left, high + GAP * 0.3, width, DRIVER))
            draw_driver(panels[-1], driver, t)
    set_clock(panels, t, panels[-2:])
    write_title(figure, title, _describe_misfits(before, after))
    return figure


def _pairs(before: RecordingResidual, after: RecordingResidual) -> list[tuple[ChannelResidual, ChannelResidual]]:
    return [(channel, after.channels[name]) for name, channel in before.channels.items() if name in after.channels]


def _size(channel: ChannelResidual) -> float:
    return channel.rmse_in_noise if channel.n else 0.0


def _height(place: int) -> float:
    return HEIGHTS[min(place // 2, len(HEIGHTS) - 1)]


def _describe_misfits(before: RecordingResidual, after: RecordingResidual) -> str:
    rmse = f"all channels: rmse {_two(before.rmse_in_noise, after.rmse_in_noise)} σ"
    lines = "blue" if is_same(before, after) else "before orange, after blue"
    return f"{rmse}; measured grey, simulated {lines}; ±2 σ of noise shaded"


def is_same(before: RecordingResidual, after: RecordingResidual) -> bool:
    """Whether nothing was changed between the two."""
    pairs = _pairs(before, after)
    return all(b is a or np.array_equal(b.simulated, a.simulated, equal_nan=True) for b, a in pairs)


def _two(before: float, after: float) -> str:
    """Before → after; once where both are the same."""
    low, high = digits(before, 3), digits(after, 3)
    return low if before == after else f"{low} → {high}"


def _row(
    figure: Figure, bottom: float, height: float, pair: tuple[ChannelResidual, ChannelResidual], t: Array
) -> Sequence[Axes]:
    values, residuals = (add_axes(figure, left, bottom, width, height) for left, width in (LEFT, RIGHT))
    _draw_values(values, pair, clock(t)[1])
    _draw_residuals(residuals, pair, clock(t)[1])
    return values, residuals


def _draw_values(axes: Axes, pair: tuple[ChannelResidual, ChannelResidual], length: float) -> None:
    given = unit(pair[1].unit)
    draw_measured(axes, pair[1].t, in_own_unit(pair[1].measured, given), GREY, 0.9, length)
    for channel, colour, dashes, width in _lines(pair):
        times, values = thin(channel.t, in_own_unit(channel.simulated + _find_shift(channel, pair[1]), given), POINTS)
        axes.plot(times / length, values, color=colour, linestyle=dashes, linewidth=width)
    axes.margins(y=0.08)
    headline(axes, _change(*pair))
    label_y(axes, "", pair[1].unit)


def _find_shift(channel: ChannelResidual, shown: ChannelResidual) -> float:
    """By how much the readings that are drawn lie above those that a channel was compared with: each is less the
    constant error of its own sensor."""
    if channel.measured.shape != shown.measured.shape:
        return 0.0
    apart = shown.measured - channel.measured
    return float(np.median(apart[np.isfinite(apart)])) if np.isfinite(apart).any() else 0.0


def _lines(pair: tuple[ChannelResidual, ChannelResidual]) -> list[tuple[ChannelResidual, str, Dashes, float]]:
    """(channel, colour, dashes, width) before and after; only after where both are the same."""
    both: list[tuple[ChannelResidual, str, Dashes, float]] = [
        (pair[0], BEFORE, (0, (5.0, 2.0)), 1.0), (pair[1], AFTER, "solid", 1.3),
    ]  # fmt: skip
    return both[1:] if np.array_equal(pair[0].simulated, pair[1].simulated, equal_nan=True) else both


def _change(before: ChannelResidual, after: ChannelResidual) -> str:
    name = name_text(after.name)
    if not after.n:
        return f"{name}: no readings"
    first, last = before.summary(), after.summary()
    absolute = number(last["rmse"], last["unit"], 3)
    if first["rmse"] != last["rmse"]:
        absolute = f"{number(first['rmse'], '1', 3)} → {absolute}"
    return f"{name}: rmse {_two(before.rmse_in_noise, after.rmse_in_noise)} σ ({absolute})"


def _draw_residuals(axes: Axes, pair: tuple[ChannelResidual, ChannelResidual], length: float) -> None:
    axes.axhspan(-2, 2, color=BAND, alpha=0.18, linewidth=0)
    axes.axhline(0, color=GREY, linewidth=0.6)
    for channel, colour, _, _ in _lines(pair):
        draw_measured(axes, channel.t, channel.in_noise, colour, 0.7, length)
    steep = _set_scale(axes, np.concatenate([c.in_noise[c.finite] for c in pair]))
    noise = gap_unit(pair[1].unit)
    told = f"residual; σ = {noise.from_si(pair[1].sigma):.3g} {pretty(noise.text)}"
    headline(axes, told + (f"; log beyond ±{LINEAR:g}" if steep else ""), GREY)
    axes.set_ylabel("[σ]", fontsize=FONT)
    axes.yaxis.set_label_coords(-0.46 / RIGHT[1], 0.5)


def _set_scale(axes: Axes, values: Array) -> bool:
    """Limits around the values; whether far ones are drawn to the logarithm."""
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)
    steep = max(-low, high) > 4 * LINEAR
    if steep:
        from matplotlib.ticker import FixedLocator, NullLocator, ScalarFormatter

        axes.set_yscale("symlog", linthresh=LINEAR, linscale=0.8)
        axes.yaxis.set_major_locator(FixedLocator(_ticks(max(-low, high))))
        axes.yaxis.set_major_formatter(ScalarFormatter())
        axes.yaxis.set_minor_locator(NullLocator())
    axes.set_ylim(min(low * (1.3 if steep else 1.08), -4.0), max(high * (1.3 if steep else 1.08), 4.0))
    return steep


def _ticks(most: float) -> list[float]:
    """0, ±5 and the largest of 20, 50, 100, 200 … that is reached."""
    far = max(m * 10.0**k for k in range(12) for m in (1, 2, 5) if m * 10.0**k <= max(most, 4 * LINEAR))
    return [-far, -LINEAR, 0.0, LINEAR, far]
