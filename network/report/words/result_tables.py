"""Results as tables: a header with units, and rows of plain values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

from network.report.words.sweep_words import level_table, run_table

if TYPE_CHECKING:
    from network.analysis.calibration.calibrate import Calibration
    from network.analysis.comparison.compare import Comparison
    from network.analysis.diagnosis.findings.result import Diagnosis
    from network.analysis.sweep.sweep import Sweep

Table: TypeAlias = tuple[list[str], list[list[Any]]]


def tabulate_comparison(comparison: Comparison) -> Table:
    """A row for each channel of each recording."""
    rows = []
    for residual in comparison.recordings:
        for name, channel in residual.channels.items():
            told = channel.summary()
            numbers = [told[key] for key in ("rmse_in_noise", "rmse", "max", "unit", "n")]
            rows.append([residual.recording.file, name, *numbers])
    return ["recording", "channel", "rmse [σ]", "rmse", "max", "unit", "n"], rows


def tabulate_calibration(calibration: Calibration) -> Table:
    """A row for each number that was free."""
    rows = []
    for told in calibration.summary()["parameters"]:
        low, high = told["interval95"]
        before = told["prior"].get("value")
        rows.append([told["path"], told["unit"], before, told["value"], told["std"], low, high, told["shift"]])
    return ["number", "unit", "before", "calibrated", "±", "95 % from", "95 % to", "moved [σ]"], rows


def tabulate_sweep(sweep: Sweep) -> Table:
    """A row for each level, or for each point of the grid."""
    columns, rows = run_table(sweep) if sweep.runs else level_table(sweep)
    return [str(column) for column in columns], [list(row) for row in rows]


def tabulate_diagnosis(diagnosis: Diagnosis) -> Table:
    """A row for each finding."""
    places = [", ".join((*f.places, *f.channels)) for f in diagnosis.findings]
    found = zip(diagnosis.findings, places, strict=True)
    rows = [[f.kind, place, f.confidence, f.part, f.whole_sentence] for f, place in found]
    return ["kind", "at", "confidence", "part", "finding"], rows
