"""Labels at the ends of lines, spread so that none covers another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.report.figures.canvas import INK, SMALL, Dashes, size_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LINE = SMALL * 1.3
"""Height of a label [pt]."""
LEADER, KEY, ROOM = 8.0, 26.0, 30.0
"""Where the line to a label ends, where its piece of line ends, where its text begins [pt]."""


@dataclass(frozen=True)
class EndLabel:
    """A label at height y (NaN: nowhere), with a piece of its line in front."""

    y: float
    text: str
    colour: str
    dashes: Dashes = "solid"
    width: float = 1.3


def spread(wanted: Array, least: float, low: float, high: float) -> Array:
    """Places as near as possible to the wanted ones, `least` apart and within low..high; closer where they must be."""
    count = len(wanted)
    if not count:
        return np.empty(0)
    least = min(least, (high - low) / max(count - 1, 1))
    order = np.argsort(wanted, kind="stable")
    blocks: list[tuple[float, int]] = []  # mean and size of runs that touch, in places less i·least
    for i, place in enumerate(wanted[order]):
        blocks.append((float(place) - i * least, 1))
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            (mean, size), (other, more) = blocks.pop(-2), blocks.pop(-1)
            blocks.append(((mean * size + other * more) / (size + more), size + more))
    free = np.concatenate([np.full(size, mean) for mean, size in blocks])
    placed = np.empty(count)
    placed[order] = np.clip(free, low, high - (count - 1) * least) + np.arange(count) * least
    return placed


def label_ends(axes: Axes, labels: Sequence[EndLabel]) -> None:
    """Writes the labels right of the axes, each joined to the end of its line."""
    from matplotlib.lines import Line2D

    low, high = axes.get_ylim()
    wide, points = (inches * 72 for inches in size_of(axes))
    at = np.array([_share(label.y, low, high) * points for label in labels])
    places = spread(at, LINE, LINE * 0.3, points - LINE * 0.3) / points
    across = axes.transAxes
    for label, end, place in zip(labels, at / points, places, strict=True):
        x = np.array([0.0, LEADER, KEY, ROOM]) / wide + 1.0
        style: dict[str, Any] = {"color": label.colour, "linestyle": label.dashes, "linewidth": label.width}
        path = ([x[0], x[1]], [end, place]) if np.isfinite(label.y) else ([], [])
        axes.add_artist(Line2D(*path, transform=across, clip_on=False, color=label.colour, linewidth=0.6))
        axes.add_artist(Line2D(x[1:3], [place, place], transform=across, clip_on=False, **style))
        axes.text(x[3], place, label.text, transform=across, fontsize=SMALL, color=INK, va="center_baseline")


def _share(y: float, low: float, high: float) -> float:
    return float(np.clip((y - low) / (high - low), 0.0, 1.0)) if np.isfinite(y) else 0.0
