"""sweep.json: levels or varied numbers, what they give, and what stays within a tolerance."""

from __future__ import annotations

from typing import Any

from network.analysis.sweep.grid_runs import VariedRun
from network.analysis.sweep.level_runs import LevelRun
from network.analysis.sweep.sweep import Sweep
from network.analysis.sweep.variations import Extremes
from network.engine.trajectory import axis_unit
from network.platform.quantities.units import unit
from network.report.words.sweep_words import tell_tolerance


def summary(sweep: Sweep) -> dict[str, Any]:
    """What sweep.json holds and --json prints."""
    out: dict[str, Any] = {"machine": sweep.machine.name, "source": sweep.source}
    if sweep.runs:
        return out | {"vary": [v.summary() for v in sweep.variations], "runs": [_point(sweep, r) for r in sweep.runs]}
    out |= {"levels": [_level(sweep, run) for run in sweep.levels], "finest": sweep.finest.level}
    for form in (run.closed_form for run in sweep.levels if run.closed_form is not None):
        out["closed_form"] = form.summary()
    if sweep.tolerance is not None:
        level = sweep.coarsest_within.level if sweep.coarsest_within else None
        out["tolerance"] = sweep.tolerance.summary() | {"level": level, "sentence": tell_tolerance(sweep)}
    return out


def _level(sweep: Sweep, run: LevelRun) -> dict[str, Any]:
    tcp = {axis: Extremes.of(axis, values).summary() for axis, values in run.tcp.items()}
    for axis, told in tcp.items():
        if gap := sweep.gap(run, axis):
            scale = unit(axis_unit(axis)).scale
            told["difference"] = {"max": gap.largest / scale, "rms": gap.rms / scale}
    return {
        "level": run.level, "lumps": run.lumps, "tcp": tcp, "temperature_difference": sweep.temperature_gap(run),
        "rmse_in_noise": run.in_noise, "tcp_rmse_in_noise": run.tcp_in_noise,
        "solve_seconds": run.solve_seconds, "method": run.method,
    }  # fmt: skip


def _point(sweep: Sweep, run: VariedRun) -> dict[str, Any]:
    values = {v.path: value for v, value in zip(sweep.variations, run.values, strict=True)}
    return {"values": values, "tcp": {axis: extremes.summary() for axis, extremes in run.tcp.items()}}
