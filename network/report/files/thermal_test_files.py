"""The files of a thermal test: iso230.json, iso230.png, and report.html with everything in it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from network.platform.files import write_text
from network.platform.publication import Kind
from network.report.figures.all_figures import save
from network.report.figures.thermal_test_figure import thermal_test_figure
from network.report.files.page import Shown, embed
from network.report.files.result_files import as_json
from network.report.words.thermal_test_words import basis_of, drift_rows, name_test, tell_targets

if TYPE_CHECKING:
    from network.analysis.acceptance.thermal_test import ThermalTest

TEST = Kind("iso230.json")
"""What `lptn iso230` leaves in a folder."""
CAPTION = "Drift since the start, temperatures and motion; dashed lines part the first and the last 60 min of motion."


def write_thermal_test(test: ThermalTest, where: Path) -> list[Path]:
    """Raises Refused where a file cannot be written."""
    data, picture, page = (where / name for name in ("iso230.json", "iso230.png", "report.html"))
    write_text(data, as_json(test.summary()))
    save(thermal_test_figure(test), picture)
    write_text(page, fill_page(test, picture.read_bytes()))
    return [data, picture, page]


def fill_page(test: ThermalTest, png: bytes) -> str:
    """The page, its picture inside."""
    from jinja2 import Environment, PackageLoader

    rooms = Environment(loader=PackageLoader("network.report"), autoescape=True, trim_blocks=True, lstrip_blocks=True)
    header, rows = drift_rows(test)
    return rooms.get_template("thermal_test.html.j2").render(
        title=name_test(test), basis=basis_of(test), header=header, rows=rows,
        notes=[*tell_targets(test), *test.notes], picture=embed(Shown("iso230", "", CAPTION, png)),
    )  # fmt: skip
