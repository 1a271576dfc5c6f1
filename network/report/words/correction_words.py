"""A correction in words: what it is made of, and what it loses."""

from __future__ import annotations

from typing import TYPE_CHECKING

from network.engine.trajectory import ROUNDING, axis_unit
from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import digits, table
from network.platform.quantities.units import unit
from network.report.words.lump_words import tell_cut

if TYPE_CHECKING:
    from network.analysis.correction.correction import Correction
    from network.analysis.correction.temperature_formula import Formula, FormulaTable


def tell_correction(correction: Correction) -> str:
    """States, inputs and sensors; the table of losses; what is left to say."""
    f = correction.filter
    sensors = f"corrected by {', '.join(f.sensors)}" if f.sensors else "without sensors"
    lines = [
        f"{correction.machine.name}: {f.own} of {correction.full} states and {len(f.unknown)} for unknown heat, "
        f"a step every {f.step:g} s, from {', '.join(f.inputs) or 'no input'}, {sensors}; "
        f"{f.multiplications} multiplications a step"
    ]
    header = ["lost against the full model, at most", *(f"{a} [{pretty(axis_unit(a))}]" for a in f.axes)]
    rows = [[loss.run, *(digits(unit(axis_unit(a)).from_si(v), 3) for a, v in loss.by_axis.items())]
            for loss in correction.losses]  # fmt: skip
    lines += ["", *(table(header, rows, header[1:]) if rows else ["No run was given: what it loses is not told."])]
    if len(correction.by_states) > 1:
        told = ", ".join(f"{n}: {digits(1e6 * lost, 3)}" for n, lost in correction.by_states.items())
        lines.append(f"Lost by number of states [µm]: {told}.")
    return "\n".join([*lines, *correction.notes, *tell_cut(correction.lumping)])


def tell_formulas(of: FormulaTable) -> str:
    """Two numbers an axis, and what they leave."""
    lines = [f"{of.machine.name}: an offset and so much per kelvin, for every axis", ""]
    names = [f"run {k + 1}" for k in range(len(of.runs))]
    header = ["axis", "from", "offset", "per kelvin", *(f"left, {name}" for name in names)]
    lines += table(header, [_formula_row(f) for f in of.formulas], header[2:])
    lines += [f"{name}: {run}" for name, run in zip(names, of.runs, strict=True)]
    for f in of.formulas:
        if f.position:
            per_K = ", ".join(f"{1e6 * d:+.3g} per K of {s}" for d, s in zip(f.slope_by_sensor, f.sensors, strict=True))
            lines.append(f"{f.axis} by {f.position}: {1e6 * f.slope:.3g} µm/m ({per_K}) about {1e3 * f.middle:.4g} mm")
    return "\n".join([*lines, *tell_cut(of.lumping)])


def _formula_row(f: Formula) -> list[str]:
    shown = unit(axis_unit(f.axis))
    per_K = ", ".join(f"{shown.from_si(b):+.3g}" for b in f.by_sensor)
    lost, offset = [v if v >= ROUNDING else 0.0 for v in f.lost], f.offset if abs(f.offset) >= ROUNDING else 0.0
    left = [f"{digits(shown.from_si(v), 3)} of {digits(shown.from_si(w), 3)}"
            for v, w in zip(lost, f.uncorrected, strict=True)]  # fmt: skip
    return [f"{f.axis} [{pretty(shown.text)}]", ", ".join(f.sensors), digits(shown.from_si(offset), 3), per_K, *left]
