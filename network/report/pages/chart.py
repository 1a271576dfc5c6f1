"""A chart as data: lines over time in plots below each other, one chart a run. Drawn by chart_svg and chart.js."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.platform.quantities.number_format import pretty
from network.report.figures.lines import clock, thin, with_gaps

POINTS = 600
"""Of a line as data: zooming in tenfold still shows its course."""
DRAWN = 300
"""Of a line as it is drawn without the script."""
ON_A_PAGE, LEAST = 50_000, 40
"""Points of all lines of a page, some 800 kB, and the fewest of one line: many runs of many channels are coarser."""
DIGITS = 4
"""Of a value, in the range of its line: a ten-thousandth of it shows."""


@dataclass(frozen=True, eq=False)
class Line:
    """Values in their shown unit over t [s]; key: what it is switched on and off by; dash: as SVG writes it.

    sampled: a step of time much longer than the others is a pause (of an input only the corners are given).
    """

    key: str
    name: str
    t: Array
    values: Array
    colour: str
    dash: str = ""
    width: float = 1.4
    sampled: bool = True


@dataclass(frozen=True)
class Plot:
    """Lines that share an axis."""

    title: str
    unit: str
    lines: Sequence[Line]
    height: int = 150

    @property
    def label(self) -> str:
        return f"{self.title} [{pretty(self.unit)}]" if self.unit not in ("", "1") else self.title


@dataclass(frozen=True)
class Chart:
    """One run. name: of the run; plots: on one clock."""

    name: str
    plots: Sequence[Plot]

    @property
    def span(self) -> tuple[float, float]:
        """First and last instant [s]."""
        ends = [(float(line.t[0]), float(line.t[-1])) for plot in self.plots for line in plot.lines if len(line.t)]
        return min((a for a, _ in ends), default=0.0), max((b for _, b in ends), default=1.0)

    @property
    def clock(self) -> tuple[str, float]:
        """Unit of its time axis, and that in seconds."""
        return clock(np.array(self.span))

    @property
    def keys(self) -> dict[str, tuple[str, str]]:
        """What can be switched, with colour and dash of its first line; no colour where several lines are one."""
        found: dict[str, tuple[str, str]] = {}
        for line in (line for plot in self.plots for line in plot.lines):
            found[line.key] = (line.colour, line.dash) if line.key not in found else ("", "")
        return found


def list_points(line: Line, most: int = POINTS) -> tuple[Array, Array]:
    """A line thinned to what shows, NaN where it pauses."""
    return thin(*(with_gaps(line.t, line.values) if line.sampled else (line.t, line.values)), most)


def share_points(charts: Sequence[Chart]) -> tuple[int, int]:
    """Points of a line, as data and as drawn, where a page has so many lines."""
    lines = sum(len(plot.lines) for chart in charts for plot in chart.plots)
    most = min(max(ON_A_PAGE // max(lines, 1), LEAST), POINTS)
    return most, min(DRAWN, most)


def tell_chart(chart: Chart, most: int = POINTS) -> str:
    """The chart as JSON that may stand in a page: no character of it ends a script or begins a tag."""
    name, length = chart.clock
    first, last = chart.span
    body = {
        "clock": name, "start": first / length, "end": max(last / length, first / length + 1e-9),
        "plots": [_describe_plot(plot, length, most) for plot in chart.plots],
    }  # fmt: skip
    text = json.dumps(body, ensure_ascii=True, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _describe_plot(plot: Plot, length: float, most: int) -> dict[str, Any]:
    return {"label": plot.label, "unit": pretty(plot.unit), "height": plot.height,
            "lines": [_describe_line(line, length, most) for line in plot.lines]}  # fmt: skip


def _describe_line(line: Line, length: float, most: int) -> dict[str, Any]:
    t, values = list_points(line, most)
    return {
        "key": line.key, "name": line.name, "colour": line.colour, "dash": line.dash, "width": line.width,
        "t": [*_shorten(t / length)], "v": [*_shorten(values)],
    }  # fmt: skip


def _shorten(values: Array) -> Iterator[float | None]:
    """Rounded to what shows; None for what is not there."""
    there = values[np.isfinite(values)]
    size = (float(np.ptp(there)) or float(np.abs(there).max()) if len(there) else 0.0) or 1.0
    places = DIGITS - int(np.floor(np.log10(size)))
    for value in np.round(values, max(places, 0)).tolist():
        yield None if not np.isfinite(value) else int(value) if value == int(value) else value
