"""A sweep over values as a picture: extremes of the tool centre point over the varied number."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from network.analysis.sweep.grid_runs import VariedRun
from network.analysis.sweep.variations import Variation
from network.catalogue.declaration.declare import Array
from network.engine.trajectory import axis_unit
from network.platform.quantities.number_format import pretty
from network.report.figures.canvas import FONT, GREY, label_y, look, name_text, write_title
from network.report.figures.labels import label_ends
from network.report.figures.panels import Curve, Panel, draw_curves, lay_panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from network.analysis.sweep.sweep import Sweep

HEIGHT = 2.1
MOST_NAMED = 12
"""Curves with a name; of more, those in between are grey."""
MANY_POINTS = 40


def grid_figure(sweep: Sweep) -> Figure:
    """One number varied: the highest, lowest and final value of every TCP axis over it. Several: for every axis the
    value furthest from zero, and the final one, with a curve for every combination of the other numbers."""
    across = max(sweep.variations, key=lambda variation: len(variation.values))
    panels = list(_alone(sweep) if len(sweep.variations) == 1 else _together(sweep, across))
    figure, drawn = lay_panels(panels)
    for panel, axes in zip(panels, drawn, strict=True):
        draw_curves(axes, panel.curves, marker="o" if len(across.values) <= MANY_POINTS else "")
        if len(across.values) > 1:
            axes.set_xlim(min(across.values), max(across.values))
        label_ends(axes, panel.labels)
        label_y(axes, panel.quantity, panel.unit)
        axes.tick_params(labelbottom=axes is drawn[-1])
    drawn[-1].set_xlabel(_name_variation(across), fontsize=FONT, labelpad=2)
    others = ", ".join(_name_variation(variation) for variation in sweep.variations if variation is not across)
    told = f"curves: {others}" if others else f"{len(sweep.runs)} runs"
    write_title(figure, f"{sweep.machine.name}: {sweep.source}", told)
    return figure


def _name_variation(variation: Variation) -> str:
    return name_text(variation.path, 60) + (f" [{pretty(variation.unit)}]" if variation.unit else "")


def _alone(sweep: Sweep) -> Iterator[Panel]:
    x = np.array(sweep.variations[0].values)
    for axis in sweep.runs[0].tcp:
        extremes = [run.tcp[axis] for run in sweep.runs]
        rows = {
            "highest": [e.highest for e in extremes], "lowest": [e.lowest for e in extremes],
            "final": [e.final for e in extremes],
        }  # fmt: skip
        yield _panel(f"TCP {axis}", axis_unit(axis), {name: (x, np.array(row)) for name, row in rows.items()})


def _together(sweep: Sweep, across: Variation) -> Iterator[Panel]:
    groups = _groups(sweep, across)
    for axis in sweep.runs[0].tcp:
        for what in ("furthest", "final"):
            rows = {
                name: (np.array([*runs]), np.array([getattr(run.tcp[axis], what) for run in runs.values()]))
                for name, runs in groups.items()
            }
            yield _panel(f"{axis}, {what}", axis_unit(axis), rows)


def _groups(sweep: Sweep, across: Variation) -> dict[str, dict[float, VariedRun]]:
    """The values of the other numbers → value of the one across → run."""
    place, groups = sweep.variations.index(across), dict[str, dict[float, VariedRun]]()
    for run in sweep.runs:
        others = [(v, x) for k, (v, x) in enumerate(zip(sweep.variations, run.values, strict=True)) if k != place]
        name = ", ".join(f"{x:.4g} {pretty(v.unit) if v.unit else ''}".rstrip() for v, x in others)
        groups.setdefault(name, {})[run.values[place]] = run
    return {name: dict(sorted(runs.items())) for name, runs in groups.items()}


def _panel(quantity: str, unit_text: str, rows: Mapping[str, tuple[Array, Array]]) -> Panel:
    names = list(rows)
    chosen = dict.fromkeys(round(k) for k in np.linspace(0, len(names) - 1, min(len(names), MOST_NAMED)))
    quiet = [Curve(*rows[name], GREY, "solid", 0.4) for k, name in enumerate(names) if k not in chosen]
    curves = {names[k]: Curve(*rows[names[k]], *look(i)) for i, k in enumerate(chosen)}
    labels = [curve.label(name, unit_text) for name, curve in curves.items()]
    return Panel(quantity, unit_text, HEIGHT, [*quiet, *curves.values()], labels)
