"""The constants of a run: what a recording does not tell exactly and a machine is not to blame for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from network.analysis.comparison.channel_residual import ChannelResidual
from network.platform.quantities.units import difference, unit
from network.recordings.recording import Recording

HELD_OUT_SHARE, HELD_OUT_MOST, FEW = 0.1, 1800.0, 10
"""Of a held-out run, and s of it at most (or as many samples, where these are further apart), from which its constants
are found; that stretch is not scored."""


@dataclass(frozen=True)
class InputConstant:
    """An input that was constant and not known exactly. value, std: SI; unit: shown."""

    value: float
    std: float
    unit: str

    def summary(self) -> dict[str, Any]:
        of = unit(self.unit)
        return {"value": of.from_si(self.value), "std": self.std / difference(of).scale, "unit": self.unit}


@dataclass(frozen=True, eq=False)
class RunConstants:
    """start: temperature of every part at the start [°C]; inputs: uncertain constants that drive the run; offsets:
    constant errors of its sensors [SI]; scored_from: s, readings before it told these and are not scored; absorbed:
    share of the squared residual that inputs and offsets take away, in the readings that told them."""

    start: Mapping[str, float]
    inputs: Mapping[str, InputConstant] = field(default_factory=dict)
    offsets: Mapping[str, float] = field(default_factory=dict)
    scored_from: float = -np.inf
    absorbed: float = 0.0

    def drive(self, recording: Recording) -> Recording:
        """The recording with its uncertain inputs as found."""
        given = recording.constants
        found = {n: replace(given[n].shift(c.value - given[n].value), std=0.0) for n, c in self.inputs.items()}
        return replace(recording, constants={**given, **found})

    def correct(self, channel: ChannelResidual) -> ChannelResidual:
        """A channel less its constant error, where it is scored."""
        measured = channel.measured - self.offsets.get(channel.name, 0.0)
        return replace(channel, measured=np.where(channel.t >= self.scored_from, measured, np.nan))

    def summary(self, units: Mapping[str, str]) -> dict[str, Any]:
        """As JSON; units: of the channels."""
        offsets = {n: {"value": x / difference(unit(units[n])).scale, "unit": "K" if units[n] == "degC" else units[n]}
                   for n, x in self.offsets.items()}  # fmt: skip
        return {
            "start": {n: f"{T:.3f} degC" for n, T in self.start.items()},
            "inputs": {n: c.summary() for n, c in self.inputs.items()}, "offsets": offsets,
            "scored_from": self.scored_from if np.isfinite(self.scored_from) else None,
            "share_absorbed": self.absorbed,
        }  # fmt: skip


def find_scored_from(recording: Recording) -> float:
    """Where the part of a held-out run that is scored begins [s]."""
    t = recording.t
    most = max(HELD_OUT_MOST, FEW * float(np.median(np.diff(t))))
    return float(t[0] + min(HELD_OUT_SHARE * (t[-1] - t[0]), most))
