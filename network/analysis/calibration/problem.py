"""What a fit minimises: a model on some runs, what it is compared to, and the priors of all that is uncertain.

J(θ, η) = |L⁻¹(z − y(θ) − N η)|² + |(θ − θ₀)/σ_θ|² + |(η − η₀)/σ_η|²: z means of measured cells, y the model, L Lᵀ the
noise, η what else is uncertain and acts linearly (start of every part, instants of jumps, sensor offsets).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from network.analysis.calibration.measured_means import OFFSET, Measured, Nuisance, RunPoint
from network.analysis.calibration.noise import Noise, Whitener, whitener
from network.catalogue.declaration.declare import Array
from network.engine.response.model import Model
from network.engine.response.parameters import Parameter
from network.machine.machine import Machine
from network.platform.printing import Brief


@dataclass(frozen=True, eq=False, repr=False)
class Problem(Brief):
    """A model with what it is compared to. offsets: of channels, common to all runs; firm_theta, firm_eta: factors by
    which the priors of θ and η are narrowed, so that a model that does not fit yet is not mended by its nuisances;
    moves: whether what it is linear about goes with θ (expansion_point.py)."""

    model: Model
    data: tuple[Measured, ...]
    whiteners: tuple[Whitener, ...]
    offsets: tuple[Nuisance, ...]
    firm_theta: float = 1.0
    firm_eta: float = 1.0
    moves: bool = False

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return self.model.parameters

    @cached_property
    def nuisances(self) -> tuple[Nuisance, ...]:
        """Offsets, then of every run its starts, its jumps and its inputs."""
        return (*self.offsets, *(n for d in self.data for n in d.own))

    @cached_property
    def by_offset(self) -> tuple[Array, ...]:
        """Whitened slopes of every run's means by the offsets (offsets, rows), which no θ changes."""
        return tuple(w(_offset_columns(self.offsets, d)) for w, d in zip(self.whiteners, self.data, strict=True))

    @cached_property
    def prior(self) -> tuple[Array, Array]:
        """Prior means and 1σ of (θ, η)."""
        mean, spread = self.stated_prior
        n = len(self.parameters)
        return mean, np.concatenate([spread[:n] / self.firm_theta, spread[n:] / self.firm_eta])

    @cached_property
    def stated_prior(self) -> tuple[Array, Array]:
        """The same not narrowed."""
        parts = [*((p.centre, p.spread) for p in self.parameters), *((n.mean, n.spread) for n in self.nuisances)]
        mean, spread = np.array(parts, float).reshape(-1, 2).T
        return mean, spread

    def temper(self, firm_theta: float, firm_eta: float) -> Problem:
        """The same with priors narrowed by other factors; what is stated is not gathered again."""
        other = replace(self, firm_theta=firm_theta, firm_eta=firm_eta)
        other.__dict__.update({name: getattr(self, name) for name in ("nuisances", "stated_prior", "by_offset")})
        return other

    def about(self, points: Sequence[RunPoint]) -> Problem:
        """The same linear about other temperatures of the parts at the start of each run, and other constants that
        drive it."""
        data = tuple(d.about(point) for d, point in zip(self.data, points, strict=True))
        model = self.model.about([d.run for d in data])
        other = replace(self, model=model, data=data)
        other.__dict__["by_offset"] = self.by_offset
        return other

    def follows(self, other: Problem) -> bool:
        """Whether it is of the same runs, linear about the same constants, if of the same machine."""
        runs = [[(id(d.recording), d.point) for d in problem.data] for problem in (self, other)]
        return runs[0] == runs[1]

    @property
    def log_determinant(self) -> float:
        return sum(w.log_determinant for w in self.whiteners)


def make_problem(
    machine: Machine, parameters: Sequence[Parameter], data: Sequence[Measured], noise: Noise | None = None
) -> Problem:
    """The problem of some runs."""
    noise = noise or Noise()
    model = Model(machine, parameters, [d.run for d in data])
    return Problem(model, tuple(data), tuple(whitener(d, noise) for d in data), tuple(_offsets(machine, data)))


def _offsets(machine: Machine, data: Sequence[Measured]) -> list[Nuisance]:
    heard = [d for d in data if d.recording.offsets]
    names = [n for n in machine.sensors if any(n in d.run.channels for d in heard)]
    return [Nuisance(n, 0.0, OFFSET[machine.sensors[n].unit]) for n in names]


def _offset_columns(offsets: Sequence[Nuisance], data: Measured) -> Array:
    may = data.recording.offsets
    names = np.repeat([n if may else "" for n in data.run.channels], data.run.knots.cells)
    return np.array([names == n.name for n in offsets], float).reshape(len(offsets), len(names))
