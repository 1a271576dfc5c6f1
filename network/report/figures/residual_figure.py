"""Autocorrelation and spectrum of residuals before and after a calibration, against white noise."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from network.analysis.comparison.examine import rows_of
from network.analysis.comparison.periodicity import spectrum
from network.analysis.comparison.resample import Grid
from network.analysis.comparison.whiteness import Whiteness, whiteness
from network.catalogue.declaration.declare import Array, Indices
from network.platform.quantities.text_table import span
from network.report.figures.canvas import (
    FAINT,
    FONT,
    GREY,
    PALETTE,
    SMALL,
    add_axes,
    headline,
    name_text,
    new_figure,
    write_title,
)
from network.report.figures.lines import thin
from network.report.words.recording_names import title_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from network.analysis.comparison.channel_residual import ChannelResidual
    from network.analysis.comparison.compare import RecordingResidual

BEFORE, AFTER, BAND = PALETTE[1], PALETTE[0], PALETTE[2]
LEFT, RIGHT = (0.8, 3.95), (5.75, 4.0)
"""Columns of autocorrelation and spectrum: (left edge, width) [in]."""
ROW, GAP = 1.05, 0.36
STYLES: tuple[dict[str, Any], ...] = (
    {"color": BEFORE, "linestyle": (0, (5.0, 2.0)), "linewidth": 1.0}, {"color": AFTER, "linewidth": 1.2},
)  # fmt: skip
WIDER = 1.15
"""Frequencies are taken together in groups this much wider from one to the next."""


def residual_figure(before: RecordingResidual, after: RecordingResidual, side: str = "") -> Figure:
    """One row for each channel: autocorrelation over the lag, and power over the period, with the bands that hold 95 %
    of white noise: of any size on the left, of the declared size (1 σ²) on the right. side: which it was, calibrated on
    or held out."""
    names = [name for name, c in before.channels.items() if c.n and name in after.channels and after.channels[name].n]
    figure = new_figure(0.62 + max(len(names), 1) * (ROW + GAP) + 0.48)
    grid, high = Grid.of(after.trajectory.t), figure.get_size_inches()[1] - 0.62
    for name in names:
        high -= ROW + GAP
        pair = before.channels[name], after.channels[name]
        left, right = (add_axes(figure, edge, high, width, ROW) for edge, width in (LEFT, RIGHT))
        _draw_row(left, right, pair, grid, last=name == names[-1])
    what = "how long it stays alike, and its power by period; before orange, after blue; shaded: 95 % of white noise"
    title = f"{after.trajectory.machine.name}: {title_of(after.recording)}{f', {side}' if side else ''}: what is left"
    write_title(figure, title, what if names else "no readings")
    return figure


def _draw_row(lags: Axes, powers: Axes, pair: tuple[ChannelResidual, ChannelResidual], grid: Grid, last: bool) -> None:
    rows = rows_of(pair, grid)
    name, length = _clock(grid.step * rows.r.shape[1])
    band = 1.96 / np.sqrt(np.maximum(rows.pairs[1], 1))
    lag = np.arange(rows.r.shape[1], dtype=np.float64) * grid.step / length
    lags.fill_between(lag, -band, band, color=BAND, alpha=0.2, linewidth=0)
    for r, style in zip(rows.r, STYLES, strict=True):
        lags.plot(*thin(lag, r, 1500), **style)
    for values, there, style in zip(rows.values, rows.there, STYLES, strict=True):
        _draw_power(powers, values, there, grid, style)
    told = whiteness(pair[1], rows.values[1], rows.r[1], rows.pairs[1], grid.step)
    _finish_lags(lags, f"{name_text(pair[1].name)}: autocorrelation{_tell(told)}", name, last)
    _finish_powers(powers, grid, last)


def _tell(found: Whiteness | None) -> str:
    """What the test says of the residual after; nothing where there is too little to test."""
    if found is None:
        return ""
    return "; after: white noise" if found.is_white else f"; after: not white, lasts about {span(found.lasting)}"


def _finish_lags(axes: Axes, title: str, clock_name: str, last: bool) -> None:
    axes.axhline(0, color=GREY, linewidth=0.6)
    axes.set_ylim(-1.05, 1.05)
    axes.set_yticks([-1, 0, 1])
    axes.margins(x=0)
    headline(axes, title)
    axes.set_ylabel("r [–]", fontsize=FONT)
    axes.yaxis.set_label_coords(-0.42 / LEFT[1], 0.5)
    _label_x(axes, f"lag [{clock_name}]", last)


def _finish_powers(axes: Axes, grid: Grid, last: bool) -> None:
    clock_name, length = _clock(grid.step * grid.n)
    longest, shortest = grid.step * grid.n / length, 2 * grid.step / length
    axes.set(xscale="log", yscale="log")
    axes.set_xlim(longest, shortest)
    _fill_band(axes, grid, length)
    axes.axhline(1, color=GREY, linewidth=0.6)
    axes.xaxis.set_major_locator(_round_times(shortest, longest))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_locator(_nothing())
    axes.yaxis.set_major_locator(_decades())
    axes.yaxis.set_minor_locator(_nothing())
    axes.grid(True, axis="x", linewidth=0.4, color=FAINT)
    headline(axes, "power; 1 σ² is the declared noise", GREY)
    axes.set_ylabel("[σ²]", fontsize=FONT)
    axes.yaxis.set_label_coords(-0.46 / RIGHT[1], 0.5)
    _label_x(axes, f"period [{clock_name}]", last)


def _label_x(axes: Axes, text: str, last: bool) -> None:
    if last:
        axes.set_xlabel(text, fontsize=FONT, labelpad=2)
    axes.tick_params(axis="x", labelsize=SMALL, labelbottom=last)


def _clock(seconds: float) -> tuple[str, float]:
    """The unit of lags and periods: minutes rather than hours, for periods are mostly short."""
    return ("s", 1.0) if seconds < 600 else ("min", 60.0) if seconds < 48 * 3600 else ("h", 3600.0)


def _draw_power(axes: Axes, values: Array, there: Array, grid: Grid, style: dict[str, Any]) -> None:
    if values.any():
        power, first = spectrum(values, there), _groups(grid.n // 2)
        sizes = np.diff(first, append=len(power))
        mean = np.add.reduceat(power, first) / sizes
        axes.plot(grid.n * grid.step / _middle(first, sizes) / _clock(grid.step * grid.n)[1], mean, **style)


def _fill_band(axes: Axes, grid: Grid, length: float) -> None:
    """Means of m neighbours of a tapered periodogram are Gamma distributed with about m/1.94 degrees of freedom."""
    from scipy.special import gammaincinv

    first = _groups(grid.n // 2)
    sizes = np.diff(first, append=grid.n // 2)
    shape = sizes / (1 + 8 / 9 * (1 - 1 / sizes) + 1 / 18 * np.maximum(1 - 2 / sizes, 0))
    low, high = (gammaincinv(shape, p) / shape for p in (0.025, 0.975))
    period = grid.n * grid.step / _middle(first, sizes) / length
    axes.fill_between(period, low, high, color=BAND, alpha=0.2, linewidth=0)


def _groups(count: int) -> Indices:
    """First frequency of every group."""
    edges = np.unique(np.rint(WIDER ** np.arange(1 + int(np.log(max(count, 2)) / np.log(WIDER)))).astype(np.intp))
    return np.asarray(edges[edges <= count] - 1)


def _middle(first: Indices, sizes: Indices) -> Array:
    return np.asarray(first + (sizes + 1) / 2)


def _round_times(low: float, high: float) -> Any:
    from matplotlib.ticker import FixedLocator

    ticks = [m * 10.0**k for k in range(-3, 7) for m in (1, 3) if low <= m * 10.0**k <= high]
    return FixedLocator(ticks)


def _decades() -> Any:
    from matplotlib.ticker import LogLocator

    return LogLocator(numticks=5)


def _nothing() -> Any:
    from matplotlib.ticker import NullLocator

    return NullLocator()
