"""Patches: a mapping of a machine file's shape, laid over another. `extends:`, levels and findings are patches.

An entry given in the patch replaces the whole entry of that name (in `tcp`: of that axis and name); null removes it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from network.catalogue.declaration.entry_path import NESTED, EntryPath, Keys, NumberPath
from network.catalogue.declaration.sections import depth, is_empty
from network.platform.refusal import Complaints, Spot, likely
from network.platform.yaml.tree import Branch, Items, Leaf, Tree, plain, tree_of

KEPT = ("nodes", "sensors")
"""Sections that stay as they are where a place is moved."""


@dataclass(frozen=True, eq=False)
class Patch(Mapping[str, Any]):
    """What is given of a machine file, as plain values: sections of entries, and null for an entry that goes."""

    sections: Mapping[str, Any]

    def __getitem__(self, section: str) -> Any:
        return self.sections[section]

    def __iter__(self) -> Iterator[str]:
        return iter(self.sections)

    def __len__(self) -> int:
        return len(self.sections)

    # -- made -------------------------------------------------------------------------------------------------------
    @classmethod
    def of(cls, entries: Iterable[tuple[EntryPath, Any]]) -> Patch:
        """The patch with these entries; None removes one."""
        sections: dict[str, Any] = {}
        for path, body in entries:
            *above, name = path.keys
            held: dict[Any, Any] = sections
            for key in above:
                held = held.setdefault(key, {})
            held[name] = body
        return cls(sections)

    @classmethod
    def difference(cls, base: Branch, now: Branch) -> Patch:
        """The patch that makes `now` of `base`: entries that differ in full, null for those that are gone."""
        sections = {}
        for key in dict.fromkeys([*base.items, *now.items]):
            old, new = (plain(tree.items[key]) if key in tree.items else None for tree in (base, now))
            if not depth(key) and old != new and key != "extends":
                sections[key] = new
            elif depth(key) and (changed := _find_changes(old or {}, new or {}, depth(key))):
                sections[key] = changed
        return cls(sections)

    # -- read -------------------------------------------------------------------------------------------------------
    def by_name(self) -> Iterator[tuple[EntryPath, Any]]:
        """(path, entry) for everything it says of an entry with a name; None for one that it removes."""
        for section, entries in self.sections.items():
            if depth(section) == 1:
                yield from ((EntryPath(section, "", name), body) for name, body in entries.items())
            elif depth(section):
                for axis, own in entries.items():
                    yield from ((EntryPath(section, axis, name), body) for name, body in own.items())

    def entries(self) -> Iterator[tuple[EntryPath, Mapping[str, Any]]]:
        """(path, entry) for everything it gives, behind each entry those that it holds."""
        for path, body in self.by_name():
            if isinstance(body, Mapping):
                yield path, body
                if path.section in NESTED:
                    yield from path.list_inner(body)

    def numbers(self) -> Iterator[tuple[NumberPath, Any]]:
        """Every single value of its entries, numbers and words, as it is written."""
        for path, body in self.entries():
            yield from ((NumberPath(path, k), v) for k, v in body.items() if not isinstance(v, Mapping | list | tuple))

    def at(self, path: EntryPath) -> Any:
        """The entry at a path."""
        body: Any = self.sections
        for key in path.keys:
            body = body[key]
        return body

    def to_plain(self) -> dict[str, Any]:
        return dict(self.sections)

    # -- changed ----------------------------------------------------------------------------------------------------
    def with_value(self, number: NumberPath, text: Any) -> Patch:
        """The patch with one more value in an entry that it gives."""
        return Patch(_put(self.sections, number.keys, text))

    def move_place(self, place: str, to: str) -> Patch:
        """The patch whose entries, but for nodes and sensors, say another place in the stead of one."""
        moved = {s: own if s in KEPT else _move(own, place, to) for s, own in self.sections.items()}
        return Patch(moved)

    def as_in(self, tree: Branch) -> Patch:
        """The entries that it gives as they stand in a tree."""
        whole = Patch(plain(tree))
        return Patch.of((path, whole.at(path)) for path, _ in self.entries() if not path.inner)

    def over(self, tree: Branch, spot: Spot) -> Branch:
        """A tree with the patch laid over it; `spot` stands in messages. Raises Refused."""
        laid = tree_of(self.sections, spot)
        assert isinstance(laid, Branch)
        return overlay(tree, laid)


def _find_changes(old: Mapping[str, Any], new: Mapping[str, Any], below: int) -> dict[str, Any]:
    """What differs between two sections whose entries lie so many keys below; empty where nothing does."""
    if below > 1:
        pairs = {key: _find_changes(old.get(key) or {}, new.get(key) or {}, below - 1) for key in {**old, **new}}
        return {key: changed for key, changed in pairs.items() if changed}
    gone: dict[str, Any] = {name: None for name in old if name not in new}
    return gone | {name: entry for name, entry in new.items() if name not in old or old[name] != entry}


def _put(tree: Any, keys: Keys, value: Any) -> Any:
    if not keys:
        return value
    if isinstance(tree, list | tuple):
        return [_put(entry, keys[1:], value) if i == keys[0] else entry for i, entry in enumerate(tree)]
    return {**tree, keys[0]: _put(tree.get(keys[0]), keys[1:], value)}


def _move(tree: Any, place: str, to: str) -> Any:
    """Places are values, or keys of single values; names of entries and their kinds are none."""
    if isinstance(tree, Mapping):
        pairs = ((k, v if k == "kind" else _move(v, place, to)) for k, v in tree.items())
        return {to if k == place and not isinstance(v, Mapping | None) else k: v for k, v in pairs}
    if isinstance(tree, list | tuple):
        return [_move(x, place, to) for x in tree]
    return to if tree == place else tree


def exchange_value(tree: Tree, keys: Keys, text: str) -> Tree:
    """The tree with the value at the end of a way that is there."""
    if not keys:
        return Leaf(text, tree.spot)
    head, rest = keys[0], keys[1:]
    if isinstance(tree, Items):
        entries = (exchange_value(e, rest, text) if i == head else e for i, e in enumerate(tree.entries))
        return Items(tuple(entries), tree.spot)
    assert isinstance(tree, Branch) and isinstance(head, str)
    return Branch({**tree.items, head: exchange_value(tree.items[head], rest, text)}, tree.spot, tree.keys)


def overlay(base: Branch, patch: Branch, complaints: Complaints | None = None) -> Branch:
    """base with patch laid over it. Raises Refused where the patch removes what is not there."""
    collected = complaints or Complaints()
    items, keys = dict(base.items), dict(base.keys)
    for key, child in patch.items.items():
        keys[key] = patch.key_spot(key)
        if depth(key) and isinstance(child, Branch):
            items[key] = _overlay(_branch(items.get(key), child), child, depth(key), key, collected)
        elif not (depth(key) and is_empty(child)):
            items[key] = child
    items.pop("extends", None)
    if complaints is None:
        collected.raise_if_any()
    return Branch(items, patch.spot, keys)


def _branch(below: Tree | None, patch: Branch) -> Branch:
    return below if isinstance(below, Branch) else Branch({}, patch.spot)


def _overlay(base: Branch, patch: Branch, below: int, where: str, complaints: Complaints) -> Branch:
    """The keys of what is removed stay in `keys`, so that a message can say who took it out."""
    items, keys = dict(base.items), dict(base.keys)
    for name, child in patch.items.items():
        keys[name] = patch.key_spot(name)
        if is_empty(child):
            if items.pop(name, None) is None:
                wrong = f"{where}.{name} is removed, and it is not there"
                complaints.refuse(patch.key_spot(name), wrong, likely(name, base.items))
        elif below > 1 and isinstance(child, Branch):
            items[name] = _overlay(_branch(items.get(name), child), child, below - 1, f"{where}.{name}", complaints)
        else:
            items[name] = child
    return Branch(items, base.spot, keys)
