"""From YAML's events to a tree, without recursion and without ever expanding an alias: what is hostile stays small."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import yaml

from network.platform.refusal import Complaints, Refused, Spot, refuse
from network.platform.yaml.tree import Branch, Items, Leaf, Tree

MOST_VALUES = 200_000
DEEPEST = 40
_PLAIN_TAGS = {
    f"tag:yaml.org,2002:{name}" for name in ("str", "int", "float", "bool", "null", "timestamp", "map", "seq")
} | {"!", None}
_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_FAULTS = (
    # where the reader was, what it says, whether the fault lies where that began; what is wrong, what would be right
    ("", "maximum nesting depth", True, "a value is nested too deeply", f"at most {DEEPEST} levels"),
    ("quoted scalar", "unexpected", True, "a quote is opened here and not closed", "close it"),
    ("quoted scalar", "", False, "a backslash means nothing here", "use single quotes, or write it twice"),
    ("flow", "", True, "a bracket is opened here and not closed properly", "close it, with commas inside"),
    ("simple key", "", True, "this line has no colon", "write `key: value`"),
    ("", "mapping values", False, "a colon stands where none can be", "mind the indentation, and quote such texts"),
    ("", "cannot start any token", False, "a value begins with a sign that YAML keeps for itself", "put it in quotes"),
    ("block", "", False, "this line does not fit what stands above it", "mind the indentation and the quotes"),
)


@dataclass
class _Open:
    """A mapping or sequence that is being read."""

    spot: Spot
    is_mapping: bool
    anchor: str | None
    children: list[Tree] = field(default_factory=list)
    items: dict[str, Tree] = field(default_factory=dict)
    keys: dict[str, Spot] = field(default_factory=dict)
    key: str | None = None
    size: int = 1
    depth: int = 1


@dataclass(frozen=True)
class _Anchored:
    tree: Tree
    size: int
    depth: int


class Builder:
    """Reads one document. Faults that leave the rest readable go to `complaints`, others are raised."""

    def __init__(self, file: str, complaints: Complaints, everywhere: Spot | None = None) -> None:
        self.file, self.complaints, self.everywhere = file, complaints, everywhere
        self.open: list[_Open] = []
        self.anchors: dict[str, _Anchored] = {}
        self.size = 0
        self.root: Tree | None = None

    def tree(self, text: str) -> Tree:
        """The document's tree; an empty leaf where there is none."""
        try:
            for event in _events(text):
                self._take(event)
        except yaml.MarkedYAMLError as error:
            raise self._not_yaml(error, text) from None
        except yaml.YAMLError as error:
            raise refuse(self._spot(0), f"is not YAML: {str(error).splitlines()[0]}", "save it as plain text") from None
        return self.root if self.root is not None else Leaf("", self._spot(0))

    def _take(self, event: yaml.Event) -> None:
        spot = self._spot(event.start_mark.line if event.start_mark else 0)
        if isinstance(event, yaml.ScalarEvent):
            self._scalar(event, spot)
        elif isinstance(event, yaml.AliasEvent):
            self._alias(str(event.anchor), spot)
        elif isinstance(event, yaml.CollectionStartEvent):
            self._begin(event, spot)
        elif isinstance(event, yaml.CollectionEndEvent):
            self._end()
        elif isinstance(event, yaml.DocumentStartEvent) and self.root is not None:
            raise refuse(spot, "a second document begins", "keep one document in a file, without `---` between")

    def _spot(self, line: int) -> Spot:
        return self.everywhere or Spot(self.file, line + 1)

    # -- values -----------------------------------------------------------------------------------------------------
    def _scalar(self, event: yaml.ScalarEvent, spot: Spot) -> None:
        self._check_tag(event.tag, spot)
        text, quoted = str(event.value), event.style not in (None, "")
        top = self.open[-1] if self.open else None
        if top is not None and top.is_mapping and top.key is None:
            self._begin_key(top, text, quoted, spot)
        else:
            leaf = Leaf(text, spot, quoted)
            self._place(_Anchored(leaf, 1, 0), event.anchor, spot)

    def _begin_key(self, top: _Open, text: str, quoted: bool, spot: Spot) -> None:
        if text == "<<" and not quoted:
            self.complaints.refuse(spot, "'<<' merges another mapping", "write its entries out, or use `extends:`")
        if text in top.keys:
            first = f" (first in line {top.keys[text].line})" if top.keys[text].line else ""
            self.complaints.refuse(spot, f"'{text}' is given twice{first}", "keep one of them")
        top.key = text
        top.keys.setdefault(text, spot)

    def _begin(self, event: Any, spot: Spot) -> None:
        self._check_tag(event.tag, spot)
        top = self.open[-1] if self.open else None
        if top is not None and top.is_mapping:
            if top.key is None:
                raise refuse(spot, "a key is not a word", "keys are plain names")
            spot = spot if event.flow_style else top.keys[top.key]
        if len(self.open) >= DEEPEST:
            raise refuse(spot, "a value is nested too deeply", f"at most {DEEPEST} levels")
        self.open.append(_Open(spot, isinstance(event, yaml.MappingStartEvent), event.anchor))

    def _end(self) -> None:
        done = self.open.pop()
        tree = Branch(done.items, done.spot, done.keys) if done.is_mapping else Items(tuple(done.children), done.spot)
        self._place(_Anchored(tree, done.size, done.depth), done.anchor, done.spot)

    def _alias(self, name: str, spot: Spot) -> None:
        if any(above.anchor == name for above in self.open):
            raise refuse(spot, f"'*{name}' contains itself", f"take the alias out of what `&{name}` marks")
        if name not in self.anchors:
            raise refuse(spot, f"'*{name}' stands for nothing", f"mark it with `&{name}` above")
        if self.open and self.open[-1].is_mapping and self.open[-1].key is None:
            raise refuse(spot, "a key is not a word", "keys are plain names")
        self._place(self.anchors[name], None, spot)

    def _place(self, value: _Anchored, anchor: str | None, spot: Spot) -> None:
        """Hands a finished value to what it stands in, and bounds what aliases make of it."""
        if anchor is not None:
            self.anchors[anchor] = value
        if not self.open:
            self.root = value.tree
            return
        top = self.open[-1]
        top.size, top.depth = top.size + value.size, max(top.depth, value.depth + 1)
        if len(self.open) + value.depth > DEEPEST:
            raise refuse(spot, "a value is nested too deeply", f"at most {DEEPEST} levels")
        if top.size > MOST_VALUES:
            raise refuse(spot, f"this expands to more than {MOST_VALUES} values", "write without nested aliases")
        if not top.is_mapping:
            top.children.append(value.tree)
        elif top.key is not None:
            top.items.setdefault(top.key, value.tree)
            top.key = None

    def _check_tag(self, tag: str | None, spot: Spot) -> None:
        if tag not in _PLAIN_TAGS:
            shown = str(tag).replace("tag:yaml.org,2002:", "!!")
            raise refuse(spot, f"a value has the YAML tag '{shown}'", "write plain values, tags are not read")

    def _not_yaml(self, error: yaml.MarkedYAMLError, text: str) -> Refused:
        """Where the reader stopped, in the words of who wrote the file."""
        context, problem = str(error.context), str(error.problem)
        mark, begun = error.problem_mark, error.context_mark
        number = mark.line if mark else 0
        line = next(iter(text.splitlines()[number : number + 1]), "")
        if "\t" in line[: len(line) - len(line.lstrip())]:
            return refuse(self._spot(number), "this line is indented with a tab", "indent with spaces")
        for where, why, at_start, wrong, right in _FAULTS:
            if where in context and why in problem:
                return refuse(self._spot(begun.line if at_start and begun else number), wrong, right)
        return refuse(self._spot(number), f"this is not YAML ({problem})", "mind indentation, colons and quotes")


def _events(text: str) -> Iterator[yaml.Event]:
    yield from yaml.parse(text, Loader=_LOADER)
