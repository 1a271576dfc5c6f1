"""What the command line exchanges in a machine: `--set path=value` and `--lumps`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from network.catalogue.declaration.sections import SECTIONS, depth, section
from network.platform.quantities.units import BadNumber, split_number, spread_parts, unit
from network.platform.refusal import Refused, Spot, likely, refuse, short
from network.platform.yaml.document import Branch, Items, Leaf, Tree, parse

AUTO = "auto"
"""What is wished of lumps where they are to be chosen along a schedule."""
KINDED = ("links", "sources", "tcp")
"""Sections whose entries name their kind."""
_SECTIONS = tuple(name for name in SECTIONS if name != "extends")


def set_value(tree: Branch, assignment: str) -> Branch:
    """`links.front bearing.conductance=5 W/K` → the tree with that value exchanged (the path as in the file).

    A value of null takes out what is there. Raises Refused for a path that leads nowhere.
    """
    path, equals, text = assignment.partition("=")
    spot = Spot(f"--set {short(assignment)}")
    if not equals or not path.strip() or not text.strip():
        raise refuse(spot, "is not path=value", "write it like links.skin.conductance=5 W/K")
    return _set(tree, path.strip(), _value(text.strip(), spot), spot, "")


def _value(text: str, spot: Spot) -> Tree:
    if text[:1] not in ("[", "{"):
        return Leaf(text, spot)
    try:
        return parse(text, spot)
    except Refused as refused:
        raise refuse(spot, f"'{short(text)}' is not YAML ({refused.refusals[0].wrong})", "mind the brackets") from None


def _set(branch: Branch, path: str, value: Tree, spot: Spot, where: str) -> Branch:
    items, keys = dict(branch.items), dict(branch.keys)
    key = _first_key(branch, path, spot, where)
    rest, here = path[len(key) + 1 :], f"{where}.{key}".lstrip(".")
    if rest:
        items[key] = _descend(items.get(key, Branch({}, spot)), rest, value, spot, here)
        if "." in where:
            keys[key] = spot
        return Branch(items, branch.spot, keys)
    _refuse_single(items.get(key), value, spot, here)
    keys[key] = spot
    if not (isinstance(value, Leaf) and value.is_null):
        items[key] = value
    elif items.pop(key, None) is None:
        raise refuse(spot, f"takes out {here}, and it is not there", likely(key, items))
    return Branch(items, branch.spot, keys)


def _refuse_single(there: Tree | None, value: Tree, spot: Spot, here: str) -> None:
    """Refuses one value in the place of a whole entry, with the numbers of it that are of that kind."""
    if not isinstance(there, Branch) or not isinstance(value, Leaf) or value.is_null or not there.items:
        return
    alike = [key for key, own in there.items.items() if isinstance(own, Leaf) and _kind(own) == _kind(value)]
    names = [f"{here}.{key}" for key in (alike or there.items) if key != "kind"]
    right = f"did you mean {names[0]}={short(value.text)}?" if len(alike) == 1 else f"name one of {', '.join(names)}"
    raise refuse(spot, f"{here} holds more than one value", right)


def _kind(leaf: Leaf) -> str | None:
    """The dimension of a number; None for what is none."""
    try:
        return unit(split_number(spread_parts(leaf.text)[0])[1]).dimension
    except BadNumber:
        return None


def _first_key(branch: Branch, path: str, spot: Spot, where: str) -> str:
    """The longest key that the path begins with, else a new one where there may be one."""
    there = [key for key in branch.items if path == key or path.startswith(key + ".")]
    if there:
        return max(there, key=len)
    head = path.partition(".")[0]
    if (not where and head in _SECTIONS) or (depth(where) > 1 and "." in path):
        return head
    if where and "." not in path:
        return path
    known = branch.items if where else [*branch.items, *(s for s in _SECTIONS if s not in branch.items)]
    raise refuse(spot, f"{where or 'the machine'} has no '{short(head)}'", likely(head, known))


def _descend(child: Tree, rest: str, value: Tree, spot: Spot, where: str) -> Tree:
    if isinstance(child, Branch):
        return _set(child, rest, value, spot, where)
    if isinstance(child, Leaf):
        raise refuse(spot, f"{where} is a single value", f"write {where}=value")
    head, _, tail = rest.partition(".")
    if not re.fullmatch("[0-9]{1,6}", head) or int(head) >= len(child.entries):
        raise refuse(spot, f"{where} is a list of {len(child.entries)}", f"write {where}.0 for the first")
    i = int(head)
    new = _descend(child.entries[i], tail, value, spot, f"{where}.{head}") if tail else value
    return Items((*child.entries[:i], new, *child.entries[i + 1 :]), child.spot)


def part_numbers(patch: Mapping[str, Any], tree: Branch) -> tuple[dict[str, Any], list[tuple[str, Any]]]:
    """(what replaces whole entries, (path, value) of what is exchanged in one) of a patch from Python. A path has dots;
    an entry that is there and is given without its kind is no whole one."""
    whole: dict[str, Any] = {}
    numbers: list[tuple[str, Any]] = []
    for name, given in patch.items():
        if "." in name:
            numbers.append((name, given))
        elif name in KINDED and isinstance(given, Mapping):
            kept = _part_section(name, given, section(tree, name), depth(name), numbers)
            whole |= {name: kept} if kept or not given else {}
        else:
            whole[name] = given
    return whole, numbers


def _part_section(
    where: str, given: Mapping[str, Any], there: Branch, below: int, numbers: list[tuple[str, Any]]
) -> dict[str, Any]:
    kept: dict[str, Any] = {}
    for name, entry in given.items():
        old = there.items.get(name)
        if below > 1 and isinstance(entry, Mapping) and isinstance(old, Branch):
            inner = _part_section(f"{where}.{name}", entry, old, below - 1, numbers)
            kept |= {name: inner} if inner or not entry else {}
        elif below == 1 and isinstance(entry, Mapping) and entry and isinstance(old, Branch) and "kind" not in entry:
            numbers += [(f"{where}.{name}.{key}", "null" if value is None else value) for key, value in entry.items()]
        else:
            kept[name] = entry
    return kept


def set_lumps(tree: Branch, wish: str, spot: Spot | None = None) -> Branch:
    """`4` for every bar, or `housing=20` for one; `spot` says where that is wished."""
    name, equals, count = (part.strip() for part in wish.rpartition("="))
    spot = spot or Spot(f"--lumps {short(wish)}")
    bars = _bars(tree)
    if is_auto(wish):
        right = "in Python choose_lumps(machine, scenario).machine has them, on the command line --lumps auto"
        raise refuse(spot, f"'{short(wish)}' needs a schedule to choose lumps by", right)
    if equals and name not in bars:
        raise refuse(spot, f"'{short(name)}' is not a bar", likely(name, bars))
    if not re.fullmatch("[1-9][0-9]{0,8}", count):
        raise refuse(spot, f"'{short(count)}' is not a number of lumps", "write N or node=N, N a whole number from 1")
    for bar in [name] if equals else bars:
        tree = _set(tree, f"nodes.{bar}.lumps", Leaf(count, spot), spot, "")
    return tree


def is_auto(wish: str) -> bool:
    """`auto`, or with a tolerance `auto:1 %`."""
    return wish.strip().partition(":")[0].strip() == AUTO


def _bars(tree: Branch) -> list[str]:
    nodes = section(tree, "nodes").items
    return [name for name, child in nodes.items() if isinstance(child, Branch) and "area" in child.items]
