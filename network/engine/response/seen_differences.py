"""Slopes by numbers that only change what is seen of a run: levers of the tool, and what sensors make of the truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.entry_path import EntryPath
from network.catalogue.declaration.sections import TCP
from network.engine.response.parameters import at_values
from network.engine.response.prediction import Prediction
from network.machine.machine import Machine


def is_seen_only(machine: Machine, path: EntryPath) -> bool:
    """Whether numbers of an entry leave temperatures and states as they are: then no run is needed to read them."""
    if path.section == "sensors":
        return not any(effect.has_state for effect in machine.sensors[path.name].effects)
    return path.section == TCP


def differ_as_seen(
    path: EntryPath, value: Mapping[str, float], step: float, predictions: Sequence[Prediction]
) -> list[Array]:
    """Changes of the channels of every run (channels, 2 K) over `step`, once an entry has the number `value`; only the
    channels that see the entry are read."""
    machine = at_values(predictions[0].machine, value)
    if path.section == TCP:
        machine = replace(machine, tcp={path.axis: machine.tcp[path.axis]})
    return [_difference(machine, path, step, q) for q in predictions]


def _difference(machine: Machine, path: EntryPath, step: float, prediction: Prediction) -> Array:
    names = prediction.run.channels
    own = [i for i, name in enumerate(names) if sees(machine, name, path)]
    out = np.zeros_like(prediction.values)
    if own:
        read = prediction.read(machine, prediction.course.readings, [names[i] for i in own])
        out[own] = (read - prediction.values[own]) / step
    return out


def sees(machine: Machine, name: str, path: EntryPath) -> bool:
    """Whether a channel can change with a number of the entry."""
    return machine.sensors[name].axis == path.axis if path.section == TCP else name == path.name
