"""A network with what was found lit: the parts it sits at, the links and entries it brings."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.entry_path import EntryPath, axis_of
from network.platform.wording import join_names
from network.report.figures.canvas import PALETTE, literal
from network.report.figures.network_figure import Picture, draw_picture
from network.report.figures.strokes import Stroke
from network.report.figures.symbols import BACKING, owner

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from network.analysis.diagnosis.findings.finding import Finding
    from network.analysis.diagnosis.findings.result import Diagnosis
    from network.machine.machine import Machine

LIGHT = PALETTE[4]
EDGE_LIGHT = PALETTE[1]
DRAWN = ("nodes", "links", "sources")
"""Sections of what stands in the picture."""
WIDER = 8.0
"""Breadth of the light beside a line [pt]."""


class LitPicture(Picture):
    """A picture with some nodes and links lit. lit: where they stand in the file; own: names of the findings'
    entries, told whole; moves: what stands at a node besides, like 'moves z'."""

    def __init__(
        self, machine: Machine, lit: Collection[EntryPath], own: Collection[str] = (),
        moves: Mapping[str, str] | None = None,
    ) -> None:  # fmt: skip
        self.lit, self.moves = lit, moves or {}
        super().__init__(machine, None, own)

    def _text(self, name: str) -> Iterator[tuple[str, str, bool]]:
        yield from super()._text(name)
        if name in self.moves:
            yield literal(self.moves[name]), EDGE_LIGHT, True

    def draw_stroke(self, axes: Axes, stroke: Stroke, curve: Array, largest: float) -> None:
        if EntryPath("links", "", stroke.name) in self.lit:
            size = abs(stroke.value or 0.0) / largest
            start, end = self._ends(stroke)
            whole = np.concatenate([[start], curve, [end]])
            axes.plot(*whole.T, color=LIGHT, linewidth=WIDER + 4.5 * size, solid_capstyle="round", zorder=0.6)
        super().draw_stroke(axes, stroke, curve, largest)

    def _breadth(self, stroke: Stroke, largest: float) -> float:
        lit = EntryPath("links", "", stroke.name) in self.lit
        return super()._breadth(stroke, largest) + (WIDER if lit else 0.0)

    def draw_node(self, axes: Axes, symbol: str) -> None:
        before = len(axes.patches)
        super().draw_node(axes, symbol)
        if EntryPath("nodes", "", owner(symbol)) in self.lit:
            for patch in axes.patches[before:]:
                patch.set(facecolor=LIGHT, edgecolor=EDGE_LIGHT, linewidth=2.5)


def lit_figure(d: Diagnosis) -> Figure:
    """The machine with its findings in it; what they are about is lit in orange."""
    lit = lit_paths(d)
    seats = [path.name for path in lit if path.section == "nodes"]
    also = [seat for f in d.findings for seat in (*f.places, *f.channels) if seat not in d.after.nodes]
    lit_up = [*seats, *(seat for seat in also if not (seats and axis_of(seat)))]
    where = join_names(list(dict.fromkeys(lit_up))) or "nothing"
    own = [path.name for f in d.findings for path, _ in f.patch.entries() if path.section in DRAWN]
    picture = LitPicture(d.after, lit, own, moves_of(d))
    figure = draw_picture(picture, f"{d.machine.name}: what was found, and where", f"lit in orange: {where}")
    _name_axes(d, figure)
    return figure


def lit_paths(d: Diagnosis) -> list[EntryPath]:
    """Parts of the findings (what is held is lit only where nothing else is), and the links they bring."""
    nodes = d.after.nodes
    paths: list[EntryPath] = []
    for finding in d.findings:
        own = [n for n in (*finding.places, *_list_measured_nodes(d, finding.channels)) if n in nodes]
        own = [n for n in own if not nodes[n].is_held] or own
        new = [path for path, _ in finding.patch.by_name() if _is_new(d, path)]
        paths += [EntryPath("nodes", "", n) for n in own] + new
    return list(dict.fromkeys(paths))


def _is_new(d: Diagnosis, path: EntryPath) -> bool:
    """Whether a link was changed or a node added."""
    return path.section == "links" or (path.section == "nodes" and path.name not in d.machine.nodes)


def _list_measured_nodes(d: Diagnosis, channels: Collection[str]) -> list[str]:
    places = [d.after.sensors[name].place for name in channels if name in d.after.sensors]
    return [place.node for place in places if place is not None]


def moves_of(d: Diagnosis) -> dict[str, str]:
    """Node → which axes of the tool centre point it moves by what was found."""
    axes: dict[str, list[str]] = {}
    for finding in d.findings:
        for name in (n for n in finding.places if n in d.after.nodes):
            axes.setdefault(name, []).extend(_axes(finding))
    return {name: f"↕ moves {join_names(list(dict.fromkeys(own)))}" for name, own in axes.items() if own}


def _axes(finding: Finding) -> list[str]:
    return [p for p in finding.places if axis_of(p)]


def _name_axes(d: Diagnosis, figure: Figure) -> None:
    """Axes of the tool centre point that a finding moves by no part: they are not in the network."""
    axes = [p for f in d.findings for p in _axes(f) if not any(n in d.after.nodes for n in f.places)]
    if axes:
        told = f"moves {join_names(list(dict.fromkeys(axes)))}"
        figure.text(0.985, 0.975, literal(told), ha="right", va="top", fontsize=9, color=PALETTE[1], bbox=BACKING)
