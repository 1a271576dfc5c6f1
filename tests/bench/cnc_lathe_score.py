"""The CNC lathe's score: how well days that no fit has seen are told from schedule, feed, room and start alone.

`python -m bench.cnc_lathe_score --resume DIR` in tests/; a stopped run goes on from DIR. Needs the recordings in
../shared/recordings.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from bench import cnc_lathe_told as told
from bench.cnc_lathe_figures import Fold, Miss, Tell, folds, score, spread
from bench.cnc_lathe_pages import as_json, markdown, table
from bench.cnc_lathe_runs import Day, runs

BY = ("day", "sixth", "climate")


@dataclass(frozen=True)
class Settings:
    """machine: the file; resume: where calibrations are kept; train: runs of a calibration at most; jobs: processes;
    left_out: days to be told, default all; by: what is left out, of BY."""

    machine: Path
    resume: Path | None
    train: int | None
    jobs: int
    left_out: tuple[str, ...]
    by: tuple[str, ...] = BY

    def methods(self) -> Mapping[str, Callable[[Fold], Tell]]:
        """The rows of the table."""
        return {
            "nothing": told.nothing,
            "ridge on lagged schedule and room": told.ridge_on_schedule,
            "ridge on temperatures and their lags": told.ridge_on_temperatures,
            "lptn as written": partial(told.as_written, path=self.machine),
            "lptn calibrated" + (f" on {self.train} runs at most" if self.train else ""): self.calibrated,
        }

    def calibrated(self, fold: Fold) -> Tell:
        began = time.perf_counter()
        tell = told.calibrated(self.thinned(fold), self.machine, self.resume)
        print(f"{fold.name} left out: {time.perf_counter() - began:.0f} s", file=sys.stderr, flush=True)
        return tell

    def thinned(self, fold: Fold) -> Fold:
        return Fold(fold.name, fold.left_out, spread(fold.training, self.train))


def scores(settings: Settings, days: Sequence[Day]) -> dict[str, dict[str, list[Miss]]]:
    """By what is left out (day, climate), by method: every day that was told."""
    over = {by: [fold for fold in folds(days, by) if wanted(settings, fold)] for by in settings.by}
    if settings.jobs > 1:
        with ProcessPoolExecutor(settings.jobs) as pool:
            list(pool.map(settings.calibrated, [fold for each in over.values() for fold in each]))
    return {by: {name: score(learn, each) for name, learn in settings.methods().items()} for by, each in over.items()}


def wanted(settings: Settings, fold: Fold) -> bool:
    return not settings.left_out or any(day.name in settings.left_out for day in fold.left_out)


def arguments(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m bench.cnc_lathe_score", description=__doc__)
    parser.add_argument("--runs", default="", help="days to leave out, as 0702,0814; default all")
    parser.add_argument(
        "--train", type=int, metavar="N", help="calibrate on N runs, evenly chosen by date; default all"
    )
    parser.add_argument("--by", choices=BY, action="append", help="what is left out; default days, then climates")
    parser.add_argument("--machine", type=Path, default=told.MACHINE, metavar="FILE")
    parser.add_argument("--resume", type=Path, metavar="DIR", help="keeps calibrations, and goes on from them")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="processes; needs --resume")
    parser.add_argument("--json", type=Path, metavar="FILE")
    parser.add_argument("--markdown", action="store_true", help="the table as markdown")
    parser.add_argument("--days", action="store_true", help="every day's figures, too")
    given = parser.parse_args(words)
    if given.jobs > 1 and given.resume is None:
        parser.error("--jobs hands calibrations over in a folder: give --resume DIR, too")
    return given


def main(words: Sequence[str] | None = None) -> None:
    given, days = arguments(words), runs()
    if not days:
        print("the recordings in ../shared/recordings are not here")
        return
    left_out = tuple(name for name in given.runs.split(",") if name)
    by = tuple(given.by or ("day", "climate"))
    found = scores(Settings(given.machine, given.resume, given.train, given.jobs, left_out, by), days)
    if given.json:
        given.json.write_text(as_json(found), encoding="utf-8")
    print(markdown(found, given.days)) if given.markdown else table(found, given.days)


if __name__ == "__main__":
    main()
