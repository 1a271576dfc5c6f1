"""How many lumps each bar needs so that no channel is off by more than a tolerance (`--lumps auto`)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from network.analysis.sweep.finer_lumps import CHOSEN, SHARE, Change, bars_of, compare_courses, courses, cut_bars
from network.catalogue.declaration.declare import Array
from network.engine.simulation import simulate
from network.engine.trajectory import Trajectory
from network.machine.machine import Machine
from network.platform.printing import Result
from network.platform.refusal import Spot, refuse
from network.recordings.call_arguments import expect, expect_run
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario

Progress = Callable[[float], None]
COUNTS = (1, 2, 4, 8, 16, 32, 64)
"""Lumps that are tried."""
BEGIN = 4
"""Index of those that the first fine run has in every bar, 16."""
MOST = 640
"""Lumps in all bars of the fine run: beyond, each of some hundred runs takes a second."""
HALF = 0.5
"""Share of the tolerance by which one more doubling may still change the fine run that all is measured by."""


@dataclass(frozen=True, eq=False, repr=False)
class LumpChoice(Result):
    """lumps: by bar; machine: cut like that; finest: lumps in every bar of the run it was measured by; changes: what
    that run differs in, by source the worst; share: tolerance, of every channel's range; still: what the last doubling
    that was tried still changes, None where the finest run stands still."""

    machine: Machine
    lumps: Mapping[str, int]
    finest: int
    changes: tuple[Change, ...]
    share: float
    still: Change | None = None

    @property
    def is_settled(self) -> bool:
        """Whether cutting the finest run once more would change little."""
        return self.still is None

    @property
    def is_within(self) -> bool:
        return all(change.is_within for change in self.changes)

    def summary(self) -> dict[str, Any]:
        return {
            "lumps": dict(self.lumps), "of": self.finest, "tolerance": self.share, "within": self.is_within,
            "finest_is_settled": self.is_settled, "channels": {c.name: c.summary() for c in self.changes},
        }  # fmt: skip

    def __repr__(self) -> str:
        return f"<lumps: {', '.join(f'{name} {count}' for name, count in self.lumps.items())}>"


def choose_lumps(
    machine: Machine, sources: Scenario | Recording | Iterable[Scenario | Recording], *, share: float = SHARE,
    keep: Iterable[str] = (), start: Start | None = None, progress: Progress | None = None,
) -> LumpChoice:  # fmt: skip
    """The fewest lumps of every bar with which each channel (axes of the tool centre point, thermometers) stays within
    a share of its range of a fine run, along all the sources; a thermometer may be off by the σ of a reading.

    keep: bars that stay as they are. Each bar is cut more coarsely alone, all others being fine: its own error,
    |y(n) − y(fine)| at most over the run, is not hidden by another bar's. Then lumps are added where they take away
    most, until these errors, summed over bars as if all came at once and the same way, are allowed. Raises Refused for
    a machine without bars.
    """
    expect("machine", machine, Machine)
    given = [sources] if isinstance(sources, Scenario | Recording | str | Path) else [*sources]
    for source in given:
        expect_run(machine, source, start)
    if not given:
        raise refuse(Spot("choose_lumps"), "has no schedule to choose by", "give a scenario or a recording")
    bars = [name for name in bars_of(machine) if name not in set(keep)]
    if not bars:
        raise refuse(Spot("--lumps auto"), "the machine has no bar to cut", "leave it out: masses are one lump each")
    said = progress or (lambda part: None)
    chosen = {name: _fewest(machine, name) for name in bars}
    trials = [_Trials(machine, source, dict(chosen), share, start) for source in given]
    for k, trial in enumerate(trials):
        trial.settle()
        for part in trial.add_lumps(chosen):
            said((k + part) / len(given))
    told = [trial.judge(chosen) for trial in trials]
    worst = max(told, key=lambda choice: _worst(choice.changes).size)
    still = max((c.still for c in told if c.still is not None), key=lambda change: change.size, default=None)
    finest = max(choice.finest for choice in told)
    lumps, cut = bars_of(machine) | chosen, cut_bars(machine, chosen, Spot(CHOSEN))
    return replace(worst, machine=cut, lumps=lumps, finest=finest, still=still)


def _fewest(machine: Machine, bar: str) -> int:
    """1; of a bar whose bending is read as many as it has, for what bends it need not happen along these sources."""
    read = (r for entry in machine.expansions.values() for r in entry.readings() if r.how == "gradient")
    written = machine.nodes[bar].lumps if any(r.place.node == bar for r in read) else 1
    return next((count for count in COUNTS if count >= written), COUNTS[-1])


def _worst(changes: Sequence[Change]) -> Change:
    return max(changes, key=lambda change: change.size)


class _Trials:
    """Runs of one machine along one source, cut in different ways."""

    def __init__(
        self, machine: Machine, source: Scenario | Recording, least: Mapping[str, int], share: float,
        start: Start | None,
    ) -> None:  # fmt: skip
        self.machine, self.source, self.bars, self.share, self.start = machine, source, [*least], share, start
        self.least = least
        self.top = BEGIN
        self.still: Change | None = None
        self.fine = self.run(self.cut(self.top))
        self.names = [course.name for course in courses(self.fine)]

    def run(self, lumps: Mapping[str, int]) -> Trajectory:
        sensed = bool(self.machine.tcp) or any(s.place is not None for s in self.machine.sensors.values())
        cut = cut_bars(self.machine, lumps)
        return simulate(cut, self.source, start=self.start, parts=not sensed)

    def cut(self, which: int) -> dict[str, int]:
        """So many lumps in every bar, and no fewer than it may have."""
        return {bar: max(COUNTS[which], count) for bar, count in self.least.items()}

    def settle(self) -> None:
        """Cuts the fine run once more, and again, until that changes little. Where no finer one is tried, the next
        doubling counts as half of the last: what a cut is off by shrinks at least with the length of a lump."""
        last = None
        while self.top + 1 < len(COUNTS) and COUNTS[self.top + 1] * len(self.bars) <= MOST:
            finer = self.run(self.cut(self.top + 1))
            last = _worst(compare_courses(self.fine, finer, self.share))
            if last.size <= HALF:
                return
            self.fine, self.top = finer, self.top + 1
        if last is None:
            coarser = self.run(self.cut(self.top - 1))
            last = _worst(compare_courses(coarser, self.fine, self.share))
        self.still = last if last.size / 2 > HALF else None

    def errors_of(self, bar: str, count: int) -> Array:
        """Of every channel, as a share of what is allowed, with this bar in so many lumps and all others fine."""
        fine = self.cut(self.top)
        if count >= fine[bar]:
            return np.zeros(len(self.names))
        changes = compare_courses(self.run(fine | {bar: count}), self.fine, self.share)
        return np.array([change.size for change in changes])

    def add_lumps(self, chosen: dict[str, int]) -> Iterator[float]:
        """Doubles lumps of bars in `chosen` until the errors of all, summed, are allowed; yields the share done."""
        errors = {}
        for k, bar in enumerate(self.bars):
            errors[bar] = self.errors_of(bar, chosen[bar])
            yield 0.5 * (k + 1) / len(self.bars)
        while (total := np.sum([*errors.values()], axis=0)).max(initial=0.0) > 1:
            worst = int(np.argmax(total))
            bar = max(self.bars, key=lambda name: float(errors[name][worst]) / chosen[name])
            chosen[bar] *= 2
            errors[bar] = self.errors_of(bar, chosen[bar])
            yield 1 - 0.5 / float(total[worst])

    def judge(self, chosen: Mapping[str, int]) -> LumpChoice:
        changes = compare_courses(self.run(chosen), self.fine, self.share)
        return LumpChoice(self.machine, chosen, COUNTS[self.top], changes, self.share, self.still)
