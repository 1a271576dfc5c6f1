"""YAML with the place of every value: text in, a tree of `Leaf`, `Branch` and `Items` out.

Every scalar stays the text that was written; what it means is decided by the field that reads it. So `10:30`, `017`,
`1e3` or `on` never turn into something else on the way.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

import yaml

from network.refusal import Complaints, Spot, refuse

LARGEST_FILE = 4_000_000
MOST_VALUES = 200_000
DEEPEST = 40
_PLAIN_TAGS = {f"tag:yaml.org,2002:{name}" for name in ("str", "int", "float", "bool", "null", "timestamp", "map", "seq")}


@dataclass(frozen=True)
class Leaf:
    """A scalar as written. `quoted` tells a text from a word that could be null."""

    text: str
    spot: Spot
    quoted: bool = False

    @property
    def is_null(self) -> bool:
        return not self.quoted and self.text in ("", "~", "null", "Null", "NULL")


@dataclass(frozen=True)
class Branch:
    """A mapping; `keys` holds the place of every key."""

    items: dict[str, Tree]
    spot: Spot
    keys: dict[str, Spot] = field(default_factory=dict)

    def key_spot(self, key: str) -> Spot:
        return self.keys.get(key, self.spot)


@dataclass(frozen=True)
class Items:
    """A sequence."""

    entries: tuple[Tree, ...]
    spot: Spot


Tree: TypeAlias = Leaf | Branch | Items


def read_text(path: Path, what: str) -> str:
    """The file's text, UTF-8; refuses what is no file, empty, too large or in another encoding."""
    spot = Spot(str(path))
    if not path.exists():
        raise refuse(spot, "there is no such file", f"give the path of {what}")
    if not path.is_file():
        raise refuse(spot, "is not a file", f"give the path of {what}")
    size = path.stat().st_size
    if size > LARGEST_FILE:
        raise refuse(spot, f"has {size / 1e6:.1f} MB", f"{what} has at most {LARGEST_FILE / 1e6:.0f} MB")
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise refuse(spot, f"is not UTF-8 text (byte {error.start})", "save it as UTF-8") from None
    if not text.strip():
        raise refuse(spot, "is empty", f"give {what}")
    return text


def load(path: Path, what: str) -> Branch:
    """Reads one YAML file into a tree. Raises `Refused` with every fault found."""
    text = read_text(path, what)
    file = str(path)
    try:
        node = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 0
        raise refuse(Spot(file, line), f"is not YAML here: {error.problem}", "mind indentation, colons and quotes") from None
    except yaml.YAMLError as error:
        raise refuse(Spot(file), f"is not YAML: {str(error).splitlines()[0]}", "save it as plain text") from None
    except RecursionError:
        raise refuse(Spot(file), "is nested too deeply", f"at most {DEEPEST} levels") from None
    tree = _Reader(file).tree(node)
    if not isinstance(tree, Branch):
        raise refuse(tree.spot, "is not a mapping", f"{what} is made of `key: value` lines")
    return tree


class _Reader:
    """Walks the composed nodes once; counts them, so that aliases cannot blow up."""

    def __init__(self, file: str) -> None:
        self.file, self.count, self.complaints = file, 0, Complaints()

    def tree(self, node: yaml.Node | None) -> Tree:
        tree = self._walk(node, 0) if node is not None else Leaf("", Spot(self.file, 1))
        self.complaints.raise_if_any()
        return tree

    def _walk(self, node: yaml.Node, depth: int) -> Tree:
        spot = Spot(self.file, node.start_mark.line + 1)
        self.count += 1
        if depth > DEEPEST:
            raise refuse(spot, "is nested too deeply or contains itself", f"at most {DEEPEST} levels")
        if self.count > MOST_VALUES:
            raise refuse(spot, f"expands to more than {MOST_VALUES} values", "write without nested aliases")
        if node.tag not in _PLAIN_TAGS:
            tag = node.tag.replace("tag:yaml.org,2002:", "!!")
            self.complaints.refuse(spot, f"has the YAML tag '{tag}'", "write plain values, tags are not read")
            return Leaf("", spot)
        if isinstance(node, yaml.MappingNode):
            return self._mapping(node, spot, depth)
        if isinstance(node, yaml.SequenceNode):
            return Items(tuple(self._walk(child, depth + 1) for child in node.value), spot)
        return Leaf(str(node.value), spot, quoted=node.style is not None)

    def _mapping(self, node: yaml.MappingNode, spot: Spot, depth: int) -> Branch:
        items: dict[str, Tree] = {}
        keys: dict[str, Spot] = {}
        for key_node, value_node in node.value:
            here = Spot(self.file, key_node.start_mark.line + 1)
            if not isinstance(key_node, yaml.ScalarNode):
                self.complaints.refuse(here, "a key is not a word", "keys are plain names")
                continue
            key = str(key_node.value)
            if key in items:
                self.complaints.refuse(
                    here, f"'{key}' is given twice (first in line {keys[key].line})", "keep one of them"
                )
            items[key], keys[key] = self._walk(value_node, depth + 1), here
        return Branch(items, spot, keys)


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
    return Leaf(str(value), spot, quoted=isinstance(value, str) and value == "null")


def plain(tree: Tree) -> Any:
    """The tree as plain dicts, lists, strings and None."""
    if isinstance(tree, Branch):
        return {key: plain(child) for key, child in tree.items.items()}
    if isinstance(tree, Items):
        return [plain(child) for child in tree.entries]
    return None if tree.is_null else tree.text


def dump(value: Mapping[str, Any]) -> str:
    """A mapping as YAML text: order kept, entries of one line where they fit."""
    return yaml.safe_dump(dict(value), sort_keys=False, allow_unicode=True, width=160, default_flow_style=None)
