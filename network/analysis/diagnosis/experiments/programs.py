"""Programs that could be run next, made from what the recordings of a machine vary; what is held stays as it was.

Every input that the recordings vary can be programmed, over the range they cover. Temperatures and what held nodes are
held at cannot: they keep their mean, and the machine begins in equilibrium with them, as after a night.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.machine.machine import Machine
from network.platform.quantities.units import show, unit
from network.recordings.columns import Column
from network.recordings.inputs import Signal, Start, constant, hold
from network.recordings.recording import Recording

RANGE = (0.02, 0.98)
"""Quantiles of the recorded values that count as the range."""
HOURS = (0.5, 1.0, 2.0, 4.0, 6.0, 8.0)
"""A program is as long as the longest recording, cut to one of these."""
HOLDS = (8, 2, 4, 1, 3, 6, 1, 5, 2, 8, 3, 5)
"""Of an alternation, in 48ths of its length: from 5 to 40 min in 4 h."""
STEADY = ("[length]", "[temperature]")
"""Dimensions of what has no state of rest at zero."""
FASTEST = 5.0
"""s: shortest interval of readings that is counted on."""
MOST = 3
"""Inputs that are programmed."""


@dataclass(frozen=True)
class Driver:
    """An input that can be programmed. rest, high: SI; is_switch: knows these two levels only."""

    name: str
    unit: str
    rest: float
    high: float
    is_switch: bool

    def format_value(self, value: float) -> str:
        return show(value, self.unit, 6)

    def level(self, share: float) -> float:
        """Between rest and high, as one would type it."""
        of = unit(self.unit)
        return of.to_si(float(f"{of.from_si(self.rest + share * (self.high - self.rest)):.2g}"))


@dataclass(frozen=True)
class Program:
    """text: what to do; signals: every input over the hours; start: temperature of all parts [°C]; interval: of the
    readings [s]."""

    text: str
    hours: float
    signals: Mapping[str, Signal]
    start: float
    interval: float

    def scenario(self) -> dict[str, Any]:
        """The run as a scenario file holds it: constants apart, steps in rows with what changes."""
        steps = {n: s for n, s in self.signals.items() if len(s.t) > 1}
        still = {n: show(s.value, s.unit, 6) for n, s in self.signals.items() if n not in steps}
        edges = sorted({0.0, *(float(t) for s in steps.values() for t in s.t)})
        lengths = np.diff([*edges, 3600 * self.hours])
        rows = [{"for": f"{length / 60:.6g} min"} | {n: show(float(s.start[s.t == t][0]), s.unit, 6)
                for n, s in steps.items() if t in s.t} for t, length in zip(edges, lengths, strict=True)]  # fmt: skip
        timed = {"phases": rows} if steps else {"duration": f"{self.hours:g} h"}
        output = f"{self.interval:.6g} s"
        return {"scenario": self.text, "start": f"{self.start:.6g} degC", "output": output, "inputs": still, **timed}

    def recording(self, channels: Mapping[str, str]) -> Recording:
        """A recording of it whose channels (name → unit) all read zero."""
        t = np.arange(0.0, 3600 * self.hours + self.interval / 2, self.interval)
        columns = {name: Column(name, text, np.zeros(len(t))) for name, text in channels.items()}
        return Recording("program", "program", t, columns, self.signals, Start(others=self.start))


def programs(
    machines: Sequence[Machine], recordings: Sequence[Recording], matter: Collection[str] = ()
) -> list[Program]:
    """The library for what some machines read, from what their recordings hold; none where nothing was varied. matter:
    inputs that are programmed before all others."""
    needed = sorted(dict.fromkeys(n for m in machines for n in m.inputs), key=lambda name: name not in matter)
    steady = {n.temperature for m in machines for n in m.nodes.values() if isinstance(n.temperature, str)}
    drivers = [d for n in needed if n not in steady and (d := driver(n, recordings)) is not None][:MOST]
    hours = _hours(recordings)
    fixed = {n: _constant(n, recordings) for n in needed if n not in {d.name for d in drivers}}
    held_at = [float(fixed[n].start[0]) for n in steady if n in fixed]
    start = float(np.mean(held_at)) if held_at else machines[0].reference
    interval = max(float(np.median([np.median(np.diff(r.t)) for r in recordings])), FASTEST)
    return [
        Program(text, hours, {**fixed, **{s.name: s for s in signals}}, start, interval)
        for text, signals in _library(drivers, hours)
    ]


def driver(name: str, recordings: Iterable[Recording]) -> Driver | None:
    """How an input can be programmed; None for a temperature and for what was never varied."""
    signals = [r.signal(name) for r in recordings]
    of = signals[0].unit
    values = _values(name, recordings)
    low, high = (float(x) for x in np.quantile(values, RANGE))
    if unit(of).is_temperature or high - low <= 1e-6 * max(abs(high), abs(low)):
        return None
    rest = 0.0 if unit(of).dimension not in STEADY and low >= 0 else float(np.clip(0.0, low, high))
    is_switch = len(np.unique(np.round((values - low) / (high - low), 2))) == 2
    found = Driver(name, of, rest, high, is_switch)
    return Driver(name, of, rest, found.level(1.0), is_switch)


def _values(name: str, recordings: Iterable[Recording]) -> Array:
    return np.concatenate([r.signal(name).at(r.t) for r in recordings])


def _hours(recordings: Iterable[Recording]) -> float:
    longest = max(float(r.t[-1] - r.t[0]) for r in recordings) / 3600
    return max((h for h in HOURS if h <= 1.05 * longest), default=HOURS[0])


def _constant(name: str, recordings: Sequence[Recording]) -> Signal:
    """An input that is left alone, at its mean."""
    return constant(name, recordings[0].signal(name).unit, float(_values(name, recordings).mean()))


def _library(drivers: Sequence[Driver], hours: float) -> Iterator[tuple[str, list[Signal]]]:
    """Every program: what to do, and the signals of all drivers."""
    if not drivers:
        return
    others = {d: [_steps(o, [(0.0, 0.0)], hours) for o in drivers if o is not d] for d in drivers}
    half = _span(hours / 2)
    for d in drivers:
        soaked = _steps(d, [(0.0, 1.0), (0.5, 0.0)], hours)
        high, rest = d.format_value(d.high), d.format_value(d.rest)
        yield f"Run {d.name} at {high} for {half}, then at {rest} for {half}", [soaked, *others[d]]
    yield from _ladder([d for d in drivers if not d.is_switch], others, hours)
    yield _alternation(drivers, hours)
    off = " and ".join(f"{d.name} at {d.format_value(d.rest)}" for d in drivers)
    yield f"Leave {off} for {_span(hours)}", [_steps(d, [(0.0, 0.0)], hours) for d in drivers]


def _ladder(
    drivers: Sequence[Driver], others: Mapping[Driver, list[Signal]], hours: float
) -> Iterator[tuple[str, list[Signal]]]:
    """Up in four steps, then to rest, for the first input that knows steps."""
    for d in drivers[:1]:
        shares = (0.25, 0.5, 0.75, 1.0, 0.0)
        told = ", ".join(d.format_value(d.level(s)) for s in shares[:-1])
        steps = [(i / len(shares), s) for i, s in enumerate(shares)]
        text = f"Run {d.name} at {told} and {d.format_value(d.rest)}, {_span(hours / len(shares))} each"
        yield text, [_steps(d, steps, hours), *others[d]]


def _alternation(drivers: Sequence[Driver], hours: float) -> tuple[str, list[Signal]]:
    """Between rest and high with holds of many lengths; a second input does so in another order."""
    texts, signals = [], []
    for i, d in enumerate(drivers):
        holds = np.roll(HOLDS, -4 * i)
        begins = np.concatenate([[0], np.cumsum(holds)[:-1]]) / sum(HOLDS)
        signals.append(_steps(d, [(float(b), float(k % 2 == 0)) for k, b in enumerate(begins)], hours))
        minutes = ", ".join(f"{60 * hours * h / sum(HOLDS):.3g}" for h in holds)
        high, rest = d.format_value(d.high), d.format_value(d.rest)
        texts.append(f"{d.name} between {high} and {rest}, held for {minutes} min in turn")
    return f"Switch {', and '.join(texts)}", signals


def _steps(d: Driver, steps: Sequence[tuple[float, float]], hours: float) -> Signal:
    """Held levels: (begin as a share of the hours, share of the range)."""
    begins, shares = zip(*steps, strict=True)
    levels = [d.rest if s == 0 else d.level(s) for s in shares]
    return hold(d.name, d.unit, 3600 * hours * np.array(begins), np.array(levels))


def _span(hours: float) -> str:
    return f"{hours:g} h" if hours >= 1 else f"{60 * hours:.3g} min"
