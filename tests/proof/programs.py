"""What is done to a machine: ladders of speed whose edges fall between samples, and air that drifts."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from proof.system import Array

SAMPLE = 10.0
"""s between samples of every recording."""
HOURS = {1: (5.0, 4.0), 3: (3.0, 4.0, 3.5, 4.0), 6: (2.5, 3.0, 2.5, 2.0, 3.0, 2.5, 4.0)}
"""h of the recordings by how many there are to learn from; the last of them is held out."""


@dataclass(frozen=True)
class Program:
    """Speeds [rpm], each from its edge [s] on, over a duration [s], in air of a mean [°C] with slow waves."""

    duration: float
    edges: tuple[float, ...]
    speeds: tuple[float, ...]
    mean: float
    waves: tuple[tuple[float, float, float], ...] = ()
    feeds: tuple[float, ...] = ()
    """m/min from the same edges on; none where no axis moves."""

    def feed(self, t: float) -> float:
        return self.feeds[bisect_right(self.edges, t + 1e-9) - 1] if self.feeds else 0.0

    def speed(self, t: float) -> float:
        return self.speeds[bisect_right(self.edges, t + 1e-9) - 1]

    def air(self, t: float) -> float:
        """Temperature of the air [°C]: waves of an amplitude [K], period [s] and phase."""
        return self.mean + sum(a * math.sin(2 * math.pi * t / period + phase) for a, period, phase in self.waves)

    def times(self, sample: float = SAMPLE) -> Array:
        return np.arange(0, self.duration + 1e-6, sample)

    def turning(self, t: float) -> float:
        """Time [s] for which the spindle has turned until t."""
        ends = (*self.edges[1:], math.inf)
        legs = zip(self.edges, ends, self.speeds, strict=True)
        return sum(max(0.0, min(t, end) - begin) for begin, end, rpm in legs if rpm)


def ladder(rng: Generator, duration: float, speeds: Array, mean: float, rest: float = 0.2) -> Program:
    """Random speeds for 8 to 45 min each, never the same twice in a row; standing still with the chance `rest`."""
    edges, chosen, t = [0.0], [pick(rng, speeds, rest, -1.0)], 0.0
    while (t := t + float(rng.uniform(480, 2700))) < duration - 600:
        edges.append(round(t, 2))
        chosen.append(pick(rng, speeds, rest, chosen[-1]))
    if not any(chosen):
        chosen[-1] = float(speeds.max())
    return Program(duration, tuple(edges), tuple(chosen), mean, (wave(rng), wave(rng)))


def wave(rng: Generator) -> tuple[float, float, float]:
    """Amplitude [K], period [s] and phase of a slow wave of the air."""
    return float(rng.uniform(0.1, 0.5)), 3600 * float(rng.uniform(1.5, 10)), float(rng.uniform(0, 6.28))


def pick(rng: Generator, speeds: Array, rest: float, last: float) -> float:
    """A speed other than the last one."""
    while True:
        speed = 0.0 if rng.random() < rest else float(rng.choice(speeds))
        if speed != last:
            return speed


def programs(rng: Generator, top: float, reference: float, runs: int = 3, spread: float = 0.45) -> tuple[Program, ...]:
    """Recordings to learn from, and one at speeds that none of them has seen, up to 15 % more.

    spread: K by which the mean of the air may differ from the reference.
    """
    usual = np.round(np.sort(rng.uniform(0.2, 1, 5)) * top, -2)
    usual[-1] = top
    unseen = np.round(usual * 1.15, -1)
    means = reference - 0.05 + spread * rng.uniform(-1, 1, runs + 1)
    plan = zip(HOURS[runs], (*[usual] * runs, unseen), means, strict=True)
    return tuple(ladder(rng, hours * 3600, speeds, float(mean)) for hours, speeds, mean in plan)
