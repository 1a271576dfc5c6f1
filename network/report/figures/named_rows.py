"""A picture of rows, each under its name, the first at the top."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from network.report.figures.canvas import FONT, WIDTH, add_axes, name_text, new_figure, text_size

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MARGIN, FOOT = 0.3, 0.6
"""Left of the names and below the rows [in]."""


def lay_rows(
    names: Sequence[str], line: float, longest: int, head: float, widths: Sequence[float], gap: float, right: float
) -> tuple[Figure, list[Axes]]:
    """A figure with a panel for each width (0: what is left of the paper), and the names beside the first. line: height
    of a row, head: above them, gap: between panels, right: what stays free beside the last [in]; longest: letters of a
    name."""
    told = [name_text(name, longest) for name in names]
    left = MARGIN + max((text_size(name, FONT)[0] for name in told), default=0.0) / 72
    height = max(len(told), 1) * line
    figure = new_figure(head + height + FOOT)
    rest = WIDTH - left - right - sum(widths) - gap * (len(widths) - 1)
    panels = []
    for width in widths:
        panels.append(add_axes(figure, left, FOOT, width or rest, height))
        left += (width or rest) + gap
    for axes in panels:
        axes.set_yticks(np.arange(len(told)), told if axes is panels[0] else [""] * len(told))
        axes.tick_params(axis="y", labelsize=FONT, length=0)
        axes.set_ylim(max(len(told), 1) - 0.4, -0.6)
    return figure, panels
