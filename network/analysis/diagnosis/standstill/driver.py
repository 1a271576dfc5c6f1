"""What may stand while a recording says that it runs: an input, all of them together, or a source without an input."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.intermittent.change_points import Windows
from network.analysis.diagnosis.intermittent.channel_fault import EDGE, inside
from network.analysis.diagnosis.standstill.laid_instants import CLOSE, lay_instants
from network.catalogue.declaration.patch import Patch
from network.catalogue.suspects.input_fault import InputFault
from network.machine.machine import Machine
from network.recordings.columns import Column
from network.recordings.recording import Recording

SHADE = 1e-6
"""Share of an input that is taken off where it is left as it is: it changes nothing, and parts the run alike."""


@dataclass(frozen=True, eq=False)
class Driver:
    """inputs: those that stand; source: one without an input, for which `inputs` says when it is on; patch: what lets
    it listen to that."""

    inputs: tuple[str, ...]
    source: str = ""
    patch: Patch = field(default_factory=lambda: Patch({}))

    @property
    def names(self) -> tuple[str, ...]:
        """What stands, as its user calls it."""
        return (self.source,) if self.source else self.inputs

    def put_in(self, machine: Machine) -> Machine:
        """The machine in which it can be stopped."""
        return machine if {*self.inputs} <= machine.inputs.keys() else machine.patched(self.patch)

    def lay_beside(self, recording: Recording) -> Recording:
        """A recording with what such a machine asks for: where nothing says when a source is on, it is."""
        on = {n: Column(n, "1", np.ones(len(recording.t))) for n in self.inputs if self.source}
        return replace(recording, columns={**on, **recording.columns})

    def stop(self, machine: Machine, recording: Recording, windows: Windows, sets_right: bool = True) -> Recording:
        """A recording with the inputs at zero in some windows, or as they are; without readings that do not count
        where these are zero, and about there."""
        edges = (edge for window in windows for edge in window)
        recording = lay_instants(machine, self.lay_beside(recording), edges)
        stands = inside(recording.t + CLOSE / 2, windows)
        told = {n: np.where(stands, 0.0 if sets_right else (1 - SHADE) * recording.columns[n].values,
                            recording.columns[n].values) for n in self.inputs}  # fmt: skip
        silent = inside(recording.t, ((begin - EDGE, end + EDGE) for begin, end in windows))
        told |= {n: np.where(silent, np.nan, recording.columns[n].values)
                 for n in self.list_gated(machine) if n in recording.columns}  # fmt: skip
        columns = {n: replace(recording.columns[n], values=values) for n, values in told.items()}
        return replace(recording, columns={**recording.columns, **columns})

    def stop_samples(self, machine: Machine, recording: Recording, windows: Windows) -> Recording:
        """A recording with the inputs at zero from the sample that is nearest to where each window begins, as it is
        sampled."""
        t = recording.t
        near = tuple((float(t[np.abs(t - a).argmin()]), float(t[np.abs(t - b).argmin()])) for a, b in windows)
        return self.stop(machine, recording, near)

    def list_gated(self, machine: Machine) -> list[str]:
        """Channels whose readings count only while one of the inputs is not zero."""
        return [n for n, sensor in machine.sensors.items() if sensor.gate in self.inputs]

    def correct(self, case: Case, windows: tuple[Windows, ...], sets_right: bool = True) -> Case:
        """A case with the stops in it, or laid out alike as its recordings are."""
        machine, runs = self.put_in(case.machine), zip(case.recordings, windows, strict=True)
        return replace(case, machine=machine, recordings=tuple(self.stop(machine, r, w, sets_right) for r, w in runs))


def list_drivers(h: Hypothesis) -> Iterator[Driver]:
    """All that could stand in the recordings of a fit."""
    signals = h.predictions[0].run.schedule.signals
    recorded = set.intersection(*({*r.columns} for r in h.case.recordings))
    moving = tuple(n for n in h.machine.inputs if n in recorded and signals[n].is_held)
    yield from (Driver((name,)) for name in moving)
    if len(moving) > 1:
        yield Driver(moving)
    for patch in map(Patch, InputFault.proposes(h.machine)):
        fault = InputFault.from_patch(h.machine, patch)
        if not h.machine.sources[fault.source].needs() and fault.on not in h.case.drivers:
            yield Driver((fault.on,), fault.source, patch)
