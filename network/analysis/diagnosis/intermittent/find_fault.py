"""The fault of a reading that explains most, of those that come and go and those that last from an instant on."""

from __future__ import annotations

from collections.abc import Callable

from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.intermittent.channel_fault import ChannelFault
from network.analysis.diagnosis.intermittent.find_onset_fault import find_onset_fault
from network.analysis.diagnosis.intermittent.intermittent_fault import find_intermittent_fault


def find_reading_fault(h: Hypothesis, rival_gain: Callable[[], float]) -> tuple[ChannelFault, Hypothesis] | None:
    """It, and the hypothesis fitted to the readings set right; None where there is none. One that leaves much beside
    it, and competes, is told where there is no other. rival_gain: what the best of the catalogue scores about the same
    fit [nats]."""
    told = find_intermittent_fault(h), find_onset_fault(h, rival_gain)
    able = [pair for pair in told if pair is not None]
    return max(able, key=lambda pair: (not pair[0].competes, pair[0].gain), default=None)
