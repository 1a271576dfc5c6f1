"""What a run says of itself in the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from network.catalogue.declaration.declare import Array
from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import digits, format_shift, span, table
from network.platform.quantities.units import Unit, unit

if TYPE_CHECKING:
    from network.engine.trajectory import Trajectory


def tell_run(run: Trajectory) -> str:
    """Method, end temperatures, movement of the tool centre point, energy, switches and warnings of a run."""
    lasted, took = span(float(run.t[-1] - run.t[0])), span(run.solve_seconds)
    lines = [f"{run.machine.name}: {run.schedule.name}, {lasted} simulated in {took}"]
    lines.append(f"method {run.method}: {run.why}; numerical error about {run.error:.1g} K")
    for part in (_temperatures(run), _displacements(run), _energy(run), _switches(run), _warnings(run)):
        lines += ["", *part] if part else []
    return "\n".join(lines)


def _temperatures(run: Trajectory) -> list[str]:
    header, rows = temperature_rows(run)
    return table(header, rows, header[1:]) if rows else []


def temperature_rows(run: Trajectory) -> tuple[list[str], list[list[str]]]:
    """Header and rows: the temperature channels, the parts where there are none."""
    sensors = {name: v for name, v in run.sensors.items() if run.machine.sensors[name].quantity == "temperature"}
    rows = [[name, *(f"{v:.2f}" for v in _ends(values))] for name, values in (sensors or run.parts).items()]
    return ["temperature [°C]", "start", "lowest", "highest", "end"], rows


def _ends(values: Array) -> tuple[float, float, float, float]:
    return float(values[0]), float(values.min()), float(values.max()), float(values[-1])


def _displacements(run: Trajectory) -> list[str]:
    header, rows = displacement_rows(run)
    return table(header, rows, header[1:4]) if rows else ["The machine file moves no tool centre point."]


def displacement_rows(run: Trajectory) -> tuple[list[str], list[list[str]]]:
    """Header and a row for each axis."""
    from network.engine.trajectory import axis_unit, drop_rounding

    rows = []
    for axis, values in run.tcp.items():
        shown = unit(axis_unit(axis))
        low, high, end = (f"{round(shown.from_si(v), 2) + 0.0:.2f}" for v in _ends(drop_rounding(values))[1:])
        rows.append([f"{axis} [{pretty(shown.text)}]", high, low, end, _main_contributor(run, axis, shown)])
    return ["tool centre point", "max", "min", "final", "mostly from"], rows


def _main_contributor(run: Trajectory, axis: str, shown: Unit) -> str:
    """The largest contribution where the axis is furthest from zero, with its share there."""
    from network.engine.trajectory import ROUNDING

    mine = run.of_axis(axis)
    peak = int(np.argmax(np.abs(run.tcp[axis])))
    name = max(mine, key=lambda n: abs(float(mine[n][peak])), default=None)
    if name is None or abs(float(mine[name][peak])) < ROUNDING:
        return "nothing"
    return f"{name} ({format_shift(shown.from_si(float(mine[name][peak])), 2)} at {run.t[peak] / 60:.0f} min)"


def _energy(run: Trajectory) -> list[str]:
    account = run.energy
    flows = (("in", account.in_), ("out", account.out), ("stored", account.total_stored))
    told = ", ".join(f"{name} {digits(value / 1e3)}" for name, value in flows)
    lines = [f"energy [kJ]: {told}; closure {account.closure:.1g}"]
    for word, sign in (("brought in by", 1.0), ("taken out by", -1.0)):
        largest = sorted(account.by_mechanism.items(), key=lambda item: -sign * item[1])[:3]
        some = [f"{name.partition('.')[2]} {digits(sign * heat / 1e3)}" for name, heat in largest if sign * heat > 0]
        lines += [f"  {word} {', '.join(some)}"] if some else []
    return lines


def _switches(run: Trajectory) -> list[str]:
    lines = []
    for name in dict.fromkeys(name for _, name, _ in run.switches):
        times = [t for t, source, _ in run.switches if source == name]
        count = "once" if len(times) == 1 else f"{len(times)} times"
        lines.append(f"{name} switches {count}, first after {span(times[0] - float(run.t[0]))}")
    return lines


def _warnings(run: Trajectory) -> list[str]:
    return [f"warning: {warning}" for warning in run.warnings]
