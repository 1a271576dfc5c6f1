"""A sensor that fails from an instant of one run on, and perhaps stays so: scored about a fit, confirmed by fits.

A reading that jumps where no input does and no other channel does has failed, whatever else is missing: it counts where
hardly anything of that channel's own excess in that run is left. A drift, or a jump that noise covers, could be heat,
too: it counts where hardly anything is left at all, and nothing of the catalogue scores as much.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from network.analysis.calibration.linearised import linearise
from network.analysis.comparison.channel_residual import ChannelResidual
from network.analysis.diagnosis.hypothesis import Hypothesis
from network.analysis.diagnosis.intermittent.change_points import BIN, CLEAR, Windows, find_steps
from network.analysis.diagnosis.intermittent.channel_samples import truth_at_samples
from network.analysis.diagnosis.intermittent.fault_shapes import list_shapes
from network.analysis.diagnosis.intermittent.onset_scan import Onset, OnsetScan
from network.analysis.diagnosis.intermittent.reading_fault import (
    EDGE,
    LEFT,
    PER_WINDOW,
    ReadingFault,
    fit_both,
    is_mended,
)
from network.analysis.diagnosis.result import Quantity
from network.catalogue.declaration.declare import Array
from network.recordings.recording import Recording

CONFIRMED = 2
"""Best scores of clear faults that are confirmed by fits, and one of those that are not (budget)."""
ROUNDS = 6
"""Times at most that instant and size are found again about the better fit."""
SETTLED = 1.0
"""Nats by which that has to gain to go on."""
BLURRED = 0.5
"""Share by which the jump of a residual in bins may differ from the size of the fault."""
NEARLY = 1.5
"""Times LEFT that a linear score may leave of the excess, for fits to be tried."""


@dataclass(frozen=True, eq=False)
class OnsetFault(ReadingFault):
    """onset: what it is, and from when on; is_clear: whether a jump shows it that nothing else could be."""

    onset: Onset
    is_clear: bool

    @property
    def kind(self) -> str:
        return self.onset.shape.kind

    @property
    def section(self) -> str:
        return self.onset.shape.section

    @property
    def channel(self) -> str:
        return self.onset.shape.channel

    @property
    def quantities(self) -> Mapping[str, Quantity]:
        o = self.onset
        size = Quantity(o.size, o.std, o.shape.unit)
        return {o.shape.key: size, "begins": Quantity(o.t0, o.width / 2, "min")}

    @property
    def windows(self) -> tuple[Windows, ...]:
        return tuple(self._windows_in(i, r) for i, r in enumerate(self.recordings))

    def _windows_in(self, run: int, recording: Recording) -> Windows:
        begin, (first, *_, last) = self.onset.begins_in(run), recording.t.tolist()
        return ((max(begin, first), last),) if begin < last else ()

    @property
    def told(self) -> str:
        o = self.onset
        later = ", and in the later recordings" if o.stays else ""
        since = f"in {self.recordings[o.run].name} from {o.t0 / 60:.0f} min on{later}"
        return f"{o.shape.tell(o.size)}, {since}. Its readings were corrected there; the machine is unchanged."

    def list_left_out(self, windows: Windows) -> list[tuple[float, float]]:
        reach = max(EDGE, self.onset.width)
        return [(t0 - reach, t0 + reach) for t0, _ in windows if t0 == self.onset.t0]

    def undo(self, recording: Recording, values: Array, windows: Windows) -> Array:
        t0 = windows[0][0] if windows else np.inf
        return self.onset.shape.set_right(recording, values, t0, self.onset.size)

    def list_corrections(self, recording: Recording, channel: ChannelResidual) -> list[Recording]:
        """As it is; and from its beginning on, where the fault stayed to the last run."""
        o, last = self.onset, len(self.recordings) - 1
        whole = ((float(recording.t[0]), float(recording.t[-1])),)
        lasts = o.shape.may_stay and (o.stays or o.run == last)
        return [recording, *([self.correct_windows(recording, whole)] if lasts else [])]


def find_onset_fault(
    h: Hypothesis, rival_gain: Callable[[], float]
) -> tuple[OnsetFault, Hypothesis] | None:  # fmt: skip
    """The fault that explains most, and the hypothesis fitted to the readings set right; None where there is none.
    rival_gain: what the best of the catalogue scores about the same fit [nats]."""
    scores = OnsetScan(h.linearised, tuple(list_shapes(h)), h.case.recordings).best()
    seen = [o for o in scores if o.gain > PER_WINDOW and o.shape.allows(o.size)]
    faults = [OnsetFault(h.case.recordings, o.gain, o, _is_clear(h, o)) for o in seen]
    clear = [f for f in faults if f.is_clear]
    other = [f for f in faults if not f.is_clear and _may_mend(h, f.onset)][:1]
    likely = [*clear[:CONFIRMED], *(f for f in other if rival_gain() < f.gain)]
    tried = [_correct(h, f) for f in likely]
    told = [_settle(h, best) for best in sorted(tried, key=lambda c: -c.fault.gain)[:1] if best.fault.gain > 0]
    return next(((c.fault, c.after) for c in told if c.is_mended), None)


@dataclass(frozen=True, eq=False)
class _Corrected:
    """Fits to readings with a fault in them and without it."""

    fault: OnsetFault
    before: Hypothesis
    after: Hypothesis

    @property
    def is_mended(self) -> bool:
        """Whether hardly anything is left; where the fault is clear, of that channel in that run."""
        if is_mended(self.before, self.after):
            return True
        left = [_excess(x, self.fault.onset) for x in (self.before, self.after)]
        return self.fault.is_clear and left[1] <= LEFT * left[0]


def _correct(h: Hypothesis, fault: OnsetFault, begin: Hypothesis | None = None) -> _Corrected:
    before, after, gain = fit_both(h, fault, begin)
    return _Corrected(replace(fault, gain=gain), before, after)


def _settle(h: Hypothesis, best: _Corrected) -> _Corrected:
    """The fault with its instant and size found again in the readings as they were, about the numbers that a fit finds
    once it is set right."""
    for _ in range(ROUNDS):
        known, after = best.fault.onset, best.after
        about = linearise(h.case.problem(h.machine, after.fit.problem.parameters), after.fit.theta)
        onset = OnsetScan(about, (known.shape,), h.case.recordings, after.chi).again(known)
        if onset is None or not onset.shape.allows(onset.size):
            break
        again = _correct(h, replace(best.fault, onset=onset), after)
        is_better, is_settled = again.fault.gain > best.fault.gain, again.fault.gain < best.fault.gain + SETTLED
        best = again if is_better else best
        if is_settled:
            break
    return best


def _may_mend(h: Hypothesis, o: Onset) -> bool:
    """Whether by the linear score little enough is left for fits to be tried."""
    excess = h.chi**2 - 1
    return excess - 2 * o.gain * max(1.0, h.chi**2) / len(h.fit.left) <= NEARLY * LEFT * excess


def _excess(h: Hypothesis, o: Onset) -> float:
    """Of the channel in the run in which it begins to fail."""
    at, data = h.linearised, h.linearised.problem.data[o.run]
    rows, _ = at.rows.slopes.blocks[o.run]
    channels = np.repeat(data.run.channels, data.run.knots.cells)[data.known]
    own = at.left[rows][channels == o.shape.channel]
    return float(np.mean(own**2)) - 1 if len(own) else 0.0


def _is_clear(h: Hypothesis, o: Onset) -> bool:
    """Whether the reading jumps by about that size where it begins, and neither an input nor another channel does."""
    jumps = h.predictions[o.run].run.knots.jumps
    reach = max(o.width, 2 * BIN) + BIN
    if not o.shape.may_jump or bool((np.abs(jumps - o.t0) < reach).any()):
        return False
    return _jumps_alike(h, o, reach) and not any(
        _jumps_at(h, o, name, reach) for name in h.predictions[o.run].run.channels if name != o.shape.channel
    )


def _jumps_alike(h: Hypothesis, o: Onset, reach: float) -> bool:
    """Whether the channel's own residual jumps so."""
    recording, truth = _read(h, o, o.shape.channel)
    full = o.shape.full(recording, truth)
    steps = find_steps(recording.t, recording.columns[o.shape.channel].values - truth, full)
    if steps is None:
        return False
    near = np.abs(steps.t - o.t0) < reach
    due = o.size * steps.full[near]
    is_jump = np.abs(steps.size[near]) > CLEAR * steps.scatter
    return bool((is_jump & (np.abs(steps.size[near] - due) < BLURRED * np.abs(due))).any())


def _jumps_at(h: Hypothesis, o: Onset, channel: str, reach: float) -> bool:
    """Whether another channel jumps at the same time."""
    recording, truth = _read(h, o, channel)
    steps = find_steps(recording.t, recording.columns[channel].values - truth, np.ones_like(truth))
    near = np.empty(0) if steps is None else np.abs(steps.size[np.abs(steps.t - o.t0) < reach])
    return steps is not None and bool((near > CLEAR * steps.scatter).any())


def _read(h: Hypothesis, o: Onset, channel: str) -> tuple[Recording, Array]:
    recording = h.case.recordings[o.run]
    return recording, truth_at_samples(h.predictions[o.run], recording, channel)
