"""Patches: a mapping of a machine file's shape, laid over another. `extends:`, `--set`, levels and findings are patches.

An entry given in the patch replaces the whole entry of that name (in `tcp`: of that axis and name); null removes it.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import yaml

from network.refusal import Complaints, Spot, likely, refuse
from network.yamlfile import Branch, Items, Leaf, Tree, load, tree_of

NAMED = ("nodes", "links", "sources", "sensors", "materials", "levels")
SECTIONS = ("machine", "reference", "extends", "closed_form", *NAMED, "tcp")


def load_tree(path: Path, above: Sequence[Path] = ()) -> Branch:
    """The file with everything it extends laid under it. Raises Refused for circles and unreadable files."""
    real = path.resolve()
    if real in above:
        circle = " → ".join(p.name for p in (*above[list(above).index(real) :], real))
        raise refuse(Spot(str(path)), f"extends itself: {circle}", "take one `extends:` out")
    tree = load(path, "a machine file")
    complaints = Complaints()
    check_sections(tree, complaints)
    complaints.raise_if_any()
    base = tree.items.get("extends")
    if base is None:
        return tree
    if not isinstance(base, Leaf) or base.is_null:
        raise refuse(base.spot, "extends is not a file name", "write `extends: other.yaml`")
    below = path.parent / base.text
    if not below.is_file():
        raise refuse(base.spot, f"extends '{base.text}', and there is no such file", f"give a path from {path.parent}")
    return merged(load_tree(below, (*above, real)), tree)


def check_sections(tree: Branch, complaints: Complaints) -> None:
    for key, child in tree.items.items():
        if key not in SECTIONS:
            complaints.refuse(tree.key_spot(key), f"unknown section '{key}'", likely(key, SECTIONS))
        elif key in (*NAMED, "tcp", "closed_form") and not isinstance(child, Branch) and not _is_empty(child):
            complaints.refuse(child.spot, f"section '{key}' is not a mapping", "write `name: {…}` lines below it")


def _is_empty(tree: Tree) -> bool:
    return isinstance(tree, Leaf) and tree.is_null


def merged(base: Branch, patch: Branch) -> Branch:
    """base with patch laid over it. Raises Refused where the patch removes what is not there."""
    items, keys = dict(base.items), dict(base.keys)
    complaints = Complaints()
    for key, child in patch.items.items():
        keys[key] = patch.key_spot(key)
        depth = 2 if key == "tcp" else 1 if key in NAMED else 0
        below = items.get(key)
        if depth and isinstance(child, Branch):
            under = below if isinstance(below, Branch) else Branch({}, child.spot)
            items[key] = _overlay(under, child, depth, key, complaints)
        elif not (depth and _is_empty(child)):
            items[key] = child
    items.pop("extends", None)
    complaints.raise_if_any()
    return Branch(items, patch.spot, keys)


def _overlay(base: Branch, patch: Branch, depth: int, where: str, complaints: Complaints) -> Branch:
    items, keys = dict(base.items), dict(base.keys)
    for name, child in patch.items.items():
        keys[name] = patch.key_spot(name)
        below = items.get(name)
        if _is_empty(child):
            if items.pop(name, None) is None:
                spot = patch.key_spot(name)
                complaints.refuse(spot, f"{where}.{name} is removed but not there", likely(name, base.items))
        elif depth > 1 and isinstance(child, Branch):
            under = below if isinstance(below, Branch) else Branch({}, child.spot)
            items[name] = _overlay(under, child, depth - 1, f"{where}.{name}", complaints)
        else:
            items[name] = child
    return Branch(items, base.spot, keys)


def set_value(tree: Branch, assignment: str) -> Branch:
    """`links.front bearing.conductance=5 W/K` → the tree with that value exchanged (the path as in the file)."""
    path, equals, text = assignment.partition("=")
    spot = Spot(f"--set {assignment}")
    if not equals or not path.strip():
        raise refuse(spot, "is not path=value", "write it like links.skin.conductance=5 W/K")
    return _set(tree, path.strip(), _value(text.strip(), spot), spot, "the machine")


def _value(text: str, spot: Spot) -> Tree:
    if text[:1] in ("[", "{"):
        try:
            return tree_of(yaml.load(text, Loader=yaml.BaseLoader), spot)
        except yaml.YAMLError:
            raise refuse(spot, f"'{text}' is not YAML", "mind brackets and quotes") from None
    return Leaf(text, spot)


def _set(branch: Branch, path: str, value: Tree, spot: Spot, where: str) -> Branch:
    items, keys = dict(branch.items), dict(branch.keys)
    key = max((k for k in items if path == k or path.startswith(k + ".")), key=len, default=None)
    if key is None:
        if "." in path or (where.count(".") == 0 and where == "the machine"):
            raise refuse(spot, f"{where} has no '{path.split('.')[0]}'", likely(path.split(".")[0], items))
        key = path
    rest, child = path[len(key) + 1 :], items.get(key)
    keys[key] = spot
    if rest:
        items[key] = _descend(child, rest, value, spot, key)
    elif isinstance(value, Leaf) and value.is_null:
        items.pop(key, None)
    else:
        items[key] = value
    return Branch(items, branch.spot, keys)


def _descend(child: Tree | None, rest: str, value: Tree, spot: Spot, key: str) -> Tree:
    if isinstance(child, Items):
        head, _, tail = rest.partition(".")
        if not head.isdigit() or int(head) >= len(child.entries):
            raise refuse(spot, f"'{key}' is a list of {len(child.entries)}", f"write {key}.0 for the first")
        entry = child.entries[int(head)]
        new = _descend(entry, tail, value, spot, head) if tail else value
        return Items((*child.entries[: int(head)], new, *child.entries[int(head) + 1 :]), child.spot)
    if not isinstance(child, Branch):
        raise refuse(spot, f"'{key}' is a single value", "give the path of a value")
    return _set(child, rest, value, spot, key)


def set_lumps(tree: Branch, wish: str) -> Branch:
    """`4` for every bar, or `housing=20` for one."""
    name, equals, count = wish.rpartition("=")
    spot = Spot(f"--lumps {wish}")
    nodes = tree.items.get("nodes")
    bars = [n for n, c in nodes.items.items() if isinstance(c, Branch) and "area" in c.items] if isinstance(nodes, Branch) else []
    if equals and name not in bars:
        raise refuse(spot, f"'{name}' is not a bar", likely(name, bars))
    for bar in [name] if equals else bars:
        tree = _set(tree, f"nodes.{bar}.lumps", Leaf(count.strip(), spot), spot, "the machine")
    return tree
