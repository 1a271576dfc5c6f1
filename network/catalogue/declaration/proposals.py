"""What proposals are made from beside a machine: what its recordings bring, and names that are not taken."""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import count
from typing import Any

from network.catalogue.declaration.number_fields import Amount
from network.platform.wording import name_of


@dataclass(frozen=True)
class Runs:
    """What recordings bring to proposals. longest: length of the longest [s]; interval: time from one sample to the
    next of the densest [s]; powers: recorded powers that no source of the machine reads, each with the most that it
    reaches; drivers: the same of other recorded columns and inputs that are no temperature and no response, like
    levels, loads and pumps; steady: inputs that never change in any of them."""

    longest: float = math.inf
    interval: float = 0.0
    powers: Mapping[str, Amount] = field(default_factory=dict)
    drivers: Mapping[str, Amount] = field(default_factory=dict)
    steady: frozenset[str] = frozenset()


def set_in_each(patches: Iterable[Mapping[str, Any]], **settings: Any) -> Iterator[Mapping[str, Any]]:
    """Proposals with settings in every entry that typical sizes do not give."""
    for patch in patches:
        yield {section: {name: {**body, **settings} for name, body in entries.items()}
               for section, entries in patch.items()}  # fmt: skip


def fresh(name: str, taken: Container[str]) -> str:
    """The name, with a number behind it if it is taken."""
    return name if name not in taken else next(n for i in count(2) if (n := f"{name} {i}") not in taken)


def fresh_entry(kind: str, of: str, taken: Container[str]) -> str:
    """The name of an entry of a kind by where it sits, as a reader says it: it stands in sentences, too."""
    return fresh(f"{name_of(kind)} {of}".strip(), taken)
