"""Relays whose modes a recording tells: in a fit an input switches them, and not what they watch.

A relay that is simulated falls out of step where anything else is wrong, and no slope leads back. Where readings show
when it was on, its heat is that of a source that follows these modes, and the machine is straight between them.
"""

from __future__ import annotations

from collections.abc import Container, Sequence
from typing import Any

from network.catalogue.mechanisms.mechanism import Relay
from network.engine.response.parameters import Parameter
from network.machine.machine import Machine

MODE = "mode of "
"""Before the name of a relay: the input that tells whether it is on, as readings of what it watches show."""
TRACED = "traced mode of "
"""The same, as what its heat does to all readings shows."""


def follow_relays(machine: Machine, inputs: Container[str]) -> Machine:
    """The machine with those relays switched by inputs for which there is one; itself where there is none."""
    bodies: dict[str, Any] = {}
    for name, entry in machine.sources.items():
        if not isinstance(entry, Relay):
            continue
        told = MODE + name if MODE + name in inputs and list_readers(machine, entry) else TRACED + name
        if told in inputs and (body := entry.follow(told)) is not None:
            bodies[name] = body
    return machine.patched({"sources": bodies}) if bodies else machine


def list_readers(machine: Machine, relay: Relay) -> list[str]:
    """Sensors that read what a relay watches, and at once: one that is slow, or whose clock is off, does not tell when
    it switched."""
    levels = relay.levels()
    if levels is None:
        return []
    watched, found = levels[0], []
    whole = machine.nodes[watched.node].length is None
    for name, sensor in machine.sensors.items():
        place = sensor.place
        same = place is not None and (place == watched or (whole and place.node == watched.node))
        if same and not any(effect.has_state or effect.looks_back for effect in sensor.effects):
            found.append(name)
    return found


def own_numbers(followed: Machine, machine: Machine, parameters: Sequence[Parameter]) -> tuple[Parameter, ...]:
    """Those of the numbers of a machine that it still has where its relays are followed."""
    if followed is machine:
        return tuple(parameters)
    fields = {path: {f.key for f in entry.params().values()} for path, entry in followed.by_path.items()}
    return tuple(p for p in parameters if p.field.key in fields.get(p.entry, ()))
