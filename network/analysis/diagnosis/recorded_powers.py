"""What the recordings of a case bring to proposals: how long they are, and powers that nothing in the machine reads."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from network.analysis.diagnosis.candidates import kinds
from network.catalogue.declaration.fields import Amount, InputField
from network.catalogue.declaration.proposals import Runs
from network.machine.machine import Machine
from network.platform.quantities.units import unit
from network.recordings.recording import Recording


def gather_runs(machine: Machine, recordings: Sequence[Recording], drivers: Iterable[str]) -> Runs:
    """drivers: columns that all recordings have and no channel of the machine is."""
    unread = [name for name in drivers if name not in {*machine.inputs, *_list_usual_inputs()}]
    most = {name: amount for name in unread if (amount := _find_most(name, recordings)) is not None}
    return Runs(max(float(np.ptp(r.t)) for r in recordings), most)


def _list_usual_inputs() -> Iterator[str]:
    """Inputs that a kind reads where no other is named: it is proposed for them anyway."""
    for kind in kinds():
        yield from (str(f.default) for f in kind.fields.values() if isinstance(f, InputField) and f.default is not None)


def _find_most(name: str, recordings: Sequence[Recording]) -> Amount | None:
    """The largest value of a recorded power that varies; None where it is none."""
    columns = [r.columns[name] for r in recordings if name in r.columns]
    if len(columns) < len(recordings) or any(unit(c.unit).dimension != unit("W").dimension for c in columns):
        return None
    values = np.concatenate([c.values for c in columns])
    values = values[np.isfinite(values)]
    if not len(values) or not np.ptp(values):
        return None
    return Amount(float(np.abs(values).max()), columns[0].unit)
