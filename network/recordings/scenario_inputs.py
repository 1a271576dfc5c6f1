"""The inputs of a scenario: constants, steps, ramps, sines and columns of a file, as signals."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from network.catalogue.declaration.fields import word_of
from network.platform.quantities.units import BadNumber, Unit, difference, split_number, unit
from network.platform.refusal import Complaints, likely
from network.platform.yaml.document import Branch, Items, Leaf, Tree
from network.recordings.inputs import Signal, constant, linear
from network.recordings.possible_input import check_possible
from network.recordings.recording import Recording
from network.recordings.yaml_values import check_keys, collecting, quantity, seconds, shift

MOST_SAMPLES = 20_000_000
LINES_PER_PERIOD = 2000
_HOLD = {"at": "8000 rpm"}
_RISE = {"from": "0 rpm", "to": "8000 rpm"}
_RAMP = {"from": "20 degC", "to": "24 degC", "for": "2 h"}
_SINE = {"mean": "22 degC", "amplitude": "2 K", "period": "24 h"}
_CSV = {"csv": "file.csv", "column": "ambient"}
_BARE = "that one has no unit, write all values with their unit"
_FORMS = "write a value, a list of steps, `{ramp: …}`, `{sine: …}` or `{csv: file.csv, column: …}`"


def signals(tree: Tree, duration: float, folder: Path) -> dict[str, Signal]:
    if not isinstance(tree, Branch):
        raise BadNumber("is not a mapping", "write `{speed: 8000 rpm, ambient: 22 degC}`")
    complaints, signals = Complaints(), dict[str, Signal]()
    for name, child in tree.items.items():
        with collecting(complaints, tree.key_spot(name), f"inputs.{name}"):
            signals[name] = _Input(name, duration, folder).read(child)
            if signals[name].unit in ("degC", "degF"):  # K may be a difference
                check_possible(signals[name])
    complaints.raise_if_any()
    return signals


@dataclass
class _Input:
    """Reads one input; its first value decides the unit. Collects faults and raises them at the end as Refused."""

    name: str
    duration: float
    folder: Path
    complaints: Complaints = field(default_factory=Complaints)
    first: Unit | None = None

    def read(self, tree: Tree) -> Signal:
        """The signal; raises BadNumber or Refused."""
        if isinstance(tree, Leaf):
            value = self._value(tree)
            return constant(self.name, self._shown, value)
        if isinstance(tree, Items):
            return self._steps(tree)
        forms = {"ramp": self._ramp, "sine": self._sine, "csv": self._csv}
        form = next((key for key in forms if key in tree.items), "")
        if not form:
            near = [likely(key, forms) for key in tree.items]
            raise BadNumber("is a mapping of no known form", near[0] if near and near[0].startswith("did") else _FORMS)
        check_keys(tree, f"inputs.{self.name}", _CSV if form == "csv" else {form: "{…}"}, (), self.complaints)
        self.complaints.raise_if_any()
        return forms[form](tree)

    def _steps(self, tree: Items) -> Signal:
        if not tree.entries:
            raise BadNumber("has no steps", _FORMS)
        knots, t = list[tuple[float, float, float]](), 0.0
        for number, entry in enumerate(tree.entries, 1):
            where, is_last = f"inputs.{self.name}, step {number}", number == len(tree.entries)
            length, start, end = self._step(entry, where, t, is_last)
            knots.append((t, start, end))
            t += length
        if knots[-1][1] != knots[-1][2]:
            knots.append((t, knots[-1][2], knots[-1][2]))
        self.complaints.raise_if_any()
        times, starts, ends = np.array(knots).T.copy()
        return Signal(self.name, self._shown, times, starts, ends)

    def _step(self, tree: Tree, where: str, t: float, is_last: bool) -> tuple[float, float, float]:
        """Length [s], first and last value of one step; NaN where there was a complaint."""
        form = _RISE if isinstance(tree, Branch) and {"from", "to"} & set(tree.items) else _HOLD
        if not isinstance(tree, Branch) or (form is _RISE and "at" in tree.items):
            right = "write `{for: 2 h, at: 8000 rpm}` or `{for: 10 min, from: 0 rpm, to: 8000 rpm}`"
            wrong = "has `at` beside `from` and `to`" if isinstance(tree, Branch) else "is not a mapping"
            self.complaints.refuse(tree.spot, f"{where} {wrong}", right)
            return math.nan, math.nan, math.nan
        check_keys(tree, where, form if is_last else {"for": "10 min", **form}, ("for",), self.complaints)
        values = [self._get(tree, where, key, self._value) for key in form]
        length = self._get(tree, where, "for", seconds, self.duration - t)
        if form is _RISE and length <= 0:
            self.complaints.refuse(tree.spot, f"{where} begins at the end of the scenario", "give `for: …`")
        return length, values[0], values[-1]

    def _ramp(self, tree: Branch) -> Signal:
        body, where = self._body(tree, "ramp", _RAMP, "after")
        start, end = self._get(body, where, "from", self._value), self._get(body, where, "to", self._value)
        after = self._get(body, where, "after", shift, 0.0)
        if after < 0:
            self.complaints.refuse(body.key_spot("after"), f"{where}, after: is before the start", "give 0 s or more")
        length = self._get(body, where, "for", seconds)
        self.complaints.raise_if_any()
        return linear(self.name, self._shown, np.array([after, after + length]), np.array([start, end]))

    def _sine(self, tree: Branch) -> Signal:
        """mean + amplitude sin(2π (t + phase) / period) by 2000 straight lines a period: the error is at most
        1.3e-6 of the amplitude, (2π/2000)²/8."""
        body, where = self._body(tree, "sine", _SINE, "phase")
        mean, amplitude = self._get(body, where, "mean", self._value), self._get(body, where, "amplitude", self._swing)
        period = self._get(body, where, "period", seconds)
        phase = self._get(body, where, "phase", shift, 0.0)
        self.complaints.raise_if_any()
        if not self.duration / period * LINES_PER_PERIOD <= MOST_SAMPLES:
            most = MOST_SAMPLES // LINES_PER_PERIOD
            raise BadNumber(f"has more than {most} periods", f"give a period of at least {self.duration / most:.3g} s")
        count = math.ceil(self.duration / period * LINES_PER_PERIOD) + 1
        t = np.arange(count, dtype=np.float64) * (period / LINES_PER_PERIOD)
        return linear(self.name, self._shown, t, mean + amplitude * np.sin(2 * np.pi * (t + phase) / period))

    def _csv(self, tree: Branch) -> Signal:
        """A column of a CSV (or of a mapping of one); before its first and after its last row it holds the ends."""

        path, column = (word_of(tree.items[key], f"`{key}: {_CSV[key]}`") for key in _CSV)
        if not os.path.exists(self.folder / path):
            raise BadNumber(f"there is no file '{path}'", "give its path relative to the scenario file")
        recording = Recording.load(self.folder / path)
        first, last = recording.t[0], recording.t[-1]
        if not (last > 0 and first < self.duration):
            raise BadNumber(
                f"'{path}' runs from {first:g} s to {last:g} s, outside of the scenario",
                f"shift its time to lie between 0 s and {self.duration:g} s",
            )
        return replace(recording.signal(column, tree.key_spot("column")), name=self.name)

    def _body(self, tree: Branch, form: str, needed: Mapping[str, str], other: str) -> tuple[Branch, str]:
        body, where = tree.items[form], f"inputs.{self.name}, {form}"
        if not isinstance(body, Branch):
            inside = ", ".join(f"{key}: {value}" for key, value in needed.items())
            raise BadNumber(f"`{form}` is not a mapping", f"write {{{form}: {{{inside}}}}}")
        check_keys(body, where, needed, (other,), self.complaints)
        return body, where

    def _get(
        self, tree: Branch, where: str, key: str, read: Callable[[Tree], float], default: float = math.nan
    ) -> float:
        if key in tree.items:
            with collecting(self.complaints, tree.key_spot(key), f"{where}, {key}"):
                return read(tree.items[key])
            return math.nan
        return default

    def _value(self, tree: Tree) -> float:
        value, given = quantity(tree)
        self._check(given, tree)
        return value

    def _swing(self, tree: Tree) -> float:
        """An amplitude: a difference, so degC counts as K."""
        number, unit_text = split_number(word_of(tree, "an amplitude, like `2 K`"))
        self._check(unit(unit_text), tree)
        return difference(unit(unit_text)).to_si(number)

    def _check(self, given: Unit, tree: Tree) -> None:
        self.first = self.first or given
        if given.dimension != self.first.dimension:
            wrong = f"'{word_of(tree, '')}' is in another kind of unit than the first value"
            raise BadNumber(wrong, _BARE if self._shown == "1" else f"that one is in {self._shown}, write all so")

    @property
    def _shown(self) -> str:
        return self.first.text if self.first else "1"
