"""A run that is proposed, and from how many σ it counts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

CLEAR = 3.0
"""σ from which a run counts as telling two explanations apart."""
FAINT = 1.0
"""σ below which a run tells nothing, and is not proposed."""


@dataclass(frozen=True)
class Experiment:
    """A run that would tell rivals apart: by how many σ, in how many hours. Where σ is not CLEAR, it is the best that
    was tried. scenario: the run as a scenario file holds it; empty where it is none."""

    text: str
    separates: tuple[str, ...]
    sigma: float
    hours: float
    scenario: Mapping[str, Any] = field(default_factory=dict)

    def summary(self) -> dict[str, Any]:
        return {"experiment": self.text, "separates": list(self.separates), "sigma": self.sigma, "hours": self.hours}


def experiment_file(number: int) -> str:
    """What the scenario of a proposed run is called, counted from 1."""
    return f"experiment-{number}.yml"
