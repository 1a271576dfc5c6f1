"""Steps of a channel from one sample to the next that its own tail of steps does not explain.

The sizes of the steps, less the trend about each, have a tail; above its (L + 1)-th largest it is taken for a power
law, the heaviest that is usual, with the exponent 1/γ of the K steps below: i ln(x_i/x_{i+1}) are exponential with
mean γ (Rényi, Hill). Then (L + 1) (1 + ln(x/x_{L+1})/(K γ))^-K steps above x are expected, the uncertainty of γ counted
in (γ is a mean of K exponential values, the ratio has an F distribution): the probability that one there is chance. Up
to L jumps leave the tail alone. γ is at least that of a normal tail.
Source: Hill (1975), "A simple general approach to inference about the tail of a distribution".
"""

from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array, Indices, Mask
from network.recordings.hygiene.data_quality import quantum_of

SPARED, TAIL = 3, 40
"""L and K: jumps that may lie in the tail without changing it, and steps that its exponent is taken from."""
AROUND = 9
"""Steps whose median is the trend that one is judged by."""
REGULAR = 1.5
"""Times the median interval up to which a step is one from a sample to the next."""


def chance_of_steps(t: Array, values: Array) -> Array:
    """Of every sample: how many steps as large as the one to it are expected by chance; 1 and more where it is usual,
    and where there are too few steps to tell."""
    chance = np.full(len(values), np.inf)
    known = np.flatnonzero(np.isfinite(values))
    if len(known) < SPARED + 2 * TAIL:
        return chance
    interval = np.diff(t[known])
    near = interval <= REGULAR * np.median(interval)
    quantum = quantum_of(values[known])
    size = np.abs(_beyond_trend(np.diff(values[known])))
    count = int(near.sum())
    if count <= SPARED + TAIL:
        return chance
    tail = np.sort(np.partition(size[near], -SPARED - TAIL - 1)[-SPARED - TAIL - 1 :])[::-1] + quantum / 2
    if tail[SPARED + TAIL] <= 0:
        return chance
    threshold = tail[SPARED]
    ranks = np.arange(SPARED + 1, SPARED + TAIL + 1)
    gamma = float(np.mean(ranks * np.log(tail[SPARED : SPARED + TAIL] / tail[SPARED + 1 : SPARED + TAIL + 1])))
    gamma = max(gamma, 1 / (2 * np.log(count)))
    seen = np.maximum(size - quantum / 2, 0.0)
    expected = (SPARED + 1) * (1 + np.log(np.maximum(seen / threshold, 1.0)) / (TAIL * gamma)) ** -TAIL
    chance[known[1:]] = np.where(near, expected, np.inf)
    return chance


def _beyond_trend(steps: Array) -> Array:
    """Steps less the median of those around them: what relaxes slowly has none."""
    from scipy.ndimage import median_filter  # slow to load, for what only a recording asks for

    return np.asarray(steps - median_filter(steps, AROUND, mode="nearest"))


def is_driven(inputs: Array, rows: Indices, within: int) -> Mask:
    """Whether an input jumped within so many samples of each row. inputs: channels × samples of what is held between
    samples."""
    changed = np.zeros(inputs.shape[1], bool)
    if len(inputs):
        steps = np.abs(np.diff(inputs, axis=1))
        changed[1:] = (np.nan_to_num(steps, nan=0.0) > 0).any(axis=0)
    reach = np.convolve(changed, np.ones(2 * within + 1), mode="same") > 0
    return np.asarray(reach[rows])
