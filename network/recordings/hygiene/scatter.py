"""A temperature that scatters from sample to sample as none of its peers does: a bad contact, or no true reading.

A robust t-test of the logarithm of its noise against those of the other temperatures (median, median deviation), one
sided, at α over the channels. What is no more than its own resolution is not judged. It is told, and weighs little in
a fit, which takes each channel's own noise; nothing is set aside.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from network.catalogue.declaration.declare import Array
from network.recordings.columns import Column
from network.recordings.hygiene.data_quality import NORMAL, noise_of, quantum_of
from network.recordings.hygiene.set_aside import SetAside
from network.recordings.time_order import FALSE_ALARM

PEERS = 4
"""Other temperatures below which a median deviation tells nothing."""
ALIKE = 0.1
"""Least spread of the logarithms of their noise."""


def find_scatter(t: Array, columns: Mapping[str, Column]) -> Iterator[SetAside]:
    """One for each channel that scatters."""
    from scipy.special import stdtr

    noise = {name: noise_of(c.values[np.isfinite(c.values)]) for name, c in columns.items()}
    noise = {name: value for name, value in noise.items() if value > 0}
    for name, value in noise.items():
        others = np.log([other for n, other in noise.items() if n != name])
        if len(others) < PEERS or value <= quantum_of(columns[name].values[np.isfinite(columns[name].values)]):
            continue
        middle = float(np.median(others))
        spread = max(float(np.median(np.abs(others - middle))) / NORMAL, ALIKE)
        away = (np.log(value) - middle) / spread / np.sqrt(1 + np.pi / 2 / len(others))
        if stdtr(len(others) - 1, -away) < FALSE_ALARM / len(noise):
            rows = np.flatnonzero(np.isfinite(columns[name].values))
            times = value / np.exp(middle)
            why = f"scatters {times:.0f} times as much from sample to sample as the other temperatures,"
            yield SetAside.of(t, columns[name], rows, why, value, is_told_only=True)
