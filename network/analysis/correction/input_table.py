"""What an input drives, as a table over its values: no law of the catalogue is needed where it is looked up."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from network.analysis.correction.linear_model import LinearModel, moves_at_once
from network.catalogue.declaration.declare import Array
from network.catalogue.mechanisms.mechanism import Inputs
from network.engine.balance import source_heat
from network.platform.quantities.units import unit
from network.platform.refusal import Complaints

FINE = 1e-4
"""Of the largest value: what straight lines between the entries of a table may miss."""
FEWEST, MOST = 8, 256
"""Steps of a table: doubled until they are fine enough."""


@dataclass(frozen=True)
class InputTable:
    """name, unit: of the input; step: between two rows in that unit; zero: at exactly zero; above, below: rows from
    just beside zero outwards (rows, v), further out along the last two. Values: heat into every lump [W], axes [m],
    then what the conductance of every driven flow lies above that at the mean input [W/K]."""

    name: str
    unit: str
    step: float
    zero: Array
    above: Array
    below: Array

    def at(self, value: float) -> Array:
        """The row at a value of the input, straight between the entries; that of zero for NaN."""
        if value == 0 or value != value:
            return self.zero
        rows, place = (self.above, value / self.step) if value > 0 else (self.below, -value / self.step)
        k = min(int(place), len(rows) - 2)
        return np.asarray(rows[k] + (place - k) * (rows[k + 1] - rows[k]))

    def map(self, matrix: Array) -> InputTable:
        """The table of matrix @ values."""
        rows = (np.asarray(values @ matrix.T) for values in (self.zero, self.above, self.below))
        return InputTable(self.name, self.unit, self.step, *rows)


def tabulate(model: LinearModel, tops: dict[str, float]) -> tuple[Array, tuple[InputTable, ...]]:
    """What is constant, and a table for every input that drives heat or moves an axis at once. tops: its largest
    magnitude, in its unit. Raises Refused for an entry that reads two inputs."""
    _refuse_two_inputs(model)
    constant = _values(model, "", np.zeros(1))[0]
    constant[: len(model.rest)] += model.rest
    names = sorted({name for group in _laws(model) for name in group})
    return constant, tuple(_table(model, name, tops.get(name, 1.0)) for name in names)


def _laws(model: LinearModel) -> Iterator[frozenset[str]]:
    """Inputs that each source, and each entry that moves at once, reads."""
    for heats in model.network.heats:
        if heats.is_heat:
            yield frozenset(heats.law.needs())
    for entry in model.machine.expansions.values():
        if moves_at_once(entry):
            yield frozenset(entry.needs())
    yield from (frozenset([films.input]) for films in model.films)


def _refuse_two_inputs(model: LinearModel) -> None:
    complaints = Complaints()
    for path, entry in model.machine.entries():
        if entry.section == "sources" and len(entry.needs()) > 1:
            reads = " and ".join(entry.needs())
            complaints.refuse(entry.spot, f"{path} reads {reads}, and a table has one input", "let it read one of them")
    complaints.raise_if_any()


def _table(model: LinearModel, name: str, top: float) -> InputTable:
    given = unit(model.machine.inputs[name] or "1")
    zero = _values(model, name, np.zeros(1))[0]

    def rows(steps: int, way: float) -> Array:
        at = np.linspace(0, top, steps + 1)
        at[0] = top * 1e-9
        return _values(model, name, np.asarray(given.scale * way * at))

    steps = FEWEST
    while steps < MOST and _bend(rows(2 * steps, 1.0)) > FINE:
        steps *= 2
    return InputTable(name, given.text, top / steps, zero, rows(steps, 1.0), rows(steps, -1.0))


def _bend(fine: Array) -> float:
    """How far every second row lies off the line between its neighbours, over the largest."""
    return float(np.abs(fine[1::2] - (fine[:-1:2] + fine[2::2]) / 2).max() / max(np.abs(fine).max(), 1e-300))


def _values(model: LinearModel, name: str, values: Array) -> Array:
    """Heat into every lump and movement of every axis by what reads `name` alone (nothing: by what reads no input), at
    its values (SI), beyond what they are at the point: (values, N + axes + driven flows)."""
    own = {name: values[:, None]} if name else {}
    u: Inputs = {**{n: v * np.ones((len(values), 1)) for n, v in model.u.items()}, **own}
    reads = frozenset([name]) if name else frozenset()
    out = np.zeros((len(values), model.network.size + len(model.axes)))
    for heats in model.network.heats:
        if heats.is_heat and frozenset(heats.law.needs()) == reads:
            q = source_heat(heats, np.tile(model.point, (len(values), 1)), u)
            out[:, : model.network.size] += q @ heats.into.T
    for (axis, _), entry in model.machine.expansions.items():
        if moves_at_once(entry) and frozenset(entry.needs()) == reads:
            flat = {n: v[:, 0] for n, v in u.items()}
            out[:, model.network.size + model.axes.index(axis)] += entry.movement(flat)
    out[:, : model.network.size] += _more_heat(model, name, u)
    return np.hstack([out, *_more_conductance(model, name, u)])


def _more_heat(model: LinearModel, name: str, u: Inputs) -> Array:
    """Into every lump by the films that read `name`, with all temperatures at the point, beyond that at the mean."""
    mine = [films for films in model.films if films.input == name]
    return sum((f.heat(model.point, u) - f.heat(model.point, _mean(model, u)) for f in mine), start=np.zeros(1))


def _more_conductance(model: LinearModel, name: str, u: Inputs) -> Iterator[Array]:
    for films in model.films:
        more = films.conductances(model.point, u) - films.conductances(model.point, _mean(model, u))
        yield more * (films.input == name)


def _mean(model: LinearModel, u: Inputs) -> Inputs:
    """The inputs of the point, at as many instants."""
    return {name: values * np.ones_like(u["time"]) for name, values in model.u.items()}
