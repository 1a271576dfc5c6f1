"""How much of an effect is seen, and how much is left once the user's numbers have been calibrated to hide it.

All on one cell for each part and in steps of 30 s: y = channels in units of their noise, S = ∂y/∂ln θ for the numbers
with ±, V their prior variances. An effect that moves y by δ leaves δ − S (SᵀS + V⁻¹)⁻¹ Sᵀ δ after calibration.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator

from proof.assembly import assemble
from proof.effect import Effect
from proof.effects_heat import stronger
from proof.layout import Layout
from proof.observing import observe, track_of
from proof.programs import Program
from proof.system import Array

COARSE = 30.0
EVERY = 60.0
LEAST, MOST = 1.2, 4.5
"""Noise units rms that an effect leaves after calibration, by design."""
NEAREST, FARTHEST = 3.0, 30.0
"""Noise units rms by which an effect moves the channels before calibration, by design."""


@dataclass(frozen=True)
class Bench:
    """A machine as the truth has it, its training programs, and what its numbers with ± can imitate."""

    layout: Layout
    numbers: Mapping[str, float]
    programs: Sequence[Program]
    plain: Array
    basis: Array

    @classmethod
    def idle(cls, layout: Layout, numbers: Mapping[str, float], programs: Sequence[Program]) -> Bench:
        """One on which nothing is weighed."""
        return cls(layout, numbers, programs, np.zeros(1), np.zeros((1, 0)))

    def remaining(self, change: Array) -> Array:
        """What calibration leaves of a change, to first order."""
        fitted, *_ = np.linalg.lstsq(self.basis, np.append(change, np.zeros(self.basis.shape[1])), rcond=None)
        return np.asarray(change - self.basis[: len(change)] @ fitted)

    def change(self, effects: Sequence[Effect]) -> Array:
        """What effects move, in units of noise."""
        return np.asarray(channels(self.layout, self.numbers, self.programs, effects) - self.plain)


def channels(
    layout: Layout, numbers: Mapping[str, float], programs: Sequence[Program], effects: Sequence[Effect] = ()
) -> Array:
    """All channels of all programs in one row, in units of their noise."""
    rows = []
    for index, program in enumerate(programs):
        build = assemble(layout, numbers)
        for effect in effects:
            effect.conceal(build, program, index)
        shown = observe(build, program, {}, program.times(EVERY), COARSE)
        rows += [values / layout.channels()[name] for name, values in shown.items()]
    return np.concatenate(rows)


def bench(layout: Layout, numbers: Mapping[str, float], programs: Sequence[Program], rooms: float = 0.0) -> Bench:
    """The sensitivities by differences of 5 %, with a row for the prior of each number below them; rooms: K by which
    the room of each run may be off, which the user does not know either."""
    plain = channels(layout, numbers, programs)
    spreads = [(path, spread) for path, _, spread in layout.uncertain()]
    columns = [
        (channels(layout, {**numbers, path: numbers[path] * 1.05}, programs) - plain) / np.log(1.05)
        for path, _ in spreads
    ]
    if rooms:
        columns += [channels(layout, numbers, warmer(programs, i)) - plain for i in range(len(programs))]
    prior = np.diag([1 / spread for _, spread in spreads] + ([1 / rooms] * len(programs) if rooms else []))
    return Bench(layout, numbers, programs, plain, np.vstack([np.array(columns).T, prior]))


def warmer(programs: Sequence[Program], which: int) -> list[Program]:
    """The programs with one of them in a room that is 1 K warmer."""
    return [replace(p, mean=p.mean + 1) if i == which else p for i, p in enumerate(programs)]


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def sized(rng: Generator, on: Bench, effect: Effect) -> Effect:
    """The effect at a strength that leaves a drawn amount after calibration and stays within what is not grotesque."""
    aim = float(np.exp(rng.uniform(np.log(LEAST), np.log(MOST))))
    for _ in range(3 if effect.scales else 0):
        change = on.change([effect])
        factor = aim / max(rms(on.remaining(change)), 1e-3)
        factor = float(np.clip(factor, NEAREST / max(rms(change), 1e-3), FARTHEST / max(rms(change), 1e-3)))
        effect = stronger(effect, factor)
    return effect


def seen(on: Bench, effects: Sequence[Effect]) -> dict[str, float]:
    """Rms in units of noise before and after calibration, for the key."""
    if not effects:
        return {"before_calibration": 0.0, "after_calibration": 0.0}
    change = on.change(effects)
    left = on.remaining(change)
    return {"before_calibration": round(rms(change), 3), "after_calibration": round(rms(left), 3)}


def warmth(layout: Layout, numbers: Mapping[str, float], programs: Sequence[Program]) -> dict[str, float]:
    """The temperature [°C] that each part exceeds a fifth of the time, without any effect."""
    build = assemble(layout, numbers)
    T = np.vstack([track_of(build, p, {}, COARSE).at(p.times(EVERY), np.eye(len(build.capacity))) for p in programs])
    return {name: float(np.quantile(T[:, cells[0]], 0.8)) for name, cells in build.cells.items()}
