"""Readings with a fault that begins at an instant set right, and whether that holds."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.intermittent.channel_fault import LEFT, fit_both, is_mended
from network.analysis.diagnosis.intermittent.channel_samples import excess_of
from network.analysis.diagnosis.intermittent.onset_fault import OnsetFault
from network.analysis.diagnosis.intermittent.onset_jump import Jump, ResidualSteps, watch_jump
from network.analysis.diagnosis.settings import SETTINGS


@dataclass(frozen=True, eq=False)
class Corrected:
    """Fits to readings with a fault in them and without it."""

    fault: OnsetFault
    before: Hypothesis
    after: Hypothesis

    @property
    def holds(self) -> bool:
        """Whether it jumps where its size says so, and takes away most of what was left: of that channel in that run
        where a jump shows it that nothing else could be, else of all."""
        if self._jump.is_due and not self._jump.is_seen:
            return False
        return is_mended(self.before, self.after) or self._is_shown

    def is_of(self, fault: OnsetFault) -> bool:
        """Whether the fits are of all its recordings."""
        return len(self.fault.recordings) == len(fault.recordings)

    @property
    def is_alone(self) -> bool:
        """Whether hardly anything is left beside it, or its jump shows it whatever is."""
        return self.after.chi <= SETTINGS.adequate or self._is_shown

    @cached_property
    def _jump(self) -> Jump:
        return watch_jump(ResidualSteps(self.after, self.fault.recordings), self.fault.onset)

    @cached_property
    def _is_shown(self) -> bool:
        left = [excess_of(x, [self.fault.channel], [self.fault.onset.run]) for x in (self.before, self.after)]
        return self._jump.is_clear and left[1] <= LEFT * left[0]


def correct_onset(h: Hypothesis, fault: OnsetFault, begin: Hypothesis | None = None) -> Corrected | None:
    fits = fit_both(h, fault, begin)
    return None if fits is None else Corrected(replace(fault, gain=fits[2]), *fits[:2])
