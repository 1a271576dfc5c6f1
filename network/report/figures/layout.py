"""Where the nodes of a network stand on paper: parts by how far they are apart, held nodes at the rim, nothing on
top of anything else. All lengths in points; the same network always gives the same picture."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import networkx as nx
import numpy as np

from network.catalogue.declaration.declare import Array
from network.platform.threads import on_one_thread
from network.report.figures.node_boxes import MARGIN, Block, Placing
from network.report.figures.rim import place_rim

FAR_APART = 1.5
"""Steps by which pieces that nothing joins stand further apart than the ends of the longest one."""


@on_one_thread
def place(
    inner: Mapping[str, Block], rim: Mapping[str, Block], edges: Sequence[tuple[str, str]], width: float
) -> Placing:
    """The picture's places; the paper grows until everything fits."""
    height = 300.0 + 14.0 * len(inner)
    start = _unit_places(list(inner), edges)
    border = _border(rim.values())
    for _ in range(12):
        placing = Placing(width, height)
        if _place_inner(placing, inner, edges, start, border):
            break
        height *= 1.15
    place_rim(placing, rim, inner, edges)
    return placing


def _border(rim: Iterable[Block]) -> tuple[float, float]:
    """Room for the held nodes, left and right, below and above."""
    extents = [block.extent("below") for block in rim]
    across = max((left + right for left, right, _, _ in extents), default=0.0)
    along = max((down + up for _, _, down, up in extents), default=0.0)
    return across + 2 * MARGIN, along + 2 * MARGIN


def _unit_places(names: Sequence[str], edges: Sequence[tuple[str, str]]) -> dict[str, Array]:
    """Kamada and Kawai's places in −1..1, the longer direction across."""
    if len(names) < 2:
        return {name: np.zeros(2) for name in names}
    graph: nx.Graph[str] = nx.Graph()
    graph.add_nodes_from(names)
    graph.add_edges_from(edges)
    inner = graph.subgraph(names)
    far = _distances(inner, graph)
    found = nx.kamada_kawai_layout(inner, dist=far)
    points = np.array([found[name] for name in names])
    points -= points.mean(axis=0)
    _, _, axes = np.linalg.svd(points, full_matrices=False)
    points = points @ (axes * np.sign(axes[:, :1] + 1e-9)).T
    return dict(zip(names, points / np.maximum(np.abs(points).max(axis=0), 0.05), strict=True))


def _distances(inner: nx.Graph[str], graph: nx.Graph[str]) -> dict[str, dict[str, float]]:
    """Steps between parts: along links between parts, else one more than by way of held nodes, else far apart."""
    direct = {a: dict(steps) for a, steps in nx.all_pairs_shortest_path_length(inner)}
    by_held = {a: dict(steps) for a, steps in nx.all_pairs_shortest_path_length(graph)}
    widest = max(max(steps.values()) for steps in direct.values()) + FAR_APART
    return {
        a: {b: float(direct[a].get(b, by_held[a].get(b, widest - 1) + 1)) for b in inner.nodes} for a in inner.nodes
    }


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
