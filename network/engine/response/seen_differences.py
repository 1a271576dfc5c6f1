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
    path: EntryPath, value: Mapping[str, float], step: float, predictions: Sequence[Prediction], cells: bool = False
) -> list[Array]:
    """Changes of the channels of every run (channels, 2 K) over `step`, once an entry has the number `value`, or of
    their cells' means (channels · cells); only the channels that see the entry are read."""
    machine = at_values(predictions[0].machine, value)
    if path.section == TCP:
        machine = replace(machine, tcp={path.axis: machine.tcp[path.axis]})
    return [_difference(machine, path, step, q, cells) for q in predictions]


def _difference(machine: Machine, path: EntryPath, step: float, prediction: Prediction, cells: bool) -> Array:
    names = prediction.run.channels
    own = [i for i, name in enumerate(names) if sees(machine, name, path)]
    if not own:
        return np.zeros_like(prediction.cells if cells else prediction.values)
    changes = _change(machine, path, prediction, own) / step
    changes = prediction.averages.of(changes, own) if cells else changes
    out = np.zeros((len(names), changes.shape[1]))
    out[own] = changes
    return out.reshape(-1) if cells else out


def _change(machine: Machine, path: EntryPath, prediction: Prediction, own: Sequence[int]) -> Array:
    """Of some channels, which see the entry (own, 2 K)."""
    sensors = [machine.sensors[prediction.run.channels[i]] for i in own]
    if path.section != TCP or any(sensor.effects for sensor in sensors):
        names = [prediction.run.channels[i] for i in own]
        return np.asarray(prediction.read(machine, prediction.course.readings, names) - prediction.values[own])
    moved = _move_axis(machine, path, prediction)
    return np.array([moved - moved[0] if sensor.zero else moved for sensor in sensors]).reshape(len(own), len(moved))


def _move_axis(machine: Machine, path: EntryPath, prediction: Prediction) -> Array:
    """By how much an entry moves its axis more with other numbers (2 K): the others of the axis stay as they are."""
    entry, readouts = machine.tcp[path.axis][path.name], prediction.course.readouts
    keys = (("reading", path.axis, path.name, str(i)) for i, _ in enumerate(entry.readings()))
    rows = [readouts.read(key, prediction.course.readings) for key in keys]
    before = prediction.machine.tcp[path.axis][path.name].movement(prediction.inputs, *rows)
    return np.asarray(entry.movement(prediction.inputs, *rows) - before)


def sees(machine: Machine, name: str, path: EntryPath) -> bool:
    """Whether a channel can change with a number of the entry."""
    return machine.sensors[name].axis == path.axis if path.section == TCP else name == path.name
