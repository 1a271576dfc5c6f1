"""Where the nodes of a network stand on paper: parts by how far they are apart, held nodes at the rim, nothing on
top of anything else. All lengths in points; the same network always gives the same picture."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import networkx as nx
import numpy as np
from threadpoolctl import threadpool_limits

from network.declare import Array
from network.report.curves import inside, overlaps

MARGIN = 8.0
FAR_APART = 1.5
"""Steps by which pieces of a network that nothing joins stand further apart than its own parts."""


MOST_TOUCHED = 8
"""Links that one symbol of a held node bears."""


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


def place(
    inner: Mapping[str, Block], rim: Mapping[str, Block], edges: Sequence[tuple[str, str]], width: float
) -> Placing:
    """The picture's places; the paper grows until everything fits."""
    height = 300.0 + 14.0 * len(inner)
    start = _unit_places(list(inner), [(a, b) for a, b in edges if a in inner and b in inner])
    border = _border(rim.values())
    for _ in range(12):
        placing = Placing(width, height)
        if _place_inner(placing, inner, edges, start, border):
            break
        height *= 1.15
    _place_rim(placing, rim, inner, edges)
    return placing


def _border(rim: Iterable[Block]) -> tuple[float, float]:
    """Room for the held nodes, left and right, below and above."""
    extents = [block.extent("below") for block in rim]
    across = max((left + right for left, right, _, _ in extents), default=0.0)
    along = max((down + up for _, _, down, up in extents), default=0.0)
    return across + 2 * MARGIN, along + 2 * MARGIN


def _unit_places(names: Sequence[str], edges: Sequence[tuple[str, str]]) -> dict[str, Array]:
    """Kamada and Kawai's places in −1..1, the longer direction across."""
    graph: nx.Graph[str] = nx.Graph()
    graph.add_nodes_from(names)
    graph.add_edges_from(edges)
    if len(names) < 2:
        return {name: np.zeros(2) for name in names}
    steps = {a: dict(lengths) for a, lengths in nx.all_pairs_shortest_path_length(graph)}
    widest = max(max(lengths.values()) for lengths in steps.values()) + FAR_APART
    far = {a: {b: float(steps[a].get(b, widest)) for b in names} for a in names}
    with threadpool_limits(limits=1, user_api="blas"):  # two threads get in each other's way
        found = nx.kamada_kawai_layout(graph, dist=far)
    points = np.array([found[name] for name in names])
    points -= points.mean(axis=0)
    _, _, axes = np.linalg.svd(points, full_matrices=False)
    points = points @ (axes * np.sign(axes[:, :1] + 1e-9)).T
    return dict(zip(names, points / np.abs(points).max(axis=0, initial=1e-9), strict=True))


def _place_inner(
    placing: Placing, inner: Mapping[str, Block], edges: Sequence[tuple[str, str]], start: Mapping[str, Array],
    border: tuple[float, float],
) -> bool:  # fmt: skip
    """Spreads the parts over the paper and moves them apart; whether that leaves no overlap."""
    names = list(inner)
    half = np.array([placing.width / 2 - border[0], placing.height / 2 - border[1]])
    points = np.array([start[name] for name in names]) * half + np.array([placing.width, placing.height]) / 2
    placing.at = dict(zip(names, map(tuple, points), strict=True))
    for name in names:
        placing.side[name] = _free_side(name, placing.at, edges)
    extents = np.array([inner[name].extent(placing.side[name]) for name in names])
    paper = (border[0], placing.width - border[0], border[1], placing.height - border[1])
    points, clear = _apart(points, extents, paper)
    placing.at = {name: (float(x), float(y)) for name, (x, y) in zip(names, points, strict=True)}
    return clear


def _free_side(name: str, at: Mapping[str, tuple[float, float]], edges: Sequence[tuple[str, str]]) -> str:
    """The side that the fewest links leave from; below where it makes no difference."""
    here = np.array(at[name])
    others = [b if a == name else a for a, b in edges if name in (a, b) and a != b]
    angles = np.array([np.arctan2(*(np.array(at[o]) - here)[::-1]) for o in others if o in at])
    towards = {"below": -np.pi / 2, "above": np.pi / 2, "right": 0.0, "left": np.pi}
    crowd = {side: float(np.clip(np.cos(angles - angle), 0, 1).sum()) for side, angle in towards.items()}
    return min(crowd, key=lambda side: round(crowd[side], 3))


def _apart(
    points: Array, extents: Array, paper: tuple[float, float, float, float], tries: int = 400
) -> tuple[Array, bool]:
    """Pushes overlapping boxes apart, each pair along the shorter way, within the paper."""
    left, right, down, up = (extents + MARGIN).T
    low = np.array([paper[0] + left, paper[2] + down])
    high = np.maximum(np.array([paper[1] - right, paper[3] - up]), low)
    points = np.clip(points.T, low, high)
    nudge = np.linspace(-1e-3, 1e-3, points.shape[1])
    points = np.clip(points + nudge * np.array([[1.0], [-1.0]]), low, high)
    for _ in range(tries):
        (x0, x1), (y0, y1) = (points[0] - left, points[0] + right), (points[1] - down, points[1] + up)
        across = np.minimum(x1[:, None] - x0, x1 - x0[:, None])
        along = np.minimum(y1[:, None] - y0, y1 - y0[:, None])
        hit = (across > 0.5) & (along > 0.5)
        np.fill_diagonal(hit, False)
        if not hit.any():
            return points.T, True
        by_x = across < along
        sign = [np.sign((c[0] + c[1])[:, None] - (c[0] + c[1]) + 1e-12) for c in ((x0, x1), (y0, y1))]
        push = np.array([np.where(hit & by_x, across * sign[0], 0), np.where(hit & ~by_x, along * sign[1], 0)])
        points = np.clip(points + 0.4 * push.sum(axis=2), low, high)
    return points.T, False


# -- held nodes -----------------------------------------------------------------------------------------------------
def _place_rim(
    placing: Placing, rim: Mapping[str, Block], inner: Mapping[str, Block], edges: Sequence[tuple[str, str]]
) -> None:
    """Every held node at the place of the rim that is nearest to what it touches."""
    boxes = [box_of(placing, name, inner[name]) for name in inner]
    for name, block in sorted(rim.items(), key=lambda item: -item[1].width):
        touched = sorted({o for a, b in edges if name in (a, b) for o in (a, b) if o in inner})
        for symbol, some in _symbols(placing, name, touched).items():
            placing.stands |= {(name, other): symbol for other in some}
            ends = np.array([placing.at[other] for other in some] or [(placing.width / 2, placing.height / 2)])
            spots = list(_rim(placing, block))
            costs = [_rim_cost(spot, side, block, ends, np.array(boxes)) for spot, side in spots]
            placing.at[symbol], placing.side[symbol] = spots[int(np.argmin(costs))]
            boxes.append(box_of(placing, symbol, block))


def _symbols(placing: Placing, name: str, touched: Sequence[str]) -> dict[str, list[str]]:
    """Shares what a held node touches among as many symbols as it takes, going round the middle of the paper."""
    count = -(-len(touched) // MOST_TOUCHED)
    if count < 2:
        return {name: list(touched)}
    ends = np.array([placing.at[other] for other in touched]) - np.array([placing.width, placing.height]) / 2
    angles = np.arctan2(ends[:, 1], ends[:, 0])
    order = np.argsort(angles)
    start = int(np.argmax(np.diff(angles[order], append=angles[order][0] + 2 * np.pi))) + 1
    round_about = [touched[i] for i in np.roll(order, -start)]
    return {f"{name}@{k}": list(some) for k, some in enumerate(np.array_split(round_about, count))}


def _rim(placing: Placing, block: Block) -> Iterator[tuple[tuple[float, float], str]]:
    """Places along the rim, with the side that faces outwards."""
    left, right, down, up = block.extent("below")
    x0, x1, y0, y1 = left + MARGIN, placing.width - right - MARGIN, down + MARGIN, placing.height - down - MARGIN
    for share in np.linspace(0, 1, 33):
        for y, side in ((y0, "below"), (y1, "above")):
            yield (float(x0 + share * (x1 - x0)), float(y)), side
        for x in (x0, x1):
            yield (float(x), float(y0 + share * (placing.height - up - MARGIN - y0))), "below"


def _rim_cost(spot: tuple[float, float], side: str, block: Block, ends: Array, boxes: Array) -> float:
    here = np.array(spot)
    left, right, down, up = block.extent(side)
    mine = np.array([here[0] - left, here[0] + right, here[1] - down, here[1] + up])
    walk = here + np.linspace(0.1, 0.85, 12)[:, None, None] * (ends - here)
    crossed = int(inside(walk.reshape(-1, 2), boxes).sum())
    return 1e5 * int(overlaps(mine, boxes, MARGIN).sum()) + 40.0 * crossed + float(np.hypot(*(ends - here).T).sum())


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
