"""Ways to leave something out of a machine file, a mapping or the rows of a recording."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from bench.rigs.case import Table, Tree

FEED = "feed"


def without(section: str, *names: str) -> Callable[[Tree], Tree]:
    """Entries of a section taken out."""
    return lambda tree: {section: dict.fromkeys(names)}


def entries(section: str, **changed: Any) -> Callable[[Tree], Tree]:
    """Entries of a section with others in their place; _ stands for a blank."""
    return lambda tree: {section: {name.replace("_", " "): entry for name, entry in changed.items()}}


def both(*changes: Callable[[Tree], Tree]) -> Callable[[Tree], Tree]:
    """Several changes, each of sections of its own."""
    return lambda tree: {section: entry for change in changes for section, entry in change(tree).items()}


def ours(heading: str) -> str:
    """`T1` of `T1 [degC]`."""
    return heading.partition("[")[0].strip()


def no_column(*names: str) -> Callable[[Tree, Table], Tree]:
    """A mapping that does not read columns of ours."""

    def hide(mapping: Tree, table: Table) -> Tree:
        columns = {theirs: text for theirs, text in mapping["columns"].items() if ours(text) not in names}
        between = {n: how for n, how in mapping.get("between", {}).items() if n not in names}
        rest = {key: value for key, value in mapping.items() if key != "between"}
        return {**rest, "columns": columns, **({"between": between} if between else {})}

    return hide


def swapped(a: str, b: str) -> Callable[[Tree, Table], Tree]:
    """A mapping in which two columns of ours have each other's name."""
    other = {a: b, b: a}

    def hide(mapping: Tree, table: Table) -> Tree:
        columns = {theirs: text.replace(ours(text), other.get(ours(text), ours(text)), 1)
                   for theirs, text in mapping["columns"].items()}  # fmt: skip
        return {**mapping, "columns": columns}

    return hide


def constant(name: str, unit: str) -> Callable[[Tree, Table], Tree]:
    """A mapping that holds an input at the mean of its column, to 0.1."""

    def hide(mapping: Tree, table: Table) -> Tree:
        theirs = next(key for key, text in mapping["columns"].items() if ours(text) == name)
        at = table[0].index(theirs)
        mean = round(float(np.mean([float(row[at]) for row in table[1:]])), 1)
        inputs = {**mapping.get("inputs", {}), name: f"{mean} {unit}"}
        return {**no_column(name)(mapping, table), "inputs": inputs}

    return hide


def another_column(theirs: str, heading: str) -> Callable[[Tree, Table], Tree]:
    """A mapping that reads a further column."""
    return lambda mapping, table: {**mapping, "columns": {**mapping["columns"], theirs: heading}}


def stop(table: Table, driver: str) -> tuple[int, int] | None:
    """First row of the standstill between two stretches of motion, and the first after it."""
    at = table[0].index(driver)
    moving = [float(row[at]) != 0 for row in table[1:]]
    ends = [i for i in range(1, len(moving)) if moving[i - 1] and not moving[i]]
    begins = [i for i in range(1, len(moving)) if moving[i] and not moving[i - 1]]
    later = [i for i in begins if ends and i > ends[0]]
    return (ends[0] + 1, later[0] + 1) if later else None


def without_stop(driver: str, *columns: str) -> Callable[[Table], Table]:
    """Rows in which inputs go on through the standstill as they were before it."""

    def hide(table: Table) -> Table:
        found = stop(table, driver)
        if found is None:
            return table
        changed = [list(row) for row in table]
        for row in changed[found[0] : found[1]]:
            for at in (table[0].index(name) for name in columns):
                row[at] = table[found[0] - 1][at]
        return changed

    return hide


def of_the_feed(tree: Tree) -> tuple[str, ...]:
    """Sources that the feed drives, or that are named so."""
    return tuple(name for name, entry in tree["sources"].items() if is_of_the_feed(name, entry))


def is_of_the_feed(name: str, entry: Tree) -> bool:
    return FEED in (entry.get("with"), entry.get("input")) or FEED in name.lower().split()


def heated(tree: Tree, names: Iterable[str]) -> frozenset[str]:
    """Nodes into which sources go."""
    return frozenset(place.partition("@")[0] for name in names for place in tree["sources"][name]["into"])


def first_path(tree: Tree, axis: str) -> str:
    """The first of an axis's expansions that stretches."""
    found: str = next(name for name, entry in tree["tcp"][axis].items() if entry["kind"] == "stretching")
    return found
