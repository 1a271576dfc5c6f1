"""What the levels of a sweep miss and cost, over their number of lumps: two panels with logarithmic axes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from network.analysis.sweep.level_runs import LevelRun
from network.engine.trajectory import axis_unit
from network.platform.quantities.number_format import pretty
from network.platform.quantities.units import unit
from network.report.figures.canvas import FONT, GREY, INK, SMALL, headline, look, name_text
from network.report.words.sweep_words import lumps_of, pretty_quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from network.analysis.sweep.sweep import Sweep

APART = 1.25
"""Ratio of two numbers of lumps from which both are written at the axis."""
NOTHING = 1e-6
"""um or urad: a smaller difference is rounding and is not drawn."""


def draw_gaps(axes: Axes, sweep: Sweep) -> None:
    """The largest difference to the finest level, axis by axis; the tolerance as a line."""
    sizes = {axis: dict(_sizes(sweep, axis)) for axis in sweep.finest.tcp}
    for i, (axis, by_level) in enumerate(sizes.items()):
        _dots(axes, sweep, by_level, look(i)[0], f"TCP {axis}")
    _draw_tolerance(axes, sweep)
    found = {run.level: [by[run.level] for by in sizes.values() if run.level in by] for run in sweep.levels}
    _finish(axes, sweep, {level: max(some) for level, some in found.items() if some})
    units = " or ".join(dict.fromkeys(pretty(axis_unit(axis)) for axis in sizes))
    headline(axes, name_text(f"largest difference to {lumps_of(sweep.finest.level)} [{units}]", 60))
    if not any(sizes.values()):
        axes.text(0.5, 0.7, "none", transform=axes.transAxes, fontsize=FONT, color=INK, ha="center")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=SMALL, frameon=False, loc="best", handlelength=1.6)


def draw_times(axes: Axes, sweep: Sweep) -> None:
    """The time to solve."""
    times = {run.level: run.solve_seconds * 1e3 for run in sweep.levels}
    _dots(axes, sweep, times, INK, "")
    _finish(axes, sweep, times)
    headline(axes, "time to solve [ms]")


def _sizes(sweep: Sweep, axis: str) -> Iterator[tuple[str, float]]:
    for run in sweep.levels:
        gap = sweep.gap(run, axis)
        size = gap.largest / unit(axis_unit(axis)).scale if gap else 0.0
        if run is not sweep.finest and size > NOTHING:
            yield run.level, size


def _dots(axes: Axes, sweep: Sweep, values: Mapping[str, float], colour: str, label: str) -> None:
    """A point for each level; those with as many lumps in every bar are joined by a line."""
    runs = sorted((run for run in sweep.levels if run.level in values), key=lambda run: run.lumps)
    even = [run for run in runs if run.level.isdigit()]
    axes.plot(_lumps(even), [values[run.level] for run in even], color=colour, linewidth=1.2)
    axes.plot(_lumps(runs), [values[run.level] for run in runs], "o", color=colour, markersize=4, label=label or None)


def _lumps(runs: list[LevelRun]) -> list[int]:
    return [run.lumps for run in runs]


def _draw_tolerance(axes: Axes, sweep: Sweep) -> None:
    if sweep.tolerance is not None:
        scale = next(unit(axis_unit(axis)).scale for axis in sweep.finest.tcp if sweep.tolerance.concerns(axis))
        label = f"tolerance {pretty_quantity(sweep.tolerance.text)}"
        axes.axhline(sweep.tolerance.value / scale, color=GREY, linewidth=0.9, linestyle=(0, (6, 3)), label=label)


def _finish(axes: Axes, sweep: Sweep, highest: Mapping[str, float]) -> None:
    """Logarithmic axes, the numbers of lumps as ticks, and the level's name above its highest point; nothing can stand
    on a logarithmic axis where nothing is drawn."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    axes.set_xscale("log")
    axes.set_yscale("log" if highest else "linear")
    ticks = sorted({run.lumps for run in sweep.levels}, reverse=True)
    kept: list[int] = []
    for count in ticks:
        if not kept or kept[-1] / count > APART:
            kept.append(count)
    axes.set_xlim(min(ticks) / 1.35, max(ticks) * 1.35)
    axes.set_xticks(kept, [str(count) for count in kept])
    axes.xaxis.set_minor_locator(NullLocator())
    decades = LogLocator(numticks=6, subs=(1.0, 2.0, 5.0) if _narrow(highest) else (1.0,))
    axes.yaxis.set_major_locator(decades if highest else NullLocator())
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.margins(y=0.2)
    axes.set_xlabel("lumps in all", fontsize=FONT, labelpad=2)
    for run in sweep.levels:
        if run.level in highest:
            at = (run.lumps, highest[run.level])
            text: dict[str, Any] = {"ha": "center", "va": "bottom", "fontsize": SMALL, "color": INK}
            under = {"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.8}
            axes.annotate(name_text(run.level, 14), at, xytext=(0, 5), textcoords="offset points", bbox=under, **text)


def _narrow(values: Mapping[str, float]) -> bool:
    """Whether powers of ten alone would be too few ticks."""
    found = np.array([*values.values()] or [1.0])
    return bool(found.max() < 100 * found.min())
