"""What the recordings of a case bring to proposals: how long they are, and powers that heat nothing in the machine."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from network.analysis.diagnosis.candidates.candidates import kinds
from network.catalogue.declaration.fields import Amount, InputField
from network.catalogue.declaration.proposals import Runs
from network.machine.machine import Machine
from network.platform.quantities.units import unit
from network.recordings.recording import Recording

ANSWERS = ("um", "urad")
"""Units of columns that answer to the machine and do not drive it, unless something reads them."""
RESPONSES = ("W", "degC", *ANSWERS)
"""Units of columns that are proposed otherwise, as powers, or that answer to the machine."""


def list_driving_columns(machine: Machine, recordings: Sequence[Recording]) -> tuple[str, ...]:
    """Columns and constants of all recordings that may drive something: what the machine or a kind reads, and all that
    is neither a channel of the machine nor a displacement, whose every sample would pass for a step of an input."""
    shared = set.intersection(*({*r.columns, *r.constants} for r in recordings)) - {*machine.sensors}
    units = {name: column.unit for r in recordings for name, column in r.columns.items()}
    answers = {n for n in shared if n in units and any(_is(units[n], each) for each in ANSWERS)}
    return tuple(sorted(shared - (answers - {*machine.inputs, *_list_usual_inputs()})))


def gather_runs(machine: Machine, recordings: Sequence[Recording], drivers: Iterable[str]) -> Runs:
    """drivers: columns that all recordings have and no channel of the machine is."""
    usual, drivers = {*_list_usual_inputs()}, [*drivers]
    found = {n: most for n in drivers if n not in usual and (most := _find_most(n, recordings)) is not None}
    heating = {n for source in machine.sources.values() for n in source.needs()}
    powers = {n: most for n, most in found.items() if _is(most.unit, "W") and n not in heating}
    others = {n: most for n, most in found.items() if not any(_is(most.unit, each) for each in RESPONSES)}
    longest = max(float(np.ptp(r.t)) for r in recordings)
    return Runs(longest, min(float(np.median(np.diff(r.t))) for r in recordings), powers, others,
                frozenset(n for n in drivers if _is_steady(n, recordings)))  # fmt: skip


def _is(text: str, other: str) -> bool:
    return bool(unit(text).dimension == unit(other).dimension)


def _list_usual_inputs() -> Iterator[str]:
    """Inputs that a kind reads where no other is named: it is proposed for them anyway."""
    for kind in kinds():
        yield from (str(f.default) for f in kind.fields.values() if isinstance(f, InputField) and f.default is not None)


def _is_steady(name: str, recordings: Sequence[Recording]) -> bool:
    """Whether an input is the same all along all recordings: what follows it cannot be told from what is constant."""
    columns = [r.columns[name].values for r in recordings if name in r.columns]
    values = np.concatenate(columns) if columns else np.zeros(0)
    return len(columns) == len(recordings) and len({*values.tolist()}) == 1


def _find_most(name: str, recordings: Sequence[Recording]) -> Amount | None:
    """The largest size of a column that varies; None where it is none."""
    columns = [r.columns[name] for r in recordings if name in r.columns]
    if len(columns) < len(recordings) or len({unit(c.unit).dimension for c in columns}) > 1:
        return None
    values = np.concatenate([c.values for c in columns])
    values = values[np.isfinite(values)]
    if not len(values) or not np.ptp(values):
        return None
    return Amount(float(np.abs(values).max()), columns[0].unit)
