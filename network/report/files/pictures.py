"""The pictures that a command leaves in a folder."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from network.analysis.calibration.tcp_bands import Band
from network.analysis.comparison.compare import Comparison
from network.engine.superposition.superposition import Superposition
from network.engine.trajectory import Trajectory
from network.report.figures.all_figures import (
    comparison_figure,
    contributions_figure,
    network_figure,
    run_figure,
    save,
    sources_figure,
)


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
    stems = [Path(residual.recording.file).stem for residual in comparison.recordings]
    names = stems if len(set(stems)) == len(stems) else [f"{i}-{stem}" for i, stem in enumerate(stems, 1)]
    written = [where / f"{name}.png" for name in names]
    for residual, path in zip(comparison.recordings, written, strict=True):
        save(comparison_figure(residual), path)
    return written
