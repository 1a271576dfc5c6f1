"""What is wrong with readings, found before anything of the machine is looked for, and set right in the recordings."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

from network.analysis.calibration.estimated_constants import Numbers
from network.analysis.comparison.compare import RecordingResidual
from network.analysis.diagnosis.findings.finding import Quantity, Rival
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.intermittent.change_points import Windows
from network.catalogue.declaration.patch import Patch
from network.machine.machine import Machine
from network.recordings.recording import Recording


@dataclass(frozen=True, eq=False)
class ReadingFault(ABC):
    """recordings: as they were; gain: what it explains [nats]."""

    recordings: tuple[Recording, ...]
    gain: float

    @property
    @abstractmethod
    def kind(self) -> str:
        """What the catalogue calls it."""

    @property
    @abstractmethod
    def section(self) -> str:
        """Of the machine's file."""

    @property
    @abstractmethod
    def channels(self) -> tuple[str, ...]:
        """The channels that are read wrong."""

    @property
    @abstractmethod
    def quantities(self) -> Mapping[str, Quantity]:
        """How large it is."""

    @property
    @abstractmethod
    def windows(self) -> tuple[Windows, ...]:
        """When it holds in each of the recordings."""

    @property
    @abstractmethod
    def told(self) -> str:
        """What is wrong, and when."""

    @property
    @abstractmethod
    def confidence(self) -> float:
        """Where nothing else speaks against it."""

    @property
    def patch(self) -> Patch:
        """What adds it to the machine, where it holds at all times; nothing where recordings alone are set right."""
        return Patch({})

    @property
    def competes(self) -> bool:
        """Whether, where it is not all that is missing, it has to explain more than a search without it does."""
        return False

    @property
    def rivals(self) -> tuple[Rival, ...]:
        """What else it could be."""
        return ()

    @property
    def needed(self) -> tuple[str, ...]:
        """The channels without which a recording cannot be set right."""
        return self.channels

    @property
    def shows_itself(self) -> bool:
        """Whether readings show it whatever the numbers of the machine are."""
        return False

    @property
    def stands_alone(self) -> bool:
        """Whether it is told, where runs speak against all that was found beside it, as long as they do not against
        it."""
        return self.shows_itself

    @property
    def changes_machine(self) -> bool:
        """Whether the machine of the case that is set right is another one."""
        return bool(self.patch)

    def resize(self, h: Hypothesis) -> ReadingFault | None:
        """The same of the size that it has beside what was found, where that is another one: about bent numbers it is
        bent, too. h: fitted to the readings set right."""
        return None

    def complete(self, recording: Recording) -> Recording:
        """A recording with what that machine asks for besides."""
        return recording

    def show(self, case: Case) -> tuple[Recording, ...]:
        """The recordings of a case that was set right, sampled as they were."""
        return case.recordings

    def lay_alike(self, case: Case) -> Case:
        """A case as it was recorded, without the readings that what is set right does not have."""
        return case

    def leave_wrong(self, case: Case) -> Case:
        """A case with the fault in its recordings, laid out for the machine that is set right."""
        return self.lay_alike(case)

    def leave_in(self, machine: Machine) -> Machine:
        """A machine for what is recorded from now on, whose sensor goes on so; the same where it does not."""
        return machine

    @abstractmethod
    def set_right(self, case: Case) -> Case:
        """The case without it: on corrected recordings, or with a machine that has it."""

    @abstractmethod
    def list_corrections(self, residual: RecordingResidual, numbers: Numbers) -> list[Recording]:
        """A recording of which only the residual beside some numbers is known, in all ways in which it may have to be
        set right."""

    def tell_correction(self, given: Recording, right: Recording) -> str:
        """What was set right in a recording that no fit used, where that is to be said."""
        return ""
