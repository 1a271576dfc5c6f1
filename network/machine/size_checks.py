"""How much of a machine there may be: what its tables and the flows between its lumps take in memory and time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil, floor
from typing import TYPE_CHECKING

from network.catalogue.declaration.declare import Declared
from network.catalogue.declaration.entry_path import EntryPath
from network.catalogue.declaration.fields import Place
from network.catalogue.expansions.base import Expansion
from network.catalogue.mechanisms.base import Link, Source
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


@dataclass(frozen=True)
class Tables:
    """How many lumps, pairs that links join and rows over all lumps a machine has."""

    lumps: int
    pairs: int
    rows: int


def count_tables(machine: Entries) -> Tables:
    """Once for a machine, which keeps them."""
    if "tables" not in machine.__dict__:
        pairs, lumps = _count_all_pairs(machine), sum(node.lumps for node in machine.nodes.values())
        machine.__dict__["tables"] = Tables(lumps, sum(pairs.values()), _count_rows(machine, pairs))
    kept: Tables = machine.__dict__["tables"]
    return kept


def is_far_from_limits(before: Entries, machine: Entries, added: Mapping[EntryPath, Declared]) -> bool:
    """Whether entries put into a machine, none of them a node, leave it within the limits although what they took the
    place of is counted, too: so that nothing has to be counted again."""
    if any(path.section == "nodes" for path in added):
        return False
    pairs = {e.name: count_pairs(machine, e) for e in added.values() if isinstance(e, Link)}
    rows = sum(1 + _rows_of(entry, pairs) for entry in added.values())
    had = count_tables(before)
    return had.pairs + sum(pairs.values()) <= MOST_PAIRS and (had.rows + rows) * had.lumps <= MOST_CELLS


def check_sizes(machine: Entries, complaints: Complaints) -> bool:
    """Whether the machine can be laid out in memory; refuses what is too large, with its size and the limit."""
    lumps = sum(node.lumps for node in machine.nodes.values())
    if lumps > MOST_IN_ALL:
        spot = machine.tree.key_spot("nodes")
        complaints.refuse(spot, f"the machine has {lumps} lumps in all", f"give it at most {MOST_IN_ALL}")
        return False
    pairs = _count_all_pairs(machine)
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


def _count_all_pairs(machine: Entries) -> dict[str, int]:
    return {name: count_pairs(machine, link) for name, link in machine.links.items() if isinstance(link, Link)}


def count_pairs(machine: Entries, link: Link) -> int:
    """Lumps of its first place times lumps of its second one, all of these where it moves along them."""
    a, b = (_count_lumps(machine, place) for place in link.between)
    return a * (machine.nodes[link.between[1].node].lumps if link.moves else b)


def _count_lumps(machine: Entries, place: Place) -> int:
    lumps = machine.nodes[place.node].lumps
    return max(1, ceil(place.stop * lumps - ROUNDING) - floor(place.start * lumps + ROUNDING))


def _count_rows(machine: Entries, pairs: Mapping[str, int]) -> int:
    """A row for every part, sensor and reading, and for what every source heats; of links that read, for each pair."""
    entries = (*machine.expansions.values(), *machine.sources.values(), *machine.links.values())
    return len(machine.nodes) + len(machine.sensors) + sum(_rows_of(entry, pairs) for entry in entries)


def _rows_of(entry: Declared, pairs: Mapping[str, int]) -> int:
    """The same of one that is neither part nor sensor; pairs: of links, by name."""
    if isinstance(entry, Expansion):
        return len(list(entry.readings()))
    if isinstance(entry, Source):
        return 1 + len(entry.readings())
    if isinstance(entry, Link) and (count := len(entry.readings())):
        return pairs[entry.name] * (1 + count)
    return 0
