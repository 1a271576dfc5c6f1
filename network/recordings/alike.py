"""Faults of one kind in many rows: told once, with their number, the first of them and the last."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field

from network.platform.refusal import Complaints, Spot


@dataclass
class _Kind:
    line: int
    wrong: str
    right: str
    count: int = 0
    last: int = 0


@dataclass
class Alike:
    """Collects the faults of one file by kind."""

    file: str
    kinds: dict[Hashable, _Kind] = field(default_factory=dict)

    def add(self, kind: Hashable, line: int, wrong: str, right: str) -> None:
        """The words of the first of a kind are those that are told."""
        known = self.kinds.setdefault(kind, _Kind(line, wrong, right))
        known.count += 1
        known.last = line

    def tell(self, complaints: Complaints) -> None:
        for kind in self.kinds.values():
            more = kind.count - 1
            rows = "1 more row like it" if more == 1 else f"{more} more rows like it, the last"
            told = f" ({rows} in line {kind.last})" if more else ""
            complaints.refuse(Spot(self.file, kind.line), kind.wrong + told, kind.right)
