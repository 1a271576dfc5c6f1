"""Explanations that were fitted, ranked: how clearly each stands out, and how well it fits."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from network.catalogue.declaration.declare import Array
from network.platform.quantities.text_table import digits
from network.report.figures.canvas import FONT, GREY, INK, PALETTE, SMALL, size_of, text_size, write_title
from network.report.figures.named_rows import lay_rows
from network.report.words.finding_words import rival_name, to_sigma

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from network.analysis.diagnosis.findings.finding import Rival
    from network.analysis.diagnosis.findings.result import Diagnosis

FOUND, OTHER, CHANCE = PALETTE[0], "#a9a9a9", PALETTE[1]
LINE, MOST, LONGEST = 0.26, 16, 46
"""Height of one candidate [in]; how many are drawn; letters of a name."""
LEAVES, GAP, RIGHT = 2.1, 0.75, 0.55
"""Width of the right panel, gap between the two, margin [in]."""


def candidates_figure(d: Diagnosis) -> Figure:
    """Left: how clearly each stands out [σ], with what chance reaches; right: the misfit, relative to that of what was
    found. What was found is blue."""
    rivals = [replace(r, gain=to_sigma(r.gain)) for r in sorted(rescale_gains(d), key=lambda r: -r.gain)[:MOST]]
    names = [rival_name(r) for r in rivals]
    figure, (gains, leaves) = lay_rows(names, LINE, LONGEST, 0.8, [0.0, LEAVES], GAP, RIGHT)
    colours = [FOUND if was_found(d, r) else OTHER for r in rivals]
    _draw_gains(gains, rivals, colours, _threshold(d))
    _draw_misfits(leaves, np.array([r.chi for r in rivals]) / _chi_of_findings(d), colours)
    gains.grid(False, axis="y")
    write_title(figure, f"{d.machine.name}: what was tried", _below(d))
    return figure


def _below(d: Diagnosis) -> str:
    first = ["tried in the stead of the first finding, nothing else added"] if len(d.findings) > 1 else []
    cut = [f"the best {MOST} of {len(d.tried)}"] if len(d.tried) > MOST else []
    chance = ["dashed: what chance reaches"] if d.findings else []
    return "; ".join(["blue: what was found", *chance, *first, *cut])


def rescale_gains(d: Diagnosis) -> tuple[Rival, ...]:
    """What was tried. A single finding is judged at the end once more, under the noise that it leaves, which makes the
    evidence of all larger or smaller by the same factor."""
    gains = [r.gain for r in d.tried if was_found(d, r)]
    if len(d.findings) != 1 or not gains or gains[0] <= 0 or not math.isfinite(d.findings[0].gain):
        return d.tried
    return tuple(replace(r, gain=r.gain * d.findings[0].gain / gains[0]) for r in d.tried)


def _chi_of_findings(d: Diagnosis) -> float:
    """The misfit of what was found; of the best where that is not among what was tried."""
    return next((r.chi for r in d.tried if was_found(d, r)), min((r.chi for r in d.tried), default=1.0)) or 1.0


def was_found(d: Diagnosis, rival: Rival) -> bool:
    return any(
        (f.kind, set(f.places), f.channels) == (rival.kind, set(rival.places), rival.channels) for f in d.findings
    )


def _threshold(d: Diagnosis) -> float:
    return to_sigma(max((f.threshold for f in d.findings), default=math.nan))


def _draw_gains(axes: Axes, rivals: list[Rival], colours: list[str], threshold: float) -> None:
    rows, gains = np.arange(len(rivals)), np.array([r.gain for r in rivals])
    gains = np.where(np.isfinite(gains), gains, 0.0)
    axes.barh(rows, gains, height=0.6, color=colours, linewidth=0)
    reach = float(np.max(gains, initial=1.0))
    for row, gain in enumerate(gains):
        text = digits(abs(gain), 2) if gain >= 0 else f"−{digits(abs(gain), 2)}"
        at = max(gain, 0.0) + 0.008 * reach
        wide = 1.12 * reach * text_size(text, SMALL)[0] / 72 / size_of(axes)[0]
        if at - 0.02 * reach < threshold < at + wide + 0.01 * reach:
            at = threshold + 0.012 * reach
        axes.text(at, row, text, fontsize=SMALL, color=INK, va="center_baseline")
    low = float(np.min(gains, initial=0.0))
    axes.set_xlim(max(low, -0.1 * reach) * 1.05, reach * 1.12)
    if math.isfinite(threshold):
        axes.axvline(threshold, color=CHANCE, linewidth=1.0, linestyle=(0, (5.0, 2.0)))
    axes.set_xlabel("how clearly it stands out over nothing missing [σ]", fontsize=FONT, labelpad=2)


def _draw_misfits(axes: Axes, misfits: Array, colours: list[str]) -> None:
    axes.axvline(1.0, color=GREY, linewidth=0.8)
    for row, (misfit, colour) in enumerate(zip(misfits, colours, strict=True)):
        axes.plot([misfit], [row], "D" if colour == FOUND else "o", color=colour, markersize=5)
        place = axes.get_yaxis_transform()
        told = f"{misfit:.2f}" if misfit < 10 else digits(misfit, 3)
        axes.text(1.03, row, told, transform=place, fontsize=SMALL, color=INK, va="center_baseline")
    finite = [1.0, *misfits[np.isfinite(misfits)]]
    room = 0.08 * (max(finite) - min(finite) or 1.0)
    axes.set_xlim(min(finite) - room, max(finite) + room)
    axes.set_xlabel("misfit in the fit; found: 1", fontsize=FONT, labelpad=2)
