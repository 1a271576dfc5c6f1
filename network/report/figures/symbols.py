"""The signs of a picture of a network: sizes, colours, marks, and their legend."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from network.machine.machine import Machine
from network.report.figures.canvas import GREY, INK, PALETTE, SMALL, text_size
from network.report.figures.strokes import capacity_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LARGE, SMALLEST = 26.0, 8.0
"""Radii of the largest and the smallest part [pt]."""
HELD, JUNCTION = 9.0, 3.5
MANY = 25
"""More nodes than this are written smaller."""
MARKS = {"source": "▲", "relay": "◐", "sensor": "◇"}
COLOURS = {
    "source": PALETTE[1],
    "relay": "#9c4f7c",
    "sensor": PALETTE[0],
    "stream": PALETTE[2],
    "link": "#7d7d7d",
    "loss": "#7fb2d0",
}
"""Of marks and lines; loss: a link to a held node."""
BACKING = {"facecolor": "white", "edgecolor": "none", "pad": 0.3, "alpha": 0.85}
EDGE: dict[str, Any] = {"edgecolor": INK, "linewidth": 0.9, "zorder": 4}
FILL, HELD_FILL = "#f6e3c5", "#d6ebf7"


def owner(symbol: str) -> str:
    """The node that a symbol stands for. (No name of a node has an @.)"""
    return symbol.partition("@")[0]


def radii_of(machine: Machine) -> Mapping[str, float]:
    """Area by the logarithm of the heat capacity, over at least two decades."""
    sizes = {name: float(np.log10(node.capacity)) for name, node in machine.nodes.items() if node.is_part}
    top = max(sizes.values(), default=0.0)
    span = max(top - min(sizes.values(), default=0.0), 2.0)
    shrink = 1.0 if len(machine.nodes) <= MANY else 0.6
    areas = {name: SMALLEST**2 + (LARGE**2 - SMALLEST**2) * (1 - (top - size) / span) for name, size in sizes.items()}
    other = {name: HELD if node.is_held else JUNCTION for name, node in machine.nodes.items()}
    return other | {name: float(shrink * np.sqrt(area)) for name, area in areas.items()}


def draw_legend(axes: Axes, machine: Machine, radius: Mapping[str, float], words: Sequence[str]) -> None:
    """Below: three sizes in kJ/K, and the marks that occur."""
    from matplotlib.patches import Circle

    x, y = axes.get_xlim()[0] + 14.0, axes.get_ylim()[0] + 30.0
    for name in examples(machine):
        r = radius[name]
        axes.add_patch(Circle((x + r, y), r, facecolor=FILL, **EDGE))
        text = capacity_text(machine, name)
        axes.text(x + 2 * r + 4, y, text, fontsize=SMALL, color=GREY, va="center")
        x += 2 * r + 14 + text_size(text, SMALL)[0]
    axes.text(x + 10, y, "     ".join(words), fontsize=SMALL, color=GREY, va="center")


def words_of(machine: Machine, marks: set[str], streams: bool) -> list[str]:
    """What the signs mean that occur."""
    nodes = machine.nodes.values()
    words = ["□ held temperature"] * any(node.is_held for node in nodes)
    words += ["• massless junction"] * any(node.is_massless for node in nodes)
    words += [f"{mark} {name}" for name, mark in MARKS.items() if name in marks]
    return words + ["→ stream (green)"] * streams


def examples(machine: Machine) -> list[str]:
    """The smallest, a middle and the largest part; of those that are told alike, one."""
    parts = sorted((n for n, node in machine.nodes.items() if node.is_part), key=lambda n: machine.nodes[n].capacity)
    some = [parts[0], parts[len(parts) // 2], parts[-1]] if parts else []
    return list({capacity_text(machine, name): name for name in some}.values())
