"""Places on paper [pt]: what a node takes up, and where it stands."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from network.catalogue.declaration.declare import Array

MARGIN = 8.0


@dataclass(frozen=True)
class Block:
    """A node: a symbol of this radius, and text of this width and height on one side of it."""

    radius: float
    width: float
    height: float

    def extent(self, side: str) -> tuple[float, float, float, float]:
        """left, right, down, up from the middle of the symbol, with the text on that side."""
        r, w, h = self.radius + 2, self.width, self.height
        return {
            "below": (max(r, w / 2), max(r, w / 2), r + h, r),
            "above": (max(r, w / 2), max(r, w / 2), r, r + h),
            "right": (r, r + w + 2, max(r, h / 2), max(r, h / 2)),
            "left": (r + w + 2, r, max(r, h / 2), max(r, h / 2)),
        }[side]


@dataclass
class Placing:
    """Positions [pt] of every symbol, on which side its text stands, and the paper they need.

    A held node that touches many parts stands at the rim several times, as `name@0`, `name@1` …; stands: which of
    them a neighbour is joined to.
    """

    width: float
    height: float
    at: dict[str, tuple[float, float]] = field(default_factory=dict)
    side: dict[str, str] = field(default_factory=dict)
    stands: dict[tuple[str, str], str] = field(default_factory=dict)

    def symbol(self, node: str, towards: str) -> str:
        """The symbol of a node that a link to another node ends at."""
        return self.stands.get((node, towards), node)


def boxes_of(placing: Placing, name: str, block: Block) -> list[Array]:
    """The symbol and its text."""
    (x, y), r, whole = placing.at[name], block.radius + 2, box_of(placing, name, block)
    text = whole.copy()
    side = placing.side[name]
    if side in ("right", "left"):
        text[0 if side == "right" else 1] = x + r if side == "right" else x - r
        text[2:] = y - block.height / 2, y + block.height / 2
    else:
        text[3 if side == "below" else 2] = y - r if side == "below" else y + r
        text[:2] = x - block.width / 2, x + block.width / 2
    return [np.array([x - r, x + r, y - r, y + r]), text]


def box_of(placing: Placing, name: str, block: Block) -> Array:
    """x0, x1, y0, y1"""
    left, right, down, up = block.extent(placing.side[name])
    x, y = placing.at[name]
    return np.array([x - left, x + right, y - down, y + up])
