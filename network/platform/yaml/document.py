"""YAML with the place of every value: text in, a tree of `Leaf`, `Branch` and `Items` out.

Every scalar stays the text that was written; what it means is decided by the field that reads it. So `10:30`, `017`,
`1e3` or `on` never turn into something else on the way.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from network.platform.package_data import hint
from network.platform.refusal import Complaints, Spot, refuse
from network.platform.yaml.events import Builder
from network.platform.yaml.tree import Branch, Items, Leaf, Tree, plain, tree_of

__all__ = ["Branch", "Items", "Leaf", "Tree", "dump", "load", "parse", "plain", "read_text", "tree_of"]

LARGEST_FILE = 4_000_000
_NO_TEXT = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def read_text(path: Path, what: str) -> str:
    """The file's text, UTF-8; refuses what is no file, empty, too large or in another encoding."""
    spot = Spot(str(path))
    raw = _read_bytes(path, spot, what)
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        wrong = f"is not UTF-8 text (byte 0x{raw[error.start]:02x} in line {line})"
        raise refuse(spot, wrong, "save it as UTF-8") from None
    strange = _NO_TEXT.search(text)
    if strange:
        here = Spot(str(path), text.count("\n", 0, strange.start()) + 1)
        raise refuse(here, f"has a character that no text has (0x{ord(strange[0]):02x})", "save it as UTF-8 text")
    if not text.strip():
        raise refuse(spot, "is empty", f"give {what}")
    return text


def _read_bytes(path: Path, spot: Spot, what: str) -> bytes:
    try:
        if not path.exists():
            raise refuse(spot, "there is no such file", f"give the path of {what}{hint(path)}")
        if not path.is_file():
            raise refuse(spot, "is not a file", f"give the path of {what}")
        size = path.stat().st_size
        if size > LARGEST_FILE:
            raise refuse(spot, f"has {size / 1e6:.1f} MB", f"{what} has at most {LARGEST_FILE / 1e6:.0f} MB")
        return path.read_bytes()
    except OSError as error:
        why = (error.strerror or "it cannot be read").lower()
        raise refuse(spot, f"cannot be read ({why})", f"give the path of {what}") from None


def load(path: Path, what: str, complaints: Complaints | None = None) -> Branch:
    """Reads one YAML file into a tree. Raises `Refused` with every fault found.

    With `complaints`, keys given twice go there and the first of them counts, so that the rest can be looked at too.
    """
    text, own = read_text(path, what), complaints or Complaints()
    tree = Builder(str(path), own).tree(text)
    if complaints is None:
        own.raise_if_any()
    if isinstance(tree, Branch):
        return tree
    if isinstance(tree, Leaf) and tree.is_null:
        raise refuse(tree.spot, "holds nothing but comments", f"give {what}")
    raise refuse(tree.spot, "is not a mapping", f"{what} is made of `key: value` lines")


def parse(text: str, spot: Spot) -> Tree:
    """A YAML text from elsewhere than a file (the command line); every value gets that spot."""
    complaints = Complaints()
    tree = Builder(spot.file, complaints, spot).tree(text)
    complaints.raise_if_any()
    return tree


WIDE = 160
"""Letters of a line of a file that is written."""
_PLAIN = (("bool", "true|false"), ("int", "[+-]?(0|[1-9][0-9]*)"), ("float", r"[+-]?(0|[1-9][0-9]*)\.[0-9]+"))


class _Dumper(yaml.SafeDumper):
    """Numbers and true/false stay plain; what other readers of YAML take for something else (`on`, `017`) is quoted."""

    def ignore_aliases(self, data: Any) -> bool:
        return True

    def represent_str(self, data: str) -> yaml.ScalarNode:
        tag = next((tag for tag, pattern in _PLAIN if re.fullmatch(pattern, data)), "str")
        return self.represent_scalar(f"tag:yaml.org,2002:{tag}", data)

    def represent_dict(self, data: Any) -> yaml.MappingNode:
        node = super().represent_dict(data)
        node.flow_style = "kind" in data or not (any(map(_holds_mapping, data.values())) or _is_table(data))
        return node

    def represent_list(self, data: Any) -> yaml.SequenceNode:
        node = super().represent_list(data)
        node.flow_style = node.flow_style or not any(map(_holds_mapping, data))
        return node


_Dumper.add_representer(str, _Dumper.represent_str)
_Dumper.add_representer(dict, _Dumper.represent_dict)
_Dumper.add_representer(list, _Dumper.represent_list)


def _holds_mapping(value: Any) -> bool:
    return isinstance(value, dict) or (isinstance(value, list) and any(map(_holds_mapping, value)))


def _is_table(data: Mapping[str, Any]) -> bool:
    """Rows of values by name that would not fit one line."""
    return bool(data) and all(isinstance(v, list) for v in data.values()) and len(str(data)) > WIDE


def dump(value: Mapping[str, Any]) -> str:
    """A mapping as YAML text: order kept, an entry in one line where it fits."""
    texts = plain(tree_of(value, Spot("")))
    return yaml.dump(texts, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=WIDE)
