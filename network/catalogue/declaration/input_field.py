"""The input channels that entries read, each by a name of the user's choice."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, cast

from network.catalogue.declaration.field import Field, word_of
from network.platform.yaml.tree import Tree

ANY = ""
"""The unit of an input that may be of any kind, like a switch."""


class InputField(Field):
    """The name of an input channel; unit: one of the kind it must have, or ANY."""

    def __init__(self, name: str | None, unit: str, meaning: str, key: str) -> None:
        super().__init__(meaning, name, key)
        self.unit = unit

    def parse(self, tree: Tree) -> str:
        return word_of(tree, "the name of an input channel")

    def schema(self) -> dict[str, Any]:
        return {"type": "string"}

    def structure(self, value: Any) -> object:
        return value


def channel(name: str | None, unit: str, meaning: str = "", key: str = "") -> str:
    """An input that an entry reads, by the name it has where none is given; None: none is read then."""
    return cast(str, InputField(name, unit, meaning or f"the input it reads, in a unit like {unit}", key))


def merge_inputs(pairs: Iterable[tuple[str, str]]) -> dict[str, str]:
    """(name, unit) pairs by name; where one reader leaves the unit open, that of another."""
    merged: dict[str, str] = {}
    for name, unit in pairs:
        merged[name] = merged.get(name) or unit
    return merged
