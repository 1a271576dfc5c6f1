"""What machines, runs and comparisons say of themselves in the terminal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from network.analysis.comparison.sentences import telling
from network.analysis.comparison.spikes import calm_spikes
from network.analysis.comparison.window import worst_window
from network.catalogue.declaration.declare import Array
from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import digits, format_shift, span, table
from network.platform.quantities.units import Unit, difference, unit
from network.report.words.describe import describe

if TYPE_CHECKING:
    from network.analysis.comparison.channel_residual import ChannelResidual
    from network.analysis.comparison.compare import Comparison, RecordingResidual
    from network.engine.trajectory import Trajectory

__all__ = ["describe", "tell_comparison", "tell_run"]

GOOD = 1.3
"""An rmse up to this many σ is noise."""


# -- a run ----------------------------------------------------------------------------------------------------------
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
    from network.engine.trajectory import axis_unit

    rows = []
    for axis, values in run.tcp.items():
        shown = unit(axis_unit(axis))
        low, high, end = (f"{shown.from_si(v):.2f}" for v in _ends(values)[1:])
        rows.append([f"{axis} [{pretty(shown.text)}]", high, low, end, _main_contributor(run, axis, shown)])
    return ["tool centre point", "max", "min", "final", "mostly from"], rows


def _main_contributor(run: Trajectory, axis: str, shown: Unit) -> str:
    """The largest contribution where the axis is furthest from zero, with its share there."""
    mine = run.of_axis(axis)
    peak = int(np.argmax(np.abs(run.tcp[axis])))
    name = max(mine, key=lambda n: abs(float(mine[n][peak])), default=None)
    if name is None:
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


# -- a comparison ---------------------------------------------------------------------------------------------------
def tell_comparison(comparison: Comparison) -> str:
    """Residuals per recording and channel, and for each recording what is worst, and when."""
    blocks = ["\n".join(_tell_recording(residual)) for residual in comparison.recordings]
    if len(comparison.recordings) > 1:
        blocks.append(f"all recordings: rmse {digits(comparison.rmse_in_noise, 3)} σ")
    return "\n\n".join(blocks)


def _tell_recording(residual: RecordingResidual) -> Iterator[str]:
    yield f"{residual.trajectory.machine.name}: {residual.recording.file}"
    yield from table(*residual_rows(residual), ["rmse [σ]", "rmse", "max", "n"])
    yield f"  all channels: rmse {digits(residual.rmse_in_noise, 3)} σ (σ: declared noise of a sample)"
    yield from tell_findings(residual)


def residual_rows(residual: RecordingResidual) -> tuple[list[str], list[list[str]]]:
    """Header and a row for each channel."""
    rows = [_row(channel) for channel in residual.channels.values()]
    return ["channel", "rmse [σ]", "rmse", "max", "unit", "n"], rows


def tell_findings(residual: RecordingResidual) -> Iterator[str]:
    """What is worst, what stands out, and which columns nothing reads."""
    yield tell_worst(residual)
    yield from telling(residual.tests)
    if residual.unused:
        yield f"Columns the machine does not use, candidate drivers of missing physics: {', '.join(residual.unused)}."


def _row(channel: ChannelResidual) -> list[str]:
    told = channel.summary()
    numbers = [digits(told[key], 3) if told[key] is not None else "–" for key in ("rmse_in_noise", "rmse", "max")]
    return [channel.name, *numbers, pretty(told["unit"]), str(channel.n)]


def tell_worst(residual: RecordingResidual) -> str:
    """The sentence about the worst channel: how far off it is simulated, which way, and between which times; single
    readings that lie far apart do not count."""
    read = [calm_spikes(channel)[0] for channel in residual.channels.values() if channel.n]
    worst = max(read, key=lambda channel: channel.rmse_in_noise)
    if worst.rmse_in_noise <= GOOD:
        return f"Every channel agrees within its noise (worst: {worst.name}, {digits(worst.rmse_in_noise, 3)} σ)."
    first, last, mean = worst_window(worst)
    given = unit(worst.unit)
    temperature = given.is_temperature
    way = ("cold" if mean > 0 else "warm") if temperature else ("low" if mean > 0 else "high")
    size = f"{digits(abs(mean) / difference(given).scale, 3)} {'K' if temperature else pretty(worst.unit)}"
    return f"Worst is {worst.name}: simulated {size} too {way} {_between(first, last, worst.t)}."


def _between(first: float, last: float, t: Array) -> str:
    whole = float(t[-1] - t[0])
    if last - first > 0.95 * whole:
        return "throughout"
    name, length = ("s", 1.0) if whole < 300 else ("min", 60.0) if whole < 6 * 3600 else ("h", 3600.0)
    return f"between {first / length:.3g} and {last / length:.3g} {name}"
