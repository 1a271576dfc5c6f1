"""One run over time: temperatures, the tool centre point, and what drove it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.expansions.base import ANGULAR_AXES
from network.engine.trajectory import Trajectory, axis_unit, drop_rounding
from network.platform.quantities.number_format import number
from network.platform.quantities.unit_values import in_own_unit
from network.platform.quantities.units import unit
from network.recordings.inputs import Signal
from network.report.figures.canvas import GREY, INK, PALETTE, look, new_figure, shorten, write_title
from network.report.figures.labels import EndLabel
from network.report.figures.lines import clock, decimate_together, outline
from network.report.figures.panels import Curve, Panel, Shade, draw_panels, panel_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from network.analysis.calibration.tcp_bands import Band

FEW = 3
"""Fewer temperature sensors than this: the parts are shown instead."""
MANY_SWITCHES = 60
POINTS = 1000


def run_figure(run: Trajectory, bands: Sequence[Band] = ()) -> Figure:
    """Temperatures, displacement and inputs of a run on one time axis; bands: of 95 %, shaded about their axes."""
    panels = list(_panels(run, bands))
    if not panels:
        return without_panels(run, "nothing to show: no temperatures, no tool centre point, no inputs")
    figure, axes = draw_panels(panels, run.t)
    _mark_switches(axes, run)
    below = [*_constants(run), *_describe_switches(run)] or [f"{len(run.t)} instants, method {run.method}"]
    write_title(figure, title(run), "; ".join(below))
    return figure


def title(run: Trajectory) -> str:
    return f"{run.machine.name}: {run.schedule.name}"


def without_panels(run: Trajectory, why: str) -> Figure:
    """The title, and why there is nothing below it."""
    figure = new_figure(1.2)
    write_title(figure, title(run), why)
    return figure


# -- panels of a run ------------------------------------------------------------------------------------------------
def _panels(run: Trajectory, bands: Sequence[Band] = ()) -> Iterator[Panel]:
    temperatures = _temperatures(run)
    if temperatures:
        yield panel_of("temperature", "degC", 2.9, temperatures, run.t)
    for quantity, angular, height in (("TCP displacement", False, 2.1), ("TCP angle", True, 1.6)):
        own = {a: drop_rounding(v) for a, v in run.tcp.items() if (a in ANGULAR_AXES) == angular}
        rows = {a: in_own_unit(v, axis_unit(a)) for a, v in own.items()}
        if rows:
            shown = "urad" if angular else "um"
            yield _shaded(panel_of(quantity, shown, height, rows, run.t), run, [b for b in bands if b.axis in rows])
    for shown, signals in _drivers(run).items():
        yield input_panel(signals, shown, run.t)


def _shaded(panel: Panel, run: Trajectory, bands: Sequence[Band]) -> Panel:
    """The panel with bands behind its curves, and their name below those of the curves."""
    shades, axes = [], [axis for axis in run.tcp if (axis in ANGULAR_AXES) == (panel.unit == "urad")]
    for band in bands:
        index = decimate_together(run.t, limits := [*band.limits(run.t, run.tcp[band.axis])], POINTS)
        low, high = (in_own_unit(v[index], band.unit) for v in limits)
        shades.append(Shade(run.t[index], low, high, look(axes.index(band.axis))[0]))
    if not shades:
        return panel
    named = EndLabel(float("nan"), "shaded: 95 %", shades[0].colour, "solid", 4.0)
    return replace(panel, shades=shades, labels=[*panel.labels, named])


def _temperatures(run: Trajectory) -> Mapping[str, Array]:
    """The temperature sensors; the parts where there are few of them."""
    nodes = run.machine.nodes
    sensors = {name: v for name, v in run.sensors.items() if run.machine.sensors[name].quantity == "temperature"}
    parts = {name: v for name, v in run.parts.items() if name in nodes and not nodes[name].is_held}
    return parts if len(sensors) < FEW and len(parts) > len(sensors) else sensors


def _drivers(run: Trajectory) -> dict[str, list[Signal]]:
    """Inputs by unit: the speed always and first, others where they vary."""
    by_unit: dict[str, list[Signal]] = {}
    for name, values in run.inputs.items():
        signal = run.schedule.signals[name]
        if is_speed(signal):
            by_unit.setdefault("rpm", []).append(signal)
        elif not _is_level(values):
            by_unit.setdefault(signal.unit, []).append(signal)
    return dict(sorted(by_unit.items(), key=lambda item: item[0] != "rpm"))


def is_speed(signal: Signal) -> bool:
    return signal.name == "speed" and signal.dimension == unit("rpm").dimension


def _is_level(values: Array) -> bool:
    return not len(values) or bool(np.ptp(values) <= 1e-9 * (1 + np.abs(values).max()))


def input_panel(signals: Sequence[Signal], shown: str, t: Array) -> Panel:
    """Inputs that share a unit, with their jumps."""
    curves = {}
    for i, signal in enumerate(signals):
        times, values = outline(signal, t)
        style = (INK, "solid") if len(signals) == 1 else look(i)
        curves[signal.name] = Curve(times, in_own_unit(values, shown), *style, 1.0)
    quantity = shorten(signals[0].name, 14) if len(signals) == 1 else "inputs"
    labels = [curve.label(name, shown) for name, curve in curves.items()]
    return Panel(quantity, shown, 1.0, [*curves.values()], labels, from_zero=shown == "rpm")


def _constants(run: Trajectory) -> Iterator[str]:
    for name, values in run.inputs.items():
        signal = run.schedule.signals[name]
        if not is_speed(signal) and _is_level(values) and len(values):
            yield f"{shorten(name)} {number(unit(signal.unit).from_si(float(values[0])), signal.unit)} throughout"


# -- relays ---------------------------------------------------------------------------------------------------------
def _describe_switches(run: Trajectory) -> Iterator[str]:
    for name in dict.fromkeys(name for _, name, _ in run.switches):
        count = sum(1 for _, source, _ in run.switches if source == name)
        yield f"{shorten(name)} switches {'once' if count == 1 else f'{count} times'} (marks: on blue, off grey)"


def _mark_switches(panels: Sequence[Axes], run: Trajectory) -> None:
    """Faint lines, on blue and off grey; many of them only as a rim of the first panel."""
    many = len(run.switches) > MANY_SWITCHES
    for on, colour in ((True, PALETTE[0]), (False, GREY)):
        at = [t / clock(run.t)[1] for t, _, mode in run.switches if mode is on]
        for axes in panels[:1] if many else panels:
            across, height = axes.get_xaxis_transform(), 0.05 if many else 1.0
            axes.vlines(at, 0, height, transform=across, color=colour, alpha=0.4, linewidth=0.5, zorder=0.5)
