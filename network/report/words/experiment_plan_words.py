"""What a schedule would tell, before it is recorded: in words, and as plan.json."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from network.analysis.calibration.identifiability_report import list_names, relative, tie
from network.analysis.calibration.uncertainty import PRIOR_ONLY
from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import digits, table
from network.platform.wording import join_names
from network.report.files.calibration_summary import prior, told_std
from network.report.words.calibration_words import before

if TYPE_CHECKING:
    from network.analysis.calibration.experiment_plan import Candidate, Foresight

WORTH = 0.1
"""Nats below which a further sensor is not worth a word."""
MOST = 5
HALVED = 0.7
"""A sensor that lowers a number's 1σ to less than this share is said to help it."""


def tell_foresight(f: Foresight) -> str:
    """Numbers, pairs, bands, further sensors."""
    head = f"{f.machine.name}: what {f.schedule} would tell"
    rows = [[p.path, before(p), f"± {relative(p, p.centre, float(f.std[j]))}", f"{f.share[j]:.2f}", verdict(f, j)]
            for j, p in enumerate(f.parameters)]  # fmt: skip
    header = ["number", "prior", "then", "of prior", ""]
    told = [s + "." for s in sentences(f)]
    return "\n\n".join(["\n".join([head, "", *table(header, rows, ["of prior"])]), "\n".join(told)])


def verdict(f: Foresight, j: int) -> str:
    """Whether the schedule determines a number."""
    return "not determined" if f.share[j] > PRIOR_ONLY else "weakly" if f.share[j] > 0.5 else "determined"


def sentences(f: Foresight) -> list[str]:
    return [*_numbers(f), *_pairs(f), *_bands(f), *_sensors(f)]


def _numbers(f: Foresight) -> Iterator[str]:
    nothing = [p.path for j, p in enumerate(f.parameters) if verdict(f, j) == "not determined"]
    count = len(f.parameters)
    yield f"This schedule with these sensors determines {count - len(nothing)} of {count} numbers"
    if nothing:
        yield f"It says nothing about {list_names(nothing)}"


def _pairs(f: Foresight) -> Iterator[str]:
    for i, j, r in list(f.pairs)[:MOST]:
        a, b = f.parameters[i], f.parameters[j]
        at = np.array([p.centre for p in (a, b)])
        what = tie(a, b, at, f.std[[i, j]], r)
        yield f"{a.path} and {b.path} come out only as {what} (correlation {r:+.3f})"


def _bands(f: Foresight) -> Iterator[str]:
    told = [f"{a.axis} from ±{digits(b.largest, 2)} to ±{digits(a.largest, 2)} {pretty(a.unit)}"
            for b, a in zip(f.bands_before, f.bands, strict=True)]  # fmt: skip
    if told:
        yield f"The tool centre point would be known along {join_names(told)} (1σ, at worst)"


def _sensors(f: Foresight) -> Iterator[str]:
    worth = [c for c in f.candidates if c.worth > WORTH][:3]
    if f.candidates and not worth:
        yield "No further sensor would tell much more"
    for k, c in enumerate(worth):
        order = "Next" if k else "A sensor that would buy most"
        yield f"{order}: {c.measures} (noise {c.noise}), {describe_help(f, c)}"


def describe_help(f: Foresight, c: Candidate) -> str:
    """What a further sensor would sharpen: numbers, and the tool centre point."""
    order = sorted(range(len(f.parameters)), key=lambda j: c.ratio[j])
    better = [f"{f.parameters[j].path} to ± {relative(f.parameters[j], 0.0, float(f.std[j] * c.ratio[j]))}"
              for j in order if c.ratio[j] < HALVED][:3]  # fmt: skip
    tcp = [f"tcp {b.axis} to ±{digits(c.bands[b.axis], 2)} {pretty(b.unit)}" for b in f.bands
           if c.bands[b.axis] < 0.9 * b.largest]  # fmt: skip
    return join_names([*better, *tcp]) if better or tcp else "a little of everything"


def summary(f: Foresight) -> dict[str, Any]:
    """plan.json."""
    return {
        "machine": f.machine.file, "schedule": f.schedule,
        "parameters": [
            {"path": p.path, "prior": prior(p), "std": told_std(p, float(f.std[j])),
             "posterior_over_prior": float(f.share[j]), "verdict": verdict(f, j)} for j, p in enumerate(f.parameters)],
        "pairs": [{"a": f.parameters[i].path, "b": f.parameters[j].path, "correlation": r} for i, j, r in f.pairs],
        "tcp_bands": [{"axis": a.axis, "before": b.largest, "after": a.largest, "unit": a.unit}
                      for b, a in zip(f.bands_before, f.bands, strict=True)],
        "sensors": [{"measures": c.measures, "noise": c.noise, "nats": c.worth, "tcp_bands": dict(c.bands),
                     "ratios": {p.path: float(r) for p, r in zip(f.parameters, c.ratio, strict=True)}}
                    for c in f.candidates],
        "sentences": sentences(f),
    }  # fmt: skip
