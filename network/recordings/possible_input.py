"""Temperatures that drive a machine: what nothing around a machine tool has is told before anything is heated by it."""

from __future__ import annotations

import numpy as np

from network.platform.quantities.text_table import digits
from network.platform.quantities.units import BadNumber
from network.recordings.inputs import Signal
from network.recordings.yaml_values import HOTTEST

COLDEST_INPUT = -200.0
"""°C of what cools it: liquid nitrogen."""


def check_possible(signal: Signal) -> None:
    """Raises BadNumber for a temperature that goes beyond them."""
    worst = find_impossible(signal)
    if worst is not None:
        wrong = f"reaches {digits(worst)} degC, which nothing around a machine tool has"
        raise BadNumber(wrong, f"give temperatures from {COLDEST_INPUT:g} to {HOTTEST:g} degC")


def find_impossible(signal: Signal) -> float | None:
    """The value of a temperature [°C] that is farthest off, where any is beyond them."""
    values = np.concatenate([signal.start, signal.end])
    far = values[~((values >= COLDEST_INPUT) & (values <= HOTTEST))]
    return float(far[np.argmax(np.abs(far))]) if len(far) else None
