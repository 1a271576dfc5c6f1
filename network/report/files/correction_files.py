"""What `lptn export` leaves: the C file or the FMU around it, export.json, and a picture of what is lost."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from network.analysis.correction.correction import Correction
from network.platform.files import write_text
from network.report.figures.canvas import save
from network.report.figures.correction_figure import correction_figure
from network.report.files.correction_c import write_c
from network.report.files.fmu import write_fmu
from network.report.files.result_files import as_json
from network.report.files.step_timing import time_step


def write_correction(correction: Correction, form: str, where: Path) -> tuple[list[Path], str, dict[str, Any]]:
    """The files; a sentence, and keys of export.json, about how the C file was built here. where: a draft. Raises
    Refused where a file cannot be written."""
    first, sentence, told = _write_code(correction, where) if form == "c" else _write_unit(correction, where)
    return [first, *_write_rest(correction, where, told)], sentence, told


def _write_code(correction: Correction, where: Path) -> tuple[Path, str, dict[str, Any]]:
    path = where / "correction.c"
    write_text(path, write_c(correction))
    seconds = time_step(path)
    return path, f"A step takes {1e6 * seconds:.2g} µs here." if seconds is not None else "", {"step_seconds": seconds}


def _write_unit(correction: Correction, where: Path) -> tuple[Path, str, dict[str, Any]]:
    path = where / "correction.fmu"
    platform = write_fmu(correction, path)
    sentence = (
        f"The FMU (FMI 2.0, co-simulation) holds a library for {platform}, and the sources for others."
        if platform
        else "The FMU (FMI 2.0, co-simulation) holds sources alone, for no C compiler for a platform that FMI 2.0 "
        "names was found here: whoever runs it builds sources/fmu.c, or export again where `gcc` or `cc` is."
    )
    return path, sentence, {"binaries": [platform] if platform else []}


def _write_rest(correction: Correction, where: Path, told: dict[str, Any]) -> list[Path]:
    data, picture = where / "export.json", where / "export.png"
    write_text(data, as_json(correction.summary() | told))
    if not correction.losses:
        return [data]
    save(correction_figure(correction), picture)
    return [data, picture]
