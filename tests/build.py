"""Small machines for the tests, written as in a file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from network import Machine
from network.platform.refusal import Spot
from network.platform.yaml.document import Branch, tree_of
from network.recordings.inputs import Schedule, Signal, hold

RPM = 2 * np.pi / 60


def machine(nodes: Mapping[str, Any], reference: str = "20 degC", **sections: Any) -> Machine:
    """A machine of plain values, as they would stand in YAML."""
    tree = tree_of({"machine": "test", "reference": reference, "nodes": nodes, **sections}, Spot("test"))
    assert isinstance(tree, Branch)
    return Machine.read(tree, "test")


def schedule(t: Any, *signals: Signal, start: Any = None) -> Schedule:
    return Schedule("test", "test", np.asarray(t, float), {signal.name: signal for signal in signals}, start)


def position(*steps: tuple[float, float]) -> Signal:
    """Held at each value [mm] from each instant [s]."""
    t, x = np.array(steps).T
    return hold("position", "mm", t, x * 1e-3)
