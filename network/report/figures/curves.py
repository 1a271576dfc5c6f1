"""Lines between nodes that keep clear of other nodes and of each other, and free spots for their labels [pt]."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import KDTree

from network.catalogue.declaration.declare import Array

BENDS = (0.0, 0.12, -0.12, 0.24, -0.24, 0.36, -0.36, 0.5, -0.5)
SAMPLES = 31
TOUCHING, PARALLEL = 4.0, 16.0
"""Curves nearer than the first run over each other; links between the same nodes keep the second in their middle."""
AWAY = (0.0, 3.0, -3.0, 9.0, -9.0, 16.0, -16.0, 24.0, -24.0)
THICK = 1.6
"""pt: width from which a line is not written over, where there is room beside it."""
ALONG = (0.5, 0.44, 0.56, 0.38, 0.62, 0.32, 0.68, 0.26, 0.74, 0.2, 0.8, 0.14, 0.86)


@dataclass
class Obstacles:
    """What is on the paper already: boxes (x0, x1, y0, y1) of symbols and texts, and curves with their ends."""

    boxes: list[Array]
    curves: list[Array] = field(default_factory=list)
    middles: dict[frozenset[tuple[float, float]], list[Array]] = field(default_factory=dict)

    def crowd(self, curve: Array, tree: KDTree | None) -> float:
        """How much a curve runs over boxes and along or across other curves."""
        over = float(inside(curve[1:-1], np.array(self.boxes)).sum()) if self.boxes else 0.0
        near = float((tree.query(curve[2:-2])[0] < TOUCHING).sum()) if tree is not None else 0.0
        return 5.0 * over + near

    def parallel(self, curve: Array, ends: frozenset[tuple[float, float]]) -> bool:
        """Whether another link between the same nodes runs too near."""
        middle = curve[len(curve) // 2]
        return any(float(np.hypot(*(middle - other))) < PARALLEL for other in self.middles.get(ends, ()))

    def spot(
        self, width: float, height: float, curve: Array, crossing: bool = False, thick: float = 0.0
    ) -> tuple[float, float] | None:
        """The middle of a free place for a label of this size at the curve: on no box, and, but for `crossing`, on no
        other curve and nearest to its own. A curve as thick as letters stays in sight: the label stands beside it."""
        others = np.concatenate([c[1:-1] for c in self.curves if c is not curve] or [np.empty((0, 2))])
        boxes = np.array(self.boxes)
        for x, y in _spots(curve, width, height, thick):
            box = _box(x, y, width, height)
            if not overlaps(box, boxes, 1.0).any() and (crossing or _belongs(x, y, box, curve, others)):
                return x, y
        return None

    def take(self, x: float, y: float, width: float, height: float) -> None:
        self.boxes.append(_box(x, y, width, height))


def _belongs(x: float, y: float, box: Array, curve: Array, others: Array) -> bool:
    """Whether a label's box is on no other curve, and nearer to its own."""
    far = np.hypot(*(others - (x, y)).T).min(initial=np.inf)
    return not inside(others, box[None, :]).any() and bool(np.hypot(*(curve - (x, y)).T).min() < far)


def _box(x: float, y: float, width: float, height: float) -> Array:
    return np.array([x - width / 2, x + width / 2, y - height / 2, y + height / 2])


def overlaps(box: Array, others: Array, gap: float = 0.0) -> Array:
    """Which of the boxes come nearer than `gap`."""
    x0, x1, y0, y1 = others.reshape(-1, 4).T
    return np.asarray((box[0] < x1 + gap) & (x0 < box[1] + gap) & (box[2] < y1 + gap) & (y0 < box[3] + gap))


def inside(points: Array, boxes: Array) -> Array:
    """Which points lie in which boxes: (points, boxes)."""
    x0, x1, y0, y1 = boxes.T
    x, y = points[:, :1], points[:, 1:]
    return np.asarray((x > x0) & (x < x1) & (y > y0) & (y < y1))


def _spots(curve: Array, width: float, height: float, thick: float) -> Iterator[tuple[float, float]]:
    aside = [away + np.sign(away) * thick / 2 for away in AWAY]
    for away in aside if thick < THICK else [*aside[1:], 0.0]:
        for share in ALONG:
            k = round(share * (len(curve) - 1))
            across = _direction(curve, k)[::-1] * [-1, 1]
            reach = away + np.sign(away) * (abs(across[0]) * width + abs(across[1]) * height) / 2
            yield float(curve[k][0] + reach * across[0]), float(curve[k][1] + reach * across[1])


def _direction(curve: Array, k: int) -> Array:
    ahead = curve[min(k + 1, len(curve) - 1)] - curve[max(k - 1, 0)]
    return np.asarray(ahead / max(float(np.hypot(*ahead)), 1e-9))


def arrow(curve: Array, size: float) -> Array:
    """Corners of a head two thirds along the curve."""
    k = round(0.68 * (len(curve) - 1))
    ahead = _direction(curve, k)
    across = ahead[::-1] * [-1, 1]
    back = curve[k] - 0.7 * size * ahead
    return np.array([curve[k] + size * ahead, back + 0.7 * size * across, back - 0.7 * size * across])


def bezier(start: Array, end: Array, bend: float) -> Array:
    """Points of a curve from start to end, its middle pushed sideways by `bend`/2 of its length."""
    ahead = end - start
    control = (start + end) / 2 + bend * np.array([-ahead[1], ahead[0]])
    s = np.linspace(0, 1, SAMPLES)[:, None]
    return np.asarray((1 - s) ** 2 * start + 2 * s * (1 - s) * control + s**2 * end)


def _clear(curve: Array, radii: tuple[float, float]) -> Array:
    """The curve without what lies under the symbols at its ends."""
    free = (np.hypot(*(curve - curve[0]).T) > radii[0]) & (np.hypot(*(curve - curve[-1]).T) > radii[1])
    return curve[free] if free.sum() > 5 else curve


def route(start: Array, end: Array, radii: tuple[float, float], among: Obstacles) -> Array:
    """The curve, from symbol to symbol, that is least in the way; straight where that does not matter."""
    if float(np.hypot(*(end - start))) == 0:
        best = _loop(start, radii[0])
    else:
        ends = frozenset([(float(start[0]), float(start[1])), (float(end[0]), float(end[1]))])
        tree = KDTree(np.concatenate(among.curves)) if among.curves else None
        choices = [_clear(bezier(start, end, bend), radii) for bend in BENDS]
        costs = [
            among.crowd(curve, tree) + 100.0 * among.parallel(curve, ends) + 12 * abs(bend)
            for curve, bend in zip(choices, BENDS, strict=True)
        ]
        best = choices[int(np.argmin(costs))]
        among.middles.setdefault(ends, []).append(best[len(best) // 2])
    among.curves.append(best)
    return best


def _loop(at: Array, radius: float) -> Array:
    """A small circle at the upper right of a node: a link between two places of one part."""
    angle = np.linspace(-0.75 * np.pi, 0.75 * np.pi, SAMPLES) + np.pi / 4
    size = 0.5 * radius + 4
    middle = at + (radius + 0.6 * size) * np.sqrt(0.5)
    return np.asarray(middle + size * np.column_stack([np.cos(angle), np.sin(angle)]))
