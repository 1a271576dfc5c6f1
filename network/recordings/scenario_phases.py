"""Scenarios in rows: phases, each with what changes at its beginning; what a row does not name holds."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import word_of
from network.platform.quantities.units import NUMBER, BadNumber, Unit
from network.platform.refusal import Complaints, Refused, Spot, likely
from network.platform.yaml.document import Branch, Items, Tree
from network.recordings.inputs import Signal
from network.recordings.possible_input import check_possible
from network.recordings.yaml_values import check_keys, collecting, quantity, seconds

LENGTH = "for"
EXAMPLE = "`{for: 30 min, speed: 6000 rpm, feed: 8 m/min}`"


@dataclass
class _Column:
    """One input down the rows: number from 0 with first and last value of every row that names it."""

    unit: Unit | None = None
    cells: list[tuple[int, float, float]] = field(default_factory=list)

    @property
    def shown(self) -> str:
        return self.unit.text or "1" if self.unit else "1"

    def signal(self, name: str, edges: Array) -> Signal:
        """What a row ends with holds until another names it; edges: where rows begin and end [s]."""
        knots = dict[float, tuple[float, float]]()
        for row, first, last in self.cells:  # where a slope ended just now, what begins counts
            knots[float(edges[row])] = first, last
            if first != last:
                knots[float(edges[row + 1])] = last, last
        t = np.array(list(knots))
        firsts, lasts = np.array(list(knots.values())).T.copy()
        return Signal(name, self.shown, t, firsts, firsts if np.array_equal(firsts, lasts) else lasts)


def read_phases(tree: Tree, duration: float | None) -> tuple[dict[str, Signal], float]:
    """Inputs of the rows, and the duration [s]: as given, else as long as all rows together. Raises Refused with every
    fault, or BadNumber."""
    if not isinstance(tree, Items) or not tree.entries:
        raise BadNumber("is no list of rows", f"write rows like {EXAMPLE}")
    complaints, columns = Complaints(), dict[str, _Column]()
    edges = _edges(tree, duration, complaints)
    for number, row in enumerate(tree.entries):
        slip = _length_meant(row)
        for name, spot, cell in _cells(row):
            if name != slip:
                with collecting(complaints, spot, f"phases, row {number + 1}, {name}"):
                    _read_cell(name, cell, number, columns)
    complaints.raise_if_any()
    made = {name: column.signal(name, edges) for name, column in columns.items()}
    for name in (name for name, signal in made.items() if signal.unit in ("degC", "degF")):  # K may be a difference
        with collecting(complaints, tree.spot, f"phases, {name}"):
            check_possible(made[name])
    complaints.raise_if_any()
    return made, duration if duration is not None else float(edges[-1])


def _edges(tree: Items, duration: float | None, complaints: Complaints) -> Array:
    """Where rows begin, and the last one ends [s]; not finite from a row on that there was a complaint about."""
    edges = [0.0]
    for number, row in enumerate(tree.entries, 1):
        where, is_last = f"phases, row {number}", number == len(tree.entries)
        if duration is not None and edges[-1] >= duration:
            wrong = f"{where} begins after {edges[-1] / 60:g} min, and the scenario lasts {duration / 60:g} min"
            complaints.refuse(row.spot, wrong, "make `duration` longer, or drop it: then the rows decide")
        rest = duration - edges[-1] if is_last and duration is not None else None
        edges.append(edges[-1] + _length(row, where, rest, complaints))
    return np.array(edges)


def _length(row: Tree, where: str, rest: float | None, complaints: Complaints) -> float:
    if not isinstance(row, Branch):
        complaints.refuse(row.spot, f"{where} is not a mapping", f"write it like {EXAMPLE}")
        return math.nan
    if LENGTH not in row.items:
        meant = _length_meant(row)
        if meant:
            complaints.refuse(row.key_spot(meant), f"{where} has no `for`, but `{meant}`", "did you mean 'for'?")
        elif rest is None:
            complaints.refuse(row.spot, f"{where} has no `for`", "say how long it lasts, as in `for: 30 min`")
        return math.nan if meant or rest is None else rest
    with collecting(complaints, row.key_spot(LENGTH), f"{where}, for"):
        return seconds(row.items[LENGTH])
    return math.nan


def _length_meant(row: Tree) -> str:
    """The key of a row without `for` that holds a time: no input is one."""
    if not isinstance(row, Branch) or LENGTH in row.items:
        return ""
    for name, cell in row.items.items():
        with suppress(BadNumber, Refused):
            seconds(cell)
            return name
    return ""


def _cells(row: Tree) -> Iterator[tuple[str, Spot, Tree]]:
    if isinstance(row, Branch):
        yield from ((name, row.key_spot(name), cell) for name, cell in row.items.items() if name != LENGTH)


def _read_cell(name: str, cell: Tree, number: int, columns: dict[str, _Column]) -> None:
    """Adds what a row says of an input. Raises BadNumber or Refused."""
    known, column = list(columns), columns.setdefault(name, _Column())
    values = [_read_value(leaf, column) for leaf in _leaves(cell, number)]
    column.cells.append((number, values[0][0], values[-1][0]))
    if name not in known and number:
        near = likely(name, known)
        also = f"name it in row 1 as well, as in `{name}: {_still(values[0][1])}`"
        raise BadNumber("is named here first", f"{near} Else {also}" if near.endswith("?") else also)


def _read_value(leaf: Tree, column: _Column) -> tuple[float, Unit]:
    """Value in SI, and its unit, which has to be of the kind that the rows above have."""
    text = word_of(leaf, "a value, like `6000 rpm`")
    if column.unit is not None and re.fullmatch(NUMBER, text) and column.shown != "1":
        raise BadNumber(f"'{text}' has no unit", f"write `{text} {column.shown}`")
    value, given = quantity(leaf)
    column.unit = column.unit or given
    if given.dimension != column.unit.dimension:
        raise BadNumber(f"'{text}' is in another kind of unit than above", f"that was {column.shown}, write all so")
    return value, given


def _leaves(cell: Tree, number: int) -> Iterator[Tree]:
    """One value that holds, or two between which it runs straight."""
    if not isinstance(cell, Branch):
        word_of(cell, "a value, like `6000 rpm`, or `{from: 0 rpm, to: 6000 rpm}`")
        yield cell
        return
    complaints = Complaints()
    check_keys(cell, f"phases, row {number + 1}", {"from": "0 rpm", "to": "6000 rpm"}, (), complaints)
    complaints.raise_if_any()
    yield from (cell.items["from"], cell.items["to"])


def _still(of: Unit) -> str:
    return "22 degC" if of.is_temperature else f"0 {of.text}".rstrip()
