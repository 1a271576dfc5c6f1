"""The tree a YAML text is read into: every value with its place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from network.platform.refusal import Spot

_NULLS = ("", "~", "null", "Null", "NULL")


@dataclass(frozen=True, slots=True)
class Leaf:
    """A scalar as written. `quoted` tells a text from a word that could be null."""

    text: str
    spot: Spot
    quoted: bool = False

    @property
    def is_null(self) -> bool:
        return not self.quoted and self.text in _NULLS


@dataclass(frozen=True, slots=True)
class Branch:
    """A mapping; `keys` holds the place of every key, also of those that a patch took out."""

    items: dict[str, Tree]
    spot: Spot
    keys: dict[str, Spot] = field(default_factory=dict)

    def key_spot(self, key: str) -> Spot:
        return self.keys.get(key, self.spot)


@dataclass(frozen=True, slots=True)
class Items:
    """A sequence."""

    entries: tuple[Tree, ...]
    spot: Spot


Tree: TypeAlias = Leaf | Branch | Items


def tree_of(value: Any, spot: Spot) -> Tree:
    """Plain Python values (a patch given from Python) as a tree."""
    if isinstance(value, Leaf | Branch | Items):
        return value
    if isinstance(value, Mapping):
        return Branch({str(k): tree_of(v, spot) for k, v in value.items()}, spot)
    if isinstance(value, Sequence) and not isinstance(value, str):
        return Items(tuple(tree_of(v, spot) for v in value), spot)
    if value is None:
        return Leaf("null", spot)
    if isinstance(value, bool):
        return Leaf("true" if value else "false", spot)
    if isinstance(value, float):
        return Leaf(repr(float(value)).removesuffix(".0"), spot)
    return Leaf(str(value), spot, quoted=isinstance(value, str) and value in _NULLS)


def plain(tree: Tree) -> Any:
    """The tree as plain dicts, lists, strings and None."""
    if isinstance(tree, Branch):
        return {key: plain(child) for key, child in tree.items.items()}
    if isinstance(tree, Items):
        return [plain(child) for child in tree.entries]
    return None if tree.is_null else tree.text
