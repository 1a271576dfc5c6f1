"""What the channels of a machine show along a program: the truth without noise, and recordings of it with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from proof.assembly import Assembly
from proof.programs import Program
from proof.running import STEP, Run, Track, air_of
from proof.system import Array


@dataclass(frozen=True)
class Noise:
    """What sensors add: a share of the variance that is coloured, quantisation [K], and a constant offset [K]."""

    coloured: float = 0.0
    memory: float = 90.0
    quantum: float = 0.01
    offset: float = 0.0


WHITE = Noise()
ROUGH = Noise(coloured=0.5, quantum=0.1, offset=0.1)


def weights_of(build: Assembly) -> tuple[Array, Array]:
    """Rows (channels × cells) and constants such that a reading is row · T + constant, in °C or µm."""
    rows, constants = [], []
    for name in build.layout.sensors:
        row = build.dense(build.readings[name])
        axis = build.layout.sensors[name].removeprefix("tcp.")
        for growth in build.layout.growths.values():
            if growth.axis == axis:
                material = build.layout.materials[build.layout.parts[growth.of.partition("@")[0]].material]
                stretch = growth.direction * material.expansion * growth.length
                row = row + 1e6 * stretch * build.dense(build.at(growth.of))
        rows.append(row)
        constants.append(-build.layout.reference * row.sum() if axis != build.layout.sensors[name] else 0.0)
    return np.array(rows), np.array(constants)


def track_of(build: Assembly, program: Program, start: Mapping[str, float], step: float = STEP) -> Track:
    """The run from `start` [°C], by part; what is not named there starts at the reference."""
    T = np.array([start.get(owner, build.layout.reference) for owner in build.owner])
    for row, weights in build.rows:
        T[row] = sum(w * T[cell] for cell, w in weights.items())
    return Run(build.freeze(), program, T, step).go()


def observe(
    build: Assembly, program: Program, start: Mapping[str, float], times: Array, step: float = STEP
) -> dict[str, Array]:
    """Every channel at the times, without noise."""
    rows, constants = weights_of(build)
    values = track_of(build, program, start, step).at(times, rows) + constants
    rpm, at = np.array([program.speed(t) for t in times]), air_of(build.airs, program)
    air = np.array([at(t) for t in times])
    shown = {name: values[:, i] for i, name in enumerate(build.layout.sensors)}
    for name, touches in build.touches.items():
        for touch in touches:
            shown[name] = touch(times, rpm, air, shown[name])
    zeroed = [name for name, place in build.layout.sensors.items() if build.layout.zeroed and place.startswith("tcp.")]
    return shown | {name: shown[name] - shown[name][0] for name in zeroed}


def disturbed(rng: Generator, values: Array, sigma: float, noise: Noise, offset: float) -> Array:
    """A reading with noise of standard deviation σ, white or partly of first order, and its offset; not rounded."""
    n = len(values)
    white, steps = rng.standard_normal(n), rng.standard_normal(n)
    keep = np.exp(-10.0 / noise.memory)
    slow = np.empty(n)
    last = steps[0]
    for i in range(n):
        slow[i] = last = keep * last + np.sqrt(1 - keep**2) * steps[i] if i else last
    mixed = np.sqrt(1 - noise.coloured) * white + np.sqrt(noise.coloured) * slow
    return np.asarray(values + sigma * mixed + offset)


@dataclass(frozen=True)
class Recording:
    """Columns as a file has them; `units` are told in its header."""

    columns: Mapping[str, Array]
    units: Mapping[str, str]
    digits: Mapping[str, int]

    def mapping(self, name: str, file: str, room: float, std: float) -> str:
        """The mapping that a user writes for it where the room [°C] was not recorded but is known to ± std [K]."""
        headings = [f"{column} [{self.units[column]}]" for column in self.columns]
        columns = [f'  "{heading}": "{heading}"' for heading in headings]
        inputs = f"inputs: {{ambient: {room:g} degC ± {std:g} K}}"
        lines = [f"recording: {name}", f"file: {file}", "columns:", *columns, inputs]
        return "\n".join(lines) + "\n"

    def text(self) -> str:
        head = ",".join(f"{name} [{self.units[name]}]" for name in self.columns)
        columns = [[f"{x:.{self.digits[name]}f}" for x in values] for name, values in self.columns.items()]
        return "\n".join([head, *(",".join(row) for row in zip(*columns, strict=True))]) + "\n"


def record(
    rng: Generator, program: Program, times: Array, shown: Mapping[str, Array], sigmas: Mapping[str, float],
    noise: Noise = WHITE, offsets: Mapping[str, float] | None = None, feed: Array | None = None,
    has_room: bool = True,
) -> Recording:  # fmt: skip
    """A recording: speed as it stands at each sample, air to 0.01 K if it is recorded, the other channels with their
    noise."""
    columns = {
        "time": times,
        "speed": np.array([program.speed(t) for t in times]),
        "ambient": np.array([program.air(t) for t in times]),
    }
    if not has_room:
        del columns["ambient"]
    units, digits = {"time": "s", "speed": "rpm", "ambient": "degC"}, {"time": 0, "speed": 0, "ambient": 2}
    if feed is not None:
        columns["feed"], units["feed"], digits["feed"] = feed, "m/min", 1
    for name, values in shown.items():
        warm = sigmas[name] < 0.1
        raw = disturbed(rng, values, sigmas[name], noise, (offsets or {}).get(name, 0.0))
        columns[name] = np.round(raw / noise.quantum) * noise.quantum if warm else raw
        units[name], digits[name] = ("degC", 2) if warm else ("um", 1)
    return Recording(columns, units, digits)
