"""A candidate whose relay switches at levels that are certain, instead of ones that are fitted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.catalogue.declaration.entry_path import EntryPath
from network.catalogue.declaration.patch import Patch
from network.catalogue.mechanisms.mechanism import Relay
from network.platform.refusal import Refused


@dataclass(frozen=True, eq=False)
class Certain:
    """candidate: with the levels written and no more free; levels: the numbers that say them, by path."""

    candidate: Candidate
    levels: Mapping[str, float]


def find_relay(c: Candidate) -> tuple[EntryPath, Relay] | None:
    """The relay that a candidate brings, with its path; None where that is not one."""
    relays = _list_relays(c)
    return relays[0] if len(relays) == 1 else None


def is_drawn(c: Candidate) -> bool:
    """Whether what switches in a candidate is looked for at levels that are drawn, too."""
    return all(relay.drawn for _, relay in _list_relays(c))


def _list_relays(c: Candidate) -> list[tuple[EntryPath, Relay]]:
    return [(p, e) for p, _ in c.patch.entries() if isinstance(e := c.machine.by_path.get(p), Relay)]


def make_certain(c: Candidate, low: float, high: float) -> Certain | None:
    """A candidate whose relay switches at two temperatures [°C]; None where it brings no relay that does, or may not do
    so at these."""
    only = find_relay(c)
    if only is None:
        return None
    path, relay = only
    try:
        keys = relay.keep_between(low, high)
        machine = c.machine.patched(Patch.of([(path, keys)])) if keys else c.machine
    except Refused:
        return None
    own = [p for p in c.own if p.entry == path and p.field.key in keys]
    levels = {p.path: float(getattr(machine.by_path[path], p.attribute)) for p in own}
    rest = tuple(p for p in c.own if p not in own)
    return Certain(replace(c, machine=machine, own=rest), levels) if keys else None
