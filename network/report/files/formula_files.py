"""Formulas of temperature as a control takes them, each with its units, and what they lose in a comment above."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from network.analysis.correction.temperature_formula import Formula, FormulaTable
from network.catalogue.expansions.base import LINEAR_AXES
from network.platform.files import write_text
from network.report.files.result_files import as_json, write_table

SIGN = "The movement told is tool minus workpiece. Try the sign: a control that adds it needs it negative."


def write_formulas(table: FormulaTable, form: str, where: Path) -> list[Path]:
    """table.csv, or the text of a control; export.json beside it. Raises Refused where a file cannot be written."""
    data = where / "export.json"
    write_text(data, as_json(table.summary()))
    if form == "table":
        path = where / "table.csv"
        write_table(path, HEADER, list(_rows(table)))
        return [path, data]
    name, comment, lines = FORMS[form]
    path, axes = where / name, [f for f in table.formulas if f.axis in LINEAR_AXES]
    places = {sensor: i for i, sensor in enumerate(table.sensors)}
    text = [*map(comment, _head(table)), "", *(line for k, f in enumerate(axes) for line in lines(f, k, places))]
    write_text(path, "\n".join([*text, ""]))
    return [path, data]


def _head(table: FormulaTable) -> list[str]:
    """What stands above, as comments."""
    lost = []
    for formula in table.formulas:
        pairs = zip(table.runs, formula.lost, formula.uncorrected, strict=True)
        lost += [f"{formula.axis}: {1e6 * left:.3g} of {1e6 * whole:.3g} um are left along {' '.join(run.split())}"
                 for run, left, whole in pairs]  # fmt: skip
    return [f"Thermal correction of {' '.join(table.machine.name.split())}, written by lptn", *lost, SIGN]


R_FIRST, W_FIRST = 10, 486
"""The first R parameter and the first word of the PLC that hold a temperature."""
HEADER = ("axis", "term", "sensor", "value", "unit")


def _rows(table: FormulaTable) -> Iterator[tuple[object, ...]]:
    """One number a row."""
    for f in table.formulas:
        told = f.summary()
        yield f.axis, "offset", "", float(told["offset"]), told["unit"]
        yield from ((f.axis, "per kelvin over the reference", s, float(b), f"{told['unit']}/K")
                    for s, b in zip(f.sensors, told["per_K"], strict=True))  # fmt: skip
        yield f.axis, "reference", "", f.reference, "degC"
        if f.position:
            yield f.axis, "position_0", f.position, 1e3 * f.middle, "mm"
            yield f.axis, "slope", f.position, 1e6 * f.slope, "um/m"
            yield from ((f.axis, "slope per kelvin over the reference", s, 1e6 * d, "um/(m K)")
                        for s, d in zip(f.sensors, f.slope_by_sensor, strict=True))  # fmt: skip


def _straight(constant: float, by_sensor: tuple[float, ...], names: list[str], reference: float, scale: float) -> str:
    """constant + Σ b (T − T_0), all times a scale."""
    pairs = ((scale * b, name) for b, name in zip(by_sensor, names, strict=True))
    terms = [f"{'-' if b < 0 else '+'} {abs(b):.6g} * ({name} - {reference:g})" for b, name in pairs]
    return " ".join([f"{scale * constant:.6g}", *terms])


def _sinumerik(f: Formula, k: int, places: Mapping[str, int]) -> Iterator[str]:
    """K0 [mm], tan β and P0 [mm] by setting data, in synchronised actions; temperatures in R parameters."""
    numbers, axis = [R_FIRST + places[sensor] for sensor in f.sensors], f.axis.upper()
    names = [f"$R{number}" for number in numbers]
    for number, sensor in zip(numbers, f.sensors, strict=True):
        yield f"; R{number}: {_one_line(sensor)} in degC, written by the PLC"
    yield f"; MD32750 $MA_TEMP_COMP_TYPE[{axis}] = {3 if f.position else 1}"
    k0 = _straight(f.offset, f.by_sensor, names, f.reference, 1e3)
    yield f"IDS={2 * k + 1} DO $SA_TEMP_COMP_ABS_VALUE[{axis}] = {k0} ; SD43900, K0 in mm"
    if f.position:
        tan = _straight(f.slope, f.slope_by_sensor, names, f.reference, 1.0)
        yield f"$SA_TEMP_COMP_REF_POSITION[{axis}] = {1e3 * f.middle:.6g} ; SD43920, P0 in mm"
        yield f"IDS={2 * k + 2} DO $SA_TEMP_COMP_SLOPE[{axis}] = {tan} ; SD43910, tan beta"


def _heidenhain(f: Formula, k: int, places: Mapping[str, int]) -> Iterator[str]:
    """A formula over temperatures for the column TEMPCOMP (or MP7530) [mm]; temperatures in words of the PLC."""
    words = [f"W{W_FIRST + 2 * places[sensor]}" for sensor in f.sensors]
    for word, sensor in zip(words, f.sensors, strict=True):
        yield f"; {word}: {_one_line(sensor)} in degC, put there by the PLC"
    yield f"{f.axis.upper()} TEMPCOMP = {_straight(f.offset, f.by_sensor, words, f.reference, 1e3)}"
    if f.position:
        slope = _straight(f.slope, f.slope_by_sensor, words, f.reference, 1e3)
        yield f"; at other positions of {f.axis} add (position - {1e3 * f.middle:.6g} mm) / 1000 times: {slope}"


def _beckhoff(f: Formula, k: int, places: Mapping[str, int]) -> Iterator[str]:
    """P-AXIS-00272 to 00274, in their units, as structured text for the PLC."""
    names, axis = [f"T{places[sensor] + 1}" for sensor in f.sensors], f.axis.upper()
    for name, sensor in zip(names, f.sensors, strict=True):
        yield f"(* {name}: {_one_line(sensor)} in degC *)"
    offset = _straight(f.offset, f.by_sensor, names, f.reference, 1e7)
    slope = _straight(f.slope, f.slope_by_sensor, names, f.reference, 1e6) if f.position else "0.0"
    yield f"{axis}_position_0 := {1e7 * f.middle:.0f}; (* P-AXIS-00272, in 0.1 um *)"
    yield f"{axis}_offset_0 := REAL_TO_DINT({offset}); (* P-AXIS-00273, in 0.1 um *)"
    yield f"{axis}_coefficient := REAL_TO_DINT({slope}); (* P-AXIS-00274, in um/m *)"


def _one_line(name: str) -> str:
    """What may stand in any of their comments."""
    return " ".join(name.split()).replace("*)", "* )").replace("(*", "( *")


FORMS: dict[str, tuple[str, Callable[[str], str], Callable[[Formula, int, Mapping[str, int]], Iterator[str]]]] = {
    "sinumerik": ("correction.spf", lambda line: f"; {line}", _sinumerik),
    "heidenhain": ("correction.txt", lambda line: f"; {line}", _heidenhain),
    "beckhoff": ("correction.st", lambda line: f"(* {_one_line(line)} *)", _beckhoff),
}
"""Form → name of the file, how a comment is written, the lines of an axis. Sinumerik: Function Manual Extended
Functions, K3; Heidenhain: Technical Manual TNC 426/430, 6.5.3; Beckhoff: TF5200 axis parameters."""
