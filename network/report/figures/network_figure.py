"""A network as a picture: parts, links with their conductance or mean heat flow, sources, relays, sensors."""

from __future__ import annotations

import textwrap
from collections.abc import Collection, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.trajectory import Trajectory
from network.machine.machine import Machine
from network.platform.quantities.number_format import number
from network.report.figures.canvas import (
    FONT,
    GREY,
    INK,
    SMALL,
    WIDTH,
    literal,
    new_figure,
    shorten,
    text_size,
    write_title,
)
from network.report.figures.curves import Obstacles, arrow, route
from network.report.figures.layout import place
from network.report.figures.node_boxes import Block, Placing, box_of, boxes_of
from network.report.figures.strokes import Stroke, capacity_text, cut, duration, notes, strokes, watts
from network.report.figures.symbols import (
    BACKING,
    COLOURS,
    EDGE,
    FILL,
    HELD_FILL,
    MANY,
    MARKS,
    draw_legend,
    owner,
    radii_of,
    words_of,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_NAMED = 26
"""More links than this are numbered, and named below."""
WIDEST, LONGEST = 20, 40
"""Letters of a line of a part's name, and of the name."""
HEAD, FOOT, ROW = 58.0, 64.0, SMALL * 1.6
STREAM = 0.3
"""Width of a stream, as a share of the widest link: what it carries is its number."""


def network_figure(machine: Machine, trajectory: Trajectory | None = None) -> Figure:
    """Parts as circles, held nodes as squares at the rim, junctions as dots; links as wide as their conductance or,
    with a trajectory, as their mean heat flow, with its direction and its number."""
    return draw_picture(Picture(machine, trajectory), *_headings(machine, trajectory))


def draw_picture(picture: Picture, title: str, below: str) -> Figure:
    """The figure of a picture, with its title."""
    left, right, bottom, top = picture.extent()
    figure = new_figure((top - bottom + HEAD + FOOT) / 72)
    axes = figure.add_axes((0, 0, 1, 1))
    middle = (left + right) / 2
    axes.set(xlim=(middle - WIDTH * 36, middle + WIDTH * 36), ylim=(bottom - FOOT, top + HEAD))
    axes.axis("off")
    picture.draw(axes)
    rows = list_rows([*(f"({k}) {told}" for k, told in enumerate(picture.numbered, 1)), *picture.unplaced])
    if rows:
        figure.set_size_inches(WIDTH, (top - bottom + HEAD + FOOT + ROW * len(rows)) / 72)
        axes.set_ylim(bottom - FOOT - ROW * len(rows), top + HEAD)
        axes.text(middle - WIDTH * 36 + 14, bottom - FOOT, "\n".join(rows), fontsize=SMALL, color=INK, va="top")
    write_title(figure, title, below)
    return figure


def list_rows(entries: Sequence[str]) -> list[str]:
    """One after the other, in as many lines as the width takes."""
    rows, most = list[str](), WIDTH * 72 - 28
    for entry in map(literal, entries):
        longer = f"{rows[-1]}   {entry}" if rows else entry
        if rows and text_size(longer, SMALL)[0] <= most:
            rows[-1] = longer
        else:
            rows.append(entry)
    return rows


def _headings(machine: Machine, run: Trajectory | None) -> tuple[str, str]:
    if run is None:
        told = "line width and number: conductance at the reference, inputs zero; of a stream its capacity flow"
        return f"{machine.name}: network", told
    told = f"line width and number: mean heat flow over {_span(duration(run))}; of a closed stream its capacity flow"
    return f"{machine.name}: {run.schedule.name}", told


def _span(seconds: float) -> str:
    length, name = next((u for u in ((3600.0, "h"), (60.0, "min")) if seconds >= 3 * u[0]), (1.0, "s"))
    return f"{seconds / length:.3g} {name}"


class Picture:
    """Sizes, places and lines of one picture."""

    def __init__(self, machine: Machine, run: Trajectory | None, whole: Collection[str] = ()) -> None:
        """whole: names of entries that are not cut."""
        self.machine, self.run, self.whole = machine, run, whole
        self.font = FONT - 0.5 if len(machine.nodes) <= MANY else 6.5
        self.strokes, self.notes = list(strokes(machine, run)), notes(machine, run, whole)
        self.radius = radii_of(machine)
        self.texts = {name: list(self._text(name)) for name in machine.nodes}
        self.blocks = {name: self._block(name) for name in machine.nodes}
        inner = {name: self.blocks[name] for name, node in machine.nodes.items() if not node.is_held}
        rim = {name: self.blocks[name] for name, node in machine.nodes.items() if node.is_held}
        edges = [(stroke.a, stroke.b) for stroke in self.strokes]
        self.placing: Placing = place(inner, rim, edges, WIDTH * 72)
        placed = [(symbol, self.blocks[owner(symbol)]) for symbol in self.placing.at]
        self.boxes = [box_of(self.placing, symbol, block) for symbol, block in placed]
        self.around = Obstacles([box for symbol, block in placed for box in boxes_of(self.placing, symbol, block)])
        self.curves = [self._route(stroke) for stroke in self.strokes]
        self.numbered, self.unplaced = list[str](), list[str]()

    def _text(self, name: str) -> Iterator[tuple[str, str, bool]]:
        """(text, colour, bold) of every line at a node."""
        yield from ((literal(line), INK, True) for line in textwrap.wrap(shorten(name, LONGEST), WIDEST))
        capacity = capacity_text(self.machine, name)
        if capacity:
            yield literal(capacity), GREY, False
        for note in self.notes[name]:
            yield f"{MARKS[note.mark]} {literal(note.text)}", COLOURS[note.mark], False

    def _block(self, name: str) -> Block:
        sizes = [text_size(text, self.font, bold) for text, _, bold in self.texts[name]]
        return Block(self.radius[name], max(width for width, _ in sizes) + 2, sum(height for _, height in sizes) + 1)

    # -- drawing ----------------------------------------------------------------------------------------------------
    def draw(self, axes: Axes) -> None:
        largest = {unit_text: self._largest(unit_text) for unit_text in ("W", "W/K")}
        for name, written in self.notes.items():
            for note in (note for note in written if note.watches):
                self._draw_watch(axes, name, note.watches)
        pairs = sorted(zip(self.strokes, self.curves, strict=True), key=lambda pair: -abs(pair[0].value or 0))
        for stroke, curve in pairs:
            self.draw_stroke(axes, stroke, curve, largest[stroke.unit])
        for stroke, curve in sorted(pairs, key=lambda pair: pair[0].name not in self.whole):
            self._label(axes, stroke, curve, largest[stroke.unit])
        for symbol in self.placing.at:
            self.draw_node(axes, symbol)
            self._draw_text(axes, symbol)
        used = {note.mark for at in self.notes.values() for note in at}
        streams = any(stroke.stream for stroke in self.strokes)
        draw_legend(axes, self.machine, self.radius, words_of(self.machine, used, streams))

    def _largest(self, unit_text: str) -> float:
        values = [abs(stroke.value or 0.0) for stroke in self.strokes if stroke.unit == unit_text]
        return max(values, default=0.0) or 1.0

    def _route(self, stroke: Stroke) -> Array:
        start, end = self._ends(stroke)
        return route(start, end, (self.radius[stroke.a] + 1.5, self.radius[stroke.b] + 1.5), self.around)

    def _ends(self, stroke: Stroke) -> tuple[Array, Array]:
        a, b = self.placing.symbol(stroke.a, stroke.b), self.placing.symbol(stroke.b, stroke.a)
        return np.array(self.placing.at[a]), np.array(self.placing.at[b])

    def extent(self) -> tuple[float, float, float, float]:
        """x0, x1, y0, y1 of everything."""
        x0, x1, y0, y1 = np.array(self.boxes).T
        points = np.concatenate([*self.curves, np.column_stack([x0, y0]), np.column_stack([x1, y1])])
        (left, bottom), (right, top) = points.min(axis=0), points.max(axis=0)
        return float(left), float(right), float(bottom), float(top)

    def draw_stroke(self, axes: Axes, stroke: Stroke, curve: Array, largest: float) -> None:
        held = any(self.machine.nodes[name].is_held for name in (stroke.a, stroke.b))
        colour = COLOURS["stream" if stroke.stream else "loss" if held else "link"]
        size = STREAM if stroke.stream else abs(stroke.value or 0.0) / largest
        start, end = self._ends(stroke)
        whole = np.concatenate([[start], curve, [end]]) if stroke.a != stroke.b else curve
        axes.plot(*whole.T, color=colour, linewidth=self._width(stroke, largest), solid_capstyle="butt", zorder=1)
        flows = stroke.unit == "W" and size > 1e-6
        if stroke.stream or flows:
            backwards = not stroke.stream and (stroke.value or 0.0) < 0
            head = arrow(curve[::-1] if backwards else curve, 4.0 + 4.0 * size)
            axes.fill(*head.T, facecolor=colour, edgecolor="white", linewidth=0.4, zorder=2)
            self.around.take(float(head[:, 0].mean()), float(head[:, 1].mean()), 6.0 + 5.0 * size, 6.0 + 5.0 * size)

    def _width(self, stroke: Stroke, largest: float) -> float:
        """Of a line [pt]."""
        return 0.7 + 4.5 * (STREAM if stroke.stream else abs(stroke.value or 0.0) / largest)

    def _breadth(self, stroke: Stroke, largest: float) -> float:
        """What a label beside a line keeps off [pt]."""
        return self._width(stroke, largest)

    def _label(self, axes: Axes, stroke: Stroke, curve: Array, largest: float) -> None:
        """Name and value where there is room, beside a line that is thick; else a number, which stands below with the
        name, and the value; else that number alone; else it stands below only."""
        if stroke.value is None:
            return
        value, key = self._value(stroke), f"({len(self.numbered) + 1})"
        both = [cut(stroke.name, self.whole, 18), value]
        own = stroke.name in self.whole
        named = [(both, False)] * (own or len(self.strokes) <= MOST_NAMED) + [(both, True)] * own
        keyed = [([f"{key} {value}"], False), ([key], False), ([key], True)]
        for lines, crossing in [*named, *keyed]:
            sizes = [text_size(line, self.font - 0.5) for line in lines]
            width, height = max(w for w, _ in sizes) + 2, sum(h for _, h in sizes)
            spot = self.around.spot(width, height, curve, crossing, 0.0 if crossing else self._breadth(stroke, largest))
            if spot is not None:
                self.around.take(*spot, width, height)
                self._write_label(axes, spot, "\n".join(lines), stroke.name)
                self.numbered += [f"{stroke.name} {value}"] * (lines is not both)
                return
        self.unplaced.append(f"{stroke.a} – {stroke.b}: {stroke.name} {value}")

    def _value(self, stroke: Stroke) -> str:
        """The number of a line; what flows through a stream is no conductance, and is called so."""
        size = (stroke.value or 0.0) if stroke.stream else abs(stroke.value or 0.0)
        told = watts(size) if stroke.unit == "W" else number(size, stroke.unit, 3)
        return f"flow {told}" if stroke.stream and stroke.unit != "W" else told

    def _write_label(self, axes: Axes, spot: tuple[float, float], text: str, name: str) -> None:
        axes.text(
            *spot, literal(text), fontsize=self.font - 0.5, color=INK, ha="center", va="center", linespacing=1.05,
            bbox=BACKING, zorder=3, gid=f"link:{name}",
        )  # fmt: skip

    def draw_node(self, axes: Axes, symbol: str) -> None:
        from matplotlib.patches import Circle, Rectangle

        name, (x, y) = owner(symbol), self.placing.at[symbol]
        node, r = self.machine.nodes[name], self.radius[name]
        if node.is_held:
            axes.add_patch(Rectangle((x - r, y - r), 2 * r, 2 * r, facecolor=HELD_FILL, **EDGE))
        else:
            axes.add_patch(Circle((x, y), r, facecolor=INK if node.is_massless else FILL, **EDGE))

    def _draw_text(self, axes: Axes, symbol: str) -> None:
        (x, y), side, name = self.placing.at[symbol], self.placing.side[symbol], owner(symbol)
        block = self.blocks[name]
        r = block.radius + 2
        left = {"right": x + r + 1, "left": x - r - 1}.get(side, x)
        top = {"below": y - r, "above": y + r + block.height}.get(side, y + block.height / 2)
        align = {"right": "left", "left": "right"}.get(side, "center")
        for text, colour, bold in self.texts[name]:
            high = self.font * 1.25
            axes.text(
                left, top - high / 2, text, fontsize=self.font, color=colour, fontweight="bold" if bold else "normal",
                ha=align, va="center", zorder=5, gid=f"node:{name}", bbox=BACKING,
            )  # fmt: skip
            top -= high

    def _draw_watch(self, axes: Axes, name: str, watched: str) -> None:
        """A dotted line from the node that switches a relay."""
        symbol = next(symbol for symbol in self.placing.at if owner(symbol) == watched)
        start, end = np.array(self.placing.at[symbol]), np.array(self.placing.at[name])
        curve = route(start, end, (self.radius[watched], self.radius[name]), self.around)
        axes.plot(*curve.T, color=COLOURS["relay"], linestyle=(0, (1, 2)), linewidth=1.1, zorder=0.8)
