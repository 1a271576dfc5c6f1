"""calibration.json: numbers with their uncertainty, what they are tied to, how well the machine then fits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from network.analysis.calibration.band_coverage import pool_coverage
from network.platform.quantities.units import difference, unit
from network.recordings.hygiene.set_aside import summarise_excluded

if TYPE_CHECKING:
    from network.analysis.calibration.calibrate import Calibration
    from network.analysis.comparison.compare import Comparison
    from network.engine.response.parameters import Parameter

STRONGLY = 0.9


def summary(c: Calibration) -> dict[str, Any]:
    pairs = [
        {"a": c.parameters[i].path, "b": c.parameters[j].path, "correlation": r} for i, j, r in c.known.pairs(STRONGLY)
    ]
    return {
        "machine": c.original.file, "parameters": [_parameter(c, j) for j in range(len(c.parameters))],
        "correlations": pairs, "noise": noise_summary(c), "misfit": c.known.misfit,
        "fit": {"train": _before_after(c, c.before, c.after, c.stated),
                "holdout": _before_after(c, c.before_holdout, c.after_holdout, c.stated_holdout)},
        "tcp_bands": [{"recording": r.recording.file, "axes": [b.summary() for b in own]}
                      for r, own in zip(_all(c), c.bands, strict=True)],
        "coverage": {"inside": pool_coverage(c.coverage), "channels": [k.summary() for k in c.coverage]},
        "validity": c.machine.validity.to_plain() if c.machine.validity else None,
        "one_machine": {"agree": not c.disagreements, "numbers": [d.summary() for d in c.disagreements]},
        "warnings": list(c.warnings), "sentences": list(c.sentences), "beginnings": c.tried, "seed": c.seed,
        "seconds": c.seconds, "lumping": None if c.cut is None else c.cut.summary(),
    }  # fmt: skip


def _all(c: Calibration) -> list[Any]:
    return [*c.after.recordings, *(c.after_holdout.recordings if c.after_holdout else ())]


def _parameter(c: Calibration, j: int) -> dict[str, Any]:
    p, theta = c.parameters[j], float(c.theta[j])
    low, high = (p.to_unit(p.value(x)) for x in c.known.interval(j))
    moved = float(c.shift[j])
    return {
        "path": p.path, "value": p.to_unit(p.value(theta)), "std": p.std_to_unit(p.std(theta, float(c.std[j]))),
        "unit": p.field.unit, "interval95": [low, high], "prior": prior(p),
        "shift": moved if np.isfinite(moved) else None,
        "at_bound": j in c.known.at_bound, "prior_only": j in c.known.prior_only,
    }  # fmt: skip


def prior(p: Parameter) -> dict[str, Any]:
    """kind: log (std is that of the logarithm), normal, unknown (low, high)."""
    kind = "log" if p.is_log else "normal"
    if p.is_unknown:
        return {"kind": "unknown", "low": p.to_unit(p.value(p.low)), "high": p.to_unit(p.value(p.high))}
    return {"kind": kind, "value": p.to_unit(p.value(p.centre)), "std": told_std(p, p.spread)}


def told_std(p: Parameter, std: float) -> float:
    """1σ of a number: that of its logarithm, or in its unit."""
    return std if p.is_log else p.std_to_unit(std)


def noise_summary(c: Calibration) -> dict[str, Any]:
    """Of every channel: declared noise, noise counted with, readings set aside, offset, colour."""
    offsets = dict(zip([n.name for n in c.fit.at.problem.offsets], c.fit.at.eta.tolist(), strict=False))
    out: dict[str, Any] = {}
    for name, sensor in c.original.sensors.items():
        used = [d for d in c.data if name in d.run.channels]
        if used:
            scale = difference(unit(sensor.unit)).scale
            coloured = c.noise.coloured.get(name)
            out[name] = {
                "declared": sensor.sigma / scale, "counted": max(float(d.sigma[name]) for d in used) / scale,
                "unit": "K" if sensor.unit == "degC" else sensor.unit,
                "set_aside": sum(int(d.channels[name].apart.sum()) for d in used),
                "offset": offsets[name] / scale if name in offsets else None,
                "coloured": {"std": coloured[0] / scale, "seconds": coloured[1]} if coloured else None,
            }  # fmt: skip
    return out


def _before_after(
    c: Calibration, before: Comparison | None, after: Comparison | None, stated: Comparison | None
) -> dict[str, Any] | None:
    if before is None or after is None or stated is None:
        return None
    units = {n: sensor.unit for n, sensor in c.original.sensors.items()}
    runs = [{"file": r.recording.file, **r.constants.summary(units)} for r in after.recordings if r.constants]
    return {"before": _residuals(before), "after": _residuals(after), "after_as_stated": _residuals(stated),
            "runs": runs}  # fmt: skip


def _residuals(comparison: Comparison) -> dict[str, Any]:
    from network.analysis.calibration.calibrate import pool_channels

    each = [
        {
            "file": r.recording.file,
            "rmse_in_noise": r.rmse_in_noise,
            "excluded": summarise_excluded(r.recording.excluded or ()),
        }
        for r in comparison.recordings
    ]
    return {
        "rmse_in_noise": comparison.rmse_in_noise,
        "channels": dict(pool_channels(comparison)),
        "recordings": each,
    }
