"""Unknown heat over time, with its uncertainty, above the inputs of every recording."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from network.catalogue.declaration.declare import Array
from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import span
from network.platform.quantities.unit_values import in_own_unit
from network.recordings.inputs import Signal
from network.report.figures.canvas import (
    FONT,
    GREY,
    INK,
    PALETTE,
    WIDTH,
    add_axes,
    gap_unit,
    headline,
    label_y,
    name_text,
    new_figure,
    size_of,
    write_title,
)
from network.report.figures.lines import clock, outline, set_clock
from network.report.figures.run_figure import is_speed
from network.report.figures.shown_inputs import followed_inputs, rank_inputs
from network.report.words.finding_words import percent
from network.report.words.heat_words import is_named, suspects_of, unit_of
from network.report.words.recording_names import name_recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from network.analysis.comparison.compare import RecordingResidual
    from network.analysis.diagnosis.findings.result import Diagnosis
    from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat

COLOURS = (PALETTE[1], PALETTE[0], PALETTE[2])
MOST_PLACES, MOST_RUNS, MOST_INPUTS = 3, 4, 3
ROW, INPUT, GAP, BETWEEN = 1.35, 0.62, 0.42, 0.3
"""Heights of a place and of an input, gaps below and beside [in]."""
LEFT, TOP, BOTTOM = 0.8, 0.82, 0.3


def heat_figure(d: Diagnosis) -> Figure:
    """One column for each recording: the heat that the most probable places would need (±2 standard deviations), and
    below it the inputs that vary."""
    places, runs = suspects_of(d, MOST_PLACES), choose_runs(d)
    recordings = [d.fits.train_before.recordings[i] for i in runs]
    inputs = choose_inputs_of(d, recordings)
    rows = [ROW] * len(places) + [INPUT] * len(inputs)
    figure = new_figure(TOP + sum(rows) + GAP * len(rows) + BOTTOM)
    panels = [_column(figure, rows, k, len(runs)) for k in range(len(runs))]
    longest = max((r.trajectory.t for r in recordings), key=lambda t: float(t[-1] - t[0]))
    for column, i, recording in zip(panels, runs, recordings, strict=True):
        _fill(d, column, places, i, recording, inputs, longest)
    for row in range(len(rows)):
        _share_scale([column[row] for column in panels])
    for row, place in enumerate(places):
        headline(panels[0][row], _describe_heat(d, place))
        label_y(panels[0][row], place.quantity, _unit(d, place))
    below = "what each place would need to agree with the recordings, nothing added; shaded ±2 σ"
    if is_named(d):
        below = "what its place lacked before it was added; shaded ±2 σ"
    write_title(figure, f"{d.machine.name}: {_kinds(places)}", f"{below}; {_describe_resolution(d, places)}")
    return figure


def _kinds(places: Sequence[UnknownHeat]) -> str:
    """What is shown: heat, temperatures of surroundings, offsets of channels."""
    words = {"offset": "offset of a channel", "temperature": "temperature of surroundings"}
    what = {words.get(place.quantity, place.quantity) for place in places}
    return f"unknown {' or '.join(sorted(what))}"


def _describe_resolution(d: Diagnosis, places: Sequence[UnknownHeat]) -> str:
    """How far apart its values lie, and what of the findings is too quick for that."""
    step = max((float(np.median(np.diff(t))) for place in places for t in place.t if len(t) > 1), default=0.0)
    periods = [f.parameters["period"].value for f in d.findings if "period" in f.parameters]
    quick = [span(p) for p in periods if p < 2 * step]
    return f"a value every {span(step)}" + (f", too coarse for a period of {quick[0]}" if quick else "")


def choose_runs(d: Diagnosis) -> list[int]:
    """The recordings in which most is unaccounted for, in their order."""
    count = len(d.fits.train_before.recordings)
    size = [sum(float(np.sum(u.heat[i] ** 2)) * u.probability for u in d.located) for i in range(count)]
    return sorted(sorted(range(count), key=lambda i: -size[i])[:MOST_RUNS])


def choose_inputs_of(d: Diagnosis, recordings: Sequence[RecordingResidual]) -> list[str]:
    """What the findings read, then what residuals follow, then what varies, speeds first."""
    paths = [path for f in d.findings for path, _ in f.patch.entries() if path in d.after.by_path]
    return order_inputs([name for path in paths for name in d.after.by_path[path].needs()], recordings)


def order_inputs(read: Sequence[str], recordings: Sequence[RecordingResidual]) -> list[str]:
    """As many as are drawn: those that are read first."""
    moving = rank_inputs(recordings)
    known = [name for name in followed_inputs(recordings) if name in moving]
    return list(dict.fromkeys([*(name for name in read if name in moving), *known, *moving]))[:MOST_INPUTS]


def _column(figure: Figure, rows: Sequence[float], k: int, of: int) -> list[Axes]:
    width = (WIDTH - LEFT - 0.25 - BETWEEN * (of - 1)) / of
    high = figure.get_size_inches()[1] - TOP
    column = []
    for row in rows:
        high -= row + GAP
        column.append(add_axes(figure, LEFT + k * (width + BETWEEN), high + GAP * 0.4, width, row))
    return column


def _fill(
    d: Diagnosis, column: list[Axes], places: Sequence[UnknownHeat], i: int, recording: RecordingResidual,
    inputs: Sequence[str], longest: Array,
) -> None:  # fmt: skip
    t, length = recording.trajectory.t, clock(longest)[1]
    for axes, place, colour in zip(column, places, COLOURS, strict=False):
        _draw_heat(axes, place.t[i], place.heat[i], place.std[i], gap_unit(_unit(d, place)).scale, colour, length)
    signals = recording.trajectory.schedule.signals
    for axes, name in zip(column[len(places) :], inputs, strict=True):
        if name in signals:
            _draw_input(axes, signals[name], t, length, first=axes.get_position().x0 < 0.1)
    above = 1 + 0.24 / size_of(column[0])[1]
    name = name_text(name_recording(d, recording))
    column[0].text(0, above, name, transform=column[0].transAxes, fontsize=FONT, fontweight="bold", color=GREY)
    set_clock(column, t, unit_of=longest)


def _draw_heat(axes: Axes, t: Array, heat: Array, std: Array, scale: float, colour: str, length: float) -> None:
    axes.axhline(0, color=GREY, linewidth=0.6)
    low, high = (heat - 2 * std) / scale, (heat + 2 * std) / scale
    axes.fill_between(t / length, low, high, color=colour, alpha=0.22, linewidth=0)
    axes.plot(t / length, heat / scale, color=colour, linewidth=1.3)


def _draw_input(axes: Axes, signal: Signal, t: Array, length: float, first: bool) -> None:
    shown = "rpm" if is_speed(signal) else signal.unit
    times, values = outline(signal, t)
    axes.plot(times / length, in_own_unit(values, shown), color=INK, linewidth=0.9)
    axes.margins(y=0.12)
    if first:
        label_y(axes, name_text(signal.name, 12), shown)


def _share_scale(row: Sequence[Axes]) -> None:
    """One scale for all recordings: sizes are to be compared."""
    ends = np.array([axes.get_ylim() for axes in row])
    for axes in row:
        axes.set_ylim(float(ends[:, 0].min()), float(ends[:, 1].max()))
        axes.tick_params(axis="y", labelleft=axes is row[0])


def _describe_heat(d: Diagnosis, u: UnknownHeat) -> str:
    what = {"node": "heat into", "link": "heat from", "channel": "offset of", "surroundings": "another temperature of"}[
        u.at.kind
    ]
    size = u.rms / gap_unit(_unit(d, u)).scale
    told = f"{what} {name_text(str(u.at))}: rms {size:.3g} {pretty(gap_unit(_unit(d, u)).text)}"
    share = f"; if it all sits at one place, {percent(u.probability)} for this one"
    return told if is_named(d) else f"{told}{share}"


def _unit(d: Diagnosis, u: UnknownHeat) -> str:
    given = unit_of(d, u)
    return "K" if given == "degC" else given
