"""Do bands of 95 % hold the readings of held-out runs of rigs and of sealed cases, and intervals the true numbers of
innocents?

`python -m bench.held_out [cases [seed]]`: rigs whose recordings lie beside the project and that measure a displacement,
then so many sealed cases.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import yaml
from bench.coverage import INSIDE
from bench.rigs.splits import SPLITS, Run, Split
from proof.cases import make_cases
from proof.sealed import opened
from rich.console import Console
from rich.table import Table

from network import Failed, Machine, Recording, Refused, calibrate
from network.analysis.calibration.band_coverage import pool_coverage
from network.analysis.calibration.calibrate import Calibration

CASES, SEED = 40, 3


@dataclass
class Bands:
    """Of held-out runs: share of the readings inside, and half widths at worst [µm]."""

    inside: list[float] = field(default_factory=list)
    wide: list[float] = field(default_factory=list)

    def add(self, found: Calibration) -> None:
        share = pool_coverage(found.coverage)
        if share is not None:
            self.inside.append(share)
            held_out = found.bands[len(found.after.recordings) :]
            self.wide.append(max((b.widest for own in held_out for b in own if b.left is not None), default=0.0))

    def row(self, name: str) -> tuple[str, ...]:
        if not self.inside:
            return name, "0", "–", "–"
        share = np.array(self.inside)
        error = f" ± {100 * share.std() / np.sqrt(len(share)):.1f}" if len(share) > 1 else ""
        return name, f"{len(share)}", f"{100 * share.mean():.1f}{error} %", f"±{np.median(self.wide):.2g} µm"


def load(run: Run) -> Recording:
    """A recording of a rig with what is laid over its mapping."""
    tree = yaml.safe_load(run.path.read_text(encoding="utf-8"))
    folder = (run.path.parent / tree["file"]).resolve().parent
    tree = {k: v for k, v in {**tree, **run.over}.items() if v is not None}
    tree["file"] = str(folder / Path(tree["file"]).name)
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / f"{run.mapping}.yaml"
        path.write_text(yaml.safe_dump(tree, allow_unicode=True), encoding="utf-8")
        return Recording.load(path)


def measure_rig(split: Split) -> Bands:
    bands = Bands()
    bands.add(calibrate(Machine.load(split.machine_file), [*map(load, split.train)], [*map(load, split.holdout)]))
    return bands


def measure_rigs() -> Iterator[tuple[str, ...]]:
    """Rigs that move a tool centre point."""
    for split in SPLITS:
        if not split.lacks and any(s.axis for s in Machine.load(split.machine_file).sensors.values()):
            yield measure_rig(split).row(split.title)


@dataclass
class Numbers:
    """Deviations from the truth in standard errors, of innocents."""

    z: list[float] = field(default_factory=list)

    def add(self, found: Calibration, true: dict[str, float]) -> None:
        known = [(j, p, true[p.path]) for j, p in enumerate(found.parameters) if p.path in true]
        self.z += [(found.theta[j] - (np.log(x) if p.is_log else x)) / found.std[j] for j, p, x in known]

    def told(self) -> str:
        z = np.abs(self.z)
        return f"{100 * np.mean(z < INSIDE):.1f} % of {len(z)}" if len(z) else "–"


def measure_cases(count: int, seed: int) -> Iterator[tuple[str, ...]]:
    """Sealed cases, by what they conceal."""
    bands: dict[str, Bands] = {}
    numbers: dict[str, Numbers] = {}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for name in make_cases(folder, count, seed):
            key, about = opened(folder, name), json.loads((folder / name / "case.json").read_text(encoding="utf-8"))
            runs = [[Recording.load(folder / name / file) for file in about[part]] for part in ("train", "holdout")]
            kind = f"innocent: {key['what']}" if key["class"] == "innocent" else key["class"]
            try:
                found = calibrate(Machine.load(folder / name / "machine.yaml"), *runs)
            except (Failed, Refused) as error:
                print(f"{name}: {error}", file=sys.stderr)
                continue
            bands.setdefault(kind, Bands()).add(found)
            if key["class"] == "innocent":
                numbers.setdefault(kind, Numbers()).add(found, key["numbers"])
    for kind in sorted(bands):
        yield *bands[kind].row(kind), numbers[kind].told() if kind in numbers else "–"


def main(cases: int = CASES, seed: int = SEED) -> None:
    began = time.process_time()
    rigs = Table(title="rigs: readings of a displacement of held-out runs inside bands of 95 %")
    for heading in ("rig", "rigs", "inside", "half width at worst"):
        rigs.add_column(heading, justify="right")
    for row in measure_rigs():
        rigs.add_row(*row)
    Console(width=140).print(rigs)
    told = Table(title=f"{cases} sealed cases, seed {seed}")
    for heading in (
        "concealed",
        "cases",
        "inside (90–98 %)",
        "half width at worst",
        "true numbers in their 95 % (93–97 %)",
    ):
        told.add_column(heading, justify="right")
    for row in measure_cases(cases, seed):
        told.add_row(*row)
    Console(width=140).print(told)
    print(f"{time.process_time() - began:.0f} s of a processor")


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:3]))
