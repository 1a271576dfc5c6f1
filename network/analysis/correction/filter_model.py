"""The filter that a control runs: few states, stepped by inputs, corrected by sensors with a constant gain.

At every step, in this order: y = S z + direct; z ← z + L (read − y), readings that are NaN counting for nothing; where
an input drives conductances, q = g (F z + direct) is what they let pass more than at the mean input, and adds to drive
and direct; the movement told is M z + direct; z ← Φ z + drive, inputs and q held until the next step. Temperatures are
rises over the machine's reference. The C file that is written of it does the same in the same order.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from network.analysis.correction.input_table import InputTable
from network.catalogue.declaration.declare import Array
from network.platform.printing import Brief


@dataclass(frozen=True, eq=False, repr=False)
class FilterModel(Brief):
    """machine: its name; step: [s]; reference: [°C]; inputs: name → unit, in the order of the values of a step;
    sensors, axes: names; axis_units.

    own: how many of the r states are the machine's; the others, `unknown`, are what heats it unknown, each in its σ,
    named by the source most like it; known: covariance of them as far as readings tell. Phi (r, r); M (axes, r),
    S (sensors, r); held: input → its column of (r + axes + sensors + 2 films), of a rise of it, of films what adds to
    their differences at once, then their g; tables: the same of other inputs;
    constant: of nothing; uniform, offset: z = uniform T − offset of a machine that has the temperature T [K over the
    reference] throughout; gain, first_gain: (r, sensors); spread: 1σ of what is told of the axes; missed: 1σ of what a
    reading misses, as far as the filter knows; films: F (films, r); film_heat: (films, r + axes), what a watt through
    each does.
    """

    machine: str
    step: float
    reference: float
    inputs: Mapping[str, str]
    sensors: tuple[str, ...]
    axes: tuple[str, ...]
    axis_units: tuple[str, ...]
    own: int
    unknown: tuple[str, ...]
    known: Array
    Phi: Array
    M: Array
    S: Array
    held: Mapping[str, Array]
    tables: tuple[InputTable, ...]
    constant: Array
    uniform: Array
    offset: Array
    gain: Array
    first_gain: Array
    spread: Array
    missed: Array
    films: Array
    film_heat: Array

    @property
    def states(self) -> int:
        return len(self.Phi)

    @property
    def multiplications(self) -> int:
        """Of one step."""
        r, width = self.states, len(self.constant)
        own = r * r + 2 * r * len(self.sensors) + r * len(self.axes) + len(self.films) * (2 * r + len(self.axes) + 1)
        return own + width * (len(self.held) + 2 * len(self.tables))

    @property
    def growth(self) -> float:
        """What a state may grow by in a step, with conductances at the ends of their tables; above 1 it never ends."""
        count, r = len(self.films), self.states
        rows = [row for table in self.tables for row in (table.zero, table.above[-1], table.below[-1])] if count else []
        at_ends = [self.Phi + (self.film_heat[:, :r].T * row[-count:]) @ self.films for row in rows]
        return max((float(np.abs(np.linalg.eigvals(Phi)).max()) for Phi in at_ends), default=0.0)

    def driven(self, inputs: Mapping[str, float]) -> Array:
        """Drive of the states, then what axes and sensors see at once: (r + axes + sensors). Inputs in their units; of
        one that is NaN the temperature counts as the reference, anything else as zero."""
        total = self.constant.copy()
        for name, column in self.held.items():
            if inputs[name] == inputs[name]:
                total += column * (inputs[name] - self.reference)
        for table in self.tables:
            total += table.at(inputs[table.name])
        return total

    def start(self, inputs: Mapping[str, float], read: Array) -> Array:
        """States from the first readings [°C]: all parts at their mean (the reference without), then bent to each."""
        finite = np.isfinite(read)
        mean = float(np.sum(read[finite]) / finite.sum()) - self.reference if finite.any() else 0.0
        z = self.uniform * mean - self.offset
        return np.asarray(z + self.first_gain @ self._missed(z, self.driven(inputs), read))

    def advance(self, z: Array, inputs: Mapping[str, float], read: Array) -> tuple[Array, Array, Array]:
        """(states at the next step, movement of the axes now, readings less what was expected)."""
        driven, r = self.driven(inputs), self.states
        missed = self._missed(z, driven, read)
        z = z + self.gain @ missed
        driven = self._let_pass(z, driven)
        return self.Phi @ z + driven[:r], self.M @ z + driven[r : r + len(self.axes)], missed

    def tell(self, z: Array, inputs: Mapping[str, float]) -> Array:
        """Movement of the axes with these states, nothing read."""
        driven = self._let_pass(z, self.driven(inputs))
        return np.asarray(self.M @ z + driven[self.states : self.states + len(self.axes)])

    def _let_pass(self, z: Array, driven: Array) -> Array:
        """With the heat of the films that their input opens or shuts."""
        count, known = len(self.films), self.states + len(self.axes)
        if not count:
            return driven
        heat = driven[-count:] * (self.films @ z + driven[-2 * count : -count])
        return np.concatenate([driven[:known] + heat @ self.film_heat, driven[known:]])

    def _missed(self, z: Array, driven: Array, read: Array) -> Array:
        first = self.states + len(self.axes)
        expected = self.S @ z + driven[first : first + len(self.sensors)]
        return np.where(np.isfinite(read), read - self.reference - expected, 0.0)

    def run(self, inputs: Mapping[str, Array], read: Array, z: Array | None = None) -> tuple[Array, Array]:
        """Movement of the axes, (steps, axes), and what the readings missed, (steps, sensors). inputs: values at every
        step in their units; read: (steps, sensors), NaN where there is none; z: states to begin with."""
        values = np.stack([*inputs.values()], axis=1).tolist() if inputs else [[]] * len(read)
        rows = [dict(zip(inputs, row, strict=True)) for row in values]
        z = self.start(rows[0], read[0]) if z is None else z
        told, missed = np.empty((len(rows), len(self.axes))), np.empty(read.shape)
        for k, row in enumerate(rows):
            z, told[k], missed[k] = self.advance(z, row, read[k])
        return told, missed
