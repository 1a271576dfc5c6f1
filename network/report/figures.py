"""All figures. Each function returns a figure of matplotlib; `save` writes it."""

from __future__ import annotations

from network.report.canvas import save
from network.report.comparison_figure import comparison_figure
from network.report.contributions_figure import contributions_figure
from network.report.network_figure import network_figure
from network.report.run_figure import run_figure

__all__ = ["comparison_figure", "contributions_figure", "network_figure", "run_figure", "save"]
