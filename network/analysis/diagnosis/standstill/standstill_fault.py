"""A stop that recordings do not tell, set right in them; the machine is as it was."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from network.analysis.calibration.estimated_constants import Numbers
from network.analysis.comparison.compare import RecordingResidual
from network.analysis.diagnosis.findings.finding import Quantity
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.intermittent.change_points import Windows
from network.analysis.diagnosis.reading_fault import ReadingFault
from network.analysis.diagnosis.standstill.driver import Driver
from network.analysis.diagnosis.standstill.held_out_stops import find_held_out_stops
from network.catalogue.suspects.input_fault import InputFault
from network.machine.machine import Machine
from network.platform.wording import join_names
from network.recordings.recording import Recording


@dataclass(frozen=True, eq=False)
class StandstillFault(ReadingFault):
    """driver: what stood; stops: when, in each of the recordings; std: of when the first begins and how
    long it lasts [s]; sure: belief beside chance."""

    driver: Driver
    stops: tuple[Windows, ...]
    std: tuple[float, float]
    sure: float

    kind, section = InputFault.kind, InputFault.section
    needed, competes, stands_alone = (), True, True

    @property
    def channels(self) -> tuple[str, ...]:
        return self.driver.names

    @property
    def quantities(self) -> Mapping[str, Quantity]:
        (begin, end), *_ = next(w for w in self.stops if w)
        return {"begins": Quantity(begin, self.std[0], "min"), "lasts": Quantity(end - begin, self.std[1], "min")}

    @property
    def windows(self) -> tuple[Windows, ...]:
        return self.stops

    @property
    def told(self) -> str:
        names, each = join_names([*self.driver.names]), join_names([*self._list_stops()])
        is_one = len(self.driver.names) == 1
        if self.driver.source:
            why = "which nothing that is recorded tells"
        else:
            why = f"though {names} {'says that it' if is_one else 'say that they'} ran"
        right = "this recording was" if sum(map(bool, self.stops)) == 1 else "these recordings were"
        return f"{names} stood still {each}, {why}: {right} set right there; the machine is unchanged."

    def _list_stops(self) -> Iterator[str]:
        for recording, windows in zip(self.recordings, self.stops, strict=True):
            if windows:
                spans = [f"from {begin / 60:.0f} to {end / 60:.0f} min" for begin, end in windows]
                yield f"in {recording.name} {' and '.join(spans)}"

    @property
    def confidence(self) -> float:
        return self.sure

    @property
    def changes_machine(self) -> bool:
        return bool(self.driver.source)

    def complete(self, recording: Recording) -> Recording:
        return self.driver.lay_beside(recording)

    def show(self, case: Case) -> tuple[Recording, ...]:
        runs = zip(self.recordings, self.stops, strict=True)
        return tuple(self.driver.stop_samples(case.machine, r, w) for r, w in runs)

    def lay_alike(self, case: Case) -> Case:
        return self.driver.correct(case, self.stops, sets_right=False)

    def leave_in(self, machine: Machine) -> Machine:
        """Without what let a source be stopped."""
        if not self.driver.source:
            return machine
        return machine.patched({"sources": {self.driver.source: {InputFault.fields["on"].key: None}}})

    def set_right(self, case: Case) -> Case:
        return self.driver.correct(case, self.stops)

    def list_corrections(self, residual: RecordingResidual, numbers: Numbers) -> list[Recording]:
        """As it is; and with the stops that its own readings show."""
        recording = residual.recording
        stops = find_held_out_stops(numbers, recording, self.driver)
        return [recording, *([self.driver.stop_samples(numbers.machine, recording, stops)] if stops else [])]

    def tell_correction(self, given: Recording, right: Recording) -> str:
        name = self.driver.inputs[0]
        before, after = (self.driver.lay_beside(r).columns[name].values for r in (given, right))
        stands = np.concatenate([[0], (before != after).astype(int), [0]])
        edges = np.append(right.t, right.t[-1])[np.flatnonzero(np.diff(stands))].reshape(-1, 2)
        if not len(edges):
            return ""
        when = " and ".join(f"from {begin / 60:.0f} to {end / 60:.0f} min" for begin, end in edges)
        names = join_names([*self.driver.names])
        return f"By its own readings {names} stood still in {given.name}, too, {when}: it was set right there."
