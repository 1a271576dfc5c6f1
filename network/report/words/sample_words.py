"""What a sweep over drawn numbers says of itself: bands, and which number brings how much of the scatter."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from network.catalogue.expansions.base import ANGULAR_AXES
from network.engine.trajectory import axis_unit
from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import digits, table

if TYPE_CHECKING:
    from network.analysis.sweep.sample import Sample

MOST_NAMED = 5
LEAST_NAMED = 0.01


def tell_sample(sample: Sample) -> str:
    return "\n".join(_tell(sample))


def _tell(sample: Sample) -> Iterator[str]:
    told = f"{len(sample.numbers)} runs with {len(sample.drawn)} numbers drawn (seed {sample.seed})"
    yield f"{sample.machine.name}: {sample.source}, {told}"
    header = ["tool centre point", "mean", "1σ", "95 % from", "to"]
    rows = [
        [f"{axis} {what} [{pretty(axis_unit(axis))}]", *map(_cell, (s.mean, s.std, s.low, s.high))]
        for (axis, what), s in sample.scatter.items()
    ]
    yield from table(header, rows, header[1:])
    if sample.shares:
        yield from (_tell_shares(sample, axis) for axis in sample.machine.tcp)
    else:
        yield "Too few runs to tell which number brings how much; take 200 or more."


def _tell_shares(sample: Sample, axis: str) -> str:
    """Of the final value: the numbers that bring most of its variance, each by itself."""
    shares = sorted(sample.shares[axis, "final"].items(), key=lambda item: -item[1])
    named = [f"{path} {share * 100:.0f} %" for path, share in shares[:MOST_NAMED] if share > LEAST_NAMED]
    way = f"about {axis}" if axis in ANGULAR_AXES else f"along {axis}"
    together = 1 - sum(share for _, share in shares)
    rest = f"; {together * 100:.0f} % by several together" if together > 0.05 else ""
    return f"The final value {way} scatters by {', '.join(named) or 'none of them'}{rest}."


def summary(sample: Sample) -> dict[str, Any]:
    """What sweep.json holds and --json prints."""
    tcp: dict[str, dict[str, Any]] = {}
    for (axis, what), scatter in sample.scatter.items():
        shares = {"shares": sample.shares[axis, what]} if sample.shares else {}
        tcp.setdefault(axis, {})[what] = scatter.summary(axis_unit(axis)) | shares
    return {
        "machine": sample.machine.name, "source": sample.source, "runs": len(sample.numbers), "seed": sample.seed,
        "drawn": [drawn.summary() for drawn in sample.drawn], "tcp": tcp,
    }  # fmt: skip


def _cell(value: float) -> str:
    return digits(value, 3) if abs(value) >= 1e-9 else "0"
