"""The files of a sweep: sweep.csv and sweep.json, with sweep.png but for numbers that are drawn."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from network.catalogue.declaration.declare import Array
from network.engine.trajectory import axis_unit
from network.platform.files import write_text
from network.platform.publication import publication
from network.report.figures.canvas import save
from network.report.figures.grid_figure import grid_figure
from network.report.figures.sweep_figure import levels_figure
from network.report.files.parquet_files import check_parquet, write_parquet
from network.report.files.result_files import as_json, write_table
from network.report.words.sweep_words import level_table, run_table

if TYPE_CHECKING:
    from network.analysis.sweep.sample import Sample
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


def write_sample(sample: Sample, output: str | Path, parquet: bool = False) -> list[Path]:
    """Puts them into a folder, all or none. Raises Refused where that cannot be."""
    if parquet:
        check_parquet()
    table, summary = f"sweep.{'parquet' if parquet else 'csv'}", "sweep.json"
    columns = dict(_columns(sample))
    with publication(output) as draft:
        if parquet:
            write_parquet(draft / table, columns)
        else:
            write_table(draft / table, columns, zip(*(values.tolist() for values in columns.values()), strict=True))
        write_text(draft / summary, as_json(sample.summary()))
    return [Path(output) / table, Path(output) / summary]


def _columns(sample: Sample) -> Iterator[tuple[str, Array]]:
    """Drawn numbers, then the extremes of every axis, in their units."""
    for i, drawn in enumerate(sample.drawn):
        yield f"{drawn.path} [{drawn.unit or '1'}]", drawn.shown(sample.numbers[:, i])
    for (axis, what), values in sample.shown.items():
        yield f"{axis} {what} [{axis_unit(axis)}]", values
