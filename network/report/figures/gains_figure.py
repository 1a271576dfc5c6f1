"""The map of gains: what each kind at each place would explain by itself, before anything is fitted."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import numpy as np

from network.analysis.diagnosis.screening.screened_gain import ScreenedGain
from network.platform.wording import name_of
from network.report.figures.canvas import FONT, INK, SMALL, name_text, text_size, write_title
from network.report.figures.named_rows import lay_rows
from network.report.words.finding_words import to_sigma

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from network.analysis.diagnosis.findings.result import Diagnosis

ROWS, COLUMNS = 18, 14
"""Places and kinds that are drawn, the best of each."""
LINE, LONGEST, KIND, MARGIN, RIGHT = 0.27, 34, 22, 0.85, 0.3
"""Height of a row [in], letters of a place and of a kind; above and right of the map [in]."""
DARK = 0.6
"""Share of the scale from which figures are white."""


def gains_figure(d: Diagnosis) -> Figure:
    """Places in rows, kinds in columns, both the best first; how clearly each stands out [σ]."""
    kinds = _best(d.screened, _kind_of, COLUMNS)
    drawn = [g for g in d.screened if g.kind in kinds]
    places = _best(drawn, _place_of, ROWS)
    sigma = np.full((len(places), len(kinds)), np.nan)
    for g in drawn:
        if _place_of(g) in places:
            sigma[places.index(_place_of(g)), kinds.index(_kind_of(g))] = to_sigma(g.gain)
    names = [name_text(name_of(kind), KIND) for kind in kinds]
    tall = max(text_size(name, SMALL)[0] for name in names) / 72
    figure, (axes,) = lay_rows(places, LINE, LONGEST, MARGIN + tall, [0.0], 0.0, RIGHT)
    _fill(axes, sigma)
    axes.set_xticks(np.arange(len(names)), names, rotation=90)
    axes.tick_params(axis="x", labelsize=SMALL, length=0, top=True, labeltop=True, bottom=False, labelbottom=False)
    axes.set_xlabel("how clearly each would stand out by itself, by the linear score [σ]", fontsize=FONT, labelpad=6)
    write_title(figure, f"{d.machine.name}: where what could be missing", _below(d, places, kinds))
    return figure


def _place_of(g: ScreenedGain) -> str:
    return ", ".join(g.seats) or "machine"


def _kind_of(g: ScreenedGain) -> str:
    return g.kind


def _best(screened: Iterable[ScreenedGain], of: Callable[[ScreenedGain], str], most: int) -> list[str]:
    """Names by their best gain."""
    return [*dict.fromkeys(of(g) for g in sorted(screened, key=lambda g: -g.gain))][:most]


def _below(d: Diagnosis, places: list[str], kinds: list[str]) -> str:
    counts = [len({of(g) for g in d.screened}) for of in (_place_of, _kind_of)]
    cut = [f"the best {len(shown)} of {count} {what}" for shown, count, what in
           zip((places, kinds), counts, ("places", "kinds"), strict=True) if count > len(shown)]  # fmt: skip
    return "; ".join(["empty: not there, or nothing shows", *cut])


def _fill(axes: Axes, sigma: np.ndarray) -> None:
    most = float(np.nanmax(sigma))
    axes.imshow(sigma, cmap="Blues", vmin=0.0, vmax=most, aspect="auto")
    axes.set_ylim(len(sigma) - 0.5, -0.5)
    axes.grid(False)
    for (i, j), x in np.ndenumerate(sigma):
        if np.isfinite(x):
            colour = "white" if x > DARK * most else INK
            axes.text(j, i, f"{x:.0f}", fontsize=SMALL, color=colour, ha="center", va="center_baseline")
