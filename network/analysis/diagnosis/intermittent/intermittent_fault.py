"""A sensor that is read otherwise for some time and not for some: found by its jumps, at other times in every run, and
its readings set right again with the share that its jumps tell.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from network.analysis.calibration.estimated_constants import Numbers
from network.analysis.comparison.compare import RecordingResidual
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.candidates.candidates import candidates, kinds
from network.analysis.diagnosis.findings.finding import Quantity
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.intermittent.change_points import (
    PAIR,
    SHARES,
    LooseContact,
    Steps,
    Windows,
    digit_of,
    find_loose_contact,
    find_steps,
)
from network.analysis.diagnosis.intermittent.channel_fault import LEFT, ChannelFault, fit_both, inside, is_mended
from network.analysis.diagnosis.intermittent.channel_samples import (
    at_share,
    change_of,
    effect_of,
    excess_of,
    list_as_fitted,
    list_inputs,
    truth_at_samples,
)
from network.analysis.diagnosis.intermittent.input_steps import list_driven
from network.analysis.diagnosis.intermittent.onset_jump import ResidualSteps, is_shared
from network.catalogue.declaration.declare import Array
from network.catalogue.sensors.base import SensorEffect
from network.engine.response.model import Prediction
from network.machine.machine import Machine
from network.recordings.inputs import Signal
from network.recordings.recording import Recording

ROUNDS = 3
"""Times that the windows are found again about the better fit."""


@dataclass(frozen=True, eq=False)
class IntermittentFault(ChannelFault):
    """A fault of one channel: the kind on that channel, its share of full strength and windows in the recordings;
    surroundings: constants that drive these, as a fit finds them, by file."""

    candidate: Candidate
    loose: LooseContact
    surroundings: Mapping[str, Mapping[str, Signal]]

    @property
    def kind(self) -> str:
        return self.candidate.kind.kind

    @property
    def section(self) -> str:
        return self.candidate.section

    @property
    def channel(self) -> str:
        return self.candidate.channels[0]

    @property
    def quantities(self) -> Mapping[str, Quantity]:
        first = self.candidate.own[0].field
        return {first.key: Quantity(self.loose.share, self.loose.std, first.unit)}

    @property
    def windows(self) -> tuple[Windows, ...]:
        return self.loose.windows

    @cached_property
    def machine(self) -> Machine:
        """The machine with the fault in it, all the time."""
        return at_share(self.candidate, self.loose.share)

    @property
    def told(self) -> str:
        names = [r.name for r in self.recordings]
        each = (f"{name} from {' and '.join(f'{a / 60:.0f} to {b / 60:.0f} min' for a, b in windows)}"
                for name, windows in zip(names, self.loose.windows, strict=True) if windows)  # fmt: skip
        fault = self.candidate.kind.told(self.machine, self.candidate.patch)
        when = f"now and then: in {'; in '.join(each)}"
        return f"{fault}, {when}. Its readings were corrected in those windows; the machine is unchanged."

    @cached_property
    def effect(self) -> SensorEffect:
        return effect_of(self.machine, self.candidate)

    def undo(self, recording: Recording, values: Array, windows: Windows) -> Array:
        found = replace(recording, constants=self.surroundings.get(recording.file, recording.constants))
        truth = self.effect.truth(values, list_inputs(self.effect, found))
        return np.where(inside(recording.t, windows), truth, values)

    def list_corrections(self, residual: RecordingResidual, numbers: Numbers) -> list[Recording]:
        """Where its residual jumps by the same share."""
        recording, channel = residual.recording, residual.channels[self.channel]
        full, values = effect_of(at_share(self.candidate, 1.0), self.candidate), recording.columns[self.channel].values
        change = change_of(full, recording, values)
        steps = find_steps(recording.t, channel.residual, change, digit_of(values))
        return [recording if steps is None else self.correct_windows(recording, steps.windows(self.loose.share))]


def find_intermittent_fault(h: Hypothesis) -> tuple[IntermittentFault, Hypothesis] | None:
    """The fault that explains most, and the hypothesis fitted to the readings set right; None where there is none."""
    tried = [pair for e in _list_faults(h) if (pair := _settle(h, e)) is not None]
    return max(tried, key=lambda pair: pair[0].gain, default=None)


def _settle(h: Hypothesis, e: IntermittentFault) -> tuple[IntermittentFault, Hypothesis] | None:
    """A fault with share and windows found again about ever better fits, for the numbers of the first are bent by it;
    None where it does not hold about any. It is given up where it leaves more than readings as they are, also of its
    own channel."""
    told, least = None, np.inf
    for _ in range(ROUNDS + 1):
        fits = fit_both(h, e)
        if fits is None or fits[1].chi > least or _mends_nothing(e, *fits[:2]):
            break
        e, least = replace(e, gain=fits[2]), fits[1].chi
        told = (e, fits[1]) if _holds(e, *fits) else told
        e = _update_fault(h, e, fits[1])
    return told


def _list_faults(h: Hypothesis) -> Iterator[IntermittentFault]:
    """Faults that jumps of the residuals show."""
    come_and_go = [kind for kind in kinds() if issubclass(kind, SensorEffect) and kind.comes_and_goes]
    recordings = list_as_fitted(h.case.recordings, h)
    jumps = ResidualSteps(h, recordings)
    for c in candidates(h.machine, h.case.drivers, among=come_and_go):
        seen = _leave_driven(_list_steps(_list_residuals(h, c, recordings)), jumps)
        loose = find_loose_contact(seen) or _find_episode(seen, c.channels[0], jumps)
        if loose is not None:
            yield IntermittentFault(h.case.recordings, 0.0, c, loose, {r.file: r.constants for r in recordings})


def _leave_driven(seen: Sequence[Steps | None], jumps: ResidualSteps) -> list[Steps | None]:
    """Steps without the jumps that inputs may make."""
    driven = list_driven(jumps.input_steps, seen)
    return [steps and replace(steps, driven=times) for steps, times in zip(seen, driven, strict=True)]


def _find_episode(seen: Sequence[Steps | None], channel: str, jumps: ResidualSteps) -> LooseContact | None:
    """A contact that is loose for few times that begin and end in a run, as no other channel tells."""
    told = find_loose_contact(_leave_lone(seen, channel, jumps), PAIR)
    if told is None:
        return None
    spans = [(of, span) for of, spans in zip(seen, told.windows, strict=True) for span in spans if of is not None]
    return told if all(begin > 0 and end < of.end for of, (begin, end) in spans) else None


def _leave_lone(seen: Sequence[Steps | None], channel: str, jumps: ResidualSteps) -> list[Steps | None]:
    """Steps without the jumps that another channel shares."""

    def leave(run: int, of: Steps) -> Steps:
        shared = (at for at in of.clear if is_shared(jumps, run, channel, at, of.reach))
        return replace(of, driven=(*of.driven, *shared))

    return [None if of is None else leave(run, of) for run, of in enumerate(seen)]


def _update_fault(h: Hypothesis, e: IntermittentFault, about: Hypothesis) -> IntermittentFault:
    """A fault with its share told by all readings in its windows, and its windows by that share, about a better fit."""
    recordings, windows = list_as_fitted(h.case.recordings, about), e.loose.windows
    runs = _list_residuals(about, e.candidate, recordings)
    within = [(run, inside(run.t, spans)) for run, spans in zip(runs, windows, strict=True) if run is not None]
    r = np.concatenate([run.residual[i] for run, i in within])
    full = np.concatenate([run.change[i] for run, i in within])
    good = np.isfinite(r)
    if not full[good].any():
        return e
    share = float(np.clip(full[good] @ r[good] / (full[good] @ full[good]), *SHARES))
    seen = _list_steps(runs)
    now = [spans if steps is None else steps.windows(share) for steps, spans in zip(seen, windows, strict=True)]
    loose = replace(e.loose, share=share, windows=tuple(now))
    return replace(e, loose=loose, surroundings={r.file: r.constants for r in recordings})


def _mends_nothing(e: IntermittentFault, before: Hypothesis, after: Hypothesis) -> bool:
    """Whether more is left once readings are set right, of all channels and of its own."""
    left = [excess_of(x, [e.channel], range(len(e.recordings))) for x in (before, after)]
    return after.chi > before.chi and left[1] > left[0]


def _holds(e: IntermittentFault, before: Hypothesis, after: Hypothesis, gain: float) -> bool:
    """Whether a fit to the readings set right explains more than one to those around the jumps left out, and hardly
    anything is left, at least of its own channel: jumps of one share there and back are no heat, whatever else is
    missing."""
    left = [excess_of(x, [e.channel], range(len(e.recordings))) for x in (before, after)]
    return gain > 0 and (is_mended(before, after) or left[1] <= LEFT * left[0])


@dataclass(frozen=True, eq=False)
class _Residual:
    """Of a channel in a run, at its samples: what a fit leaves, and what full strength would change of what it says
    (change) and of what was read, if that were true (of_read); digit: by which it is read."""

    t: Array
    residual: Array
    change: Array
    of_read: Array
    digit: float


def _list_residuals(h: Hypothesis, c: Candidate, recordings: Sequence[Recording]) -> list[_Residual | None]:
    """Of the channel of a candidate in every run; None where it is not read."""
    full, name = effect_of(at_share(c, 1.0), c), c.channels[0]

    def residual(p: Prediction, r: Recording) -> _Residual:
        values, truth = r.columns[name].values, truth_at_samples(p, r, name)
        changes = (change_of(full, r, truth), change_of(full, r, values))
        return _Residual(r.t, values - truth, *changes, digit_of(values))

    runs = zip(h.predictions, recordings, strict=True)
    return [residual(p, r) if name in p.run.channels else None for p, r in runs]


def _list_steps(residuals: Sequence[_Residual | None]) -> list[Steps | None]:
    """The steps of these, in shares of what is read: what a fit says is bent by a reading that fails. None of runs that
    are too short."""
    return [None if of is None else find_steps(of.t, of.residual, of.of_read, of.digit) for of in residuals]
