"""Scenarios: what drives a simulation over time, from a file or from plain Python values."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from network import yamlfile
from network.declare import Array
from network.fields import word_of
from network.inputs import Schedule, Signal, Start, constant, linear
from network.refusal import Complaints, Refused, Spot, likely, refuse
from network.units import BadNumber, Unit, difference, in_unit, split_number, unit
from network.yamlfile import Branch, Items, Leaf, Tree

MOST_SAMPLES = 20_000_000
LINES_PER_PERIOD = 2000
ABSOLUTE_ZERO = -273.15
_DAY = 86400.0
_HOLD = {"at": "8000 rpm"}
_RISE = {"from": "0 rpm", "to": "8000 rpm"}
_RAMP = {"from": "20 degC", "to": "24 degC", "for": "2 h"}
_SINE = {"mean": "22 degC", "amplitude": "2 K", "period": "24 h"}
_CSV = {"csv": "file.csv", "column": "ambient"}
_START = "a temperature like `22 degC`, `{housing: 24 degC, others: 22 degC}` or `steady`"
_BARE = "that one has no unit, write all values with their unit"
_FORMS = "write a value, a list of steps, `{ramp: …}`, `{sine: …}` or `{csv: file.csv, column: …}`"


@dataclass(frozen=True, eq=False)
class Scenario:
    """Inputs over a duration. `schedule` drives a simulation; its instants are 0, output, 2 output … and the end.

    output: [s] between two of them.
    """

    schedule: Schedule
    output: float

    @property
    def name(self) -> str:
        return self.schedule.name

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.schedule.t[-1])

    @classmethod
    def load(cls, path: str | Path) -> Scenario:
        """The scenario of a YAML file. Raises Refused with every fault found."""
        return _read(yamlfile.load(Path(path), "a scenario"), Path(path).parent)

    @classmethod
    def of(
        cls, name: str, duration: str, inputs: Mapping[str, Any] | None = None, output: str = "10 s",
        start: str | Mapping[str, str] | None = None, folder: str | Path = ".",
    ) -> Scenario:  # fmt: skip
        """The same from Python values written as in a file; `folder` is where paths start. Raises Refused."""
        given = {"scenario": name, "duration": duration, "output": output, "start": start, "inputs": inputs}
        tree = yamlfile.tree_of({key: value for key, value in given.items() if value is not None}, Spot("python"))
        assert isinstance(tree, Branch)
        return _read(tree, Path(folder))

    def __str__(self) -> str:
        return f"{self.name}: {self.duration / 3600:g} h, inputs {', '.join(self.schedule.signals) or 'none'}"


@contextmanager
def told(complaints: Complaints, spot: Spot, what: str) -> Iterator[None]:
    """Turns a bad number or a refusal into complaints about `what`, and goes on."""
    try:
        yield
    except BadNumber as error:
        complaints.refuse(spot, f"{what}: {error.wrong}", error.right)
    except Refused as refused:
        complaints.absorb(refused)


def check_keys(
    tree: Branch, where: str, needed: Mapping[str, str], others: Sequence[str], complaints: Complaints
) -> None:
    """Complains about unknown and missing keys; `needed` holds an example for each."""
    known = [*needed, *others]
    for key in tree.items:
        if key not in known:
            complaints.refuse(tree.key_spot(key), f"{where} has an unknown key '{key}'", likely(key, known))
    for key, example in needed.items():
        if key not in tree.items:
            complaints.refuse(tree.spot, f"{where} has no `{key}`", f"add `{key}: {example}`")


def read_keys(
    tree: Branch, readers: Mapping[str, Callable[[Tree], Any]], values: dict[str, Any], complaints: Complaints
) -> None:
    """Reads the keys that are there into `values`, in the order of `readers`; a faulty one is left out."""
    for key in [key for key in readers if key in tree.items]:
        with told(complaints, tree.key_spot(key), key):
            values[key] = readers[key](tree.items[key])


def _in(tree: Tree, wanted: str, right: str) -> tuple[str, float]:
    text = word_of(tree, right)
    try:
        return text, in_unit(text, wanted)
    except BadNumber as error:
        raise BadNumber(error.wrong, f"give {right}") from None


def seconds(tree: Tree) -> float:
    """A time above zero [s]. Raises BadNumber."""
    text, value = _in(tree, "s", "a time, like `10 min`")
    if not 0 < value < math.inf:
        raise BadNumber(f"'{text}' is " + ("not finite" if value > 0 else "not above zero"), "give a time above zero")
    return value


def _shift(tree: Tree) -> float:
    """A time of either sign [s], or zero. Raises BadNumber."""
    text, value = _in(tree, "s", "a time, like `1 h`")
    if not math.isfinite(value):
        raise BadNumber(f"'{text}' is not finite", "give a finite time")
    return value


def quantity(tree: Tree) -> tuple[float, Unit]:
    """A value of an input in SI (temperatures in °C) and the unit it came in. Raises BadNumber.

    Only a switch, from 0 to 1, goes without unit; another bare number is written like `3 1`.
    """
    text = word_of(tree, "a number with its unit, like `8000 rpm`")
    if "±" in text or "+-" in text or "+/-" in text:
        raise BadNumber(f"'{text}' has a spread", "inputs are known, so drop the ±")
    number, unit_text = split_number(text)
    if not unit_text and not 0 <= number <= 1:
        raise BadNumber(f"'{text}' has no unit", f"write it like `{text} rpm`, only a switch (0 or 1) goes without")
    value = unit(unit_text).to_si(number)
    if not math.isfinite(value) or (unit(unit_text).is_temperature and value < ABSOLUTE_ZERO - 1e-9):
        raise BadNumber(f"'{text}' is out of range", "give a finite value, a temperature above absolute zero")
    return value, unit(unit_text)


def parse_start(tree: Tree) -> Start:
    """`22 degC`, `{housing: 24 degC, others: 22 degC}` or `steady`. Raises Refused."""
    complaints = Complaints()
    children = dict(tree.items) if isinstance(tree, Branch) else {"others": tree}
    if isinstance(tree, Leaf) and tree.text == "steady":
        return Start(steady=True)
    temperatures = {}
    for node, child in children.items():
        where = f"start.{node}" if isinstance(tree, Branch) else "start"
        with told(complaints, tree.key_spot(node) if isinstance(tree, Branch) else tree.spot, where):
            temperatures[node] = _temperature(child)
    complaints.raise_if_any()
    others = temperatures.pop("others", None)
    return Start(others=others, nodes=temperatures or None)


def _temperature(tree: Tree) -> float:
    text, value = _in(tree, "degC", _START)
    if not ABSOLUTE_ZERO <= value < math.inf:
        raise BadNumber(f"'{text}' is out of range", "give a temperature above absolute zero")
    return value


def _read(tree: Branch, folder: Path) -> Scenario:
    complaints = Complaints()
    needed = {"scenario": "name", "duration": "4 h"}
    check_keys(tree, "the scenario", needed, ("output", "start", "inputs"), complaints)
    readers: dict[str, Callable[[Tree], Any]] = {
        "scenario": lambda child: word_of(child, "a name"),
        "duration": seconds,
        "output": seconds,
        "start": parse_start,
        "inputs": lambda child: _signals(child, values.get("duration", _DAY), folder),
    }
    values: dict[str, Any] = {"output": 10.0, "start": None, "inputs": {}}
    read_keys(tree, readers, values, complaints)
    if "duration" in values:
        with told(complaints, tree.key_spot("output"), "output"):
            values["t"] = _instants(values["duration"], values["output"])
    complaints.raise_if_any()
    schedule = Schedule(values["scenario"], tree.spot.file, values["t"], values["inputs"], values["start"])
    return Scenario(schedule, values["output"])


def _instants(duration: float, output: float) -> Array:
    """0, output, 2 output … and the end."""
    if output > duration:
        raise BadNumber(f"{output:g} s is longer than the duration, {duration:g} s", f"give {duration / 100:g} s, say")
    if duration / output > MOST_SAMPLES:
        wrong = f"{output:g} s makes more than {MOST_SAMPLES / 1e6:g} million samples in {duration:g} s"
        raise BadNumber(wrong, f"give {duration / MOST_SAMPLES:.3g} s or more")
    t = np.arange(math.floor(duration / output * (1 + 1e-12)) + 1, dtype=np.float64) * output
    if duration - t[-1] > 1e-9 * output:
        return np.append(t, duration)
    t[-1] = duration
    return t


def _signals(tree: Tree, duration: float, folder: Path) -> dict[str, Signal]:
    if not isinstance(tree, Branch):
        raise BadNumber("is not a mapping", "write `{speed: 8000 rpm, ambient: 22 degC}`")
    complaints, signals = Complaints(), dict[str, Signal]()
    for name, child in tree.items.items():
        with told(complaints, tree.key_spot(name), f"inputs.{name}"):
            signals[name] = _Input(name, duration, folder).read(child)
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
        after = self._get(body, where, "after", _shift, 0.0)
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
        phase = self._get(body, where, "phase", _shift, 0.0)
        self.complaints.raise_if_any()
        if self.duration / period * LINES_PER_PERIOD > MOST_SAMPLES:
            most = MOST_SAMPLES // LINES_PER_PERIOD
            raise BadNumber(f"has more than {most} periods", f"give a period of at least {self.duration / most:.3g} s")
        count = math.ceil(self.duration / period * LINES_PER_PERIOD) + 1
        t = np.arange(count, dtype=np.float64) * (period / LINES_PER_PERIOD)
        return linear(self.name, self._shown, t, mean + amplitude * np.sin(2 * np.pi * (t + phase) / period))

    def _csv(self, tree: Branch) -> Signal:
        """A column of a CSV (or of a mapping of one); before its first and after its last row it holds the ends."""
        from network.recording import Recording  # a recording reads its own start with this module

        path, column = (word_of(tree.items[key], f"`{key}: {_CSV[key]}`") for key in _CSV)
        if not (self.folder / path).exists():
            raise BadNumber(f"there is no file '{path}'", "give its path relative to the scenario file")
        recording = Recording.load(self.folder / path)
        first, last = recording.t[0], recording.t[-1]
        if last <= 0 or first >= self.duration:
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
            with told(self.complaints, tree.key_spot(key), f"{where}, {key}"):
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


def start_of(text: str) -> Start:
    """The start given on the command line, in the form of a file. Raises Refused."""
    spot = Spot("--start")
    try:
        value = yaml.load(text, Loader=yaml.BaseLoader)
    except yaml.YAMLError:
        raise refuse(spot, f"'{text}' is not understood", "write '22 degC', 'steady' or '{housing: 24 degC}'") from None
    return parse_start(yamlfile.tree_of(value, spot))
