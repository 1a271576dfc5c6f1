from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self

from network.catalogue.declaration.fields import channel, word
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.suspects.base import Suspect


class InputFault(Suspect, kind="input_fault"):
    """What drives a machine stands for a time, and no recording says so: u(t) = 0 from one instant to another.

    A machine that stood for a tool change while its program ran on, a heater that tripped; or a source without an
    input, always on by the file, that paused. All that is driven fails at once, at full strength, which tells it from
    heat that is missing in one part. It is a matter of a recording and no part of the machine: where the input has a
    column this is set right; where there is none, one is laid beside the recording that says when the source was on,
    the patch `while:`. No slope tells its instants, so every stretch of every run is tried.
    """

    shows_in_readings = True
    searched = False
    """By no slope: all stretches are tried in the recordings."""
    source = word("the source that pauses")
    on = channel(None, "1", "the input that says when it is on", key="while")
    strength = "on"
    sentence = "{source} stands at times, and nothing that is recorded says when"

    def patch(self, machine: MachineLike) -> Mapping[str, Any]:
        return {"sources": {self.source: {self.fields["on"].key: self.on}}}

    @classmethod
    def suspected(cls, machine: MachineLike) -> Iterator[Self]:
        """Every source of which nothing says yet when it is there."""
        key = cls.fields["on"].key
        for name, entry in machine.sources.items():
            if key not in entry.to_plain() and (on := f"{name} on") not in machine.inputs:
                yield cls(source=name, on=on)

    @classmethod
    def from_patch(cls, machine: MachineLike, patch: Mapping[str, Any]) -> Self:
        ((name, body),) = patch["sources"].items()
        return cls(source=name, on=body[cls.fields["on"].key])
