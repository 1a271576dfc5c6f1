"""A sensor that is read otherwise for some time and not for some: found by its jumps, its readings set right again.

Such a fault is no part of the machine, and comes at other times in every run. What it did to the readings is undone
with the share that its jumps tell; around them, where it changes, readings are left out. It counts where a fit to the
readings so set right explains more than chance does.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from network.analysis.comparison.channel_residual import ChannelResidual
from network.analysis.diagnosis.candidates import Candidate, candidates, kinds
from network.analysis.diagnosis.hypothesis import Case, Hypothesis, fit_hypothesis
from network.analysis.diagnosis.intermittent.change_points import (
    SHARES,
    LooseContact,
    Windows,
    find_loose_contact,
    find_steps,
)
from network.catalogue.declaration.declare import Array, Mask
from network.catalogue.sensors.base import SensorEffect
from network.engine.response.model import Prediction
from network.engine.response.parameters import at_values
from network.machine.machine import Machine
from network.recordings.recording import Recording

EDGE = 100.0
"""s about a jump in which readings are left out."""
PER_WINDOW = 14.0
"""Nats that the instants of a window cost."""
ROUNDS = 3
"""Times that the windows are found again about the better fit."""
LEFT = 0.5
"""Share of the excess χ² − 1 that the fault may leave."""


@dataclass(frozen=True, eq=False)
class IntermittentFault:
    """A fault of one channel: the kind on that channel, its share of full strength and windows in the recordings as
    they were, and what it explains [nats]."""

    candidate: Candidate
    loose: LooseContact
    recordings: tuple[Recording, ...]
    gain: float = 0.0

    @property
    def channel(self) -> str:
        return self.candidate.channels[0]

    @cached_property
    def machine(self) -> Machine:
        """The machine with the fault in it, all the time."""
        return _at_share(self.candidate, self.loose.share)

    @property
    def told(self) -> str:
        """What is wrong, and when."""
        names = [r.name for r in self.recordings]
        each = (f"{name} from {' and '.join(f'{a / 60:.0f} to {b / 60:.0f} min' for a, b in windows)}"
                for name, windows in zip(names, self.loose.windows, strict=True) if windows)  # fmt: skip
        fault = self.candidate.kind.told(self.machine, self.candidate.patch)
        when = f"now and then: in {'; in '.join(each)}"
        return f"{fault}, {when}. Its readings were corrected in those windows; the machine is unchanged."

    @cached_property
    def effect(self) -> SensorEffect:
        return effect_of(self.machine, self.candidate)

    def correct_windows(self, recording: Recording, windows: Windows, sets_right: bool = True) -> Recording:
        """A recording with the readings of the windows set right, and none about their ends."""
        column, t = recording.columns[self.channel], recording.t
        truth = self.effect.truth(column.values, _inputs(self.effect, recording))
        values = np.where(_inside(t, windows) & sets_right, truth, column.values)
        about = [(edge - EDGE, edge + EDGE) for window in windows for edge in window]
        values = np.where(_inside(t, about), np.nan, values)
        columns = {**recording.columns, self.channel: replace(column, values=values)}
        return replace(recording, columns=columns)

    def correct_by_jumps(self, recording: Recording, channel: ChannelResidual) -> Recording:
        """A recording of which only the residual is known, set right where that jumps by the same share."""
        full = effect_of(_at_share(self.candidate, 1.0), self.candidate)
        change = change_of(full, recording, channel.simulated)
        steps = find_steps(recording.t, channel.residual, change)
        return recording if steps is None else self.correct_windows(recording, steps.windows(self.loose.share))


def find_intermittent_fault(h: Hypothesis) -> tuple[IntermittentFault, Hypothesis] | None:
    """The fault that explains most, and the hypothesis fitted to the readings set right; None where there is none."""
    tried = [pair for e in _list_faults(h) if (pair := _confirm_fault(h, e)) is not None]
    if not tried:
        return None
    best = max(tried, key=lambda pair: pair[0].gain)
    for _ in range(ROUNDS):
        again = _confirm_fault(h, _update_fault(h, *best))
        if again is None or again[1].chi > best[1].chi:
            break
        best = again
    return best


def _list_faults(h: Hypothesis) -> Iterator[IntermittentFault]:
    """Faults that jumps of the residuals show."""
    come_and_go = [kind for kind in kinds() if issubclass(kind, SensorEffect) and kind.comes_and_goes]
    for c in candidates(h.machine, h.case.drivers, among=come_and_go):
        seen = [steps for run in _list_residuals(h, c, h.case.recordings) if (steps := find_steps(*run)) is not None]
        loose = find_loose_contact(seen) if len(seen) == len(h.predictions) else None
        if loose is not None:
            yield IntermittentFault(c, loose, h.case.recordings)


def _update_fault(h: Hypothesis, e: IntermittentFault, about: Hypothesis) -> IntermittentFault:
    """A fault with its share told by all readings in its windows, and its windows by that share, about a better fit."""
    runs, windows = _list_residuals(about, e.candidate, h.case.recordings), e.loose.windows
    inside = [_inside(t, spans) for (t, _, _), spans in zip(runs, windows, strict=True)]
    r = np.concatenate([residual[i] for (_, residual, _), i in zip(runs, inside, strict=True)])
    full = np.concatenate([change[i] for (_, _, change), i in zip(runs, inside, strict=True)])
    good = np.isfinite(r)
    share = float(np.clip(full[good] @ r[good] / (full[good] @ full[good]), *SHARES))
    now = [
        spans if (steps := find_steps(*run)) is None else steps.windows(share)
        for run, spans in zip(runs, windows, strict=True)
    ]
    return replace(e, loose=replace(e.loose, share=share, windows=tuple(now)))


def _confirm_fault(h: Hypothesis, e: IntermittentFault) -> tuple[IntermittentFault, Hypothesis] | None:
    """A fit to the readings set right against one to those around the jumps left out."""
    cases = (_with(h.case, e, right) for right in (False, True))
    before, after = (fit_hypothesis(case, h.machine, h.found, h.own, h.values) for case in cases)
    gain = after.evidence - before.evidence - PER_WINDOW * sum(map(len, e.loose.windows))
    if gain <= 0 or after.chi**2 - 1 > LEFT * (before.chi**2 - 1):
        return None
    return replace(e, gain=gain), after


def _with(case: Case, e: IntermittentFault, sets_right: bool) -> Case:
    runs = zip(case.recordings, e.loose.windows, strict=True)
    return replace(case, recordings=tuple(e.correct_windows(r, windows, sets_right) for r, windows in runs))


def effect_of(machine: Machine, c: Candidate) -> SensorEffect:
    """The effect that a candidate puts on its channel."""
    return next(e for e in machine.sensors[c.channels[0]].effects if isinstance(e, c.kind))


def change_of(full: SensorEffect, recording: Recording, truth: Array) -> Array:
    """What an effect adds to a reading."""
    return np.asarray(full.reading(truth, np.zeros_like(truth), _inputs(full, recording)) - truth)


def _list_residuals(h: Hypothesis, c: Candidate, recordings: Sequence[Recording]) -> list[tuple[Array, Array, Array]]:
    """Of a channel in every run that has it: times, residual, and change at full strength."""
    full = effect_of(_at_share(c, 1.0), c)
    pairs = zip(h.predictions, recordings, strict=True)
    return [_at_samples(full, p, r, c.channels[0]) for p, r in pairs if c.channels[0] in p.run.channels]


def _at_share(c: Candidate, share: float) -> Machine:
    return at_values(c.machine, {c.own[0].path: share})


def _inside(t: Array, windows: Iterable[tuple[float, float]]) -> Mask:
    none = np.zeros(len(t), bool)
    return np.asarray(np.any([none, *((t >= begin) & (t < end) for begin, end in windows)], axis=0))


def _at_samples(
    full: SensorEffect, prediction: Prediction, recording: Recording, channel: str
) -> tuple[Array, Array, Array]:  # fmt: skip
    values = prediction.values[prediction.run.channels.index(channel)]
    edges, K = prediction.course.problem.plan.edges, values.shape[-1] // 2
    truth = np.interp(recording.t, edges, np.append(values[:K], values[-1]))
    return recording.t, recording.columns[channel].values - truth, change_of(full, recording, truth)


def _inputs(effect: SensorEffect, recording: Recording) -> Mapping[str, Array]:
    return {"time": recording.t, **{name: recording.signal(name).at(recording.t) for name in effect.needs()}}
