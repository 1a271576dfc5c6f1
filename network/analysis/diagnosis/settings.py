"""The numbers that steer what a diagnosis tells, in one place: each with its unit, its meaning and where it comes from.

Origins: `convention` (a usual level), `prior` (engineering size), `budget` (how much is tried), `derived`, and `bench`
where it was set on development cases and nothing better is known. Numbers of one algorithm alone, like steps of a fit,
stand with it. Groups: what is moved together where it is asked how much hangs on them (bench/sensitivity.py).
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any


def number(value: float, unit: str, meaning: str, origin: str, group: str) -> Any:
    """A setting."""
    return field(default=value, metadata={"unit": unit, "meaning": meaning, "origin": origin, "group": group})


@dataclass(frozen=True)
class Settings:
    """All of them. χ is the rms of whitened residuals, its excess χ² − 1."""

    noise: float = number(
        1.06, "χ", "nothing is missing below it", "bench: lumps and straight inputs leave as much", "misfit"
    )
    further: float = number(1.1, "χ", "nothing is looked for beside a finding below it", "bench", "misfit")
    adequate: float = number(1.25, "χ", "what was found is a part beyond it, and more is tried", "bench", "misfit")
    doubtful: float = number(1.5, "χ", "what has no name is told, and lumps alone do not mend it", "bench", "misfit")
    hopeless: float = number(3.0, "χ/χ", "ratio by which a coarser machine is behind a finer one", "bench", "misfit")
    worth: float = number(0.015, "1", "share of χ that a finding takes away at least", "bench", "misfit")
    poor: float = number(0.6, "1", "share of the excess left from which more candidates are fitted", "budget", "misfit")
    half: float = number(
        0.5, "1", "share of the left-out excess below which what has no name comes first", "derived", "misfit"
    )
    quantile: float = number(
        0.99, "1", "of the gain that chance reaches, over all candidates", "convention", "evidence"
    )
    least: float = number(
        12.0, "nats", "evidence below which nothing is told", "bench: laws straight between knots", "evidence"
    )
    per_shape: float = number(2.0, "nats", "added to it for each number of a shape", "bench", "evidence")
    structure: float = number(20.0, "nats", "evidence that finer lumps add at least", "bench", "evidence")
    alike: float = number(
        6.0, "nats", "within it two explanations cannot be told apart", "convention: 400 to 1", "evidence"
    )
    softening: float = number(
        4.0, "nats", "that count as e to one: models are less right than evidence", "bench", "belief"
    )
    covered: float = number(0.9, "1", "belief that a told set has", "convention: α = 0.1", "belief")
    most_sure: float = number(0.99, "1", "confidence that nothing exceeds", "convention", "belief")
    barred: float = number(
        0.5, "1", "confidence of what is not sure, at most: as likely as not", "convention", "belief"
    )
    errors: float = number(3.0, "σ", "from not there, and of numbers of the file bent far", "convention", "invariants")
    strained: float = number(
        5.0, "σ", "prior σ by which constant errors of sensors stand in for something", "convention", "invariants"
    )
    shift: float = number(
        2.0, "σ", "prior σ from which a number of the file counts as wrong", "convention", "invariants"
    )
    worse: float = number(
        1.02, "χ/χ", "ratio of misfits from which a run is told worse", "convention: 2 %", "invariants"
    )
    paired: float = number(2.0, "σ", "paired block errors from which that is no chance", "convention", "invariants")
    strength: float = number(1.5, "ln", "prior 1σ of a strength: a factor of 4.5 either way", "prior", "priors")
    shape: float = number(1.0, "ln", "prior 1σ of a shape", "prior", "priors")
    exponent: float = number(0.25, "ln", "the same of a bare number that has a default", "prior", "priors")
    signed: float = number(3.0, "1", "prior 1σ of what may be negative, over its typical size", "prior", "priors")
    degrees: float = number(3.0, "K", "prior 1σ of a temperature that a proposal brings", "prior", "priors")
    findings: float = number(2, "1", "found at most; a diagnosis of what is written looks further", "budget", "budgets")
    calibrated: float = number(0.15, "1", "share of the time for the null", "budget", "budgets")
    searched: float = number(0.8, "1", "share of the time after which nothing more is looked for", "budget", "budgets")

    def summary(self) -> dict[str, Any]:
        """As diagnosis.json has it."""
        return {f.name: {"value": getattr(self, f.name), **f.metadata} for f in fields(self)}


SETTINGS = Settings()
