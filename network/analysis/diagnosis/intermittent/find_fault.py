"""The fault of a reading that explains most, of those that come and go and those that last from an instant on."""

from __future__ import annotations

from collections.abc import Callable

from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.intermittent.channel_fault import ChannelFault
from network.analysis.diagnosis.intermittent.find_onset_fault import find_onset_fault
from network.analysis.diagnosis.intermittent.intermittent_fault import find_intermittent_fault


def find_reading_fault(
    h: Hypothesis, rival_gain: Callable[[], float], may_be_open: bool = False
) -> tuple[ChannelFault, Hypothesis] | None:
    """It, and the hypothesis fitted to the readings set right; None where there is none. rival_gain: what the best of
    the catalogue scores about the same fit [nats]; may_be_open: whether much may be left beside one that begins at an
    instant, where there is no other."""
    told = find_intermittent_fault(h), find_onset_fault(h, rival_gain, may_be_open)
    able = [pair for pair in told if pair is not None]
    return max(able, key=lambda pair: (not pair[0].competes, pair[0].gain), default=None)
