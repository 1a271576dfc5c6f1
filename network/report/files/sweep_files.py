"""The files of a sweep: sweep.csv, sweep.json and sweep.png."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from network.platform.files import write_text
from network.platform.publication import publication
from network.report.figures.canvas import save
from network.report.figures.grid_figure import grid_figure
from network.report.figures.sweep_figure import levels_figure
from network.report.files.result_files import as_json, write_table
from network.report.words.sweep_words import level_table, run_table

if TYPE_CHECKING:
    from network.analysis.sweep.sweep import Sweep


def write_sweep(sweep: Sweep, output: str | Path) -> list[Path]:
    """Puts them into a folder, all or none. Raises Refused where that cannot be."""
    names = [f"sweep.{ending}" for ending in ("csv", "json", "png")]
    with publication(output) as draft:
        table, summary, picture = (draft / name for name in names)
        write_table(table, *(run_table(sweep) if sweep.runs else level_table(sweep)))
        write_text(summary, as_json(sweep.summary()))
        save(grid_figure(sweep) if sweep.runs else levels_figure(sweep), picture)
    return [Path(output) / name for name in names]
