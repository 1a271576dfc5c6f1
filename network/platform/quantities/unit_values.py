"""Columns of values inside (SI, °C) in a unit that they are shown in."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from network.platform.quantities.units import Unit, difference, unit

Array = NDArray[np.float64]


def in_own_unit(values: Array, of: Unit | str) -> Array:
    """A channel in its unit, from SI and °C. Raises BadNumber for an unknown one."""
    given = unit(of) if isinstance(of, str) else of
    return np.asarray((values - given.offset) / given.scale)


def in_difference_unit(values: Array, unit_text: str) -> Array:
    """Differences (residuals) of a channel in its unit."""
    return in_own_unit(values, difference(unit(unit_text)))
