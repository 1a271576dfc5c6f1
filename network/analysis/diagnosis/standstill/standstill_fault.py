"""A stop that recordings do not tell, set right in them; the machine is as it was."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from network.analysis.comparison.compare import RecordingResidual
from network.analysis.diagnosis.finding import Quantity
from network.analysis.diagnosis.hypothesis import Case
from network.analysis.diagnosis.intermittent.change_points import Windows
from network.analysis.diagnosis.reading_fault import ReadingFault
from network.analysis.diagnosis.standstill.driver import Driver
from network.catalogue.suspects.input_fault import InputFault
from network.machine.machine import Machine
from network.platform.wording import join_names
from network.recordings.recording import Recording


@dataclass(frozen=True, eq=False)
class StandstillFault(ReadingFault):
    """driver: what stood; stops: when, in each of the recordings; std: of the instants of the first [s]; sure: belief
    beside chance."""

    driver: Driver
    stops: tuple[Windows, ...]
    std: tuple[float, float]
    sure: float

    @property
    def kind(self) -> str:
        return InputFault.kind

    @property
    def section(self) -> str:
        return InputFault.section

    @property
    def channels(self) -> tuple[str, ...]:
        return self.driver.names

    @property
    def quantities(self) -> Mapping[str, Quantity]:
        (begin, end), *_ = next(w for w in self.stops if w)
        lasts = float((self.std[0] ** 2 + self.std[1] ** 2) ** 0.5)
        return {"begins": Quantity(begin, self.std[0], "min"), "lasts": Quantity(end - begin, lasts, "min")}

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

    def leave_wrong(self, case: Case) -> Case:
        return self.driver.correct(case, self.stops, sets_right=False)

    def leave_in(self, machine: Machine) -> Machine:
        """Without what let a source be stopped."""
        if not self.driver.source:
            return machine
        entry = machine.sources[self.driver.source].to_plain()
        own = {key: None for key, value in entry.items() if value in self.driver.inputs}
        return machine.patched({"sources": {self.driver.source: {**entry, **own}}})

    def set_right(self, case: Case) -> Case:
        return self.driver.correct(case, self.stops)

    def list_corrections(self, residual: RecordingResidual) -> list[Recording]:
        """As it is: when something stood elsewhere is not known."""
        return [residual.recording]
