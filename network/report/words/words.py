"""What comparisons say of themselves in the terminal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from network.analysis.comparison.amounts import amount
from network.analysis.comparison.sentences import telling
from network.analysis.comparison.spikes import calm_spikes
from network.analysis.comparison.window import worst_window
from network.catalogue.declaration.declare import Array
from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import digits, table
from network.platform.quantities.units import unit

if TYPE_CHECKING:
    from network.analysis.comparison.channel_residual import ChannelResidual
    from network.analysis.comparison.compare import Comparison, RecordingResidual

GOOD = 1.3
"""An rmse up to this many σ is noise."""


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
    way = ("cold" if mean > 0 else "warm") if unit(worst.unit).is_temperature else ("low" if mean > 0 else "high")
    size = amount(mean, worst.unit)
    return f"Worst is {worst.name}: simulated {size} too {way} {_between(first, last, worst.t)}."


def rmse_by_channel(comparison: Comparison) -> dict[str, float]:
    """Rms residual of every channel over all recordings, in noise units."""
    from network.analysis.calibration.calibrate import pool_channels

    return {name: told["rmse_in_noise"] for name, told in pool_channels(comparison).items()}


def rmse_rows(columns: Sequence[tuple[str, Comparison]]) -> tuple[list[str], list[list[str]]]:
    """Header and a row for each channel, with a column for each comparison; – where it lacks the channel."""
    each = [rmse_by_channel(comparison) for _, comparison in columns]
    names = dict.fromkeys(name for column in each for name in column)
    rows = [[name, *(digits(column[name], 3) if name in column else "–" for column in each)] for name in names]
    rows.append(["all channels", *(digits(comparison.rmse_in_noise, 3) for _, comparison in columns)])
    return ["rmse [σ]", *(name for name, _ in columns)], rows


def _between(first: float, last: float, t: Array) -> str:
    whole = float(t[-1] - t[0])
    if last - first > 0.95 * whole:
        return "throughout"
    name, length = ("s", 1.0) if whole < 300 else ("min", 60.0) if whole < 6 * 3600 else ("h", 3600.0)
    return f"between {first / length:.3g} and {last / length:.3g} {name}"
