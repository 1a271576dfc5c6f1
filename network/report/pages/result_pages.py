"""The pages of a simulation, a comparison and a calibration: what the commands tell, with charts to look into."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from network.platform.files import write_text
from network.platform.quantities.text_table import digits
from network.report.pages.chart import Chart
from network.report.pages.chart_page import PAGE, Page, Table, fill_page
from network.report.pages.run_charts import chart_comparison, chart_fits, chart_run
from network.report.words.lump_words import tell_cut
from network.report.words.recording_names import title_of

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from network.analysis.calibration.calibrate import Calibration
    from network.analysis.calibration.tcp_bands import Band
    from network.analysis.comparison.compare import Comparison
    from network.analysis.sweep.lumping_error import LumpingError
    from network.engine.superposition.superposition import Superposition
    from network.engine.trajectory import Trajectory

RUN = "Temperatures, the tool centre point and inputs over time; a channel is switched off and on by its name."
BESIDE = "Every channel: measured grey, simulated blue."
BOTH = "Every channel: measured grey, simulated before the calibration orange, after it blue."


def write_page(text: str, where: Path) -> Path:
    """report.html in a folder. Raises Refused where it cannot be written."""
    write_text(where / PAGE, text)
    return where / PAGE


def page_of_run(
    run: Trajectory, shares: Superposition | None, bands: Sequence[Band] = (), lumping: LumpingError | None = None
) -> str:
    """What `lptn simulate` says, and the run."""
    from network.report.words.band_words import tell_bands

    told = [line for line in (str(shares).splitlines() if shares is not None else ()) if line.strip()]
    notes = [*tell_cut(lumping), *(f"Warning: {warning}" for warning in run.warnings)]
    page = Page(
        f"{run.machine.name}: {run.schedule.name}", [*told, *tell_bands(bands)], [*_tables_of_run(run)], notes,
        [chart_run(run)], RUN, _account(run),
    )  # fmt: skip
    return fill_page(page)


def _tables_of_run(run: Trajectory) -> Iterator[Table]:
    from network.report.words.run_words import displacement_rows, temperature_rows

    for header, rows in (displacement_rows(run), temperature_rows(run)):
        if rows:
            yield Table(header, rows)


def _account(run: Trajectory) -> str:
    e = run.energy
    flows = (("in", e.in_), ("out", e.out), ("stored", e.total_stored))
    told = ", ".join(f"{name} {digits(value / 1e3)} kJ" for name, value in flows)
    return f"Energy: {told}; closure {e.closure:.1g}. Method {run.method}: {run.why}."


def page_of_comparison(comparison: Comparison, lumping: LumpingError | None = None) -> str:
    """What `lptn compare` says, and every recording."""
    from network.report.words.words import residual_rows, tell_findings

    tables, notes = list[Table](), list[str]()
    for residual in comparison.recordings:
        tables.append(Table(*residual_rows(residual), f"{title_of(residual.recording)} ({residual.recording.file})"))
        notes += [f"{title_of(residual.recording)}: {line}" for line in tell_findings(residual)]
    many = len(comparison.recordings)
    basis = [f"Measured less simulated on {many} recording{'s' if many > 1 else ''}: rmse "
             f"{digits(comparison.rmse_in_noise, 3)} σ over all channels (σ: declared noise of a sample)."]  # fmt: skip
    charts = [chart_comparison(residual) for residual in comparison.recordings]
    notes += [*tell_cut(lumping), *(f"Warning: {warning}" for warning in comparison.warnings)]
    return fill_page(Page(f"{comparison.machine.name}: measured and simulated", basis, tables, notes, charts, BESIDE))


def page_of_calibration(c: Calibration) -> str:
    """What `lptn calibrate` says, and every recording before and after."""
    from network.report.words.calibration_words import band_lines, fit_rows, head_of, number_rows

    notes = [*band_lines(c), *(f"{sentence}." for sentence in c.sentences), *tell_cut(c.cut)]
    notes += [f"Warning: {w}" for w in c.warnings]
    tables = [Table(*fit_rows(c), "What is left, in units of noise"), Table(*number_rows(c), "Numbers of the file")]
    page = Page(f"{c.original.name}: calibrated", [f"{head_of(c)}."], tables, notes, [*_charts_of(c)], BOTH)
    return fill_page(page)


def _charts_of(c: Calibration) -> Iterator[Chart]:
    """The held-out recordings first: they show what was learned."""
    sides = (("held out", c.before_holdout, c.after_holdout), ("calibrated on", c.before, c.after))
    return chart_fits(sides, lambda residual: title_of(residual.recording))
