"""Whether readings of temperatures can be true of a machine tool, and whether one of them is in another unit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from network.catalogue.declaration.declare import Array
from network.machine.machine import Machine
from network.platform.quantities.text_table import digits
from network.platform.quantities.units import unit
from network.platform.refusal import Complaints, Spot
from network.recordings.columns import Column
from network.recordings.possible_input import COLDEST_INPUT
from network.recordings.recording import Recording
from network.recordings.yaml_values import COLDEST, HOTTEST

MOST = 0.9
"""Of the readings: fewer that cannot be true are a loose contact, which is looked for later."""
USUAL = (-30.0, 150.0)
FIRST_READINGS = 60.0
"""s: the stretch whose median is where a channel starts."""
NEAR, CLOSE = 5.0, 4.0
"""K: how near to each other the other channels start, and how close to their start in another unit the odd one."""
AGREE = 2 / 3


def check_readings(machine: Machine, recording: Recording, complaints: Complaints) -> None:
    """Complains of channels and inputs whose temperatures no machine tool has."""
    for name, column in temperatures(machine, recording).items():
        low = COLDEST if name in machine.sensors else COLDEST_INPUT
        values = column.values[np.isfinite(column.values)]
        wrong = values[(values < low) | (values > HOTTEST)]
        if len(wrong) > MOST * len(values):
            told, right = _impossible(column, float(np.median(wrong)))
            complaints.refuse(Spot(recording.file, 1), f"{name} {told}", right)


def _impossible(column: Column, value: float) -> tuple[str, str]:
    """What a channel reads, and the unit in which that would be usual."""
    given = unit(column.unit)
    number = given.from_si(value)
    in_celsius = f" = {digits(value)} °C" if given.text != "degC" else ""
    near = [u for u in ("degC", "degF", "K") if USUAL[0] <= unit(u).to_si(number) <= USUAL[1]]
    usual = f"is it in {near[0]}?" if near and near[0] != given.text else "check the sensor and the unit in its header"
    return f"reads {digits(number)} {given.text}{in_celsius}, which no part of a machine tool has", usual


def doubtful_units(machine: Machine, recording: Recording) -> Iterator[str]:
    """Sentences on channels that start where the others would if they were told in another unit."""
    for name, text, above in misread_units(machine, recording):
        yield f"{recording.file}: {name} starts {above:.0f} K above the other temperatures; is it in {text}?"


def misread_units(machine: Machine, recording: Recording) -> Iterator[tuple[str, str, float]]:
    """Such channels, the unit, and how far above the others each starts as it stands [K]."""
    starts = {name: _start(recording.t, c.values) for name, c in temperatures(machine, recording).items()}
    for name in [name for name in starts if name in machine.sensors]:
        others = np.array([T for other, T in starts.items() if other != name and np.isfinite(T)])
        middle = float(np.median(others)) if len(others) else np.nan
        if not len(others) or np.mean(np.abs(others - middle) < NEAR) < AGREE:
            continue
        for text in ("degF", "K"):
            if abs(starts[name] - unit(text).from_si(middle)) < CLOSE:
                yield name, text, starts[name] - middle


def _start(t: Array, values: Array) -> float:
    early = values[(t <= t[0] + FIRST_READINGS) & np.isfinite(values)]
    return float(np.median(early)) if len(early) else np.nan


def temperatures(machine: Machine, recording: Recording) -> Mapping[str, Column]:
    """Channels and inputs of a machine that are temperatures and not differences."""
    sensed = [name for name, sensor in machine.sensors.items() if sensor.place and not sensor.zero]
    names = [*sensed, *(name for name in machine.inputs if name not in sensed)]
    columns = {name: recording.columns[name] for name in names if name in recording.columns}
    return {name: column for name, column in columns.items() if unit(column.unit).is_temperature}
