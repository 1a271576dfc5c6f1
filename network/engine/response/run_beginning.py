"""The beginning of a run in even steps: inputs, and what its channels show of many machines that differ in numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from network.catalogue.declaration.declare import Array
from network.engine.balance import affine_heat
from network.engine.channels import Readouts
from network.engine.network import Network
from network.engine.response.batch import Draws, step_of
from network.engine.response.cells import cell_matrix
from network.engine.response.measured_run import Run
from network.engine.response.output_jacobian import Slopes, channels_of, slopes_of
from network.engine.solvers.plan import Plan, spans
from network.machine.machine import Machine


@dataclass(frozen=True, eq=False)
class Beginning:
    """A share of a run in even steps as its channels show it, by machines that differ in numbers only. network,
    outputs: of one of them."""

    machine: Machine
    network: Network
    outputs: Readouts
    run: Run
    share: float

    @cached_property
    def plan(self) -> Plan:
        t, h = self.run.knots.samples, step_of(self.run)
        count = max(2, round(self.share * float(t[-1] - t[0]) / h))
        edges = np.asarray(float(t[0]) + h * np.arange(count + 1), float)
        left, right = spans(self.run.schedule, edges)
        return Plan(self.network, edges, edges, left, right, np.zeros(self.network.size), "modal", "")

    @property
    def count(self) -> int:
        """Steps."""
        return len(self.plan.steps)

    @cached_property
    def u(self) -> dict[str, Array]:
        """Inputs at the edges."""
        return {n: np.append(self.plan.left[n], self.plan.right[n][-1]) for n in self.plan.left}

    @cached_property
    def averages(self) -> list[csr_matrix]:
        """From values at the edges to means over the cells, for each channel."""
        run, plan, K = self.run, self.plan, self.count
        within = run.knots.samples <= plan.edges[-1] + 1e-6
        told: dict[bytes, csr_matrix] = {}
        for there in run.present.values():
            if there.tobytes() not in told:
                A = cell_matrix(run.knots, plan.edges, there & within)
                told[there.tobytes()] = csr_matrix(
                    np.pad(A[:, :K], ((0, 0), (0, 1))) + np.pad(A[:, K:], ((0, 0), (1, 0)))
                )
        return [told[there.tobytes()] for there in run.present.values()]

    @cached_property
    def level(self) -> Array:
        return np.full((self.outputs.width, self.count + 1), self.machine.reference)

    @cached_property
    def slopes(self) -> Slopes | None:
        """One matrix from readings to channels, if there is one."""
        slopes = slopes_of(self.machine, self.outputs, self.level, self.u, self.run.channels)
        return slopes if slopes and slopes.is_constant and slopes.is_straight else None

    @cached_property
    def apart(self) -> Array:
        """Values of channels (channels, K + 1) that do not come from readings."""
        assert self.slopes is not None
        return self.values(self.level) - self.slopes.matrix @ self.level

    def values(self, readings: Array) -> Array:
        return channels_of(self.machine, self.outputs, readings, self.u, self.run.channels)

    def inputs(self, network: Network) -> tuple[Array, Array]:
        """Held temperatures and heats of a network at both ends of the steps, (K, inputs) each."""
        plan = self.plan.with_network(network, self.plan.T0)
        held = plan.evaluate_held(plan.left), plan.evaluate_held(plan.right)
        heat = (affine_heat(network, u, np.zeros(1), len(plan.steps)) for u in plan.just_inside)
        begin, end = (np.hstack(pair) for pair in zip(held, heat, strict=True))
        return begin, end

    def start(self, began: Mapping[str, Array], draws: int) -> Array:
        """Temperatures of all lumps (draws, N); began: where parts start in every draw, others as the run has them."""
        T0 = np.full((draws, self.network.size), self.machine.reference)
        for name, part in self.network.parts.items():
            T0[:, part] = np.reshape(began.get(name, self.run.start.get(name, self.machine.reference)), (-1, 1))
        return T0

    def means(self, draws: Draws, modes: Array, edges: Array) -> Array:
        """Means over cells (draws, channels · cells) from modal states (K + 1, draws, n) and inputs at the edges."""
        if self.slopes is None:
            return self._one_by_one(draws, modes, edges)
        shows, direct = (self.slopes.matrix @ a for a in (draws.shows, draws.direct))
        y = np.real(np.matmul(modes.transpose(1, 0, 2), shows.transpose(0, 2, 1))) + edges @ direct.transpose(0, 2, 1)
        y += self.apart.T
        y[:, :, self.slopes.zeroed] -= y[:, :1, self.slopes.zeroed]
        return np.hstack([(A @ y[:, :, i].T).T for i, A in enumerate(self.averages)])

    def _one_by_one(self, draws: Draws, modes: Array, edges: Array) -> Array:
        """Where channels do not follow the readings by one matrix."""
        readings = (np.real(show @ modes[:, m].T) + direct @ edges.T
                    for m, (show, direct) in enumerate(zip(draws.shows, draws.direct, strict=True)))  # fmt: skip
        values = (self.values(r) for r in readings)
        return np.array([np.concatenate([A @ row for A, row in zip(self.averages, v, strict=True)]) for v in values])
