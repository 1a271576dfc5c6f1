"""How much of a machine there may be: what its tables and the flows between its lumps take in memory and time."""

from __future__ import annotations

from math import ceil, floor
from typing import TYPE_CHECKING

from network.catalogue.declaration.fields import Place
from network.catalogue.mechanisms.base import Link
from network.catalogue.nodes import MOST_IN_ALL
from network.platform.refusal import Complaints

if TYPE_CHECKING:
    from network.machine.entries import Entries

MOST_PAIRS = 500_000
"""Pairs of lumps that links join, half a kB each: a link of two bars joins every lump of one with every one of the
other."""
MOST_CELLS = 60_000_000
"""Numbers of 8 B in the tables of a network, which has a row over all lumps for everything that is read or heated;
three of the largest are there at once."""
ROUNDING = 1e-9
"""Lumps, by which a place may end beside the border of one."""


def check_sizes(machine: Entries, complaints: Complaints) -> bool:
    """Whether the machine can be laid out in memory; refuses what is too large, with its size and the limit."""
    lumps = sum(node.lumps for node in machine.nodes.values())
    if lumps > MOST_IN_ALL:
        spot = machine.tree.key_spot("nodes")
        complaints.refuse(spot, f"the machine has {lumps} lumps in all", f"give it at most {MOST_IN_ALL}")
        return False
    pairs = {name: count_pairs(machine, link) for name, link in machine.links.items() if isinstance(link, Link)}
    if not sum(pairs.values()) <= MOST_PAIRS:
        most = max(pairs, key=lambda name: pairs[name])
        wrong = f"the links join {sum(pairs.values())} pairs of lumps, links.{most} {pairs[most]} of them"
        right = f"at most {MOST_PAIRS} can be computed: give fewer lumps, or places, like bar@0 or bar@0.2..0.3"
        complaints.refuse(machine.links[most].spot_of("between"), wrong, right)
        return False
    rows = _count_rows(machine, pairs)
    if not rows * lumps <= MOST_CELLS:
        wrong = f"the machine needs {rows} rows over {lumps} lumps, {rows * lumps / 1e6:.0f} million numbers"
        right = f"give it fewer lumps or entries: at most {MOST_CELLS // 1_000_000} million can be computed"
        complaints.refuse(machine.tree.key_spot("nodes"), wrong, right)
        return False
    return True


def count_pairs(machine: Entries, link: Link) -> int:
    """Lumps of its first place times lumps of its second one, all of these where it moves along them."""
    a, b = (_count_lumps(machine, place) for place in link.between)
    return a * (machine.nodes[link.between[1].node].lumps if link.moves else b)


def _count_lumps(machine: Entries, place: Place) -> int:
    lumps = machine.nodes[place.node].lumps
    return max(1, ceil(place.stop * lumps - ROUNDING) - floor(place.start * lumps + ROUNDING))


def _count_rows(machine: Entries, pairs: dict[str, int]) -> int:
    """A row for every part, sensor and reading, and for what every source heats; of links that read, for each pair."""
    reading = sum(len(list(entry.readings())) for entry in machine.expansions.values())
    heated = sum(1 + len(source.readings()) for source in machine.sources.values())
    reads = {name: len(machine.links[name].readings()) for name in pairs}
    read = sum(pairs[name] * (1 + count) for name, count in reads.items() if count)
    return len(machine.nodes) + len(machine.sensors) + reading + heated + read
