"""Then and now: how far each number and sensor differs, in its standard errors, with what an unchanged one reaches."""

from __future__ import annotations

from typing import TYPE_CHECKING

from network.report.figures.canvas import FONT, GREY, INK, PALETTE, SMALL, write_title
from network.report.figures.named_rows import lay_rows
from network.report.words.change_words import count, moves

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from network.analysis.change.changes import Changes

LINE, MOST, LONGEST, RIGHT = 0.24, 24, 44, 1.6
"""Height of a row [in]; rows; letters of a name; room for what a change moves [in]."""


def change_figure(found: Changes) -> Figure:
    """A dot for every number and sensor, the furthest first; blue: what changed, with what it moves the tool by."""
    rows = sorted(found.tested.items(), key=lambda item: -abs(item[1]))[:MOST]
    figure, (axes,) = lay_rows([name for name, _ in rows], LINE, LONGEST, 0.7, [0.0], 0.0, RIGHT)
    _draw_dots(axes, found, rows)
    axes.set_xlabel("now less then, in standard errors of the difference [σ]", fontsize=FONT)
    cut = f"; the furthest {MOST} of {len(found.tested)}" if len(found.tested) > MOST else ""
    below = f"{count(found.now)} of now, {count(found.then)} of then; dashed: what chance reaches; blue: changed{cut}"
    write_title(figure, f"{found.machine.name}: then and now", below)
    return figure


def _draw_dots(axes: Axes, found: Changes, rows: list[tuple[str, float]]) -> None:
    changed = {change.number: change for change in found.found}
    axes.set_xscale("symlog", linthresh=found.limit)
    axes.axvline(0.0, color=GREY, linewidth=0.8)
    for limit in (-found.limit, found.limit):
        axes.axvline(limit, color=PALETTE[1], linewidth=1.0, linestyle=(0, (5.0, 2.0)))
    for row, (name, sigma) in enumerate(rows):
        is_changed = name in changed
        axes.plot([sigma], [row], "D" if is_changed else "o", color=PALETTE[0] if is_changed else GREY, markersize=5)
        if is_changed:
            told = moves(changed[name])
            axes.text(1.02, row, told if told != "–" else "", transform=axes.get_yaxis_transform(), fontsize=SMALL,
                      color=INK, va="center_baseline")  # fmt: skip
    if changed:
        axes.text(1.02, -1.0, "moves the tool", transform=axes.get_yaxis_transform(), fontsize=SMALL, color=GREY,
                  va="center_baseline")  # fmt: skip
    reach = 2 * max(found.limit, *(abs(sigma) for _, sigma in rows)) if rows else 2 * found.limit
    axes.set_xlim(-reach, reach)
