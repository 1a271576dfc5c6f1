"""A chart drawn as SVG: what stands in a page until its script draws it anew, and all there is without JavaScript."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from markupsafe import Markup

from network.catalogue.declaration.declare import Array
from network.report.figures.lines import time_ticks
from network.report.pages.chart import DRAWN, Chart, Line, Plot, list_points

WIDTH, LEFT, RIGHT, TOP, GAP, FOOT = 960, 66, 12, 20, 12, 34
"""Of the drawing and its margins [px]; chart.js has the same."""


def draw_chart(chart: Chart, most: int = DRAWN) -> Markup:
    """The SVG, its names escaped, its lines of so many points."""
    height = sum(TOP + plot.height + GAP for plot in chart.plots) + FOOT
    parts = [Markup('<svg class="drawing" viewBox="0 0 {} {}" role="img" aria-label="{}">').format(
        WIDTH, height, f"{chart.name}: {', '.join(plot.label for plot in chart.plots)}")]  # fmt: skip
    top = 0
    for plot in chart.plots:
        parts += [*_draw_plot(chart, plot, top + TOP, most)]
        top += TOP + plot.height + GAP
    return Markup("").join([*parts, *_draw_clock(chart, top), Markup("</svg>")])


def _draw_plot(chart: Chart, plot: Plot, top: int, most: int) -> Iterator[Markup]:
    yield Markup('<text class="label" x="{}" y="{}">{}</text>').format(LEFT, top - 6, plot.label)
    low, high = find_range(plot.lines)
    for tick in find_ticks(low, high):
        y = top + plot.height * (high - tick) / (high - low)
        yield Markup('<line class="grid" x1="{}" x2="{}" y1="{:.1f}" y2="{:.1f}"/>').format(LEFT, WIDTH - RIGHT, y, y)
        told = f"{tick:.6g}".replace("-", "−")
        yield Markup('<text class="tick" x="{}" y="{:.1f}" text-anchor="end">{}</text>').format(LEFT - 6, y + 4, told)
    for line in plot.lines:
        yield _draw_line(chart, line, list_points(line, most), (top, plot.height), (low, high))


def _draw_line(
    chart: Chart, line: Line, points: tuple[Array, Array], place: tuple[int, int], ends: tuple[float, float]
) -> Markup:
    (t, values), (top, height), (low, high), (first, last) = points, place, ends, chart.span
    x = LEFT + (WIDTH - LEFT - RIGHT) * (t - first) / max(last - first, 1e-9)
    y = top + height * (high - values) / (high - low)
    shape = Markup('<path class="line" d="{}" stroke="{}" stroke-width="{}" stroke-dasharray="{}"/>')
    return shape.format(write_path(x, y), line.colour, line.width, line.dash or "none")


def write_path(x: Array, y: Array) -> str:
    """Points as a path, broken where there is none."""
    words, pen = [], "M"
    for a, b in zip(x.tolist(), y.tolist(), strict=True):
        if not (np.isfinite(a) and np.isfinite(b)):
            pen = "M"
            continue
        words.append(f"{pen}{a:.1f} {b:.1f}")
        pen = "L"
    return "".join(words)


def _draw_clock(chart: Chart, top: int) -> Iterator[Markup]:
    name, length = chart.clock
    first, last = (end / length for end in chart.span)
    for tick in time_ticks(first, max(last, first + 1e-9), name):
        x = LEFT + (WIDTH - LEFT - RIGHT) * (tick - first) / max(last - first, 1e-9)
        yield Markup('<line class="grid" x1="{:.1f}" x2="{:.1f}" y1="{}" y2="{}"/>').format(x, x, TOP, top - GAP)
        yield Markup('<text class="tick" x="{:.1f}" y="{}" text-anchor="middle">{:.6g}</text>').format(x, top + 6, tick)
    yield Markup('<text class="tick" x="{}" y="{}" text-anchor="end">time [{}]</text>').format(
        WIDTH - RIGHT, top + 24, name
    )


def find_range(lines: Sequence[Line]) -> tuple[float, float]:
    """Lowest and highest value of some lines, with a little room."""
    values = np.concatenate([line.values[np.isfinite(line.values)] for line in lines] or [np.zeros(1)])
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    room = 0.04 * (high - low) or 0.05 * abs(high) or 0.5
    return low - room, high + room


def find_ticks(low: float, high: float, most: int = 5) -> list[float]:
    """Round values from low to high, at most so many."""
    rough = (high - low) / most
    decade = 10.0 ** np.floor(np.log10(rough))
    step = next(float(s * decade) for s in (1, 2, 5, 10) if s * decade >= rough * (1 - 1e-9))
    return [i * step for i in range(int(np.ceil(low / step)), int(np.floor(high / step)) + 1)]
