"""Which runs of which rig are learned from, and which are held out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
RECORDINGS = ROOT.parent / "shared" / "recordings"

AFTER_THE_START: Mapping[str, Any] = {"start": None}
"""The mapping's temperatures are those of the first sample, and hold for no later one."""


@dataclass(frozen=True)
class Run:
    """A mapping of tests/recordings; over: keys laid over it (None removes one; `file` by its name alone)."""

    mapping: str
    over: Mapping[str, Any] = field(default_factory=dict)

    @property
    def path(self) -> Path:
        return ROOT / "tests" / "recordings" / f"{self.mapping}.yaml"


@dataclass(frozen=True)
class Split:
    """name: of its folder; rig: folder of the recordings; counts: channel → input, readings count while it is not 0."""

    name: str
    title: str
    rig: str
    machine: str
    train: tuple[Run, ...]
    holdout: tuple[Run, ...]
    counts: Mapping[str, str] = field(default_factory=dict)

    @property
    def machine_file(self) -> Path:
        return ROOT / "machines" / f"{self.machine}.yaml"

    @property
    def lacks(self) -> tuple[Path, ...]:
        """Files and folders without which it cannot be run."""
        wanted = (RECORDINGS / self.rig, self.machine_file, *(run.path for run in (*self.train, *self.holdout)))
        return tuple(path for path in wanted if not path.exists())


def runs(*names: str) -> tuple[Run, ...]:
    return tuple(Run(name) for name in names)


def parted(name: str, at: str) -> tuple[tuple[Run, ...], tuple[Run, ...]]:
    """One recording until an instant, and from it on."""
    return (Run(name, {"until": at}),), (Run(name, {"from": at, **AFTER_THE_START}),)


def days(*dates: str) -> tuple[Run, ...]:
    return tuple(Run("cnc_lathe_plain", {"recording": f"CNC lathe, {d}", "file": f"run_{d}.csv"}) for d in dates)


def board(name: str) -> Split:
    """One board against itself: the runs are of different ones."""
    words = name.replace("_", " ")
    halves = parted(f"tclab_{name}", "5 min")
    return Split(f"two-heaters-{name.replace('_', '-')}", f"two heaters, {words}: 5 min → rest", "tclab-apm",
                 "two_heater_rig", *halves)  # fmt: skip


VORON = ("voron_2021_06_13", "voron_2021_06_05")
STANDS = {"disp_x": "speed", "disp_z": "speed"}
"""Its displacement is frozen while the machine stands."""

SPLITS = (
    Split("two-heaters", "two heaters, energy balance and second order → mhe", "tclab-apm", "two_heater_rig",
          runs("tclab_energy_balance", "tclab_second_order"), runs("tclab_mhe")),
    *(board(name) for name in ("energy_balance", "second_order", "mhe")),
    Split("gantry-13", "heated gantry, 13 → 5 June", "voron-frame", "heated_gantry", runs(VORON[0]), runs(VORON[1])),
    Split("gantry-5", "heated gantry, 5 → 13 June", "voron-frame", "heated_gantry", runs(VORON[1]), runs(VORON[0])),
    Split("oven", "toaster oven, first 10 min → rest", "toaster-oven", "toaster_oven",
          *parted("toaster_full_power", "10 min")),
    Split("building", "heated building, 17 → 9 days", "building-darkgrey", "heated_building",
          runs("building_train"), runs("building_holdout")),
    Split("lathe", "lathe, days 1 to 3 → 4 (120 s a sample assumed)", "ace-lathe", "lathe_warm_up",
          runs("lathe_day01", "lathe_day02", "lathe_day03"), runs("lathe_day04")),
    Split("three-blocks", "three blocks, first 4 h → last 4 h", "three-blocks", "three_blocks",
          *parted("three_blocks", "4 h")),
    # both speeds and their changes, rooms of 20, 25 and 30 °C and rising, and the only stop; held out: each of them
    # in another order, and a room that rises twice as fast as any of the six
    Split("cnc", "CNC lathe, six days → three others", "cnc-lathe", "cnc_lathe_plain",
          days("20200616", "20200701", "20200703", "20200713", "20200807", "20200810"),
          days("20200618", "20200730", "20200817"), STANDS),
)  # fmt: skip


def split(name: str) -> Split:
    return next(s for s in SPLITS if s.name == name)
