"""Numbers of the file that calibration bent to make up for what was missing, and where they stand with it in."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from network.analysis.diagnosis.settings import SETTINGS
from network.engine.response.parameters import Parameter, free_parameters
from network.platform.quantities.text_table import format_shift
from network.platform.quantities.units import show
from network.platform.wording import join_names

if TYPE_CHECKING:
    from network.analysis.diagnosis.findings.result import Diagnosis
    from network.machine.machine import Machine

FAR, BACK = 2.0, 0.6
"""Prior σ from which a number is bent; share of its shift at most that is left of one that came back."""
MOST = 5


@dataclass(frozen=True)
class Moved:
    """A number: in the file, calibrated as written, calibrated with the findings; shifts in prior σ."""

    path: str
    file: str
    before: str
    after: str
    shift_before: float
    shift_after: float

    @property
    def came_back(self) -> bool:
        return abs(self.shift_before) > FAR and abs(self.shift_after) < BACK * abs(self.shift_before)

    @property
    def is_far(self) -> bool:
        return abs(self.shift_after) > FAR


def list_moved(d: Diagnosis) -> list[Moved]:
    """All uncertain numbers with a prior that both machines still have, the most bent first."""
    return sorted(_all(d), key=lambda m: -max(abs(m.shift_before), abs(m.shift_after)))


def _all(d: Diagnosis) -> Iterator[Moved]:
    for p in free_parameters(d.machine):
        values = [value_at(machine, p) for machine in (d.before, d.after)]
        if p.is_unknown or None in values:
            continue
        before, after = (v for v in values if v is not None)
        file, was, now = (show(v, p.field.unit) for v in (p.value(p.centre), before, after))
        yield Moved(p.path, file, was, now, _shift(p, before), _shift(p, after))


def value_at(machine: Machine, p: Parameter) -> float | None:
    """The number at the path of a parameter [SI]; None where the machine has none there."""
    entry = machine.by_path.get(p.entry)
    names = {f.key: name for name, f in entry.params().items()} if entry is not None else {}
    value = entry.__dict__[names[p.field.key]] if entry is not None and p.field.key in names else None
    return float(value) if isinstance(value, int | float) else None


def _shift(p: Parameter, value: float) -> float:
    if p.is_log and value <= 0:
        return -math.inf
    return ((math.log(value) if p.is_log else value) - p.centre) / p.spread


def strained_words(d: Diagnosis) -> str:
    """Which numbers lie farther from the file than their ± allow; empty where none does."""
    far = [m.path for m in list_moved(d) if abs(m.shift_after) > SETTINGS.errors]
    its = "their" if len(far) > 1 else "its"
    return f"{join_names(_shorten(far))} must lie more than {SETTINGS.errors:g} times {its} ±" if far else ""


def _shorten(told: list[str]) -> list[str]:
    return [*told[:MOST], *([f"{len(told) - MOST} more"] if len(told) > MOST else [])]


def describe_moved(d: Diagnosis) -> Iterator[str]:
    """What came back to the file, and what still lies far from it."""
    numbers = list_moved(d)
    back = [m for m in numbers if m.came_back] if d.findings else []
    if back:
        shifts = [f"{m.path} from {format_shift(m.shift_before)} to {format_shift(m.shift_after)}" for m in back]
        bent = "Numbers that calibration alone had bent come back to the file (shifts in units of their ±)"
        yield f"{bent}: {join_names(_shorten(shifts))}."
    elif d.verdict == "parameters_only":
        shifts = [f"{m.path} ({m.file} → {m.after}, {format_shift(m.shift_after)} times its ±)" for m in numbers[:MOST]]
        yield f"Numbers that moved most from the file (in units of their ±): {join_names(shifts)}."
        return
    far = [f"{m.path} ({m.file} → {m.after}, {format_shift(m.shift_after)} times its ±)" for m in numbers if m.is_far]
    if far:
        yield f"Still far from the file: {join_names(far[:MOST])}{' …' if len(far) > MOST else ''}."
