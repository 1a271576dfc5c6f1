"""The trade of a warm-up: minutes against what then still moves, for every speed, with the tolerance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from network.platform.quantities.number_format import pretty
from network.report.figures.canvas import FONT, GREY, INK, SMALL, label_y, look, stack_panels, write_title
from network.report.figures.labels import EndLabel, label_ends
from network.report.figures.panels import beside
from network.report.words.warm_up_words import name_speed, tell_warm_up

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from network.analysis.sweep.warm_up import WarmUp


def warm_up_figure(found: WarmUp) -> Figure:
    """Dots where a warm-up was tried, a ring where the shortest is that serves."""
    shown, limit = found.tolerance.unit, found.tolerance.unit.from_si(found.tolerance.value)
    labels = []
    for i, attempt in enumerate(found.attempts):
        end = shown.from_si(float(attempt.left[-1]))
        labels.append(EndLabel(end, name_speed(found, attempt), *look(i)))
    figure, (axes,) = stack_panels([3.4], right=beside(labels))
    for i, attempt in enumerate(found.attempts):
        minutes = np.append(0.0, attempt.lengths / 60)
        left = np.append(found.none, attempt.left) / shown.scale
        axes.plot(minutes, left, color=look(i)[0], linestyle=look(i)[1], linewidth=1.4, marker=".", markersize=4)
        if attempt.shortest is not None:
            where = attempt.shortest / 60, shown.from_si(attempt.leaves)
            axes.plot(*where, color=look(i)[0], marker="o", markersize=9, fillstyle="none", linestyle="none")
    axes.axhline(limit, color=GREY, linewidth=0.8, linestyle=(0, (4, 3)))
    axes.annotate(f"tolerance {limit:.4g} {pretty(shown.text)}", (0, limit), xytext=(3, 3), textcoords="offset points",
                  fontsize=SMALL, color=GREY)  # fmt: skip
    axes.set_ylim(bottom=0)
    axes.set_xlabel("warm-up [min]", fontsize=FONT, color=INK)
    label_y(axes, "moves afterwards", shown.text)
    label_ends(axes, labels)
    write_title(figure, f"{found.machine.name}: warm-up", tell_warm_up(found).splitlines()[0])
    return figure
