"""Whether a reading is seen to jump where it is said to fail: a part cannot jump, a reading can."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.intermittent.change_points import CLEAR, SIDE, Steps, digit_of, find_steps
from network.analysis.diagnosis.intermittent.channel_samples import truth_at_samples
from network.analysis.diagnosis.intermittent.input_steps import MANY, InputStep, exceeds_inputs, list_input_steps
from network.analysis.diagnosis.intermittent.onset_scan import Onset
from network.catalogue.declaration.declare import Array
from network.recordings.recording import Recording

BLURRED = 0.5
"""Share by which the jump of a residual in bins may differ from the size of the fault."""


@dataclass(frozen=True)
class Jump:
    """is_due: it is large enough to be seen; is_seen: it is, of about the size of the fault; is_alone: no input and no
    other channel jumps at that time; at [s]; size: of the fault by the jump alone, whatever else is missing, and 1σ."""

    is_due: bool = False
    is_seen: bool = False
    is_alone: bool = False
    at: float = 0.0
    size: float = 0.0
    std: float = 0.0

    @property
    def is_clear(self) -> bool:
        return self.is_seen and self.is_alone


@dataclass(frozen=True, eq=False)
class ResidualSteps:
    """Steps of what a fit leaves of recordings as they were, found once in every run and channel."""

    h: Hypothesis
    recordings: Sequence[Recording]
    known: dict[tuple[int, str], Steps | None] = field(default_factory=dict)

    @cached_property
    def input_steps(self) -> list[InputStep]:
        """Of the inputs of all runs."""
        return list_input_steps(p.run for p in self.h.predictions)

    def of(self, run: int, channel: str) -> Steps | None:
        """Beside a unit of change; None where the run is too short."""
        key = (run, channel)
        if key not in self.known:
            recording, truth = self.recordings[run], self.truth(run, channel)
            values = recording.columns[channel].values
            self.known[key] = find_steps(recording.t, values - truth, np.ones_like(truth), digit_of(values))
        return self.known[key]

    def of_fault(self, o: Onset) -> Steps | None:
        """Of the channel that fails, in the run in which it begins to, beside what full strength would change."""
        steps, recording = self.of(o.run, o.shape.channel), self.recordings[o.run]
        if steps is None:
            return None
        full = o.shape.full(recording, self.truth(o.run, o.shape.channel))
        return replace(steps, full=np.interp(steps.t, recording.t, full))

    def truth(self, run: int, channel: str) -> Array:
        return truth_at_samples(self.h.predictions[run], self.recordings[run], channel)


def watch_jump(steps: ResidualSteps, o: Onset) -> Jump:
    """What recordings show of a fault beside what a fit says."""
    own = steps.of_fault(o)
    if own is None or not o.shape.may_jump:
        return Jump()
    reach = own.reach
    due, near = o.size * own.full, np.abs(own.t - o.t0) < max(o.width, reach)
    is_due = near & (np.abs(due) > CLEAR * own.scatter)
    is_seen = is_due & (np.abs(own.size - due) < BLURRED * np.abs(due))
    if not is_seen.any():
        return Jump(bool(is_due.any()))
    k = int(np.where(is_seen, np.abs(own.size), 0.0).argmax())
    run, name, at = o.run, o.shape.channel, float(own.t[k])
    is_alone = not (_is_driven(steps, run, name, at, reach) or is_shared(steps, run, name, at, reach))
    return Jump(True, True, is_alone, at, *_size_by_readings(steps, o, own, k))


def may_be_driven(steps: ResidualSteps, o: Onset) -> bool:
    """Whether an input steps as it begins that may make the channel jump: what is read then is as well what the input
    does to it, in a way that the file lacks."""
    own = steps.of(o.run, o.shape.channel)
    return own is not None and o.shape.may_jump and _is_driven(steps, o.run, o.shape.channel, o.t0, own.reach)


def begin_with_jump(steps: ResidualSteps, o: Onset, at: float) -> Onset:
    """An onset at a clear jump, of the size that the jump alone tells."""
    own = steps.of(o.run, o.shape.channel)
    assert own is not None
    size, std = _size_by_readings(steps, o, own, int(np.abs(own.t - at).argmin()))
    return replace(o, t0=at, size=size, std=std)


def _size_by_readings(steps: ResidualSteps, o: Onset, own: Steps, k: int) -> tuple[float, float]:
    """Of a fault that makes the kth step, and its 1σ; infinite where it would change nothing there."""
    full = _full_by_readings(steps.recordings[o.run], o, float(own.t[max(k - SIDE - 1, 0)]))
    return (float(own.size[k]) / full, own.scatter / abs(full)) if full else (np.inf, np.inf)


def _full_by_readings(recording: Recording, o: Onset, before: float) -> float:
    """What full strength would add, by the readings before the jump: those are true, what a fit says need not be."""
    values = recording.columns[o.shape.channel].values
    good = np.isfinite(values)
    return float(np.interp(before, recording.t[good], o.shape.full(recording, values)[good]))


def list_lone_jumps(steps: ResidualSteps) -> Iterator[tuple[int, str, float, float]]:
    """The largest clear jump of each channel in each run that no input and no other channel shares: run, channel, when
    and over how long [s]. It shows a reading that fails also where something else is missing that outweighs it."""
    for run, prediction in enumerate(steps.h.predictions):
        for name in prediction.run.channels:
            if (own := steps.of(run, name)) is None:
                continue
            reach = own.reach
            for at in own.clear:
                if not (_is_driven(steps, run, name, at, reach) or is_shared(steps, run, name, at, reach)):
                    yield run, name, at, reach
                    break


def _is_driven(steps: ResidualSteps, run: int, channel: str, at: float, reach: float) -> bool:
    """Whether an input steps at that time; not where the channel jumps at none of many other steps of inputs, or by far
    less than here."""
    moved = [m for m in steps.input_steps if channel in steps.h.predictions[m.run].run.channels]
    here = {name: by for m in moved if m.run == run and abs(m.t - at) < reach for name, by in m.moved.items()}
    if not here:
        return False
    elsewhere = [m for m in moved if m.run != run or abs(m.t - at) >= 2 * reach]
    pairs = [(m, of) for m in elsewhere if (of := steps.of(m.run, channel)) is not None and of.covers(m.t, reach)]
    own = steps.of(run, channel)
    if own is None or len(pairs) < MANY:
        return True
    jumps = [_size_near(of, m.t, reach) for m, of in pairs]
    is_due = any(size > CLEAR * of.scatter for size, (_, of) in zip(jumps, pairs, strict=True))
    step, others = InputStep(run, at, here), [m for m, _ in pairs]
    return is_due and not exceeds_inputs(step, _size_near(own, at, reach), others, jumps)


def is_shared(steps: ResidualSteps, run: int, channel: str, at: float, reach: float) -> bool:
    """Whether another channel jumps at that time."""
    names = [name for name in steps.h.predictions[run].run.channels if name != channel]
    return any(_jumps_near(s, at, reach) for name in names if (s := steps.of(run, name)) is not None)


def _jumps_near(steps: Steps, at: float, reach: float) -> bool:
    return _size_near(steps, at, reach) > CLEAR * steps.scatter


def _size_near(steps: Steps, at: float, reach: float) -> float:
    """Of the largest step within reach."""
    return float(np.abs(steps.size[np.abs(steps.t - at) < reach]).max(initial=0.0))
