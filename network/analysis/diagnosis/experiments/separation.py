"""How far a program would tell two explanations apart, that fit what was recorded equally well.

If one holds, a run reads y₁; the other, its parameters and the run's own nuisances refitted, comes as near as
J = min |L⁻¹(y₁ − y₂(θ₂ + δ))|² + δᵀPδ, P: what the recordings already say of them (the channels' constant errors belong
to θ). Linearised about its fit J = rᵀr − gᵀ(SSᵀ + P)⁻¹g with r = L⁻¹(y₁ − y₂), g = S r. √J, over the misfit χ that they
leave where that is above 1, is the distance in noise units (σ). Source: T-optimal design, Atkinson & Fedorov,
Biometrika 62 (1975) 57; unverified.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised, linearise
from network.analysis.calibration.projector import Projector
from network.analysis.diagnosis.experiments.programs import Program
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.proposals import fresh
from network.engine.response.model import Model
from network.machine.machine import Machine
from network.platform.quantities.units import show

USUAL_NOISE = 0.1
"""K: of a further sensor, where the machine has none of its kind."""


@dataclass(frozen=True, eq=False)
class Pair:
    """A finding and what it may be instead, both fitted to the same recordings."""

    holds: Hypothesis
    rival: Hypothesis

    @property
    def chi(self) -> float:
        return max(1.0, self.holds.chi, self.rival.chi)


@dataclass(frozen=True, eq=False)
class Outcome:
    """A pair on a program. at: the rival about its numbers; moved: what the other reads beyond it, whitened; channel:
    of each row; extra: part → channel of the sensor that was supposed there."""

    pair: Pair
    at: Linearised
    moved: Array
    channel: Array
    extra: dict[str, str]

    def sigma(self, extra: Collection[str] = ()) -> float:
        """√J/χ [σ] with the channels there are and some of the extra ones."""
        own = ~np.isin(self.channel, [n for part, n in self.extra.items() if part not in extra])
        slopes, moved = self.at.slopes[:, own], self.moved[own]
        J = Projector(slopes, slopes @ slopes.T + self._known).misfit(moved)
        return float(np.sqrt(max(J, 0.0))) / self.pair.chi

    @property
    def _known(self) -> Array:
        """P: what the recordings say of parameters and offsets, and the priors of the program's own nuisances."""
        precision = np.diag(self.at.problem.prior[1] ** -2.0)
        shared = self.pair.rival.fit.folded.shared
        precision[: len(shared), : len(shared)] = shared
        return precision


def outcome(pair: Pair, program: Program, parts: Sequence[str] = ()) -> Outcome:
    """Both explanations on a program, with further sensors supposed at some parts. Raises Failed or LinAlgError."""
    holds, rival = pair.holds, pair.rival
    extra = {part: fresh(f"T_{part} beside", rival.machine.sensors) for part in parts}
    one, other = (_add_sensors(h.machine, extra) for h in (holds, rival))
    case = _on(program, rival, other, [*extra.values()])
    at = linearise(case.problem(other, rival.fit.problem.parameters), rival.fit.theta)
    (data,) = case.lay_out(one)
    (there,) = Model(one, holds.fit.problem.parameters, [data.run]).predict(holds.fit.theta)
    (here,), (whiten,) = at.predictions, at.problem.whiteners
    channel = np.repeat(np.array(here.run.channels), here.run.knots.cells)[whiten.known]
    by_offset = at.rows.slopes.parts[0].by_offset[: len(rival.fit.problem.offsets)]
    moved = whiten(there.cells - here.cells) + _offsets(pair) @ by_offset
    return Outcome(pair, at, moved, channel, extra)


def _offsets(pair: Pair) -> Array:
    """How the channels' constant errors differ between the two fits, which go with their numbers."""
    one, other = ({n.name: x for n, x in zip(h.fit.problem.offsets, h.fit.eta, strict=False)}
                  for h in (pair.holds, pair.rival))  # fmt: skip
    return np.array([one.get(name, 0.0) - x for name, x in other.items()])


def about(h: Hypothesis, program: Program) -> Linearised:
    """A hypothesis about its numbers on a program. Raises Failed."""
    case = _on(program, h, h.machine, ())
    return linearise(case.problem(h.machine, h.fit.problem.parameters), h.fit.theta)


def _on(program: Program, h: Hypothesis, machine: Machine, extra: Sequence[str]) -> Case:
    """The case of a hypothesis with the program as its only run, on the channels that were recorded and extra ones."""
    channels = [*dict.fromkeys(n for d in h.fit.problem.data for n in d.run.channels), *extra]
    run = program.recording({n: machine.sensors[n].unit for n in channels})
    return h.case.on((run,))


def _add_sensors(machine: Machine, extra: dict[str, str]) -> Machine:
    """The machine with further sensors as good as those it has."""
    if not extra:
        return machine
    there = [s.sigma for s in machine.sensors.values() if s.place is not None]
    noise = show(float(np.median(there)) if there else USUAL_NOISE, "K", 6)
    return machine.patched({"sensors": {name: {"measures": part, "noise": noise} for part, name in extra.items()}})
