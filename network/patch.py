"""Patches: a mapping of a machine file's shape, laid over another. `extends:`, levels and findings are patches.

An entry given in the patch replaces the whole entry of that name (in `tcp`: of that axis and name); null removes it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from network.refusal import Complaints, Refused, likely, refuse, short
from network.sections import NAMED, SECTIONS, as_meant, check_sections, is_empty
from network.settings import set_lumps, set_value
from network.yamlfile import Branch, Leaf, Tree, load

__all__ = ["NAMED", "SECTIONS", "check_sections", "load_tree", "merged", "set_lumps", "set_value"]


def load_tree(path: Path, complaints: Complaints | None = None) -> Branch:
    """The file with everything it extends laid under it. Raises Refused for circles and unreadable files.

    With `complaints`, what leaves the rest readable goes there instead.
    """
    own = complaints or Complaints()
    layers: list[Branch] = []
    try:
        layers.extend(_chain(path, own))
    except Refused as refused:
        own.absorb(refused)
        raise Refused(own.refusals) from None
    for layer in layers:
        check_sections(layer, own)
    layers = [as_meant(layer, own) for layer in layers]
    tree = layers.pop()
    while layers:
        tree = merged(tree, layers.pop(), own)
    if complaints is None:
        own.raise_if_any()
    return tree


def _chain(path: Path, complaints: Complaints) -> Iterator[Branch]:
    """The file, the one it extends, and so on."""
    above: list[Path] = []
    while True:
        tree = load(path, "a machine file", complaints)
        above.append(path.resolve())
        yield tree
        base = tree.items.get("extends")
        if base is None:
            return
        path = _extended(path, base, above)


def _extended(path: Path, base: Tree, above: list[Path]) -> Path:
    if not isinstance(base, Leaf) or base.is_null:
        raise refuse(base.spot, "extends is not a file name", "write `extends: other.yaml`")
    below = path.parent / base.text
    try:
        found, real = below.is_file(), below.resolve()
    except (OSError, ValueError):
        found = False
    if not found:
        wrong = f"extends '{short(base.text)}', and there is no such file"
        raise refuse(base.spot, wrong, f"give its path from {path.parent}")
    if real in above:
        circle = " → ".join(p.name for p in (*above[above.index(real) :], real))
        raise refuse(base.spot, f"extends itself: {circle}", "take one `extends:` out")
    return below


def merged(base: Branch, patch: Branch, complaints: Complaints | None = None) -> Branch:
    """base with patch laid over it. Raises Refused where the patch removes what is not there."""
    own = complaints or Complaints()
    items, keys = dict(base.items), dict(base.keys)
    for key, child in patch.items.items():
        keys[key] = patch.key_spot(key)
        depth = 2 if key == "tcp" else 1 if key in NAMED else 0
        if depth and isinstance(child, Branch):
            items[key] = _overlay(_branch(items.get(key), child), child, depth, key, own)
        elif not (depth and is_empty(child)):
            items[key] = child
    items.pop("extends", None)
    if complaints is None:
        own.raise_if_any()
    return Branch(items, patch.spot, keys)


def _branch(below: Tree | None, patch: Branch) -> Branch:
    return below if isinstance(below, Branch) else Branch({}, patch.spot)


def _overlay(base: Branch, patch: Branch, depth: int, where: str, complaints: Complaints) -> Branch:
    """The keys of what is removed stay in `keys`, so that a message can say who took it out."""
    items, keys = dict(base.items), dict(base.keys)
    for name, child in patch.items.items():
        keys[name] = patch.key_spot(name)
        if is_empty(child):
            if items.pop(name, None) is None:
                wrong = f"{where}.{name} is removed, and it is not there"
                complaints.refuse(patch.key_spot(name), wrong, likely(name, base.items))
        elif depth > 1 and isinstance(child, Branch):
            items[name] = _overlay(_branch(items.get(name), child), child, depth - 1, f"{where}.{name}", complaints)
        else:
            items[name] = child
    return Branch(items, base.spot, keys)
