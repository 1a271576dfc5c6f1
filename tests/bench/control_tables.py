"""Two numbers an axis on six recordings of two rigs: what they leave of the movement on a day they were not fitted on.

`python -m bench.control_tables` from the folder tests/. Each rig is calibrated on its days; then every day is told by
the table fitted along the others (their only other day, where there are two), and by the filter of the C file without
its sensors, both beside the full model.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from network import Machine, calibrate, simulate
from network.analysis.correction.correction import make_correction
from network.analysis.correction.temperature_formula import Formula, fit_formulas
from network.engine.trajectory import Trajectory
from network.recordings.load_source import load_recording
from network.recordings.recording import Recording

ROOT = Path(__file__).parents[2]
RIGS = {
    "lathe_warm_up": ("lathe_day01", "lathe_day02", "lathe_day03", "lathe_day04"),
    "heated_gantry": ("voron_2021_06_05", "voron_2021_06_13"),
}
Row = tuple[str, str, float, float, float, str]


def rows_of(machine: Machine, days: Sequence[Recording]) -> Iterator[Row]:
    """Of every day: its name, axis, largest movement, what the table of the others leaves, what the filter loses [µm],
    and the sensor that the table reads."""
    for day in days:
        others = [other for other in days if other is not day]
        run = simulate(machine, day)
        lost = make_correction(machine, [day]).losses[0].by_axis
        for formula in fit_formulas(machine, others).formulas:
            moved = float(np.abs(run.tcp[formula.axis]).max())
            left = float(np.abs(run.tcp[formula.axis] - told(formula, run)).max())
            yield (day.name, formula.axis, 1e6 * moved, 1e6 * left, 1e6 * lost[formula.axis], formula.sensors[0])


def told(formula: Formula, run: Trajectory) -> np.ndarray:
    """What a table says along a run [m]."""
    rises = [run.sensors[name] - formula.reference for name in formula.sensors]
    return formula.offset + sum(b * rise for b, rise in zip(formula.by_sensor, rises, strict=True))


def main() -> None:
    table = Table(title="Two numbers an axis, on a day they were not fitted on [µm]")
    for column in ("rig", "recording", "axis", "moves", "table leaves", "C file loses", "table reads"):
        table.add_column(column)
    for rig, names in RIGS.items():
        days = [load_recording(ROOT / "tests" / "recordings" / f"{name}.yaml") for name in names]
        machine = calibrate(Machine.load(ROOT / "machines" / f"{rig}.yaml"), days).machine
        for name, axis, moved, left, lost, sensor in rows_of(machine, days):
            table.add_row(rig, name, axis, f"{moved:.1f}", f"{left:.1f}", f"{lost:.2f}", sensor)
    Console(width=130).print(table)


if __name__ == "__main__":
    main()
