"""Courses over time of what a run delivers: known, or worked out when they are asked for, and then kept."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeVar

import numpy as np

from network.catalogue.declaration.declare import Array, Indices

Key = TypeVar("Key")


class Courses(ABC):
    """Readings and sensor states over the instants of output, row by row."""

    @abstractmethod
    def rows(self, which: Indices) -> Array:
        """Some of them: (rows, instants)."""

    @abstractmethod
    def limits(self) -> tuple[Array, Array]:
        """What no row is below and above, at any instant of output; nothing tighter need be known."""

    @property
    @abstractmethod
    def width(self) -> int:
        """How many there are."""

    def __getitem__(self, row: int) -> Array:
        return np.asarray(self.rows(np.array([row]))[0])

    def all(self) -> Array:
        """All of them: (width, instants)."""
        return self.rows(np.arange(self.width))


class KnownCourses(Courses):
    """Those of a solver that finds them all."""

    def __init__(self, y: Array) -> None:
        self.y = y

    def rows(self, which: Indices) -> Array:
        return self.y if len(which) == len(self.y) else self.y[which]

    def limits(self) -> tuple[Array, Array]:
        return _extreme(np.fmin, self.y), _extreme(np.fmax, self.y)

    @property
    def width(self) -> int:
        return len(self.y)

    def __getitem__(self, row: int) -> Array:
        return np.asarray(self.y[row])


def _extreme(of: np.ufunc, y: Array) -> Array:
    """Of every row, NaN for one with a value that is not finite."""
    return np.where(np.isfinite(y).all(axis=1), of.reduce(y, axis=1), np.nan)


class LazyCourses(Mapping[Key, Array]):
    """Courses by name; each is worked out when it is first asked for."""

    def __init__(self, ways: Mapping[Key, Callable[[], Array]]) -> None:
        self._ways, self._known = dict(ways), dict[Key, Array]()

    def __getitem__(self, name: Key) -> Array:
        if name not in self._known:
            self._known[name] = self._ways[name]()
        return self._known[name]

    def __contains__(self, name: object) -> bool:
        return name in self._ways

    def __iter__(self) -> Iterator[Key]:
        return iter(self._ways)

    def __len__(self) -> int:
        return len(self._ways)

    def __reduce__(self) -> tuple[Any, ...]:
        """Goes to other processes as what it holds."""
        return dict, (dict(self.items()),)
