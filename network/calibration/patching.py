"""A calibrated machine as a patch of its file: value ± standard error for each number, and what options changed."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from network.calibration.parameters import Parameter
from network.machine import Machine
from network.patch import load_tree
from network.refusal import Refused, Spot, refuse
from network.sections import NAMED
from network.units import Number, difference, unit
from network.yamlfile import Branch, Items, Leaf, Tree, dump, load, plain

FILE = "machine.calibrated.yaml"
DIGITS, SPREAD_DIGITS = 6, 3
_ONCE = ("machine", "reference", "closed_form")


def text_of(p: Parameter, value: float, spread: float) -> str:
    """A calibrated number as it stands in a file; spread: 1σ of θ. Rounded where nobody would miss it."""
    given = unit(p.field.unit)
    shown = difference(given) if p.field.unit == "K" else given
    value = shown.to_si(float(f"{shown.from_si(value):.{DIGITS}g}"))
    if p.is_log:
        spread = float(f"{max(spread, 1e-6) * 100:.{SPREAD_DIGITS}g}") / 100
        return str(p.field.write(Number(value, "log", spread)))
    scale = difference(given).scale
    spread = float(f"{max(spread, 1e-12 * scale) / scale:.{SPREAD_DIGITS}g}") * scale
    return str(p.field.write(Number(value, "normal", spread)))


def exchanged(tree: Tree, path: str, text: str) -> Tree:
    """The tree with the value at a path that is there."""
    if not path:
        return Leaf(text, tree.spot)
    if isinstance(tree, Items):
        head, _, rest = path.partition(".")
        entries = list(tree.entries)
        entries[int(head)] = exchanged(entries[int(head)], rest, text)
        return Items(tuple(entries), tree.spot)
    assert isinstance(tree, Branch)
    key = max((k for k in tree.items if path == k or path.startswith(k + ".")), key=len)
    items = {**tree.items, key: exchanged(tree.items[key], path[len(key) + 1 :], text)}
    return Branch(items, tree.spot, tree.keys)


def calibrated(
    machine: Machine, parameters: Iterable[Parameter], theta: Iterable[float], std: Iterable[float]
) -> Machine:
    """The machine with value ± standard error for each number, so that its tree says so, too."""
    tree: Tree = machine.tree
    for p, x, s in zip(parameters, theta, std, strict=True):
        tree = exchanged(tree, p.path, text_of(p, p.value(x), s))
    assert isinstance(tree, Branch)
    return Machine.read(tree, machine.file)


def difference_of(base: Branch, now: Branch) -> dict[str, Any]:
    """The patch that makes `now` of `base`: entries that differ in full, null for those that are gone."""
    patch: dict[str, Any] = {}
    for key in dict.fromkeys([*base.items, *now.items]):
        old, new = plain_at(base, key), plain_at(now, key)
        if key in _ONCE and old != new:
            patch[key] = new
        elif key in NAMED and (changed := _changed(old, new)):
            patch[key] = changed
        elif key == "tcp":
            axes = {
                axis: _changed((old or {}).get(axis), (new or {}).get(axis)) for axis in {**(old or {}), **(new or {})}
            }
            if any(axes.values()):
                patch[key] = {axis: entries for axis, entries in axes.items() if entries}
    return patch


def plain_at(tree: Branch, key: str) -> Any:
    return plain(tree.items[key]) if key in tree.items else None


def _changed(old: Mapping[str, Any] | None, new: Mapping[str, Any] | None) -> dict[str, Any]:
    old, new = old or {}, new or {}
    gone: dict[str, Any] = {name: None for name in old if name not in new}
    return gone | {name: entry for name, entry in new.items() if name not in old or old[name] != entry}


def patch_text(machine: Machine, where: Path, remark: str) -> str:
    """The file of a calibrated machine in a folder: it extends the machine's own file, or is whole where that cannot
    be read."""
    try:
        base = load_tree(Path(machine.file))
    except Refused:
        return f"# {remark}\n{dump(machine.to_plain())}"
    beside = os.path.relpath(Path(machine.file).resolve(), where.resolve())
    return f"# {remark}\n" + dump({"extends": Path(beside).as_posix()} | difference_of(base, machine.tree))


def check_target(machine: Machine, where: Path) -> None:
    """Raises Refused where the result would replace a file that it extends."""
    target, path = (where / FILE).resolve(), Path(machine.file)
    while path.is_file():
        if path.resolve() == target:
            wrong = f"holds {FILE}, and that is a file the machine is made of"
            raise refuse(Spot(str(where)), wrong, "give another -o")
        above = load(path, "a machine file").items.get("extends")
        if not isinstance(above, Leaf):
            return
        path = path.parent / above.text
