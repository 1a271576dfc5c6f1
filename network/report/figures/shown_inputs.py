"""Which inputs a picture shows below what is off: those that it follows first, then what drives the machine."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from network.platform.quantities.units import unit
from network.platform.refusal import Refused
from network.recordings.inputs import Signal
from network.report.figures.run_figure import is_speed

if TYPE_CHECKING:
    from network.analysis.comparison.compare import RecordingResidual

MOST = 2
"""Inputs below a picture of one recording."""


def choose_inputs(residual: RecordingResidual) -> list[Signal]:
    """What the residuals of a recording follow, the strongest first; then the speed, else an input that varies."""
    usual = rank_inputs([residual])[:1]
    followed = [name for name in followed_inputs([residual]) if signal_of(residual, name) is not None]
    names = list(dict.fromkeys([*followed[: MOST - 1], *usual, *followed]))[:MOST]
    found = (signal_of(residual, name) for name in names)
    return [signal for signal in found if signal is not None]


def followed_inputs(residuals: Iterable[RecordingResidual]) -> list[str]:
    """Inputs and unused columns that residuals follow, by how much of them they account for."""
    weight: dict[str, float] = defaultdict(float)
    for residual in residuals:
        for tests in residual.tests.values():
            for driver in tests.drivers:
                weight[driver.of] += driver.weight
    return sorted(weight, key=lambda name: -weight[name])


def rank_inputs(residuals: Sequence[RecordingResidual]) -> list[str]:
    """Inputs that vary in any recording, speeds first, temperatures last; all where none does."""
    order: dict[str, tuple[bool, bool, bool]] = {}
    for residual in residuals:
        for name in residual.trajectory.inputs:
            signal = residual.trajectory.schedule.signals[name]
            still = bool(np.ptp(np.concatenate([signal.start, signal.end])) == 0)
            told = (still, not is_speed(signal), unit(signal.unit).is_temperature)
            order[name] = min(order.get(name, told), told)
    moving = [name for name, (still, _, _) in order.items() if not still] or list(order)
    return sorted(moving, key=lambda name: order[name])


def signal_of(residual: RecordingResidual, name: str) -> Signal | None:
    """An input, or a column that the machine does not read; None for one with gaps."""
    if name in residual.trajectory.schedule.signals:
        return residual.trajectory.schedule.signals[name]
    try:
        return residual.recording.signal(name)
    except Refused:
        return None
