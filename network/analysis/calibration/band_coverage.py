"""Whether bands hold: the share of readings of the tool centre point inside their 95 %.

A reading is inside where |measured − simulated| ≤ 1.96 √(σ_θ² + left² + σ²), σ the declared noise of one sample, σ_θ of
the channel itself, as it is zeroed and as its effects change it. Readings of one run lie off together, so that a share
is as sure as there are runs, not readings.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from network.analysis.calibration.tcp_bands import Posterior, run_of, spread_of
from network.analysis.calibration.uncertainty import LEVEL
from network.analysis.comparison.compare import Comparison, RecordingResidual
from network.machine.machine import Machine
from network.platform.quantities.text_table import digits


@dataclass(frozen=True)
class Coverage:
    """Of one channel of one recording: share of its n readings that lie inside the band."""

    file: str
    channel: str
    inside: float
    n: int

    @property
    def sentence(self) -> str:
        return f"{self.file}: {digits(100 * self.inside, 3)} % of the readings of {self.channel} are inside their band"

    def summary(self) -> dict[str, Any]:
        return {"file": self.file, "channel": self.channel, "inside": self.inside, "n": self.n}


def measure_coverage(machine: Machine, comparison: Comparison | None) -> tuple[Coverage, ...]:
    """Of every displacement channel of every recording that was compared; none for a machine without calibration."""
    known = machine.validity
    if known is None or comparison is None:
        return ()
    numbers = Posterior.of(machine, known.root)
    return tuple(c for r in comparison.recordings for c in _measure(machine, numbers, r))


def _measure(machine: Machine, numbers: Posterior, r: RecordingResidual) -> Iterator[Coverage]:
    names = [n for n, c in r.channels.items() if machine.sensors[n].axis is not None and c.n]
    if not names or machine.validity is None:
        return
    t, _, spread = spread_of(machine, numbers, run_of(machine, r.recording, r.trajectory.schedule.start), names)
    for name, std in zip(names, spread, strict=True):
        channel, left = r.channels[name], machine.validity.left.get(machine.sensors[name].axis or "", 0.0)
        half = LEVEL * np.sqrt(np.interp(channel.t, t, std) ** 2 + left**2 + channel.sigma**2)
        inside = np.abs(channel.residual[channel.finite]) <= half[channel.finite]
        yield Coverage(r.recording.file, name, float(inside.mean()), channel.n)


def pool_coverage(several: tuple[Coverage, ...]) -> float | None:
    """Share of all readings."""
    n = sum(c.n for c in several)
    return sum(c.inside * c.n for c in several) / n if n else None
