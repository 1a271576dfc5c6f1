"""What a caller in Python gives: each thing in its place, told in a sentence where another stands there."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from network.machine.machine import Machine
from network.platform.refusal import Spot, refuse
from network.recordings.inputs import Schedule, Start
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario

STARTS = "Start(others=22.0) is 22 °C everywhere, Start(steady=True) in equilibrium"


def expect(name: str, given: object, *kinds: type) -> None:
    """Raises TypeError where something else is given: a file's name, or what belongs in another place."""
    if isinstance(given, kinds):
        return
    known = " or ".join(kind.__name__ for kind in kinds)
    article, right = "an" if known[0] in "aeiou" else "a", _right(given, kinds)
    raise TypeError(f"{name} is {article} {known}, not {_name(given)}{f': {right}' if right else ''}")


def _name(given: object) -> str:
    name = type(given).__name__
    return "None" if given is None else f"{'an' if name[0] in 'aeiou' else 'a'} {name}"


def _right(given: object, kinds: tuple[type, ...]) -> str:
    if kinds[0] is Start:
        return STARTS
    if isinstance(given, str | Path) and hasattr(kinds[0], "load"):
        return f"{kinds[0].__name__}.load({given!r})"
    if kinds == (Recording,) and isinstance(given, Scenario):
        return "nothing is measured in a scenario; simulate it, or give what was recorded"
    return "look at their order" if hasattr(kinds[0], "load") else ""


def expect_run(machine: object, source: object, start: object = None) -> None:
    """Raises TypeError unless they are a machine, what drives it, and where it starts."""
    expect("machine", machine, Machine)
    expect("source", source, Scenario, Recording, Schedule)
    expect_start(start)


def expect_start(start: object) -> None:
    """Raises TypeError unless it is a start, or none."""
    if start is not None:
        expect("start", start, Start)


def as_several(recordings: Recording | Iterable[Recording]) -> tuple[Recording, ...]:
    """One recording or several, as several. Raises TypeError for what is none."""
    given: object = recordings
    if isinstance(given, str | Path | Scenario | Machine) or not isinstance(given, Recording | Iterable):
        expect("recording", given, Recording)
    several = (recordings,) if isinstance(recordings, Recording) else tuple(recordings)
    for each in several:
        expect("recording", each, Recording)
    return several


def expect_fit(machine: object, recordings: Iterable[object], start: object) -> None:
    """Raises TypeError unless they are a machine and a start, Refused where there is no recording."""
    expect("machine", machine, Machine)
    expect_start(start)
    if not [*recordings]:
        raise refuse(Spot("recordings"), "there is none", "give at least one")
