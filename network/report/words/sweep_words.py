"""What a sweep says of itself in the terminal: its table, what the closed form found, whether a tolerance is kept."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from network.analysis.sweep.level_runs import PAPER, WRITTEN
from network.catalogue.expansions.base import ANGULAR_AXES
from network.engine.trajectory import axis_unit
from network.machine.overrides import AUTO
from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import digits, table
from network.platform.quantities.units import unit
from network.platform.wording import join_names

if TYPE_CHECKING:
    from network.analysis.sweep.level_runs import LevelRun
    from network.analysis.sweep.sweep import Sweep
    from network.engine.paper.closed_form import ClosedForm, Law

MOST_LAWS = 4
SURELY = 0.8
"""Share of a time from which one that is shorter is not told: medians of three solutions scatter by a fifth."""


def tell_sweep(sweep: Sweep) -> str:
    lines = [*_tell_runs(sweep)] if sweep.runs else [*_tell_levels(sweep)]
    return "\n".join(lines)


# -- levels ---------------------------------------------------------------------------------------------------------
def _tell_levels(sweep: Sweep) -> Iterator[str]:
    finest = sweep.finest
    told = f"{len(sweep.levels)} levels; Δ is the difference to {_name_run(finest)} ({finest.lumps} lumps in all)"
    yield f"{sweep.machine.name}: {sweep.source}, {told}"
    columns, rows = level_table(sweep)
    header = [column.shown for column in columns]
    yield from table(header, [[_cell(value) for value in row] for row in rows], header[1:])
    for run in sweep.levels:
        if run.closed_form is not None:
            yield ""
            yield from _tell_closed_form(run.closed_form)
    if sweep.tolerance is not None:
        yield ""
        yield tell_tolerance(sweep)
    yield from tell_convergence(sweep)


def tell_convergence(sweep: Sweep) -> Iterator[str]:
    """What the finest level is off itself, and where temperatures differ most."""
    places = dict.fromkeys(place for run in sweep.levels if (place := sweep.furthest_temperature(run)))
    if places:
        yield f"ΔT max is that of {join_names(list(places))}."
    if sweep.beyond is None:
        return
    most = {axis: sweep.gap(sweep.beyond, axis) for axis in sweep.finest.tcp}
    told = [
        f"{axis} by {_cell(gap.largest / unit(axis_unit(axis)).scale)} {pretty(axis_unit(axis))}"
        for axis, gap in most.items()
        if gap is not None
    ]
    if told:
        name = _name_run(sweep.finest)
        yield f"{name[0].upper()}{name[1:]}: twice as many would change {join_names(told)} at most."


@dataclass(frozen=True)
class Heading:
    """Name and unit of a column; empty for a column without."""

    name: str
    unit: str = ""

    @property
    def shown(self) -> str:
        return f"{self.name} [{pretty(self.unit)}]" if self.unit else self.name

    def __str__(self) -> str:
        return f"{self.name} [{self.unit}]" if self.unit else self.name


def level_table(sweep: Sweep) -> tuple[list[Heading], list[list[str | int | float | None]]]:
    """The table of levels: headings, and rows of plain values, None where there is none; empty columns are left out."""
    headings = [Heading("level"), Heading("lumps")]
    for axis in sweep.finest.tcp:
        headings += [Heading(f"Δ{axis} {what}", axis_unit(axis)) for what in ("max", "rms")]
    headings += [Heading("ΔT max", "K"), Heading("rmse", "σ"), Heading("TCP rmse", "σ"), Heading("solve", "ms")]
    rows = [[run.level, run.lumps, *_list_gaps(sweep, run), *_others(sweep, run)] for run in sweep.levels]
    kept = [k for k in range(len(headings)) if any(row[k] is not None for row in rows)]
    return [headings[k] for k in kept], [[row[k] for k in kept] for row in rows]


def _list_gaps(sweep: Sweep, run: LevelRun) -> Iterator[float | None]:
    for axis in sweep.finest.tcp:
        gap, scale = sweep.gap(run, axis), unit(axis_unit(axis)).scale
        yield from (gap.largest / scale, gap.rms / scale) if gap else (None, None)


def _others(sweep: Sweep, run: LevelRun) -> Iterator[float | None]:
    yield sweep.temperature_gap(run)
    yield from (None if math.isnan(value) else value for value in (run.in_noise, run.tcp_in_noise))
    yield run.solve_seconds * 1e3


def _cell(value: str | int | float | None) -> str:
    if isinstance(value, float):
        return digits(value, 3) if abs(value) >= 1e-9 else "0"
    return "–" if value is None else str(value)


def _name_run(run: LevelRun) -> str:
    if run.level == PAPER:
        return "the paper's closed form"
    if run.level in (WRITTEN, AUTO):
        return "the file as written" if run.level == WRITTEN else "lumps chosen per bar"
    return f"{lumps_of(run.level)} in every bar" if run.level.isdigit() else f"'{run.level}'"


def tell_tolerance(sweep: Sweep) -> str:
    """Which is the coarsest level that stays within the tolerance, or that none does."""
    assert sweep.tolerance is not None
    finest, within, text = sweep.finest, sweep.coarsest_within, pretty_quantity(sweep.tolerance.text)
    if within is not None:
        stays = "stay" if within.level.isdigit() and within.level != "1" else "stays"
        name = _short(within)[0].upper() + _short(within)[1:]
        told = f"{_gaps(sweep, within)}{_gain(within, finest)}"
        return f"{name} {stays} within {text} of {_short(finest, within)}: {told}."
    others = [run for run in sweep.levels if run is not finest and _worst(sweep, run) < math.inf]
    if not others:
        return f"No level stays within {text} of {_short(finest)}."
    nearest = min(others, key=lambda run: _worst(sweep, run))
    return f"No level stays within {text} of {_short(finest)}; nearest is {_short(nearest)}: {_gaps(sweep, nearest)}."


def _gain(run: LevelRun, finest: LevelRun) -> str:
    """What it takes instead, where that is less by more than times scatter."""
    if run.solve_seconds > SURELY * finest.solve_seconds:
        return ""
    return f"; {digits(run.solve_seconds * 1e3, 2)} ms instead of {digits(finest.solve_seconds * 1e3, 2)} ms"


def _short(run: LevelRun, after: LevelRun | None = None) -> str:
    """4 lumps; bare where a level with lumps was named just before."""
    if run.level == PAPER or not run.level.isdigit():
        return _name_run(run)
    return run.level if after is not None and after.level.isdigit() else lumps_of(run.level)


def lumps_of(level: str) -> str:
    """'4 lumps' for the level 4; other levels by their name."""
    return f"{level} lump{'s' if level != '1' else ''}" if level.isdigit() else level


def _worst(sweep: Sweep, run: LevelRun) -> float:
    assert sweep.tolerance is not None
    gaps = [sweep.gap(run, axis) for axis in sweep.finest.tcp if sweep.tolerance.concerns(axis)]
    return max((gap.largest if gap else math.inf for gap in gaps), default=math.inf)


def _gaps(sweep: Sweep, run: LevelRun) -> str:
    """0.4 µm at most along z, 0.1 µm along y: the largest first."""
    assert sweep.tolerance is not None
    gaps = {axis: sweep.gap(run, axis) for axis in sweep.finest.tcp if sweep.tolerance.concerns(axis)}
    sizes = sorted(((gap.largest, axis) for axis, gap in gaps.items() if gap), reverse=True)
    told = [f"{_cell(size / unit(axis_unit(axis)).scale)} {pretty(axis_unit(axis))}" for size, axis in sizes]
    ways = [f"{'about' if axis in ANGULAR_AXES else 'along'} {axis}" for _, axis in sizes]
    first = f"{told[0]} at most {ways[0]}"
    return ", ".join([first, *(f"{size} {way}" for size, way in zip(told[1:], ways[1:], strict=True))])


def pretty_quantity(text: str) -> str:
    number, _, unit_text = text.partition(" ")
    return f"{number} {pretty(unit_text)}"


# -- the closed form ------------------------------------------------------------------------------------------------
def _tell_closed_form(form: ClosedForm) -> Iterator[str]:
    tau = " to ".join(dict.fromkeys(f"{tau:.0f}" for tau in form.tau))
    lump = f"one lump of {digits(form.unit.heat_capacity / 1e3)} kJ/K, τ = {tau} s"
    yield f"The paper's closed form takes {', '.join(form.unit.parts)} for {lump}:"
    for law in form.laws[:MOST_LAWS]:
        yield f"  from {law.start / 60:.4g} to {law.stop / 60:.4g} min: {'; '.join(_tell_law(law))}"
    if len(form.laws) > MOST_LAWS:
        yield f"  … and {len(form.laws) - MOST_LAWS} more"
    if form.jumps:
        yield "  jumps where a run begins: next to the heat source inside, temperature counts as settled at once"
    if form.left_out:
        yield f"  left out: {', '.join(form.left_out)}"
    if form.simplified:
        yield f"  taken at one temperature: {', '.join(form.simplified)}"


def _tell_law(law: Law) -> Iterator[str]:
    """The law of each axis in µm and s, t counted from its beginning."""
    for axis, (i, j) in law.exponential.items():
        yield f"δ{axis} = {_format_coefficient(i * 1e6)} e^(−t/{law.tau:.0f}) {_term(j * 1e6)} µm"
    for axis, (slope, start) in law.linear.items():
        yield f"δ{axis} = {_format_coefficient(slope * 1e6)} t {_term(start * 1e6)} µm"


def _format_coefficient(value: float) -> str:
    return (digits(value, 3) if abs(value) > 1e-9 else "0").replace("-", "−")


def _term(value: float) -> str:
    return f"{'−' if value < -1e-9 else '+'} {_format_coefficient(abs(value))}"


# -- values ---------------------------------------------------------------------------------------------------------
def _tell_runs(sweep: Sweep) -> Iterator[str]:
    paths = ", ".join(variation.path for variation in sweep.variations)
    yield f"{sweep.machine.name}: {sweep.source}, {len(sweep.runs)} runs over {paths}"
    columns, rows = run_table(sweep)
    header, given = [column.shown for column in columns], len(sweep.variations)
    shown = [[*(f"{value:.6g}" for value in row[:given]), *map(_cell, row[given:])] for row in rows]
    yield from table(header, shown, header)


def run_table(sweep: Sweep) -> tuple[list[Heading], list[list[float]]]:
    """The table of values: headings, and one row for each point of the grid."""
    headings = [Heading(v.path, v.unit or "1") for v in sweep.variations]
    for axis in sweep.runs[0].tcp:
        headings += [Heading(f"{axis} {what}", axis_unit(axis)) for what in ("max", "min", "final")]
    rows = [[*run.values, *(n for e in run.tcp.values() for n in (e.highest, e.lowest, e.final))] for run in sweep.runs]
    return headings, rows
