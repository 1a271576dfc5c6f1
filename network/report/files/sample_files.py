"""The files of a sweep over drawn numbers: all runs as one table of columns, and sweep.json."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from network.catalogue.declaration.declare import Array
from network.engine.trajectory import axis_unit
from network.platform.files import write_text
from network.platform.publication import publication
from network.report.files.parquet_files import check_parquet, write_parquet
from network.report.files.result_files import as_json, write_table

if TYPE_CHECKING:
    from network.analysis.sweep.sample import Sample


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
