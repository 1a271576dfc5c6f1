"""Do residuals swing with a period: the highest peak of the spectrum above a background of slow drift and noise."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from network.analysis.comparison.amounts import amount, to_unit
from network.analysis.comparison.background import background
from network.analysis.comparison.cycles import Cycles, cycles_sentence
from network.catalogue.declaration.declare import Array
from network.platform.quantities.text_table import span

LEVEL = 1e-4
"""A period is called one by chance less often than this."""
FEWEST = 48
SHORTEST, LONGEST = 4.0, 0.5
"""Periods looked for: from so many samples to this part of the length."""
WIDTHS = (3, 7, 15, 31, 63, 127)
"""Neighbouring frequencies taken together, at most half their own number: a period that wanders has a broad peak."""
ABOVE = 3.0
"""A peak stands at least this far above the background, which is not known better than to a few tens of percent."""
LEAST = 0.25
"""A swing of less than this many σ is nobody's concern."""


@dataclass(frozen=True)
class Periodicity:
    """A swing of one channel. period: [s]; amplitude: half the swing, SI, and in σ; p: its probability without one;
    unit: of the channel; clarity: power around the period over that of the background; by_regime: the period at each
    level of the speed, where it changes with it."""

    name: str
    period: float
    amplitude: float
    in_noise: float
    p: float
    unit: str
    clarity: float
    by_regime: tuple[Cycles, ...] = field(default=())

    @property
    def sentence(self) -> str:
        changes = f" ({cycles_sentence(self.by_regime)})" if self.by_regime else ""
        swing = amount(self.amplitude, self.unit, 2)
        return f"{self.name} swings by ±{swing} with a period of {span(self.period)}{changes}"

    @property
    def weight(self) -> float:
        """rms in σ."""
        return self.in_noise / float(np.sqrt(2))

    def summary(self) -> dict[str, Any]:
        regimes = [cycles.summary() for cycles in self.by_regime]
        return {
            "seconds": self.period, "amplitude": to_unit(self.amplitude, self.unit), "in_noise": self.in_noise,
            "p": self.p, "by_regime": regimes,
        }  # fmt: skip


@dataclass(frozen=True)
class Peak:
    """centre: its middle, in steps of 1/length; variance: what it adds; clarity: power within a factor 2 of the centre
    over that of the background."""

    centre: float
    variance: float
    clarity: float
    p: float


def periodicity(
    name: str, unit_text: str, sigma: float, values: Array, there: Array, step: float
) -> Periodicity | None:
    """The period of one row in σ with 0 in gaps, None where nothing is one. sigma: SI."""
    n = len(values)
    if there.sum() < max(FEWEST, n / 2) or not values.any():
        return None
    peak = highest_peak(spectrum(values, there), n)
    if peak is None or peak.p > LEVEL or np.sqrt(2 * peak.variance) < LEAST:
        return None
    amplitude = float(np.sqrt(2 * peak.variance))
    return Periodicity(name, n * step / peak.centre, amplitude * sigma, amplitude, peak.p, unit_text, peak.clarity)


def spectrum(values: Array, there: Array) -> Array:
    """P_k = |Σ w_i x_i exp(−2πi ik/n)|²/Σ w_i², k = 1 … n/2: the variance of a sample where the noise is white.

    w: Hann's taper, 0 in gaps; a straight line is taken out first.
    """
    n = len(values)
    taper = there * (0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(n) + 0.5) / n))
    line = np.stack([np.ones(n), np.linspace(-1, 1, n)]) * there
    level = values - np.linalg.solve(line @ line.T, line @ values) @ line
    return np.asarray(np.abs(np.fft.rfft(taper * level)[1:]) ** 2 / np.sum(taper**2))


def highest_peak(power: Array, n: int) -> Peak | None:
    """The band whose power is least likely to come from the background."""
    below = background(power, n)
    most = int(n / SHORTEST)
    found = min(_bands((power / below)[:most]), default=None)
    if found is None:
        return None
    p, low, high = found
    low, high = max(low - 1, 0), min(high + 1, most)
    above = np.maximum((power - below)[low:high], 0.0)
    if not above.any():
        return None
    centre = float(above @ np.arange(low + 1, high + 1)) / float(above.sum())
    if centre < 1 / LONGEST:
        return None
    around = slice(int(centre / 2), int(centre * 2))
    clarity = float(power[around].sum() / below[around].sum())
    return Peak(centre, 2 / n * float(above.sum()), clarity, p)


def _bands(ratio: Array) -> Iterator[tuple[float, int, int]]:
    """(probability, first, last + 1) of the highest band of every width, the number of places to choose from counted.

    The mean of m neighbours is Gamma distributed; Hann's taper makes neighbours alike by 4/9 and 1/36.
    """
    from scipy.special import gammaincc

    total, lowest = np.concatenate([[0.0], np.cumsum(ratio)]), int(1 / LONGEST) - 1
    for m in WIDTHS:
        start = np.arange(lowest if m == WIDTHS[0] else m + m // 2, len(ratio) - m + 1)
        if len(start):
            means = (total[start + m] - total[start]) / m
            best = int(np.argmax(means))
            if means[best] < ABOVE:
                continue
            shape = m / (1 + 8 / 9 * (1 - 1 / m) + 1 / 18 * (1 - 2 / m))
            p = float(gammaincc(shape, shape * means[best])) * len(start) * len(WIDTHS)
            yield min(p, 1.0), int(start[best]), int(start[best]) + m
