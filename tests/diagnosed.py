"""A diagnosis made by hand, for tests of what is told of one: a motor block on a body whose cooling was left out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from fits import ANOTHER, USUAL, recorded, speeds, two_blocks

from network import Machine, compare
from network.analysis.comparison.compare import Comparison
from network.analysis.diagnosis.experiments.experiment import Experiment
from network.analysis.diagnosis.findings.finding import Finding, Quantity, Rival
from network.analysis.diagnosis.findings.result import Diagnosis, Fits
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.latent_heat.location import Location
from network.catalogue.declaration.patch import Patch
from network.platform.yaml.document import dump

LEAK = {"kind": "convection", "between": ["body", "air"], "conductance": "6.1 W/K ± 3 %"}
PATCH = {"links": {"wet side": LEAK}}
BENT = {"links": {"skin": {"kind": "convection", "between": ["body", "air"], "conductance": "14.8 W/K ± 2 %"}}}
STRAIGHT = {"links": {"skin": {"kind": "convection", "between": ["body", "air"], "conductance": "7.1 W/K ± 2 %"}}}
AGAINST = "fits 3.3 times worse"


def saved(folder: Path, **sections: Mapping[str, Any]) -> Machine:
    """The machine as its user has it, in a file."""
    path = folder / "blocks.yaml"
    path.write_text(dump(two_blocks(**sections).to_plain()), encoding="utf-8")
    return Machine.load(path)


def rival(kind: str, places: str, confidence: float, chi: float, gain: float, why_not: str = AGAINST) -> Rival:
    return Rival(kind, tuple(places.split()), (), confidence, chi, gain, why_not)


def finding(**changed: Any) -> Finding:
    patch = Patch(changed.pop("patch", PATCH))
    usual = Finding(
        "convection", "links", ("body", "air"), (), 0.93, {"conductance": Quantity(6.1, 0.2, "W/K")},
        "Body loses heat to air over 6.1 W/K that is not in the file.", patch, 412.3, 9.3, ((2400.0, 6600.0),),
        (rival("radiation", "body air", 0.05, 1.3, 300.0), rival("windage", "motor", 0.01, 3.4, 90.0)),
    )  # fmt: skip
    return replace(usual, **changed)


def unknown_heat(at: Location, probability: float, runs: int, size: float) -> UnknownHeat:
    """Bursts of `size` in the first run, nothing that stands out in the others."""
    t = np.arange(0.0, 4 * 3600 + 1, 300.0)
    first = np.where((t > 2400) & (t < 9000) & (np.sin(t / 300) > 0), size, 0.0)
    heat = (first, *(np.zeros(len(t)) for _ in range(runs - 1)))
    std = tuple(np.full(len(t), abs(size) / 10) for _ in range(runs))
    rms = float(np.sqrt(np.mean(first**2)))
    return UnknownHeat(at, probability, rms, 200 * probability, (t,) * runs, heat, std)


def fits_of(before: Machine, after: Machine, holdout: bool = True) -> Fits:
    truth = after
    runs = [replace(recorded(truth, speeds(*steps), i), name=f"train{i}", file=f"train{i}.csv")
            for i, steps in enumerate((USUAL, ANOTHER), 1)]  # fmt: skip
    sides: list[Comparison] = [compare(m, runs) for m in (before, after)]
    if not holdout:
        return Fits(*sides, None, None)
    last = replace(recorded(truth, speeds((0.0, 7000), (2.0, 4000)), 7), name="holdout", file="holdout.csv")
    return Fits(*sides, *(compare(m, [last]) for m in (before, after)))


def diagnosed(folder: Path, verdict: str = "missing_physics", holdout: bool = True, **changed: Any) -> Diagnosis:
    """What a diagnosis could look like; `changed`: fields of it."""
    machine = saved(folder)
    before, after = machine.patched(BENT), machine.patched(STRAIGHT).patched(PATCH)
    fits = fits_of(before, after, holdout)
    located = (
        unknown_heat(Location(("body",)), 0.81, 2, -310.0), unknown_heat(Location(("motor", "body")), 0.12, 2, 45.0),
        unknown_heat(Location(channel="T_body"), 0.04, 2, 0.6),
    )  # fmt: skip
    usual: dict[str, Any] = {
        "machine": machine, "before": before, "after": after, "verdict": verdict, "findings": (finding(),),
        "channels": {"T_body": 12.0, "T_motor": 2.0, "dz": 1.1}, "located": located, "fits": fits,
        "tried": (rival("convection", "body air", 0.93, 1.02, 412.3), *finding().alternatives),
        "notes": ("train1: 3 readings of T_body are outliers and were excluded.",),
        "advice": (Experiment("Stop the spindle and let it cool for 40 min", ("convection", "radiation"), 6.1, 0.7),),
        "shifts": {"links.skin.conductance": 0.1}, "seed": 0, "seconds": 12.4,
    }  # fmt: skip
    return Diagnosis(**(usual | changed))
