"""Largest residual: where the calibrated machine is worst, and the name that a person would try there first."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from bench.baselines.given import Given, found, nothing
from numpy.typing import NDArray

from network import Recording
from network.analysis.calibration.estimated_constants import compare_estimating
from network.analysis.comparison.channel_residual import ChannelResidual, pool_residuals
from network.catalogue.declaration.declare import Array

FITS = 1.5
"""Noise units rms up to which a channel is let pass."""
FOLLOWS = 2.0
"""Mean residual while the spindle runs over that while it stands, from which it is put down to the speed."""


def largest_residual(given: Given) -> dict[str, Any]:
    """Too warm only while running: windage; too cold then: a fan. Too warm always: a source; too cold: a loss."""
    told = compare_estimating(given.calibrated.numbers, given.recordings).recordings
    known = set.intersection(*({*r.channels} for r in told))
    misfit = {name: pool_residuals(r.channels[name] for r in told) for name in known}
    worst = max(misfit, key=lambda name: misfit[name])
    if misfit[worst] < FITS:
        return nothing()
    sensor = given.machine.sensors[worst]
    if sensor.place is None:
        return found("stretching", f"tcp.{sensor.axis}")
    running, standing = means(given.recordings, [r.channels[worst] for r in told])
    size = running if abs(running) > abs(standing) else standing
    with_speed = abs(running) > FOLLOWS * abs(standing)
    kinds = ("windage", "forced_convection") if with_speed else ("heat_source", "convection")
    return found(kinds[size < 0], sensor.place.node, *([] if size > 0 else ["ambient"]))


def means(runs: Sequence[Recording], residuals: Sequence[ChannelResidual]) -> tuple[float, float]:
    """Mean residual while the spindle turns and while it stands."""
    rest = np.concatenate([c.residual for c in residuals])
    on = np.concatenate([turning(r, c.t) for r, c in zip(runs, residuals, strict=True)])
    warm, cold = (rest[np.isfinite(rest) & of] for of in (on, ~on))
    return float(warm.mean()) if len(warm) else 0.0, float(cold.mean()) if len(cold) else 0.0


def turning(recording: Recording, t: Array) -> NDArray[np.bool_]:
    known = {*recording.columns, *recording.constants}
    return np.abs(recording.signal("speed").at(t)) > 0 if "speed" in known else np.zeros(len(t), bool)
