"""What a long sweep has done so far, in a file from which it goes on after a stop."""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from network.analysis.sweep.level_runs import Job
from network.catalogue.declaration.declare import Array, Indices
from network.engine.simulation import schedule_for
from network.platform.parallel import Told
from network.platform.publication import cannot_be_written
from network.platform.refusal import Spot, refuse

HEAD = "lptn sweep "


@dataclass(frozen=True, eq=False)
class Journal:
    """values: (runs, columns) [SI], NaN for runs that are not done."""

    path: Path
    values: Array

    @classmethod
    def open(cls, path: Path, job: Job, paths: Sequence[str], numbers: Array, width: int) -> Journal:
        """Begun, or read where it is there; paths, numbers (runs, paths): what differs from run to run. Raises Refused
        for the journal of another sweep."""
        mark = HEAD + _fingerprint(job, paths, numbers)
        values = np.full((len(numbers), width), np.nan)
        try:
            if not path.exists():
                path.write_text(mark + "\n", encoding="utf-8")
                return cls(path, values)
            text = path.read_text(encoding="utf-8")
            whole = text[: text.rfind("\n") + 1]
            first, *lines = whole.split("\n")
            if first == mark and whole != text:  # a stop cut the last line off
                path.write_text(whole, encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise cannot_be_written(path, error if isinstance(error, OSError) else OSError(str(error))) from None
        if first != mark:
            right = "give another file, or the machine, scenario and options that it began with"
            raise refuse(Spot(f"--resume {path}"), "belongs to another sweep", right)
        for line in filter(None, lines):
            row, *cells = line.split(",")
            if len(cells) == width:
                values[int(row)] = [float.fromhex(cell) for cell in cells]
        return cls(path, values)

    def append(self, rows: Indices, found: Array) -> None:
        """Adds some runs, exactly."""
        lines = (f"{row}," + ",".join(map(float.hex, cells)) for row, cells in zip(rows, found.tolist(), strict=True))
        try:
            with self.path.open("a", encoding="utf-8") as file:
                file.write("\n".join(lines) + "\n")
        except OSError as error:
            raise cannot_be_written(self.path, error) from None

    def run_missing(self, run: Callable[[Indices], Array], each: int, tell: Told | None) -> Array:
        """The values of all runs. Those that are not done are run in rounds of about `each`, and written after each
        round; tell is told the share that is done."""
        values = self.values.copy()
        missing = np.flatnonzero(np.isnan(values).any(axis=1))
        for rows in np.array_split(missing, max(1, len(missing) // each)) if len(missing) else ():
            values[rows] = run(rows)
            self.append(rows, values[rows])
            if tell is not None:
                tell(1 - float(np.isnan(values).any(axis=1).mean()))
        return values


def _fingerprint(job: Job, paths: Sequence[str], numbers: Array) -> str:
    schedule = schedule_for(job.machine, job.source, job.start)
    seen = (str(job.machine.tree), schedule.t, sorted(schedule.signals.items()), job.method, list(paths))
    return hashlib.sha256(pickle.dumps(seen, 4) + numbers.tobytes()).hexdigest()[:32]
