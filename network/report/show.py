"""What every result says of itself: in words for a terminal, and as the contents of a JSON file.

The function for a class is fetched when the first of its kind is printed, so that `lptn check` starts fast.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

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
    "Sample": ("words.sample_words", "tell_sample"),
    "Calibration": ("words.calibration_words", "tell_calibration"),
    "Foresight": ("words.experiment_plan_words", "tell_foresight"),
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


def tell(what: Any) -> str:
    """As a person reads it in a terminal."""
    return str(_function(TELL, what)(what))


def summarise(what: Any) -> dict[str, Any]:
    """As a machine reads it."""
    return dict(_function(SUMMARISE, what)(what))


def _function(table: dict[str, tuple[str, str]], what: Any) -> Any:
    module, name = table[type(what).__name__]
    return getattr(import_module(f"network.report.{module}"), name)
