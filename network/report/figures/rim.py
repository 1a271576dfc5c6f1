"""Held nodes at the rim of a picture, each near to what it touches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from network.catalogue.declaration.declare import Array
from network.report.figures.curves import inside, overlaps
from network.report.figures.node_boxes import MARGIN, Block, Placing, box_of

MOST_TOUCHED = 6
"""Links that one symbol of a held node bears."""


def place_rim(
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
