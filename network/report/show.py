"""What every result says of itself: in words for a terminal, as the contents of a JSON file, as a picture, as a table.

The function for a class is fetched when the first of its kind is printed, so that `lptn check` starts fast.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes

from network.platform.quantities.number_format import write_minus

TELL = {
    "Machine": ("words.describe", "describe"),
    "Trajectory": ("words.run_words", "tell_run"),
    "Superposition": ("words.source_words", "tell_superposition"),
    "ThermalTest": ("words.thermal_test_words", "tell_thermal_test"),
    "Correction": ("words.correction_words", "tell_correction"),
    "FormulaTable": ("words.correction_words", "tell_formulas"),
    "WarmUp": ("words.warm_up_words", "tell_warm_up"),
    "Comparison": ("words.words", "tell_comparison"),
    "Sweep": ("words.sweep_words", "tell_sweep"),
    "LumpingError": ("words.lump_words", "tell_lumping"),
    "LumpChoice": ("words.lump_words", "tell_choice"),
    "Sample": ("words.sample_words", "tell_sample"),
    "Calibration": ("words.calibration_words", "tell_calibration"),
    "Foresight": ("words.experiment_plan_words", "tell_foresight"),
    "Changes": ("words.change_words", "tell_changes"),
    "Diagnosis": ("words.diagnosis_words", "tell_diagnosis"),
}
"""Class → module and function that puts it into words."""
SUMMARISE = {
    "Sweep": ("files.sweep_summary", "summary"),
    "Sample": ("words.sample_words", "summary"),
    "Calibration": ("files.calibration_summary", "summary"),
    "Foresight": ("words.experiment_plan_words", "summary"),
}
"""Class → module and function that makes a mapping of it."""
PLOT = {
    "Machine": ("figures.axes_plots", "plot_machine"),
    "Trajectory": ("figures.axes_plots", "plot_run"),
    "Superposition": ("figures.axes_plots", "plot_shares"),
    "Comparison": ("figures.axes_plots", "plot_comparison"),
    "Calibration": ("figures.axes_plots", "plot_calibration"),
    "Diagnosis": ("figures.axes_plots", "plot_diagnosis"),
    "Sweep": ("figures.axes_plots", "plot_sweep"),
}
"""Class → module and function that draws it into axes."""
TABULATE = {
    "Comparison": ("words.result_tables", "tabulate_comparison"),
    "Calibration": ("words.result_tables", "tabulate_calibration"),
    "Diagnosis": ("words.result_tables", "tabulate_diagnosis"),
    "Sweep": ("words.result_tables", "tabulate_sweep"),
}
"""Class → module and function that makes a table of it."""


def tell(what: Any) -> str:
    """As a person reads it in a terminal: with one sign for minus."""
    return write_minus(str(_function(TELL, what)(what)))


def summarise(what: Any) -> dict[str, Any]:
    """As a machine reads it."""
    return dict(_function(SUMMARISE, what)(what))


def plot(what: Any, names: Sequence[str], axes: Axes | None) -> Axes:
    """As a picture, in axes."""
    drawn: Axes = _function(PLOT, what)(what, names, axes)
    return drawn


def tabulate(what: Any) -> tuple[list[str], list[list[Any]]]:
    """As a table: header and rows."""
    header, rows = _function(TABULATE, what)(what)
    return header, rows


def _function(table: dict[str, tuple[str, str]], what: Any) -> Any:
    module, name = table[type(what).__name__]
    return getattr(import_module(f"network.report.{module}"), name)
