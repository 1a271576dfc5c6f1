"""All figures. Each function returns a figure of matplotlib; `save` writes it."""

from __future__ import annotations

from network.report.figures.calibration_figure import band_figure, shift_figure
from network.report.figures.canvas import save
from network.report.figures.comparison_figure import comparison_figure
from network.report.figures.contributions_figure import contributions_figure
from network.report.figures.fit_figure import fit_figure
from network.report.figures.network_figure import network_figure
from network.report.figures.residual_figure import residual_figure
from network.report.figures.run_figure import run_figure
from network.report.figures.sources_figure import sources_figure

__all__ = [
    "band_figure", "comparison_figure", "contributions_figure", "fit_figure", "network_figure", "residual_figure",
    "run_figure", "save", "shift_figure", "sources_figure",
]  # fmt: skip
