"""Times of a recording: each there, each once, in order; and where they jump so that one run ends and another begins.

Whatever samples a machine at random, but evenly, makes intervals that are at worst exponential (mean m, median m ln 2).
The longest of n is then above m ln(n/α) with probability α at most: a step of the clock beyond that, forward or back,
is no matter of sampling. A shorter step back is a row in the wrong place, which is refused.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from network.catalogue.declaration.declare import Array
from network.platform.quantities.text_table import span
from network.platform.refusal import Complaints
from network.recordings.alike import Alike
from network.recordings.columns import Samples

FALSE_ALARM = 1e-3
"""α: the share of recordings in which chance alone makes what is told."""
LEAST = 2
"""Samples of a run."""
_ORDER = "give rows in the order of time, each time once"


@dataclass(frozen=True)
class Step:
    """A step of the clock between samples index - 1 and index that no sampling explains."""

    index: int
    before: float
    after: float
    interval: float
    longest: float

    @property
    def is_back(self) -> bool:
        return self.after <= self.before

    @property
    def sentence(self) -> str:
        """What the clock does there."""
        if self.is_back:
            return f"the clock goes back from {self.before:.10g} s to {self.after:.10g} s, where another run begins"
        gap, usual = span(self.after - self.before), span(self.interval)
        return (
            f"nothing is recorded for {gap} from {self.before:.10g} s on (samples are {usual} apart, and chance "
            f"makes no gap above {span(self.longest)})"
        )


def longest_interval(t: Array) -> float:
    """The interval that chance makes none longer than in 1 - α of recordings with as many samples [s]."""
    steps = np.diff(t)
    forward = steps[steps > 0]
    if not len(forward):
        return np.inf
    return float(np.median(forward) / np.log(2) * np.log(len(forward) / FALSE_ALARM))


def find_steps(samples: Samples, complaints: Complaints) -> tuple[Step, ...]:
    """Where the clock jumps. Complains, once for each kind, of rows without time and of times that are out of order."""
    faults = [Alike(file) for file in samples.files]
    t = samples.t
    for k in np.flatnonzero(~np.isfinite(t)).tolist():
        faults[samples.file_of[k]].add("no time", int(samples.lines[k]), "has no time", "give every row a time")
    known = np.flatnonzero(np.isfinite(t))
    found = []
    for step in _steps(t[known]):
        k = int(known[step.index])
        wrong = _fault(t[known], step, samples, k)
        if wrong:
            right = _ORDER if step.index and samples.file_of[k] == samples.file_of[k - 1] else _FILES
            faults[samples.file_of[k]].add("order", int(samples.lines[k]), wrong, right)
        else:
            found.append(step)
    for each in faults:
        each.tell(complaints)
    return tuple(found)


_FILES = "list them in the order of time, each piece of time once"


def _steps(t: Array) -> Iterator[Step]:
    longest = longest_interval(t)
    steps = np.diff(t)
    interval = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    for k in np.flatnonzero((steps <= 0) | (steps > longest)):
        yield Step(int(k) + 1, float(t[k]), float(t[k + 1]), interval, longest)


def _fault(t: Array, step: Step, samples: Samples, row: int) -> str:
    """What is wrong where the clock goes back and no run begins; '' where nothing is."""
    if not step.is_back:
        return ""
    shown = [_tell_time(samples, value) for value in (step.before, step.after)]
    if step.before == step.after:
        return f"the time {shown[0]} stands twice"
    wrong = f"the time goes back from {shown[0]} to {shown[1]}"
    if samples.file_of[row] != samples.file_of[row - 1]:
        return _fault_of_files(samples, row, wrong)
    first = float(t[: step.index][_begin(t, step.index)])
    is_reset = step.after <= first + step.interval / 2
    is_far = step.before - step.after > step.longest
    following = np.diff(t[step.index : step.index + LEAST])
    alone = step.index - _begin(t, step.index) < LEAST or len(following) < LEAST - 1 or not (following > 0).all()
    far_alone = len(following) and following[0] > step.longest
    return wrong if alone or far_alone or not (is_reset or is_far) else ""


def _begin(t: Array, index: int) -> int:
    """The first sample of the stretch that ends before `index`, between jumps of either kind."""
    steps = np.diff(t[:index])
    jumps = np.flatnonzero((steps <= 0) | (steps > longest_interval(t)))
    return int(jumps[-1]) + 1 if len(jumps) else 0


def _fault_of_files(samples: Samples, row: int, wrong: str) -> str:
    """Files that are in another order than their times, or overlap; '' where the second has a clock of its own."""
    own, before = (samples.t[samples.file_of == samples.file_of[row - k]] for k in (0, 1))
    name = samples.files[samples.file_of[row - 1]]
    if own[-1] < before[0]:
        return f"lies before {name}, behind which it is listed"
    if samples.time_unit and own[0] <= before[0] + np.median(np.diff(before)) / 2:
        return ""
    return f"overlaps with {name}: {wrong}"


def _tell_time(samples: Samples, seconds: float) -> str:
    """As the file has it."""
    from network.platform.quantities.units import unit

    if not samples.time_unit:
        return f"{seconds:.12g} s"
    return f"{seconds / unit(samples.time_unit).scale:.12g} {samples.time_unit}"
