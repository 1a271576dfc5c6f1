"""What is drawn of a relay, and how well a draw tells the beginning of the runs.

Where a relay switches is not a smooth matter, so its numbers are drawn before they are fitted: many at once, each
judged by the misfit that is left when the other parameters are adjusted linearly. Over the beginning of the runs a
wrong period has not yet lost its step.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised
from network.analysis.calibration.measured_means import START_ANYWHERE
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.switching.share_view import View
from network.catalogue.declaration.declare import Array
from network.catalogue.mechanisms.base import Source
from network.catalogue.mechanisms.mechanism import Relay
from network.engine.assembly import build
from network.engine.channels import readouts
from network.engine.network import Network
from network.engine.response.batch import draws_of, serves, step_of
from network.engine.response.batch_march import means_of
from network.engine.response.heat_sensitivity import Slots
from network.engine.response.parameters import values_at
from network.engine.response.run_beginning import Beginning
from network.machine.checks import places_of

FARTHEST = 4.0
"""Prior 1σ that a start may lie off."""
AROUND = 0.3
"""Prior σ in which numbers are drawn about some that are known."""
MOST_SWITCHES = 120
"""An hour, two a minute, beyond which a draw is not looked at: readings of a minute show no more than the mean."""


@dataclass(frozen=True, eq=False)
class Space:
    """What is drawn: the numbers of a candidate, then the starts of the parts that it brings or lets go."""

    candidate: Candidate

    @cached_property
    def network(self) -> Network:
        return build(self.candidate.machine)

    @property
    def serves(self) -> bool:
        """Whether it can be searched."""
        return serves(self.network)

    @cached_property
    def beginnings(self) -> dict[float, list[list[tuple[int, Beginning]]]]:
        """Of the runs, by share, once they are known; those with the same steps together, each with its place."""
        return {}

    @cached_property
    def parts(self) -> tuple[str, ...]:
        base = self.candidate.base.nodes
        named = self.candidate.machine.nodes.items()
        return tuple(n for n, node in named if node.is_part and not (n in base and base[n].is_part))

    @cached_property
    def prior(self) -> tuple[Array, Array, Array, Array]:
        """Centre, 1σ, and bounds."""
        own = [(p.centre, p.spread, p.low, p.high) for p in self.candidate.own]
        middle = self.candidate.machine.reference
        far = FARTHEST * START_ANYWHERE
        rows = [*own, *((middle, START_ANYWHERE, middle - far, middle + far) for _ in self.parts)]
        centre, spread, low, high = np.array(rows, float).T
        return centre, spread, low, high

    def draw(self, count: int, seed: int, near: Array | None = None) -> Array:
        """Draws from the prior (count, numbers); near some numbers, these and others as far from them as draws are
        apart."""
        centre, spread, low, high = self.prior
        away = np.random.default_rng(seed).standard_normal((count, len(centre))) * spread
        if near is not None:
            centre, away = near, AROUND * away
            away[0] = 0.0
        return np.clip(centre + away, low, high)

    def numbers(self, theta: Array) -> dict[str, float]:
        return values_at(self.candidate.own, theta[: len(self.candidate.own)])

    def starts(self, theta: Array) -> dict[str, float]:
        return dict(zip(self.parts, theta[len(self.candidate.own) :].tolist(), strict=True))


def parts_about(candidate: Candidate) -> tuple[str, ...]:
    """The parts that its switched heat enters; where it enters a node held until now, the parts linked to that."""
    base = candidate.base
    relays = (e for _, e in candidate.machine.entries() if isinstance(e, Source) and isinstance(e, Relay))
    into = {place.node for relay in relays for place, _ in relay.into}
    own = [n for n in into if n in base.nodes and base.nodes[n].is_part]
    if own:
        return tuple(own)
    pairs = [{place.node for _, place in places_of(link)} for link in base.links.values()]
    return tuple(dict.fromkeys(n for pair in pairs for n in pair if base.nodes[n].is_part and pair & into))


@dataclass(frozen=True, eq=False)
class Judge:
    """Draws of a candidate beside a fit. values: the numbers of the file, at which the fit was made."""

    space: Space
    about: Linearised
    values: Mapping[str, float]

    @cached_property
    def _slots(self) -> Slots:
        """The numbers of the candidate in a network with the others."""
        c, network = self.space.candidate, self.space.network
        beside = tuple(p for p in self.about.problem.parameters if p.path in c.machine.uncertain)
        shared = Slots(network, beside).at({p.path: self.values[p.path] for p in beside})
        return Slots(shared, tuple(p for p in c.own if p not in beside))

    def misfits(self, view: View, theta: Array, residual: Array) -> Array:
        """Misfits of draws (draws, numbers) with these residuals, their priors and the adjusted parameters in it."""
        centre, spread, _, _ = self.space.prior
        strain = np.sum(((theta - centre) / spread) ** 2, axis=1)
        misfit = np.einsum("ij,ij->i", residual, residual) - view.take_up(residual)[1] + strain
        return np.where(np.isfinite(misfit), misfit, np.inf)

    def residuals(self, view: View, theta: Array) -> Array:
        """Whitened residuals of draws (draws, rows); not numbers where one switches all the time."""
        if not len(theta):
            return np.empty((0, view.projector.slopes.shape[1]))
        means, switches = self._runs(theta, view.share)
        residual = view.white(means)
        residual[switches > MOST_SWITCHES * view.hours] = np.nan
        return residual

    def _runs(self, theta: Array, share: float) -> tuple[Array, Array]:
        """Cells' means of all runs, one after the other, and switchings in all."""
        space, slots = self.space, self._slots
        networks = [slots.at(space.numbers(row)) for row in theta]
        began = dict(zip(space.parts, theta[:, len(space.candidate.own) :].T, strict=True))
        means: dict[int, Array] = {}
        switches = np.zeros(len(theta))
        for together in self._beginnings(share):
            runs = [b for _, b in together]
            told, switched = means_of(runs, draws_of(networks, runs[0].run), began)
            means.update(zip((i for i, _ in together), told, strict=True))
            switches += switched
        return np.concatenate([means[i] for i in sorted(means)], axis=1), switches

    def _beginnings(self, share: float) -> list[list[tuple[int, Beginning]]]:
        """The beginnings of the runs, each with its place among them, those with the same steps together."""
        known = self.space.beginnings
        if share not in known:
            machine, network = self.space.candidate.machine, self.space.network
            groups: dict[float, list[tuple[int, Beginning]]] = {}
            for i, d in enumerate(self.about.problem.data):
                begun = Beginning(machine, network, readouts(network, parts=False), d.run, share)
                groups.setdefault(round(step_of(d.run), 6), []).append((i, begun))
            known[share] = list(groups.values())
        return known[share]


def apart(theta: Array, misfit: Array, spread: Array, distance: float, most: int) -> list[int]:
    """Indices of the best draws that differ by a distance [prior σ] in some number."""
    chosen: list[int] = []
    for i in np.argsort(misfit):
        if len(chosen) == most or not np.isfinite(misfit[i]):
            break
        if all((np.abs(theta[i] - theta[j]) / spread).max() > distance for j in chosen):
            chosen.append(int(i))
    return chosen
