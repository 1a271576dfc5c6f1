"""Days of the CNC lathe as a calibration on others tells them, over what was measured; how often bands of 95 % hold.

`python -m bench.cnc_lathe_picture --train 11 --resume DIR -o FILE` in tests/, DIR as of bench.cnc_lathe_score.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from bench.cnc_lathe_figures import Fold, folds, grid, spread
from bench.cnc_lathe_runs import DISPLACEMENTS, Day, runs
from bench.cnc_lathe_told import MACHINE, calibrated_machine, simulated

from network.analysis.calibration.tcp_bands import bands_of
from network.catalogue.declaration.declare import Array
from network.report.figures.canvas import GREY, PALETTE, WIDTH, add_axes, headline, label_y, new_figure, save

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN = ("0701", "0730", "0807", "0813", "0818")
"""One day of each: a steady room at 20 and at 30 °C, a falling speed, a falling and a rising room."""
ROW, GAP, FOOT, HEAD = 1.2, 0.5, 0.3, 0.35


@dataclass(frozen=True, eq=False)
class Told:
    """A day on the grid: t [min]; measured (NaN where the machine stands), told, low, high: x and z [µm]."""

    day: Day
    t: Array
    measured: Array
    told: Array
    low: Array
    high: Array

    @property
    def covered(self) -> Array:
        """Share of the readings within the band, x and z."""
        known = np.isfinite(self.measured)
        inside = known & (self.measured >= self.low) & (self.measured <= self.high)
        return np.asarray(inside.sum(axis=0) / known.sum(axis=0))


def tell_day(fold: Fold, day: Day, machine: Path, resume: Path | None) -> Told:
    """The day as the fold's training runs tell it, with the bands that the calibrated file gives."""
    found = calibrated_machine(fold.training, machine, resume)
    t, at = day.recording.t, grid(day.recording.t)
    centre = simulated(found)(day)
    limits = [band.limits(t, centre[:, k]) for k, band in enumerate(bands_of(found, day.blanked().recording))]
    low, high = (np.stack([side[k] for side in limits], axis=1)[at] * 1e6 for k in (0, 1))
    measured = np.where(day.counted, day.values(*DISPLACEMENTS) * 1e6, np.nan)[at]
    return Told(day, (t[at] - t[0]) / 60, measured, centre[at] * 1e6, low, high)


def picture(days: Sequence[Told]) -> Figure:
    """A row for each day, x beside z."""
    figure = new_figure(HEAD + len(days) * (ROW + GAP) + FOOT)
    width, high = (WIDTH - 1.9) / 2, figure.get_size_inches()[1] - HEAD
    for one in days:
        high -= ROW
        for k, axis in enumerate("xz"):
            axes = add_axes(figure, 0.75 + k * (width + 0.9), high, width, ROW)
            axes.fill_between(one.t, one.low[:, k], one.high[:, k], color=PALETTE[5], alpha=0.35, linewidth=0)
            axes.plot(one.t, one.measured[:, k], color=GREY, linewidth=1.4)
            axes.plot(one.t, one.told[:, k], color=PALETTE[0], linewidth=1.2)
            label_y(axes, axis, "um")
            if k == 0:
                headline(axes, f"{one.day.name}, room {one.day.climate}: measured (grey), told (blue), band of 95 %")
            if one is days[-1]:
                axes.set_xlabel("min", fontsize=8)
        high -= GAP
    return figure


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m bench.cnc_lathe_picture", description=__doc__)
    parser.add_argument("--train", type=int, metavar="N")
    parser.add_argument("--by", choices=("day", "sixth", "climate"), default="day", help="what is left out at a time")
    parser.add_argument("--resume", type=Path, metavar="DIR")
    parser.add_argument("--days", default=",".join(SHOWN), help="days to draw; `all` tells how bands hold on all")
    parser.add_argument("-o", type=Path, metavar="FILE", dest="out")
    given, told = parser.parse_args(words), []
    for fold in folds(runs(), given.by):
        few = Fold(fold.name, fold.left_out, spread(fold.training, given.train))
        for day in (one for one in fold.left_out if given.days == "all" or one.name in given.days.split(",")):
            told.append(tell_day(few, day, MACHINE, given.resume))
            print(day.name, *(f"{axis} {share:.0%}" for axis, share in zip("xz", told[-1].covered, strict=True)))
    print("all", *(f"{a} {s:.0%}" for a, s in zip("xz", np.mean([one.covered for one in told], axis=0), strict=True)))
    if given.out is not None:
        save(picture([one for one in told if one.day.name in SHOWN]), given.out)


if __name__ == "__main__":
    main()
