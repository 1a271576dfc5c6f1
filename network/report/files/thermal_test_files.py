"""The files of a thermal test: iso230.json, iso230.png, and report.html with everything in it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from network.platform.files import write_text
from network.platform.publication import Kind
from network.report.figures.canvas import save
from network.report.figures.thermal_test_figure import thermal_test_figure
from network.report.files.page import Shown, embed
from network.report.files.result_files import as_json
from network.report.pages.chart_page import Page, Table, fill_page
from network.report.pages.drift_chart import chart_test
from network.report.words.lump_words import tell_cut
from network.report.words.thermal_test_words import (
    basis_of,
    drift_rows,
    name_test,
    start_of_test,
    tell_combined,
    tell_targets,
)

if TYPE_CHECKING:
    from network.analysis.acceptance.thermal_test import ThermalTest

TEST = Kind("iso230.json")
"""What `lptn iso230` leaves in a folder."""
CAPTION = "Drift since the start, temperatures and motion; dashed lines part the first and the last 60 min of motion."

CHART = "The same to look into; an axis or a channel is switched off and on by its name."
MEANING = (
    "All figures are ranges, the largest less the smallest value. Drift: over the whole test. First and last 60 min: "
    "of the motion. Stable: from when on the drift of the last 60 min stays below {share} of the largest of the first "
    "60 min ({origin}). Tilt: of the rotation that carries the tool along the axis (b for x, a for y). Measured "
    "values are straight lines through 5 min of readings."
)


def write_thermal_test(test: ThermalTest, where: Path) -> list[Path]:
    """Raises Refused where a file cannot be written."""
    data, picture, page = (where / name for name in ("iso230.json", "iso230.png", "report.html"))
    write_text(data, as_json(test.summary()))
    save(thermal_test_figure(test), picture)
    write_text(page, page_of_test(test, picture.read_bytes()))
    return [data, picture, page]


def page_of_test(test: ThermalTest, png: bytes) -> str:
    """The page, its picture inside."""
    meaning = MEANING.format(share=f"{100 * test.stable_share:.4g} %", origin=test.stable_origin)
    notes = [*tell_combined(test), *tell_targets(test), *test.notes]
    page = Page(
        name_test(test), [basis_of(test), *start_of_test(test)], [Table(*drift_rows(test))],
        [*notes, *tell_cut(test.lumping)], [chart_test(test)], CHART, meaning, embed(Shown("iso230", "", CAPTION, png)),
    )  # fmt: skip
    return fill_page(page)
