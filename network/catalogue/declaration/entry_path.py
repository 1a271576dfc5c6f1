"""Where an entry of a machine file stands, and a number of it. Text, like 'links.skin.conductance', is the user's form.

What is special about a section is known here alone: `tcp` has its entries by axis and name, and an entry of nodes or
sensors may hold entries of its own.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from network.catalogue.declaration.sections import TCP

Keys: TypeAlias = tuple[str | int, ...]
NESTED: Mapping[str, Mapping[str, bool]] = {
    "nodes": {"melts": False, "drifts": False}, "sources": {"oil": False}, "sensors": {"effects": True},
}  # fmt: skip
"""Section → the keys under which its entries hold others, and whether that is a list."""


@dataclass(frozen=True, slots=True)
class EntryPath:
    """section, axis (of `tcp` only), name; inner: the way on to an entry that this one holds, like ('effects', 0)."""

    section: str
    axis: str
    name: str
    inner: Keys = ()

    @classmethod
    def parse(cls, text: str) -> EntryPath:
        """'links.skin', 'tcp.z.bed grows', 'sensors.T.effects.0'. Raises ValueError for what is no path.

        Of a name with a dot in it only a machine knows where it ends: see `Machine.paths`.
        """
        section, _, rest = text.partition(".")
        axis, _, name = rest.partition(".") if section == TCP else ("", "", rest)
        if not name:
            raise ValueError(f"'{text}' is no path of an entry")
        for key, many in NESTED.get(section, {}).items():
            if found := re.fullmatch(rf"(.+)\.{key}" + (r"\.([0-9]+)" if many else ""), name):
                return cls(section, axis, found[1], (key, int(found[2])) if many else (key,))
        return cls(section, axis, name)

    def __str__(self) -> str:
        return ".".join(map(str, self.keys))

    @property
    def keys(self) -> Keys:
        """The way to it from the top of the file, key by key."""
        return (self.section, *((self.axis,) if self.section == TCP else ()), self.name, *self.inner)

    def list_inner(self, entry: Mapping[str, Any]) -> Iterator[tuple[EntryPath, Any]]:
        """What an entry holds (its YAML, or its values by name), each with its path."""
        for key, many in NESTED.get(self.section, {}).items():
            held = entry.get(key)
            if many:
                yield from ((replace(self, inner=(key, i)), one) for i, one in enumerate(held or ()))
            elif held is not None:
                yield replace(self, inner=(key,)), held


@dataclass(frozen=True, slots=True)
class NumberPath:
    """A number of an entry, by its key in the file."""

    entry: EntryPath
    key: str

    @classmethod
    def parse(cls, text: str, paths: Mapping[str, EntryPath]) -> NumberPath | None:
        """The number at a path as the user writes it; paths: the entries there are. None where there is none."""
        entry, _, key = text.rpartition(".")
        return cls(paths[entry], key) if entry in paths else None

    def __str__(self) -> str:
        return f"{self.entry}.{self.key}"

    @property
    def keys(self) -> Keys:
        return (*self.entry.keys, self.key)


def displacement(axis: str) -> str:
    """What the movement of the tool centre point along an axis is called, as sensors measure it: 'tcp.z'."""
    return f"{TCP}.{axis}"


def axis_of(name: str) -> str | None:
    """'z' of 'tcp.z'; None for what is called otherwise."""
    above = displacement("")
    return name.removeprefix(above) if name.startswith(above) else None
