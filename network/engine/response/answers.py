"""What the means of cells answer to pushes, apart by which laws bring it about."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from network.catalogue.declaration.declare import Array


class Answers(NamedTuple):
    """Of pushes (pushes, ·). straight: by straight laws; bent: what bent laws add, None where none is bent or that was
    not asked for."""

    straight: Array
    bent: Array | None = None

    @property
    def whole(self) -> Array:
        return self.straight if self.bent is None else self.straight + self.bent

    @property
    def added(self) -> Array:
        """What bent laws add, nothing where none is bent."""
        return np.zeros_like(self.straight) if self.bent is None else self.bent

    def beside(self, rows: Array) -> Answers:
        """Further rows below, to which bent laws add nothing."""
        if not len(rows):
            return self
        bent = None if self.bent is None else np.concatenate([self.bent, np.zeros_like(rows)])
        return Answers(np.concatenate([self.straight, rows]), bent)

    def above(self, other: Answers) -> Answers:
        """These, and others below them."""
        if self.bent is None and other.bent is None:
            return Answers(np.concatenate([self.straight, other.straight]))
        return Answers(*(np.concatenate(pair) for pair in ((self.straight, other.straight), (self.added, other.added))))

    def first(self, count: int) -> Answers:
        """So many of them."""
        return Answers(self.straight[:count], None if self.bent is None else self.bent[:count])

    def among(self, count: int, own: list[int]) -> Answers:
        """As some rows of so many, the others zero."""
        if len(own) == count:
            return self
        spread = [None if rows is None else _spread(rows, count, own) for rows in self]
        assert spread[0] is not None
        return Answers(spread[0], spread[1])


def _spread(rows: Array, count: int, own: list[int]) -> Array:
    out = np.zeros((count, rows.shape[1]))
    out[own] = rows
    return out
