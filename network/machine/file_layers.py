"""A machine file on disk: what it extends is laid under it, and the files it is made of."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from network.catalogue.declaration.patch import Patch, overlay
from network.catalogue.declaration.sections import NAMED, as_meant, check_sections
from network.platform.refusal import Complaints, Refused, Spot, refuse, short
from network.platform.yaml.document import Branch, Leaf, Tree, load

RECORDED = (".csv", ".xlsx")
OTHERS = {"scenario": "a scenario", "recording": "the mapping of a recording"}
RIGHT = "a machine file is needed here; it stands before scenarios and recordings"


def load_tree(path: Path, complaints: Complaints | None = None) -> Branch:
    """The file with everything it extends laid under it. Raises Refused for circles and unreadable files.

    With `complaints`, what leaves the rest readable goes there instead.
    """
    collected = complaints or Complaints()
    layers: list[Branch] = []
    try:
        layers.extend(_chain(path, collected))
    except Refused as refused:
        collected.absorb(refused)
        raise Refused(collected.refusals) from None
    for layer in layers:
        check_sections(layer, collected)
    layers = [as_meant(layer, collected) for layer in layers]
    tree = layers.pop()
    while layers:
        tree = overlay(tree, layers.pop(), collected)
    if complaints is None:
        collected.raise_if_any()
    return tree


def _chain(path: Path, complaints: Complaints) -> Iterator[Branch]:
    """The file, the one it extends, and so on."""
    above: list[Path] = []
    while True:
        tree = _load_machine(path, complaints)
        above.append(path.resolve())
        yield tree
        base = tree.items.get("extends")
        if base is None:
            return
        path = _find_base(path, base, above)


def _load_machine(path: Path, complaints: Complaints) -> Branch:
    """One file; where it is no machine at all, that is told instead of everything that it lacks."""
    if path.suffix.lower() in RECORDED and os.path.isfile(path):
        raise refuse(Spot(str(path), 1), "is a recording", RIGHT)
    tree = load(path, "a machine file", complaints)
    for key, what in OTHERS.items():
        if key in tree.items and not set(tree.items) & {*NAMED, "machine", "extends"}:
            raise refuse(Spot(str(path), 1), f"is {what}", RIGHT)
    return tree


def _find_base(path: Path, base: Tree, above: list[Path]) -> Path:
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


def is_made_of(file: str, target: Path) -> bool:
    """Whether the machine of a file is made of another: of the file itself, or of one that it extends."""
    path = Path(file)
    while path.is_file():
        if path.resolve() == target.resolve():
            return True
        above = load(path, "a machine file").items.get("extends")
        if not isinstance(above, Leaf):
            return False
        path = path.parent / above.text
    return False


def patch_from(file: str, tree: Branch, folder: Path) -> tuple[str, Patch] | None:
    """How a machine that was changed stands in a folder: the path from there to its file, and the patch over that file.
    None where the file cannot be read: then it has to be written whole."""
    try:
        base = load_tree(Path(file))
    except Refused:
        return None
    beside = os.path.relpath(Path(file).resolve(), folder.resolve())
    return Path(beside).as_posix(), Patch.difference(base, tree)
