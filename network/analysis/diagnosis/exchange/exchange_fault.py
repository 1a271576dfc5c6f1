"""Two channels that stand under each other's names: in all runs, which is the machine's, or in some recordings only."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from network.analysis.calibration.estimated_constants import Numbers
from network.analysis.comparison.compare import RecordingResidual
from network.analysis.diagnosis.candidates.candidate import Candidate, candidate
from network.analysis.diagnosis.exchange.exchange_scan import Runs
from network.analysis.diagnosis.exchange.exchanged_columns import Pair, exchange_columns
from network.analysis.diagnosis.findings.finding import Quantity, Rival
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.intermittent.change_points import Windows
from network.analysis.diagnosis.intermittent.channel_samples import effect_of
from network.analysis.diagnosis.reading_fault import ReadingFault
from network.catalogue.declaration.patch import Patch
from network.catalogue.sensors.sensor_swap import SensorSwap
from network.recordings.recording import Recording


@dataclass(frozen=True, eq=False)
class ExchangeFault(ReadingFault):
    """swap: of the pair, over the machine; runs: the recordings in which it is exchanged; is_machines: whether nothing
    speaks against all of them; share: of belief, beside its rivals."""

    swap: Candidate
    runs: Runs
    is_machines: bool
    share: float
    beside: tuple[Rival, ...] = ()

    kind, section, competes = SensorSwap.kind, "sensors", True

    @property
    def channels(self) -> tuple[str, ...]:
        return self.swap.channels

    @property
    def pair(self) -> Pair:
        a, b = self.channels
        return a, b

    @property
    def quantities(self) -> Mapping[str, Quantity]:
        return {}

    @property
    def windows(self) -> tuple[Windows, ...]:
        spans = [((float(r.t[0]), float(r.t[-1])),) for r in self.recordings]
        return tuple(span if is_in else () for span, is_in in zip(spans, self.runs, strict=True))

    @property
    def told(self) -> str:
        fault = effect_of(self.swap.machine, self.swap).said(channel=self.channels[0])
        if self.is_machines:
            return f"{fault}."
        names = [r.name for r, is_in in zip(self.recordings, self.runs, strict=True) if is_in]
        return f"{fault} in {' and '.join(names)}. Their readings were put back there; the machine is unchanged."

    @property
    def confidence(self) -> float:
        return self.share

    @property
    def patch(self) -> Patch:
        return self.swap.patch if self.is_machines else Patch({})

    @property
    def rivals(self) -> tuple[Rival, ...]:
        return self.beside

    def set_right(self, case: Case) -> Case:
        if not self.is_machines:
            return replace(case, recordings=exchange_runs(case.recordings, self.pair, self.runs))
        swap = candidate(case.machine, SensorSwap, self.swap.patch)
        return case if swap is None else replace(case, machine=swap.machine)

    def leave_wrong(self, case: Case) -> Case:
        """For a machine that has the exchange, readings exchanged are those that it does not explain."""
        if not self.is_machines:
            return case
        everywhere = (True,) * len(case.recordings)
        return replace(case, recordings=exchange_runs(case.recordings, self.pair, everywhere))

    def list_corrections(self, residual: RecordingResidual, numbers: Numbers) -> list[Recording]:
        """As it is; and exchanged, where some recordings are and some are not."""
        recording = residual.recording
        return [recording] if self.is_machines else [recording, exchange_columns(recording, self.pair)]


def exchange_runs(recordings: tuple[Recording, ...], pair: Pair, runs: Runs) -> tuple[Recording, ...]:
    """Two channels exchanged in some recordings."""
    each = zip(recordings, runs, strict=True)
    return tuple(exchange_columns(r, pair) if is_in else r for r, is_in in each)
