"""The filter beside a running machine: line by line what has moved, how sure that is, and whether the readings agree.

Two things are told as warnings. The heat that the filter does not know leaves its band: the squares of it, in units of
what readings tell of it, exceed what one in a thousand machines with numbers within their ± would have (χ²). And what a
reading misses, averaged over SMOOTH, lies further from zero than THREE σ of a single reading, which noise never does.
With either goes the input that it followed over the last day, if more closely than chance allows.
"""

from __future__ import annotations

import hashlib
import math
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import stdtrit
from scipy.stats import chi2

from network.analysis.correction.filter_model import FilterModel
from network.catalogue.declaration.declare import Array
from network.platform.quantities.units import BadNumber

SMOOTH = 600.0
"""s"""
THREE, RARE = 3.0, 1e-3
TOLD = 0.01
"""Share of the variance of unknown heat below which readings do not tell a direction of it."""
MEMORY, APART = 24 * 3600.0, 60.0
"""s of what was missed that are kept, and between two of them."""
CHANCE = 0.01
LONGEST = 30 * 86400.0
"""s: a gap that is bridged; after a longer one the machine starts anew."""
SURE = 1.96


@dataclass(frozen=True)
class Told:
    """At an instant [s]: movement of the axes and half the width of its band of 95 %, in their units; warnings: a
    sentence for every sensor that lies outside of what the filter expects."""

    t: float
    moved: Array
    band: Array
    warnings: tuple[str, ...]


class Follower:
    """Steps the filter along lines that come when they come; inputs hold between them.

    t: of the last line; at: the instant that the states z stand for, a step after the last reading that they took.
    """

    def __init__(self, filter_: FilterModel) -> None:
        self.filter = filter_
        self.t = self.at = math.nan
        self.z: Array = np.zeros(filter_.states)
        self.inputs: dict[str, float] = {}
        self.average: Array = np.zeros(len(filter_.sensors))
        self.memory: deque[tuple[float, list[float], list[float]]] = deque()
        self.weight: Array = np.asarray(np.linalg.pinv(filter_.known, rcond=TOLD, hermitian=True), np.float64)

    def take(self, t: float, inputs: Mapping[str, float], read: Array) -> Told:
        """One line: inputs in the filter's units, readings [°C], NaN where there is none; an input that is NaN holds.
        Lines that come faster than the filter steps are told from its states, and their readings not taken."""
        now = {name: inputs[name] if inputs[name] == inputs[name] else self.inputs.get(name, math.nan)
               for name in self.filter.inputs}  # fmt: skip
        self._go_on(t, now, read)
        if self.at > t + self.filter.step / 2:
            moved = self.filter.tell(self.z, now)
        else:
            self.z, moved, missed = self.filter.advance(self.z, now, read)
            self.at += self.filter.step
            self._remember(t, now, read, missed)
        self.t, self.inputs = t, now
        return Told(t, moved, SURE * self.filter.spread, tuple(self._warn()))

    def _go_on(self, t: float, now: Mapping[str, float], read: Array) -> None:
        """Brings the states to an instant: by steps without readings, or from its first readings."""
        if not self.inputs or not 0 <= t - self.t < LONGEST:
            self.z, self.at = self.filter.start(now, read), t
            return
        nothing = np.full(len(self.filter.sensors), np.nan)
        while self.at + self.filter.step / 2 <= t:
            self.z, _, _ = self.filter.advance(self.z, self.inputs, nothing)
            self.at += self.filter.step

    def _remember(self, t: float, now: Mapping[str, float], read: Array, missed: Array) -> None:
        gap = t - self.t if t > self.t else self.filter.step
        share = 1 - math.exp(-gap / SMOOTH)
        self.average = np.where(np.isfinite(read), self.average + share * (missed - self.average), self.average)
        while self.memory and not t - MEMORY <= self.memory[0][0] <= t:
            self.memory.popleft()
        if not self.memory or t - self.memory[-1][0] >= APART:
            self.memory.append((t, [*missed.tolist(), *self.unknown.tolist()], list(now.values())))

    @property
    def unknown(self) -> Array:
        """The heat that is not known, in its σ."""
        return self.z[self.filter.own :]

    def _warn(self) -> Iterator[str]:
        f, d = self.filter, self.unknown
        if f.sensors and float(d @ self.weight @ d) > chi2.ppf(1 - RARE, len(d)):
            k = int(np.argmax(np.abs(d)))
            follows = self._followed(len(f.sensors) + k)
            what = f"{'more' if d[k] > 0 else 'less'} heat than the machine file has, most like that of {f.unknown[k]}"
            yield f"{what}, {abs(d[k]):.1f} times its ±{follows}"
        for i, (name, off, sigma) in enumerate(zip(f.sensors, self.average, f.missed, strict=True)):
            if abs(off) > THREE * sigma:
                way = "above" if off > 0 else "below"
                yield f"{name} reads {abs(off):.2f} K {way} what the model expects{self._followed(i)}"

    def _followed(self, i: int) -> str:
        """The input that what is remembered at a place follows most closely, if more than by chance."""
        series = np.array([row[1][i] for row in self.memory])
        best, name = 0.0, ""
        for k, each in enumerate(self.filter.inputs):
            excess = _correlate(series, np.array([row[2][k] for row in self.memory]))
            best, name = (excess, each) if excess > best else (best, name)
        return f"; it follows {name}" if name else ""

    # -- state --------------------------------------------------------------------------------------------------------
    def to_plain(self) -> dict[str, Any]:
        """What is saved."""
        return {
            "filter": identify(self.filter), "t": self.t, "at": self.at, "z": self.z.tolist(), "inputs": self.inputs,
            "average": self.average.tolist(),
        }  # fmt: skip

    def restore(self, plain: Mapping[str, Any]) -> None:
        """Goes on from a saved state. Raises BadNumber for one of another filter."""
        if plain.get("filter") != identify(self.filter):
            raise BadNumber("is the state of another filter", "take the machine it was saved with, or remove the file")
        self.t, self.at, self.z = float(plain["t"]), float(plain["at"]), np.array(plain["z"], float)
        self.inputs = {name: math.nan if value is None else float(value) for name, value in plain["inputs"].items()}
        self.average = np.array(plain["average"], float)


def identify(filter_: FilterModel) -> str:
    """Changes with any number of the filter."""
    arrays = (filter_.Phi, filter_.M, filter_.S, filter_.gain, filter_.constant, filter_.films, *filter_.held.values())
    named = repr((filter_.step, list(filter_.inputs), filter_.sensors, filter_.axes)).encode()
    return hashlib.sha256(named + b"".join(np.ascontiguousarray(a).tobytes() for a in arrays)).hexdigest()[:16]


def _correlate(a: Array, b: Array) -> float:
    """How far the correlation of two series exceeds what chance gives at CHANCE; below zero where it does not. The
    number of independent samples is less by the memory of both (Bretherton et al., J. Climate 12 (1999) 1990)."""
    both = np.isfinite(a) & np.isfinite(b)
    a, b = a[both] - a[both].mean() if both.any() else a[both], b[both] - b[both].mean() if both.any() else b[both]
    size = math.sqrt(float(a @ a) * float(b @ b)) if len(a) > 3 else 0.0
    if size <= 0:
        return -1.0
    lags = [float(x[1:] @ x[:-1]) / float(x @ x) for x in (a, b)]
    count = len(a) * (1 - lags[0] * lags[1]) / (1 + lags[0] * lags[1])
    if count <= 3:
        return -1.0
    student = float(stdtrit(count - 2, 1 - CHANCE / 2))
    return abs(float(a @ b)) / size - student / math.sqrt(count - 2 + student**2)
