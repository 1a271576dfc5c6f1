"""What every baseline begins with: the files of a case, and the machine as written, calibrated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from network import Machine, Recording
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.cli.proof_case import description
from network.recordings.load_source import load_recording

SURE = 0.5
"""Confidence of a name that comes without one."""


@dataclass(frozen=True, eq=False)
class Given:
    """A machine file and the recordings to learn from."""

    machine: Machine
    recordings: tuple[Recording, ...]

    @classmethod
    def load(cls, case: Path) -> Given:
        recordings = (load_recording(case / name) for name in description(case)["train"])
        return cls(Machine.load(case / "machine.yaml"), tuple(recordings))

    @cached_property
    def case(self) -> Case:
        return Case(self.machine, self.recordings)

    @cached_property
    def calibrated(self) -> Hypothesis:
        """As written, under the white noise of the file; sensors may be off by a constant."""
        return fit_hypothesis(self.case, self.machine)

    @cached_property
    def sensed(self) -> dict[str, str]:
        """Sensor by the part it touches, the first of each, where all recordings have it."""
        known = set.intersection(*({*r.columns} for r in self.recordings))
        pairs = [(s.place.node, name) for name, s in self.machine.sensors.items() if s.place and name in known]
        return dict(reversed(pairs))


def found(kind: str, *places: str) -> dict[str, Any]:
    """An answer that names one thing."""
    named: Mapping[str, Any] = {"kind": kind, "places": list(places), "channels": [], "confidence": SURE}
    return {"verdict": "missing_physics", "findings": [named]}


def nothing() -> dict[str, Any]:
    return {"verdict": "adequate", "findings": []}
