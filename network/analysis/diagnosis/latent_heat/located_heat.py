"""The heat, offset or temperature that one place would need for simulation and recordings to agree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from network.analysis.diagnosis.latent_heat.location import Location
from network.catalogue.declaration.declare import Array
from network.platform.printing import Brief


@dataclass(frozen=True, eq=False, repr=False)
class UnknownHeat(Brief):
    """Heat that a place would need for simulation and recordings to agree, before anything was added; at a channel it
    is an offset in the channel's unit, SI; of surroundings K beside what is given. t, heat, std: for each recording
    [s, W]; files: of these; size, ell: its 1σ and correlation time [s] at which it explains most."""

    at: Location
    probability: float
    rms: float
    gain: float
    t: tuple[Array, ...]
    heat: tuple[Array, ...]
    std: tuple[Array, ...]

    files: tuple[str, ...] = ()
    size: float = 0.0
    ell: float = np.inf

    @property
    def is_offset(self) -> bool:
        return self.at.kind == "channel"

    @property
    def is_room(self) -> bool:
        return self.at.kind == "surroundings"

    @property
    def quantity(self) -> str:
        """What it is."""
        return {"channel": "offset", "surroundings": "temperature"}.get(self.at.kind, "heat")

    @property
    def unit(self) -> str:
        """Of a heat or a temperature; an offset has that of its channel."""
        return "K" if self.is_room else "W"

    def list_courses(self) -> list[dict[str, Any]]:
        """Over time in every recording: heat [W], a temperature [K] or an offset [SI], with its 1σ."""
        runs = zip(self.files, self.t, self.heat, self.std, strict=True)
        return [{"file": f, "t": t.tolist(), self.quantity: x.tolist(), "std": s.tolist()} for f, t, x, s in runs]

    def summary(self) -> dict[str, Any]:
        """A part or a link with its heat, or surroundings with their temperature."""
        rms = {"value": self.rms, "unit": self.unit}
        return {"name": str(self.at), "probability": self.probability, f"{self.quantity}_rms": rms,
                **({"course": self.list_courses()} if self.files else {})}  # fmt: skip
