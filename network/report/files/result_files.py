"""What several commands write: tables, JSON, and the files of a run."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

from network.catalogue.declaration.declare import Array
from network.engine.superposition.superposition import Superposition
from network.engine.trajectory import Trajectory
from network.platform.files import write_text
from network.platform.publication import Kind
from network.recordings.csv_table import write_csv
from network.report.words.source_words import summarise_superposition

if TYPE_CHECKING:
    from network.analysis.calibration.tcp_bands import Band
    from network.analysis.sweep.lumping_error import LumpingError

RUN = Kind("summary.json", ("run.png", "network.png", "contributions.png", "sources.png", "bands.csv", "report.html"))
"""What `lptn simulate` leaves in a folder."""


def as_json(value: Mapping[str, Any]) -> str:
    """JSON text; what is no number or infinite becomes null."""
    return json.dumps(tidy(value), indent=1, ensure_ascii=False) + "\n"


def tidy(value: Any) -> Any:
    """Plain values that JSON knows: numbers of numpy as numbers, nothing for what is infinite."""
    if isinstance(value, Mapping):
        return {str(key): tidy(child) for key, child in value.items()}
    if isinstance(value, list | tuple):
        return [tidy(child) for child in value]
    if hasattr(value, "tolist"):
        return tidy(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value


def write_table(path: Path, header: Iterable[object], rows: Iterable[Iterable[object]]) -> None:
    """A table as CSV, 7 digits; nothing for None."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(str, header))
    writer.writerows([f"{cell:.7g}" if isinstance(cell, float) else cell for cell in row] for row in rows)
    write_text(path, text.getvalue())


def run_summary(run: Trajectory, shares: Superposition | None, lumping: LumpingError | None = None) -> dict[str, Any]:
    """What summary.json holds; `from`: where the movement comes from; `lumping`: what finer lumps would change."""
    found = {"from": summarise_superposition(shares)} if shares is not None else {}
    return run.summary() | found | {"lumping": None if lumping is None else lumping.summary()}


def write_run(
    run: Trajectory, where: Path, shares: Superposition | None = None, lumping: LumpingError | None = None,
    parquet: bool = False,
) -> list[Path]:  # fmt: skip
    """results.csv (a recording's format), parts.csv (what every part has and does, and where the movement comes from),
    and summary.json; parquet: both tables as Parquet instead."""
    ending = "parquet" if parquet else "csv"
    results, parts, summary = (where / name for name in (f"results.{ending}", f"parts.{ending}", "summary.json"))
    more = shares.columns_in_si() if shares is not None else ()
    for path, columns in ((results, run.columns_in_si()), (parts, chain(run.part_columns_in_si(), more))):
        if parquet:
            from network.report.files.parquet_files import write_run_columns

            write_run_columns(path, run.t, columns)
        else:
            write_csv(path, run.t, {name: (unit_text, values) for name, unit_text, values in columns})
    write_text(summary, as_json(run_summary(run, shares, lumping)))
    return [results, parts, summary]


def write_bands(run: Trajectory, bands: Sequence[Band], where: Path) -> list[Path]:
    """bands.csv: what the tool centre point lies in with 95 %, lower and upper end for each axis; nothing without
    bands."""
    path = where / "bands.csv"
    if not bands:
        return []
    columns: dict[str, tuple[str, Array]] = {}
    for band in bands:
        low, high = band.limits(run.t, run.tcp[band.axis])
        columns |= {f"{band.axis}_low": (band.unit, low), f"{band.axis}_high": (band.unit, high)}
    write_csv(path, run.t, columns)
    return [path]
