"""Heat that a diagnosis put in against the heat that was hidden: do they go together, and are they as much?"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from bench.rigs.case import Tree

from network import Failed, Machine, Recording, Refused, simulate
from network.catalogue.declaration.declare import Array

PIECES = 24
"""Stretches of a run whose mean heat flows are compared."""


@dataclass(frozen=True)
class Recovered:
    """correlation: of mean heat flows over the pieces of the training runs; energy: share of what was hidden."""

    correlation: float
    energy: float


def recovered(
    original: Path, hidden: tuple[str, ...], diagnosed: Path, concealed: Path, truth: list[Path], given: list[Path]
) -> Recovered | None:
    """original, truth: machine and mappings with nothing hidden; None where no source was put in."""
    added = tuple(sorted({*_sources(diagnosed)} - {*_sources(concealed)}))
    if not added:
        return None
    try:
        wanted = np.concatenate([flows(original, hidden, path) for path in truth])
        found = np.concatenate([flows(diagnosed, added, path) for path in given])
    except (Failed, Refused):
        return None
    spread = float(wanted.std() * found.std())
    together = float(np.mean((wanted - wanted.mean()) * (found - found.mean()))) / spread if spread > 0 else 0.0
    return Recovered(together, float(found.sum() / wanted.sum()))


def _sources(path: Path) -> Tree:
    machine: Tree = Machine.load(path).to_plain().get("sources", {})
    return machine


def flows(machine: Path, names: tuple[str, ...], mapping: Path) -> Array:
    """Mean heat [J] of sources over the pieces of a run: differences of what went in until then."""
    loaded, run = Machine.load(machine), Recording.load(mapping)
    went = [_energy(loaded, names, run.until(share)) for share in np.linspace(0, 1, PIECES + 1)[1:]]
    return np.diff([0.0, *went])


def _energy(machine: Machine, names: tuple[str, ...], run: Recording) -> float:
    heat = simulate(machine, run, parts=False).energy.by_mechanism
    return sum(heat[f"sources.{name}"] for name in names)
