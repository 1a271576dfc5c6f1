"""Scenarios: what drives a simulation over time, from a file or from plain Python values."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import word_of
from network.platform.printing import Result
from network.platform.quantities.units import BadNumber
from network.platform.refusal import Complaints, Spot
from network.platform.yaml import document
from network.platform.yaml.document import Branch, Tree
from network.recordings.inputs import Schedule
from network.recordings.scenario_inputs import MOST_SAMPLES, signals
from network.recordings.scenario_phases import read_phases
from network.recordings.yaml_values import check_keys, collecting, parse_start, read_keys, seconds

_DAY = 86400.0
USUAL_OUTPUT = 10.0
"""s; shorter where a run has fewer than a hundred of them."""


@dataclass(frozen=True, eq=False, repr=False)
class Scenario(Result):
    """Inputs over a duration. `schedule` drives a simulation; its instants are 0, output, 2 output … and the end.

    output: [s] between two of them.
    """

    schedule: Schedule
    output: float

    @property
    def name(self) -> str:
        return self.schedule.name

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.schedule.t[-1])

    @classmethod
    def load(cls, path: str | Path) -> Scenario:
        """The scenario of a YAML file. Raises Refused with every fault found."""
        return _read(document.load(Path(path), "a scenario"), Path(path).parent)

    @classmethod
    def of(
        cls, name: str, duration: str | None = None, inputs: Mapping[str, Any] | None = None, output: str = "10 s",
        start: str | Mapping[str, str] | None = None, folder: str | Path = ".",
        phases: Sequence[Mapping[str, Any]] | None = None,
    ) -> Scenario:  # fmt: skip
        """The same from Python values written as in a file; `folder` is where paths start. Raises Refused."""
        given = {"scenario": name, "duration": duration, "output": output, "start": start, "inputs": inputs,
                 "phases": phases}  # fmt: skip
        tree = document.tree_of({key: value for key, value in given.items() if value is not None}, Spot("python"))
        assert isinstance(tree, Branch)
        return _read(tree, Path(folder))

    def __str__(self) -> str:
        return f"{self.name}: {self.duration / 3600:g} h, inputs {', '.join(self.schedule.signals) or 'none'}"


def _read(tree: Branch, folder: Path) -> Scenario:
    complaints = Complaints()
    needed = {"scenario": "name"} if "phases" in tree.items else {"scenario": "name", "duration": "4 h"}
    others = ("duration", "output", "start", "inputs", "phases")
    check_keys(tree, "the scenario", needed, [key for key in others if key not in needed], complaints)
    values: dict[str, Any] = {"output": None, "start": None, "inputs": {}}
    readers: dict[str, Callable[[Tree], Any]] = {
        "scenario": lambda child: word_of(child, "a name"),
        "duration": seconds,
        "phases": lambda child: read_phases(child, values.get("duration")),
        "output": seconds,
        "start": parse_start,
        "inputs": lambda child: signals(child, _duration(values) or _DAY, folder),
    }
    read_keys(tree, readers, values, complaints)
    duration, rows = _duration(values), values.get("phases", ({}, 0.0))[0]
    _check_once(tree, rows, complaints)
    if duration:
        with collecting(complaints, tree.key_spot("output"), "output"):
            values["output"] = values["output"] or min(USUAL_OUTPUT, duration / 100)
            values["t"] = _instants(duration, values["output"])
    complaints.raise_if_any()
    given = {**values["inputs"], **rows}
    return Scenario(Schedule(values["scenario"], tree.spot.file, values["t"], given, values["start"]), values["output"])


def _duration(values: Mapping[str, Any]) -> float | None:
    """As given, else as long as all phases together [s]; None where neither could be read."""
    duration: float | None = values.get("duration") or values.get("phases", ({}, None))[1]
    return duration


def _check_once(tree: Branch, rows: Mapping[str, Any], complaints: Complaints) -> None:
    """Complains about what stands in `phases` and in `inputs`."""
    inputs = tree.items.get("inputs")
    for name in rows:
        if isinstance(inputs, Branch) and name in inputs.items:
            complaints.refuse(inputs.key_spot(name), f"inputs.{name} is given in `phases` as well", "give it once")


def _instants(duration: float, output: float) -> Array:
    """0, output, 2 output … and the end."""
    if not output <= duration:
        raise BadNumber(f"{output:g} s is longer than the duration, {duration:g} s", f"give {duration / 100:g} s, say")
    if not duration / output <= MOST_SAMPLES:
        wrong = f"{output:g} s makes more than {MOST_SAMPLES / 1e6:g} million samples in {duration:g} s"
        raise BadNumber(wrong, f"give {duration / MOST_SAMPLES:.3g} s or more")
    t = np.arange(math.floor(duration / output * (1 + 1e-12)) + 1, dtype=np.float64) * output
    if duration - t[-1] > 1e-9 * output:
        return np.append(t, duration)
    t[-1] = duration
    return t
