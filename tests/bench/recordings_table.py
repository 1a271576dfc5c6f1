"""Real recordings: what calibration leaves of the residual where it was calibrated, and where it was not.

`python -m bench.recordings_table`, or with the others by `make bench`; needs the recordings in ../shared/recordings.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from bench.rigs.figures import rms
from rich.console import Console
from rich.table import Table

from network import Failed, Machine, Recording, calibrate
from network.analysis.calibration.calibrate import Calibration
from network.analysis.comparison.channel_residual import ChannelResidual
from network.analysis.comparison.compare import Comparison
from network.catalogue.declaration.declare import Array
from network.platform.quantities.units import difference, unit
from network.recordings.hygiene.data_quality import look_at

ROOT = Path(__file__).parents[2]
RECORDINGS = ROOT.parent / "shared" / "recordings"


@dataclass(frozen=True)
class Row:
    """A machine file with the mappings to calibrate on and to hold out."""

    name: str
    machine: str
    train: tuple[str, ...]
    holdout: tuple[str, ...] = ()

    def calibrated(self) -> Calibration:
        machine = Machine.load(ROOT / "machines" / f"{self.machine}.yaml")
        return calibrate(machine, [load(n) for n in self.train], [load(n) for n in self.holdout])


ROWS = (
    Row("two heaters, energy balance and second order → mhe", "two_heater_rig",
        ("tclab_energy_balance", "tclab_second_order"), ("tclab_mhe",)),
    Row("heated gantry, 13 June → 5 June", "heated_gantry", ("voron_2021_06_13",), ("voron_2021_06_05",)),
    Row("heated gantry, 5 June → 13 June", "heated_gantry", ("voron_2021_06_05",), ("voron_2021_06_13",)),
    Row("toaster oven (one recording only)", "toaster_oven", ("toaster_full_power",)),
    Row("heated building, 17 days → 9 days", "heated_building", ("building_train",), ("building_holdout",)),
    Row("lathe, days 1 to 3 → day 4 (120 s a sample assumed)", "lathe_warm_up",
        ("lathe_day01", "lathe_day02", "lathe_day03"), ("lathe_day04",)),
)  # fmt: skip


def load(name: str) -> Recording:
    return Recording.load(ROOT / "tests" / "recordings" / f"{name}.yaml")


def told(before: Comparison | None, after: Comparison | None) -> str:
    if before is None or after is None:
        return "–"
    return f"{pooled(before):.3g} → {pooled(after):.3g} σ"


def kept(channel: ChannelResidual) -> Array:
    """Residuals in units of noise, without readings far from their neighbours (false trips of a probe)."""
    used = look_at(channel.name, channel.measured, channel.sigma).used
    return channel.in_noise[used]


def pooled(comparison: Comparison) -> float:
    return rms(np.concatenate([kept(c) for r in comparison.recordings for c in r.channels.values() if c.n]))


def channels(before: Comparison, after: Comparison) -> str:
    """The last recording's channels before and after calibration, in their units."""
    pairs = zip(before.recordings[-1].channels.values(), after.recordings[-1].channels.values(), strict=True)
    return ", ".join(f"{a.name} {size(b):.2g} → {size(a):.2g} {a.summary()['unit']}" for b, a in pairs)


def size(channel: ChannelResidual) -> float:
    return rms(kept(channel)) * channel.sigma / difference(unit(channel.unit)).scale


def recordings_table() -> Table:
    table = Table(
        title="real recordings: rmse before → after calibration, in units of declared noise, without outliers"
    )
    for heading in (
        "recordings",
        "calibrated on",
        "held out",
        "start estimated",
        "channels of the last one",
        "prior σ moved most",
        "seconds",
    ):
        table.add_column(heading)
    for row in ROWS:
        try:
            found = row.calibrated()
        except Failed as failed:
            table.add_row(row.name, str(failed))
            continue
        most = max((abs(s) for s in found.shift if s == s), default=0.0)
        table.add_row(
            row.name, told(found.before, found.after), told(found.before_holdout, found.after_holdout),
            f"{pooled(found.stated_holdout):.3g} σ" if found.stated_holdout else "–",
            channels(found.before_holdout or found.before, found.after_holdout or found.after), f"{most:.1f}",
            f"{found.seconds:.1f}",
        )  # fmt: skip
    return table


def main() -> None:
    if RECORDINGS.is_dir():
        Console(width=200).print(recordings_table())
    else:
        print("the recordings in ../shared/recordings are not here")


if __name__ == "__main__":
    main()
