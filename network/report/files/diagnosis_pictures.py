"""The pictures of a diagnosis: file name, place on the page, caption, and what draws it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from network.report.words.heat_words import is_named
from network.report.words.recording_names import name_recording, stems_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from network.analysis.comparison.compare import Comparison
    from network.analysis.diagnosis.findings.result import Diagnosis

LIT = "The network with what was found in it, lit in orange."
RANKED = "Every explanation that was fitted: how clearly it stands out (dashed: chance), and how much worse it fits."
GAINS = "What each kind at each place would explain by itself, by the linear score that says what is worth a fit."
HEAT = "Heat that the likeliest places would have needed, ±2 standard deviations, above the inputs."
LACKED = (
    "What the place lacked before it was added, ±2 standard deviations, above the inputs: less than was found, for "
    "calibration had hidden the rest in other numbers."
)


@dataclass(frozen=True)
class Picture:
    name: str
    place: str
    caption: str
    draw: Callable[[], Figure]


def pictures_of(d: Diagnosis) -> Iterator[Picture]:
    """Where it is, what it was weighed against, when it shows; then every recording, the held-out ones first."""
    if d.findings:
        yield Picture("network.png", "found", LIT, partial(_lit, d))
    if d.tried:
        yield Picture("candidates.png", "found", RANKED, partial(_draw_ranking, d))
    if d.screened and d.findings:
        yield Picture("gains.png", "found", GAINS, partial(_draw_gains, d))
    if d.located and d.findings:
        yield Picture("heat.png", "where", LACKED if is_named(d) else HEAT, partial(_heat, d))
    if d.fits.holdout_before is not None and d.fits.holdout_after is not None:
        yield from _fits(d, "holdout-", "held out", d.fits.holdout_before, d.fits.holdout_after)
    yield from _fits(d, "", "fitted", d.fits.train_before, d.fits.train_after)


def _fits(d: Diagnosis, prefix: str, what: str, before: Comparison, after: Comparison) -> Iterator[Picture]:
    from network.report.figures.fit_figure import fit_figure

    for stem, b, a in zip(stems_of(after), before.recordings, after.recordings, strict=True):
        name = name_recording(d, a)
        title = f"{d.machine.name}: {name}, {what}"
        caption = f"{name}, {what}: measured, and simulated before and after."
        draw = partial(fit_figure, b, a, title, large=bool(prefix))
        yield Picture(f"{prefix}fit-{stem}.png", "fits", caption, draw)


def _lit(d: Diagnosis) -> Figure:
    from network.report.figures.lit_figure import lit_figure

    return lit_figure(d)


def _draw_ranking(d: Diagnosis) -> Figure:
    from network.report.figures.explanations_figure import candidates_figure

    return candidates_figure(d)


def _draw_gains(d: Diagnosis) -> Figure:
    from network.report.figures.gains_figure import gains_figure

    return gains_figure(d)


def _heat(d: Diagnosis) -> Figure:
    from network.report.figures.heat_figure import heat_figure

    return heat_figure(d)
