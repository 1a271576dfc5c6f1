"""Explanations that were fitted, ranked: what each adds to the evidence, and what it leaves."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from network.report.canvas import (
    FONT,
    GREY,
    INK,
    PALETTE,
    SMALL,
    WIDTH,
    add_axes,
    name_text,
    new_figure,
    text_size,
    write_title,
)
from network.report.finding_words import rival_name

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from network.diagnosis.verdict import Diagnosis, Rival

FOUND, OTHER, CHANCE = PALETTE[0], "#a9a9a9", PALETTE[1]
LINE, MOST, LONGEST = 0.26, 16, 46
"""Height of one candidate [in]; how many are drawn; letters of a name."""
LEAVES, GAP, RIGHT = 2.1, 0.75, 0.55
"""Width of the right panel, gap between the two, margin [in]."""


def candidates_figure(d: Diagnosis) -> Figure:
    """Left: log evidence over nothing missing [nats], with what chance reaches; right: rms residual left [noise units].
    What was found is blue."""
    rivals = sorted(d.tried, key=lambda r: -r.gain)[:MOST]
    names = [name_text(rival_name(r), LONGEST) for r in rivals]
    left = 0.3 + max((text_size(name, FONT)[0] for name in names), default=0.0) / 72
    height = max(len(rivals), 1) * LINE
    figure = new_figure(0.8 + height + 0.6)
    width = WIDTH - left - GAP - LEAVES - RIGHT
    gains = add_axes(figure, left, 0.6, width, height)
    leaves = add_axes(figure, left + width + GAP, 0.6, LEAVES, height)
    colours = [FOUND if was_found(d, r) else OTHER for r in rivals]
    _draw_gains(gains, rivals, colours, _threshold(d))
    _draw_leaves(leaves, rivals, colours)
    _finish(gains, leaves, names)
    first = " for the first finding" if len(d.findings) > 1 else ""
    cut = f"; the best {MOST} of {len(d.tried)}" if len(d.tried) > MOST else ""
    write_title(figure, f"{d.machine.name}: explanations that were fitted{first}", f"blue: what was found{cut}")
    return figure


def was_found(d: Diagnosis, rival: Rival) -> bool:
    return any(
        (f.kind, set(f.places), f.channels) == (rival.kind, set(rival.places), rival.channels) for f in d.findings
    )


def _threshold(d: Diagnosis) -> float:
    return max((f.threshold for f in d.findings), default=math.nan)


def _draw_gains(axes: Axes, rivals: list[Rival], colours: list[str], threshold: float) -> None:
    rows, gains = np.arange(len(rivals)), np.array([r.gain for r in rivals])
    gains = np.where(np.isfinite(gains), gains, 0.0)
    axes.barh(rows, gains, height=0.6, color=colours, linewidth=0)
    reach = float(np.max(gains, initial=1.0))
    for row, gain in enumerate(gains):
        text = f"{gain:.0f}".replace("-", "−")
        axes.text(max(gain, 0.0) + 0.008 * reach, row, text, fontsize=SMALL, color=INK, va="center_baseline")
    low = float(np.min(gains, initial=0.0))
    axes.set_xlim(max(low, -0.1 * reach) * 1.05, reach * 1.12)
    if math.isfinite(threshold):
        axes.axvline(threshold, color=CHANCE, linewidth=1.0, linestyle=(0, (5.0, 2.0)))
    axes.set_xlabel("log evidence over nothing missing [nats]; dashed: what chance reaches", fontsize=FONT, labelpad=2)


def _draw_leaves(axes: Axes, rivals: list[Rival], colours: list[str]) -> None:
    axes.axvline(1.0, color=GREY, linewidth=0.8)
    for row, (rival, colour) in enumerate(zip(rivals, colours, strict=True)):
        axes.plot([rival.chi], [row], "D" if colour == FOUND else "o", color=colour, markersize=5)
        place = axes.get_yaxis_transform()
        axes.text(1.03, row, f"{rival.chi:.3g}", transform=place, fontsize=SMALL, color=INK, va="center_baseline")
    chis = [r.chi for r in rivals if math.isfinite(r.chi)]
    high = max([*chis, 1.0])
    axes.set_xlim(min([*chis, 1.0]) - 0.06 * high, high * 1.06)
    axes.set_xlabel("rms residual left [σ]", fontsize=FONT, labelpad=2)


def _finish(gains: Axes, leaves: Axes, names: list[str]) -> None:
    for axes in (gains, leaves):
        axes.set_ylim(max(len(names), 1) - 0.4, -0.6)
        axes.set_yticks(np.arange(len(names)), names if axes is gains else [""] * len(names))
        axes.tick_params(axis="y", labelsize=FONT, length=0)
    gains.grid(False, axis="y")
