"""What a calibration says of the machine it made: where it holds, what it leaves, and how its numbers are tied.

Section `calibrated` of a machine file: `ranges` of the inputs it was calibrated in, `left` of each axis, `misfit` of
each channel, and `correlation_root`, the rows of L with L Lᵀ the correlation of the numbers, by their paths. L and not
the correlation itself, because a few digits of L keep what numbers tell together far better than each of them. `start`
says that runs began at their first readings, where those calibrated on did so though nobody had said it: later runs are
told by the same rule.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

from network.catalogue.declaration.sections import CALIBRATED, section
from network.catalogue.expansions.base import ANGULAR_AXES, AXES
from network.platform.quantities.units import NUMBER, BadNumber, in_unit, show, unit
from network.platform.refusal import Complaints, likely, short
from network.platform.yaml.tree import Branch, Items, Leaf, Tree

T = TypeVar("T")
KEYS = ("ranges", "left", "misfit", "correlation_root")
START, FIRST_READINGS = "start", "first readings"
DIGITS, LEFT_DIGITS, ROOT_DECIMALS = 6, 3, 4
_RANGE = re.compile(rf"^({NUMBER})\s*\.\.\s*({NUMBER})\s*(.*)$")


@dataclass(frozen=True)
class Range:
    """Smallest and largest value of an input [SI]; unit: shown."""

    low: float
    high: float
    unit: str

    def __str__(self) -> str:
        low, high = (f"{unit(self.unit).from_si(x):.{DIGITS}g}" for x in (self.low, self.high))
        return f"{low}..{high} {self.unit}".removesuffix(" 1").rstrip()


@dataclass(frozen=True)
class Validity:
    """ranges: of the inputs over the runs calibrated on; left: 1σ of what the machine leaves on a run it has not seen,
    by axis [m or rad], of those measured; root: rows of L by the paths of the numbers; misfit: χ and ρ of each channel
    in the runs calibrated on, the rms of what is left in noise and how it lasts from one mean to the next; starts_read:
    whether runs that do not say where they begin do so at their first readings, however near the reference."""

    ranges: Mapping[str, Range]
    left: Mapping[str, float]
    root: Mapping[str, tuple[float, ...]]
    misfit: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    starts_read: bool = False

    def to_plain(self) -> dict[str, Any]:
        """The section as it stands in a file."""
        left = {axis: show(x, left_unit(axis), LEFT_DIGITS) for axis, x in self.left.items()}
        root = {path: [round(x, ROOT_DECIMALS) + 0.0 for x in row] for path, row in self.root.items()}
        misfit = {name: [float(f"{x:.{DIGITS}g}") for x in pair] for name, pair in self.misfit.items()}
        ranges = {name: str(r) for name, r in self.ranges.items()}
        start = {START: FIRST_READINGS} if self.starts_read else {}
        return {**start, "ranges": ranges, "left": left, "misfit": misfit, "correlation_root": root}


def left_unit(axis: str) -> str:
    """What is left of an axis is shown in."""
    return "urad" if axis in ANGULAR_AXES else "um"


def read_validity(tree: Branch, complaints: Complaints) -> Validity | None:
    """The section of a machine file; None where it is not given, or at fault, which is told."""
    branch, own = section(tree, CALIBRATED), Complaints()
    for key in (key for key in branch.items if key not in (START, *KEYS)):
        own.refuse(branch.key_spot(key), f"{CALIBRATED} has an unknown key '{short(key)}'", likely(key, (START, *KEYS)))
    ranges = dict(_read_each(branch, "ranges", _range, own))
    left = dict(_read_each(branch, "left", _left, own))
    misfit = dict(_read_each(branch, "misfit", _misfit, own))
    root = dict(_read_each(branch, "correlation_root", _row, own))
    for count, (path, row) in enumerate(root.items(), start=1):
        if len(row) != count:
            wrong = f"{CALIBRATED}.correlation_root.{path} has {len(row)} numbers, and it is row {count}"
            own.refuse(section(branch, "correlation_root").key_spot(path), wrong, "calibrate again, or take it out")
    starts_read = _read_start(branch, own)
    complaints.refusals.extend(own.refusals)
    return Validity(ranges, left, root, misfit, starts_read) if branch.items and not own.refusals else None


def _read_start(branch: Branch, complaints: Complaints) -> bool:
    held = branch.items.get(START)
    if held is None:
        return False
    if not isinstance(held, Leaf) or held.text.strip() != FIRST_READINGS:
        complaints.refuse(held.spot, f"{CALIBRATED}.{START} is not '{FIRST_READINGS}'", "write that, or take it out")
    return True


def _read_each(
    branch: Branch, key: str, read: Callable[[str, Tree], T], complaints: Complaints
) -> Iterator[tuple[str, T]]:
    held = branch.items.get(key)
    if held is not None and not isinstance(held, Branch):
        complaints.refuse(held.spot, f"{CALIBRATED}.{key} is not a mapping", "calibrate again, or take it out")
    for name, child in section(branch, key).items.items():
        try:
            yield name, read(name, child)
        except BadNumber as error:
            complaints.refuse(child.spot, f"{CALIBRATED}.{key}.{name} {error.wrong}", error.right)


def _text(tree: Tree) -> str:
    if not isinstance(tree, Leaf):
        raise BadNumber("is not a single value", "write it like 0..8000 rpm, or 4.3 um")
    return tree.text.strip()


def _range(name: str, tree: Tree) -> Range:
    match = _RANGE.match(text := _text(tree))
    if match is None:
        raise BadNumber(f"'{short(text)}' is not a range", "write it like 0..8000 rpm")
    low, high = (unit(match[3]).to_si(float(match[i])) for i in (1, 2))
    if not low <= high:
        raise BadNumber(f"'{short(text)}' has its ends the wrong way round", "write the lower one first")
    return Range(low, high, match[3])


def _left(axis: str, tree: Tree) -> float:
    if axis not in AXES:
        raise BadNumber(f"is no axis: '{short(axis)}'", "the axes are " + ", ".join(AXES))
    value = in_unit(_text(tree), left_unit(axis))
    if not value >= 0:
        raise BadNumber(f"'{short(_text(tree))}' is below zero", f"give 1σ in {left_unit(axis)}")
    return value


def _misfit(channel: str, tree: Tree) -> tuple[float, float]:
    if len(pair := _numbers(tree)) != 2 or not (pair[0] >= 0 and 0 <= pair[1] < 1):
        raise BadNumber("is no misfit χ ≥ 0 and its correlation 0 ≤ ρ < 1", "write it like [1.4, 0.9]")
    return pair[0], pair[1]


def _numbers(tree: Tree) -> tuple[float, ...]:
    if not isinstance(tree, Items):
        raise BadNumber("is not a list", "calibrate again, or take it out")
    return tuple(in_unit(_text(x), "1") for x in tree.entries)


def _row(path: str, tree: Tree) -> tuple[float, ...]:
    row = _numbers(tree)
    if not any(row) or any(abs(x) > 1 for x in row):
        raise BadNumber("is no row of a correlation's root", "calibrate again, or take it out")
    return row
