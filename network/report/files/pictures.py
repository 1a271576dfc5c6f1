"""The pictures that a command leaves in a folder."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from network.analysis.calibration.tcp_bands import Band
from network.analysis.comparison.compare import Comparison
from network.engine.superposition.superposition import Superposition
from network.engine.trajectory import Trajectory
from network.report.figures.canvas import save
from network.report.figures.comparison_figure import comparison_figure
from network.report.figures.network_figure import network_figure
from network.report.figures.run_figure import run_figure
from network.report.figures.sources_figure import contributions_figure, sources_figure
from network.report.words.recording_names import stems_of


def draw_run(
    run: Trajectory, where: Path, bands: Sequence[Band] = (), shares: Superposition | None = None
) -> list[Path]:
    """run.png, network.png and, where something moves the tool centre point, contributions.png and sources.png."""
    pictures = {"run.png": run_figure(run, bands), "network.png": network_figure(run.machine, run)}
    if run.tcp:
        pictures["contributions.png"] = contributions_figure(run)
    if shares is not None and run.tcp:
        pictures["sources.png"] = sources_figure(shares)
    for name, figure in pictures.items():
        save(figure, where / name)
    return [where / name for name in pictures]


def draw_comparison(comparison: Comparison, where: Path) -> list[Path]:
    """One picture for each recording, named like its file."""
    written = [where / f"{stem}.png" for stem in stems_of(comparison)]
    for residual, path in zip(comparison.recordings, written, strict=True):
        save(comparison_figure(residual), path)
    return written
