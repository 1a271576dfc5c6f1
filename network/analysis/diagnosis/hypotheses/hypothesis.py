"""A hypothesis: a machine with what is supposed to be missing in it, fitted to the recordings of a case."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from network.analysis.calibration.estimate import Estimate
from network.analysis.calibration.gauss_newton import Linearised
from network.analysis.calibration.misfit import strain_of
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.declaration.declare import Array
from network.engine.response.model import Prediction
from network.engine.response.parameters import Parameter, at_values, values_at
from network.machine.machine import Machine


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A machine with what is supposed to be missing in it, fitted.

    found: the patches laid over it, in their order; own: their numbers, free along with those of the file; fit: an
    estimate where it is only compared with others; beside: its log evidence with heat of any course beside it, or as
    finer lumps tell, where that was weighed.
    """

    case: Case
    machine: Machine
    found: tuple[Candidate, ...]
    own: tuple[Parameter, ...]
    fit: Linearised | Estimate
    beside: float | None = None

    @property
    def weighed(self) -> float:
        """The log evidence by which it is compared with rivals."""
        return self.evidence if self.beside is None else self.beside

    @cached_property
    def chi(self) -> float:
        """Rms of the whitened residual, with what starts, jumps and offsets were strained by to get there."""
        misfit = float(self.fit.left @ self.fit.left) + strain_of(self.fit)
        return float(np.sqrt(misfit / max(len(self.fit.left), 1)))

    @cached_property
    def offset_pull(self) -> float:
        """How far the constant errors of sensors were taken from zero to get there: the farthest, in prior σ."""
        first, count = self.fit.free, len(self.fit.problem.offsets)
        mean, spread = (x[first : first + count] for x in self.fit.problem.prior)
        away = np.abs(self.fit.eta[:count] - mean) / (spread * self.fit.problem.firm_eta)
        return float(away.max(initial=0.0))

    @property
    def switches(self) -> bool:
        """Whether a relay is among what was found."""
        return any(c.switches for c in self.found)

    @cached_property
    def values(self) -> dict[str, float]:
        return values_at(self.fit.problem.parameters, self.fit.theta)

    @property
    def own_values(self) -> dict[str, float]:
        """The numbers of what was found, by path."""
        return {p.path: self.values[p.path] for p in self.own}

    @cached_property
    def numbers(self) -> Machine:
        """The machine with its numbers as fitted."""
        return at_values(self.machine, self.values)

    @cached_property
    def evidence(self) -> float:
        """Log evidence under the noise of the case (Laplace)."""
        return self.fit.log_evidence - self.price

    @cached_property
    def price(self) -> float:
        """What the choice of instants costs [nats]: each the log of how many samples its prior (1σ) spans. They have no
        slope by which the evidence could count it."""
        instants = [p for p in self.own if p.field.is_instant]
        spans = [p.spread * (p.value(p.centre) if p.is_log else 1.0) for p in instants]
        return sum(float(np.log(max(1.0, span / self.case.runs.interval))) for span in spans)

    @property
    def linearised(self) -> Linearised:
        """The fit with its runs and slopes, which one that is only compared has no more."""
        assert isinstance(self.fit, Linearised)
        return self.fit

    @property
    def predictions(self) -> tuple[Prediction, ...]:
        return self.linearised.predictions

    @cached_property
    def shift(self) -> Array:
        """How far the numbers of the file moved, in prior σ."""
        own = {p.path for p in self.own}
        pairs = zip(self.fit.problem.parameters, self.fit.theta, strict=True)
        return np.array([(x - p.centre) / p.spread for p, x in pairs if p.path not in own])

    @property
    def is_bent(self) -> bool:
        """Whether a number of the file stands far from it."""
        return float(np.abs(self.shift).max(initial=0.0)) > SETTINGS.errors

    @property
    def root(self) -> Machine:
        """The machine without what was found (as refined)."""
        return self.found[0].base if self.found else self.machine

    @property
    def name(self) -> str:
        return " + ".join(c.name for c in self.found) or "as it is"


@dataclass(frozen=True, eq=False)
class SameFit:
    """A hypothesis as a key of what is worked out once for its fit, however much time was left then."""

    of: Hypothesis

    def __hash__(self) -> int:
        return hash(self.of.fit)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, SameFit) and other.of.fit is self.of.fit
