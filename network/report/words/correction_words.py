"""A correction in words: what it is made of, and what it loses."""

from __future__ import annotations

from typing import TYPE_CHECKING

from network.engine.trajectory import axis_unit
from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import digits, table
from network.platform.quantities.units import unit

if TYPE_CHECKING:
    from network.analysis.correction.correction import Correction


def tell_correction(correction: Correction) -> str:
    """States, inputs and sensors; the table of losses; what is left to say."""
    f = correction.filter
    sensors = f"corrected by {', '.join(f.sensors)}" if f.sensors else "without sensors"
    lines = [
        f"{correction.machine.name}: {f.states} of {correction.full} states, a step every {f.step:g} s, from "
        f"{', '.join(f.inputs) or 'no input'}, {sensors}; {f.multiplications} multiplications a step"
    ]
    header = ["lost against the full model, at most", *(f"{a} [{pretty(axis_unit(a))}]" for a in f.axes)]
    rows = [[loss.run, *(digits(unit(axis_unit(a)).from_si(v), 3) for a, v in loss.by_axis.items())]
            for loss in correction.losses]  # fmt: skip
    lines += ["", *(table(header, rows, header[1:]) if rows else ["No run was given: what it loses is not told."])]
    if len(correction.by_states) > 1:
        told = ", ".join(f"{n}: {digits(1e6 * lost, 3)}" for n, lost in correction.by_states.items())
        lines.append(f"Lost by number of states [µm]: {told}.")
    return "\n".join([*lines, *correction.notes])
