"""Inputs of a scenario fitted to another machine: `speed=9000 rpm` makes 9000 rpm of its largest speed, `feed=feed_x` a
feed_x of its feed."""

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


def rename_inputs(source: Scenario | Recording, names: Sequence[str]) -> Scenario | Recording:
    """The source with inputs under the names that a machine has for them. Raises Refused for a recording, an input that
    is not there, and a name that is taken."""
    if not names:
        return source
    if isinstance(source, Recording):
        raise refuse(Spot("--input"), "renames inputs of a scenario, and this is a recording", "name them in a mapping")
    complaints, signals = Complaints(), dict(source.schedule.signals)
    for given in names:
        with collecting(complaints, Spot("--input"), given):
            theirs, _, ours = (text.strip() for text in given.partition("="))
            if theirs not in signals:
                raise BadNumber(f"names the input '{theirs}', which is not there", likely(theirs, signals))
            if not ours or ours in signals:
                wrong = f"calls {theirs} '{ours}', which is there already" if ours else f"does not say what {theirs} is"
                raise BadNumber(wrong, "write PROGRAM's name, =, and the machine's, as in `feed=feed_x`")
            signals[ours] = replace(signals.pop(theirs), name=ours)
    complaints.raise_if_any()
    return replace(source, schedule=replace(source.schedule, signals=signals))


def _scale(signal: Signal, value: str) -> Signal:
    wanted = in_unit(value, signal.unit)
    largest = float(np.abs([signal.start, signal.end]).max())
    if not largest:
        raise BadNumber(f"scales '{signal.name}', which is zero throughout", "scale an input that moves")
    factor = wanted / largest
    return replace(signal, start=signal.start * factor, end=signal.end * factor)
