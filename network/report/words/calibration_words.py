"""What a calibration says of itself in the terminal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from network.analysis.calibration.identifiability_report import relative
from network.analysis.sweep.finer_lumps import has_chosen_lumps
from network.engine.response.parameters import Parameter
from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import digits, format_shift, span, table
from network.platform.wording import join_names
from network.report.words.band_words import tell_coverage
from network.report.words.words import rmse_rows

if TYPE_CHECKING:
    from network.analysis.calibration.calibrate import Calibration
    from network.analysis.calibration.tcp_bands import Band


def tell_calibration(c: Calibration) -> str:
    """Numbers before and after, residuals before and after, bands of the tool centre point, sentences, warnings."""
    header, rows = number_rows(c)
    numbers = "\n".join(table(header, rows, ["moved [σ]"]))
    blocks = [head_of(c), numbers, "\n".join(_residuals(c)), "\n".join(band_lines(c))]
    told = [sentence + "." for sentence in c.sentences]
    told += _tell_cut(c)
    told += [f"warning: {warning}" for warning in c.warnings]
    return "\n\n".join(block for block in [*blocks, "\n".join(told)] if block)


def _tell_cut(c: Calibration) -> list[str]:
    if c.cut is None or c.cut.is_within:
        return []
    return [f"{c.cut}{'' if has_chosen_lumps(c.cut.machine) else ' Calibrate with it.'}"]


def head_of(c: Calibration) -> str:
    """How many numbers, on how much, how long it took."""
    count, many = len(c.parameters), len(c.data)
    samples = sum(len(d.recording.t) for d in c.data)
    numbers = f"{count} number{'s' if count > 1 else ''}"
    recordings = f"{many} recording{'s' if many > 1 else ''}"
    return f"{c.original.name}: {numbers} calibrated on {recordings} ({samples} samples) in {span(c.seconds)}"


def number_rows(c: Calibration) -> tuple[list[str], list[list[str]]]:
    """Header and a row for each number."""
    header = ["number", "before", "calibrated", "95 %", "moved [σ]", ""]
    rows = []
    for j, p in enumerate(c.parameters):
        low, high = (_bare(p, p.value(x)) for x in c.known.interval(j))
        moved = format_shift(float(c.shift[j])) if np.isfinite(c.shift[j]) else "–"
        rows.append([p.path, before(p), _value(c, j), f"{low} … {high}", moved, _remark(c, j)])
    return header, rows


def before(p: Parameter) -> str:
    """The prior as in the file."""
    if p.is_unknown:
        return f"unknown {_bare(p, p.value(p.low))}..{_bare(p, p.value(p.high))}"
    return f"{p.format_value(p.centre)} ± {relative(p, p.centre, p.spread)}"


def _value(c: Calibration, j: int) -> str:
    p, theta = c.parameters[j], float(c.theta[j])
    return f"{p.format_value(theta)} ± {relative(p, theta, float(c.std[j]))}"


def _bare(p: Parameter, value: float) -> str:
    return digits(p.to_unit(value), 3)


def _remark(c: Calibration, j: int) -> str:
    if j in c.known.at_bound:
        return "at bound"
    return "prior only" if j in c.known.prior_only else ""


def _residuals(c: Calibration) -> Iterator[str]:
    header, rows = fit_rows(c)
    yield from table(header, rows, header[1:])
    if any(p.is_unknown for p in c.parameters):
        yield "  before: unknown numbers at the middle of their range"


def fit_rows(c: Calibration) -> tuple[list[str], list[list[str]]]:
    """Header and a row for each channel: before and after, where it was calibrated and where it was held out."""
    columns = [
        ("calibrated on: before", c.before), ("calibrated on: after", c.after),
        ("held out: before", c.before_holdout), ("held out: after", c.after_holdout),
    ]  # fmt: skip
    return rmse_rows([(name, comparison) for name, comparison in columns if comparison is not None])


def band_lines(c: Calibration) -> Iterator[str]:
    """The widest band of every axis over all recordings, and whether bands held on what was held out."""
    widest: dict[str, Band] = {}
    for band in (band for own in c.bands for band in own):
        if band.axis not in widest or band.widest > widest[band.axis].widest:
            widest[band.axis] = band
    axes = [f"{b.axis} to ±{digits(b.widest, 2)} {pretty(b.unit)}" for b in widest.values()]
    if axes:
        yield f"The calibrated machine tells the tool centre point along {join_names(axes)} at worst (95 %)."
    alone = [axis for axis, b in widest.items() if b.left is None]
    if alone:
        yield f"Along {join_names(alone)} that counts its numbers only: no probe measured it."
    if len(c.data) == 1 and len(alone) < len(axes):
        yield (
            "What it leaves on other runs is told from the halves of a single one, and another day may leave far more; "
            "calibrate on several to be surer."
        )
    yield from tell_coverage(c.coverage)
