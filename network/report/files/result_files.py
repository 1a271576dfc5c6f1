"""What several commands write: tables, JSON, and the files of a run."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from network.engine.trajectory import Trajectory
from network.platform.files import write_text
from network.platform.publication import Kind
from network.recordings.csv_table import write_csv

RUN = Kind("summary.json", ("run.png", "network.png", "contributions.png", "bands.csv"))
"""What `lptn simulate` leaves in a folder."""


def as_json(value: Mapping[str, Any]) -> str:
    """JSON text; NaN becomes null."""
    return json.dumps(_finite(value), indent=1, ensure_ascii=False) + "\n"


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _finite(child) for key, child in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(child) for child in value]
    return None if isinstance(value, float) and value != value else value


def write_table(path: Path, header: Iterable[object], rows: Iterable[Iterable[object]]) -> None:
    """A table as CSV, 7 digits; nothing for None."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(str, header))
    writer.writerows([f"{cell:.7g}" if isinstance(cell, float) else cell for cell in row] for row in rows)
    write_text(path, text.getvalue())


def write_run(run: Trajectory, where: Path) -> list[Path]:
    """results.csv (a recording's format), parts.csv (what every part has and does), and summary.json."""
    results, parts, summary = (where / name for name in ("results.csv", "parts.csv", "summary.json"))
    for path, columns in ((results, run.columns()), (parts, run.part_columns())):
        write_csv(path, run.t, {name: (unit_text, values) for name, unit_text, values in columns})
    write_text(summary, as_json(run.summary()))
    return [results, parts, summary]
