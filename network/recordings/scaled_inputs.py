"""Inputs of a scenario scaled to another machine: `speed=9000 rpm` makes 9000 rpm of its largest speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from network.platform.quantities.units import BadNumber, in_unit
from network.platform.refusal import Complaints, Spot, likely, refuse
from network.recordings.inputs import Signal
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario
from network.recordings.yaml_values import collecting


def scale_inputs(source: Scenario | Recording, tops: Sequence[str]) -> Scenario | Recording:
    """The source with the inputs named scaled so that their largest magnitude is the one given. Raises Refused for a
    recording, an input that is not there or rests, another kind of unit."""
    if not tops:
        return source
    if isinstance(source, Recording):
        raise refuse(Spot("--top"), "scales a scenario, and this is a recording", "give it as it was recorded")
    complaints, signals = Complaints(), dict(source.schedule.signals)
    for given in tops:
        with collecting(complaints, Spot("--top"), given):
            name, _, value = (text.strip() for text in given.partition("="))
            if name not in signals:
                raise BadNumber(f"names the input '{name}', which is not there", likely(name, signals))
            signals[name] = _scale(signals[name], value)
    complaints.raise_if_any()
    return replace(source, schedule=replace(source.schedule, signals=signals))


def _scale(signal: Signal, value: str) -> Signal:
    wanted = in_unit(value, signal.unit)
    largest = float(np.abs([signal.start, signal.end]).max())
    if not largest:
        raise BadNumber(f"scales '{signal.name}', which is zero throughout", "scale an input that moves")
    factor = wanted / largest
    return replace(signal, start=signal.start * factor, end=signal.end * factor)
