"""bands.csv: what the tool centre point lies in with 95 %, at the instants of a run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from network.analysis.calibration.tcp_bands import Band
from network.catalogue.declaration.declare import Array
from network.engine.trajectory import Trajectory
from network.recordings.csv_table import write_csv

FILE = "bands.csv"


def write_bands(run: Trajectory, bands: Sequence[Band], where: Path) -> list[Path]:
    """Lower and upper end for each axis; nothing without bands."""
    path = where / FILE
    if not bands:
        return []
    columns: dict[str, tuple[str, Array]] = {}
    for band in bands:
        low, high = band.limits(run.t, run.tcp[band.axis])
        columns |= {f"{band.axis}_low": (band.unit, low), f"{band.axis}_high": (band.unit, high)}
    write_csv(path, run.t, columns)
    return [path]
