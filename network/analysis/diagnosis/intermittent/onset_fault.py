"""A sensor that fails from an instant of one run on, and perhaps stays so."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from network.analysis.calibration.estimated_constants import Numbers
from network.analysis.comparison.compare import RecordingResidual
from network.analysis.diagnosis.findings.finding import Quantity
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.intermittent.change_points import Windows
from network.analysis.diagnosis.intermittent.channel_fault import EDGE, ChannelFault
from network.analysis.diagnosis.intermittent.onset_scan import Onset, OnsetScan
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.declaration.declare import Array
from network.catalogue.sensors.sensor_fault import SensorFault
from network.machine.machine import Machine
from network.recordings.recording import Recording


@dataclass(frozen=True, eq=False)
class OnsetFault(ChannelFault):
    """onset: what it is, and from when on; is_clear: whether a jump shows it that nothing else could be; is_open:
    whether much is left beside it."""

    onset: Onset
    is_clear: bool
    is_open: bool = False

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
    def jump(self) -> tuple[str, int, float]:
        """Where and when it begins."""
        return self.channel, self.onset.run, self.onset.t0

    @property
    def competes(self) -> bool:
        return self.is_open

    @property
    def shows_itself(self) -> bool:
        return self.is_clear

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
        file = "where it lasts the file has it, until it is mended" if self.lasts else "the machine is unchanged"
        return f"{o.shape.tell(o.size)}, {since}. Its readings were corrected there; {file}."

    @property
    def lasts(self) -> bool:
        return self.onset.shape.may_stay and (self.onset.stays or self.onset.run == len(self.recordings) - 1)

    def leave_in(self, machine: Machine) -> Machine:
        if not self.lasts:
            return machine
        effect = self.onset.shape.describe_effect(self.onset.size)
        return machine.patched({"sensors": {self.channel: SensorFault.put_on(machine.sensors[self.channel], effect)}})

    def resize(self, h: Hypothesis) -> OnsetFault | None:
        known, scan = self.onset, OnsetScan(h.linearised, (self.onset.shape,), h.case.recordings)
        more = scan.again(known, 2 * known.width)
        if more is None or abs(more.size) < SETTINGS.errors * more.std:
            return None
        size, std = known.shape.add(known.size, more.size), known.shape.add(known.size, more.std) - known.size
        return replace(self, onset=replace(known, size=size, std=std)) if known.shape.allows(size) else None

    def list_left_out(self, windows: Windows) -> list[tuple[float, float]]:
        reach = max(EDGE, self.onset.width)
        return [(t0 - reach, t0 + reach) for t0, _ in windows if t0 == self.onset.t0]

    def undo(self, recording: Recording, values: Array, windows: Windows) -> Array:
        t0 = windows[0][0] if windows else np.inf
        return self.onset.shape.set_right(recording, values, t0, self.onset.size)

    def list_corrections(self, residual: RecordingResidual, numbers: Numbers) -> list[Recording]:
        """As it is; and from its beginning on, where the fault stayed to the last run."""
        recording = residual.recording
        whole = ((float(recording.t[0]), float(recording.t[-1])),)
        return [recording, *([self.correct_windows(recording, whole)] if self.lasts else [])]
