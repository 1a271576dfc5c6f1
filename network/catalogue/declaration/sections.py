"""The sections of a machine file, and the shape each has."""

from __future__ import annotations

from network.platform.refusal import Complaints, likely, short
from network.platform.yaml.tree import Branch, Leaf, Tree

NAMED = ("nodes", "links", "sources", "sensors", "materials", "levels")
"""Sections of entries by name."""
TCP = "tcp"
"""The section of entries by axis and name."""
CALIBRATED = "calibrated"
"""The section that says how far a calibration holds."""
SECTIONS = ("machine", "reference", "extends", "closed_form", *NAMED, TCP, CALIBRATED)
_MAPPINGS = (*NAMED, TCP, "closed_form", CALIBRATED)
_ONLY_IN_LEVELS = ("lumps", "merge")


def depth(section: str) -> int:
    """How many keys of a section lead to an entry; 0 where the section itself is exchanged as a whole."""
    return 2 if section == TCP else 1 if section in NAMED else 0


def is_empty(tree: Tree | None) -> bool:
    """Nothing, or a null; `{}` is not empty, it stands for a massless node."""
    return tree is None or (isinstance(tree, Leaf) and tree.is_null)


def section(tree: Branch, name: str) -> Branch:
    """A section of a machine file, empty where it is not given."""
    found = tree.items.get(name)
    return found if isinstance(found, Branch) else Branch({}, tree.spot)


def check_sections(tree: Branch, complaints: Complaints) -> None:
    """Every section is known and has the right shape."""
    for key, child in tree.items.items():
        if key not in SECTIONS:
            complaints.refuse(tree.key_spot(key), f"unknown section '{short(key)}'", likely(key, SECTIONS))
        elif key in _MAPPINGS and not isinstance(child, Branch) and not is_empty(child):
            complaints.refuse(child.spot, f"section '{key}' is not a mapping", "write `name: {…}` lines below it")
        elif isinstance(child, Branch) and key == TCP:
            _check_axes(child, complaints)
        elif isinstance(child, Branch) and key == "levels":
            _check_levels(child, complaints)


def as_meant(tree: Branch, complaints: Complaints) -> Branch:
    """The tree with each misspelt section, which has been told, under the name that is likely meant and not given: what
    stands in it counts as there."""
    meant = {key: name for key in tree.items for name in SECTIONS if _means(key, name) and name not in tree.items}
    if not meant:
        return tree
    items = {meant.get(key, key): child for key, child in tree.items.items()}
    renamed = Branch(items, tree.spot, {meant.get(key, key): spot for key, spot in tree.keys.items()})
    check_sections(renamed, complaints)
    return renamed


def _means(key: str, name: str) -> bool:
    return key not in SECTIONS and likely(key, SECTIONS) == f"did you mean '{name}'?"


def _check_axes(tcp: Branch, complaints: Complaints) -> None:
    for axis, entries in tcp.items.items():
        if not isinstance(entries, Branch) and not is_empty(entries):
            complaints.refuse(entries.spot, f"{TCP}.{axis} is not a mapping", "write `name: {kind: …}` lines below it")


def _check_levels(levels: Branch, complaints: Complaints) -> None:
    known = [*_ONLY_IN_LEVELS, *(key for key in SECTIONS if key not in ("extends", "levels", CALIBRATED))]
    for name, level in levels.items.items():
        if isinstance(level, Branch):
            for key in (key for key in level.items if key not in known):
                wrong = f"levels.{name} has an unknown key '{short(key)}'"
                complaints.refuse(level.key_spot(key), wrong, likely(key, known))
        elif not is_empty(level):
            complaints.refuse(level.spot, f"levels.{name} is not a mapping", "write `{lumps: 1}` or `{merge: {…}}`")
