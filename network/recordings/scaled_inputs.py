"""Inputs of a scenario fitted to another machine: `speed=9000 rpm` makes 9000 rpm of its largest speed, `feed=feed_x` a
feed_x of its feed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
    why = "scales a scenario, and this is a recording", "give it as it was recorded"
    return _change_inputs(source, tops, Spot("--top"), why, _put_scaled)


def rename_inputs(source: Scenario | Recording, names: Sequence[str]) -> Scenario | Recording:
    """The source with inputs under the names that a machine has for them. Raises Refused for a recording, an input that
    is not there, and a name that is taken."""
    why = "renames inputs of a scenario, and this is a recording", "name them in a mapping"
    return _change_inputs(source, names, Spot("--input"), why, _put_renamed)


def _change_inputs(
    source: Scenario | Recording, given: Sequence[str], spot: Spot, not_recording: tuple[str, str],
    put: Callable[[dict[str, Signal], str, str], None],
) -> Scenario | Recording:  # fmt: skip
    """The source with its signals as `put` leaves them, given each of them and both sides of an assignment."""
    if not given:
        return source
    if isinstance(source, Recording):
        raise refuse(spot, *not_recording)
    complaints, signals = Complaints(), dict(source.schedule.signals)
    for each in given:
        with collecting(complaints, spot, each):
            name, _, value = (text.strip() for text in each.partition("="))
            put(signals, name, value)
    complaints.raise_if_any()
    return replace(source, schedule=replace(source.schedule, signals=signals))


def _put_scaled(signals: dict[str, Signal], name: str, value: str) -> None:
    if name not in signals:
        raise BadNumber(f"names the input '{name}', which is not there", likely(name, signals))
    signals[name] = _scale(signals[name], value)


def _put_renamed(signals: dict[str, Signal], theirs: str, ours: str) -> None:
    if theirs not in signals:
        raise BadNumber(f"names the input '{theirs}', which is not there", likely(theirs, signals))
    if not ours or ours in signals:
        wrong = f"calls {theirs} '{ours}', which is there already" if ours else f"does not say what {theirs} is"
        raise BadNumber(wrong, "write PROGRAM's name, =, and the machine's, as in `feed=feed_x`")
    signals[ours] = replace(signals.pop(theirs), name=ours)


def _scale(signal: Signal, value: str) -> Signal:
    wanted = in_unit(value, signal.unit)
    largest = float(np.abs([signal.start, signal.end]).max())
    if not largest:
        raise BadNumber(f"scales '{signal.name}', which is zero throughout", "scale an input that moves")
    factor = wanted / largest
    return replace(signal, start=signal.start * factor, end=signal.end * factor)
