"""What `lptn export` leaves: the C file, export.json, and a picture of what is lost."""

from __future__ import annotations

from pathlib import Path

from network.analysis.correction.correction import Correction
from network.platform.files import write_text
from network.report.figures.all_figures import save
from network.report.figures.correction_figure import correction_figure
from network.report.files.correction_c import write_c
from network.report.files.result_files import as_json


def write_correction(correction: Correction, where: Path) -> list[Path]:
    """Raises Refused where a file cannot be written."""
    code, data, picture = (where / name for name in ("correction.c", "export.json", "export.png"))
    write_text(code, write_c(correction))
    write_text(data, as_json(correction.summary()))
    written = [code, data]
    if correction.losses:
        save(correction_figure(correction), picture)
        written.append(picture)
    return written
