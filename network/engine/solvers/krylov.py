"""Large linear networks in a small subspace: rational Krylov, with an estimate of what that leaves out.

With y = √C T the balance is symmetric, dy/dt = −A y + B u. The answers (A + σ)⁻¹ B and (A + σ)⁻² B at some shifts σ,
spread evenly over the logarithm of the rates that the schedule can stir, span nearly all that y goes through; so do
those of the rows that are read, and as A is symmetric both together square what is left out. In the orthonormal basis V
of the span the balance is a small one of the same form (Galerkin: a machine that is passive stays so, and the uniform
temperature lies in V, so that no heat is lost). Source: Güttel, GAMM-Mitteilungen 36 (2013) 8; Antoulas, Approximation
of Large-Scale Dynamical Systems (2005), ch. 11.

The error is the largest difference, at instants spread over the run, to the same reduced with two shifts of three.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix, diags
from scipy.sparse.linalg import spsolve

from network.catalogue.declaration.declare import Array
from network.engine.channels import Readouts
from network.engine.network import Network
from network.engine.solvers.elimination import Regime
from network.engine.solvers.forcing import force_sources
from network.engine.solvers.linear import LinearProblem, force_states
from network.engine.solvers.modal_run import solve
from network.engine.solvers.orthonormal_basis import orthonormalise
from network.engine.solvers.plan import Plan
from network.engine.solvers.regimes import regimes as regimes_of
from network.engine.solvers.sparse_balance import ShiftedMatrix, sparse_matrix
from network.platform.refusal import Failed

SHIFTS = (6, 12, 24)
"""So many are tried, one after the other, until little enough is left out."""
TOLERANCE = 1e-5
"""K: error up to which the reduced balance is taken."""
KEPT_COARSELY = 1e-12
"""Of the largest singular value of the coarser span."""
LOOKED_AT = 400
"""Instants at which the two reductions are compared."""
MOST_ROWS, MOST_COLUMNS = 16, 2400
"""Rows that are read up to which they take part in the subspace; columns that span it at most."""


@dataclass(frozen=True)
class Reduction:
    """A small problem of the form of the large one, and the largest error of what is read from it [K]."""

    problem: LinearProblem
    error: float


def reduce_by_krylov(plan: Plan, readouts: Readouts) -> Reduction | None:
    """The reduction of a plan; None where it is none, or its error exceeds TOLERANCE."""
    sides = [_Side(plan.network, plan, k) for k in regimes_of(plan.network, plan.left)[0]]
    starts = _starts(plan, readouts, sides[0])
    all_rows_take_part = len(readouts.own_rows) == readouts.width and len(readouts.own_rows) <= MOST_ROWS
    for count in SHIFTS if all_rows_take_part else SHIFTS[1:]:
        if len(sides) * 2 * count * starts.shape[1] > min(MOST_COLUMNS, plan.network.size):
            return None
        span = _span(plan, sides, starts, count)
        if span is None:
            return None
        V, along = orthonormalise(span.columns)
        fine = _galerkin(plan, readouts, sides, V)
        error = _difference(fine, _restrict(fine, along[:, span.is_coarse]))
        if error <= TOLERANCE:
            return Reduction(fine, error)
    return None


class _Side:
    """One regime of the large balance: S and the columns of held nodes, junctions eliminated; A = −C^-1/2 S C^-1/2."""

    def __init__(self, network: Network, plan: Plan, k: int) -> None:
        free, bound, massless = network.free, network.bound, network.massless
        self.K = sparse_matrix(network, {name: values[k] for name, values in plan.left.items()})
        self.by_free, self.by_held = csr_matrix((len(massless), len(free))), np.zeros((len(massless), len(bound)))
        self.S, self.H = self.K[free][:, free], self.K[free][:, bound].toarray()
        self.junctions = np.zeros((0, 0))
        if len(massless):
            inner = self.K[massless][:, massless].tocsc()
            if not np.linalg.cond(inner.toarray()) <= 1e14:
                raise Failed(
                    "a massless junction has no conductance to the rest; give its links a conductance above zero"
                )
            self.junctions = -np.linalg.inv(inner.toarray())
            self.by_free = csr_matrix(-spsolve(inner, self.K[massless][:, free].tocsc()))
            self.by_held = self.junctions @ self.K[massless][:, bound].toarray()
            into = self.K[free][:, massless]
            self.S, self.H = self.S + into @ self.by_free, self.H + into @ self.by_held
        self.into_junctions = self.K[free][:, massless]
        root = diags(1 / np.sqrt(network.capacity[free]))
        self.A = ShiftedMatrix(-(root @ self.S @ root))

    def heat(self, network: Network, into: Array) -> Array:
        """Heat into free lumps from columns over all lumps, that of junctions passed on."""
        return np.asarray(into[network.free] + self.into_junctions @ (self.junctions @ into[network.massless]))


def _starts(plan: Plan, readouts: Readouts, side: _Side) -> Array:
    """Columns over √C T that the subspace answers: sources, held nodes, an uneven start, and the rows that are read."""
    network = plan.network
    root = np.sqrt(network.capacity[network.free])[:, None]
    into = [side.heat(network, heats.into) for heats in network.heats if heats.into.shape[1]]
    T0 = plan.T0[network.free][:, None]
    uneven = [root**2 * (T0 - T0.mean())] if np.ptp(T0) > 1e-9 else []
    own = readouts.own_rows
    read = [own[:, network.free].T] if len(own) <= MOST_ROWS else []
    columns = np.hstack([*into, side.H, *uneven, *read]) / root
    size = np.linalg.norm(columns, axis=0)
    return np.asarray(columns[:, size > 0] / size[size > 0])


@dataclass(frozen=True)
class _Span:
    """Columns that span the subspace, in the order of the permutation put back; those of two shifts of three."""

    columns: Array
    is_coarse: Array


def _span(plan: Plan, sides: Sequence[_Side], starts: Array, count: int) -> _Span | None:
    root = np.sqrt(plan.network.capacity[plan.network.free])[:, None]
    first = root / np.linalg.norm(root)
    T0 = root * plan.T0[plan.network.free][:, None]
    width = starts.shape[1]
    columns = np.empty((len(root), 2 + 2 * width * count * len(sides)))
    columns[:, :1], columns[:, 1:2], is_coarse = first, T0 / max(float(np.linalg.norm(T0)), 1.0), [True, True]
    for side in sides:
        begun = np.asfortranarray(starts[side.A.order])
        for i, shift in enumerate(_shifts(plan, side, count)):
            by = side.A.factorise(shift)
            if by is None:
                return None
            for answer in ((once := by(begun)), by(once)):
                here = len(is_coarse)
                columns[side.A.order, here : here + width] = answer / np.linalg.norm(answer, axis=0)
                is_coarse += [i % 3 != 2] * answer.shape[1]
    return _Span(columns, np.array(is_coarse))


def _shifts(plan: Plan, side: _Side, count: int) -> Array:
    """From the slowest that shows within the run to the fastest that shows between two samples or input changes."""
    duration = float(plan.t[-1] - plan.t[0])
    shortest = float(min(np.diff(plan.t).min(), plan.steps.min()))
    fastest = min(2 * float(side.A.A.diagonal().max()), 10 / shortest)
    return np.geomspace(0.25 / duration, max(fastest, 25 / duration), count)


def _galerkin(plan: Plan, readouts: Readouts, sides: Sequence[_Side], V: Array) -> LinearProblem:
    """The balance in the basis V of √C T."""
    network = plan.network
    root = np.sqrt(network.capacity[network.free])
    basis = V / root[:, None]
    regimes = tuple(_regime(network, side, basis, readouts) for side in sides)
    regime_of, forcing = regimes_of(network, plan.left)[1], force_sources(plan)
    f0, f1 = force_states(regimes, regime_of, forcing, readouts)
    z0 = V.T @ (root * plan.T0[network.free])
    problem = LinearProblem(
        plan, readouts, regimes, regime_of, forcing, f0, f1, np.append(z0, np.zeros(readouts.states)),
        np.ones(V.shape[1] + readouts.states), basis,
    )  # fmt: skip
    return replace(problem, x0=problem.begin(plan.T0))


def _regime(network: Network, side: _Side, basis: Array, readouts: Readouts) -> Regime:
    N, r, nz = network.size, basis.shape[1], readouts.states
    P, P_held = np.zeros((N, r + nz)), np.zeros((N, len(network.bound)))
    P[network.free, :r], P[network.massless, :r] = basis, side.by_free @ basis
    P_held[network.bound, np.arange(len(network.bound))], P_held[network.massless] = 1.0, side.by_held
    row, column = (index.ravel() for index in np.meshgrid(network.massless, network.massless, indexing="ij"))
    P_heat: Any = csr_matrix((side.junctions.ravel(), (row, column)), (N, N))
    A, F_held, F_heat = np.zeros((r + nz, r + nz)), np.zeros((r + nz, P_held.shape[1])), np.zeros((r + nz, N))
    A[:r, :r] = basis.T @ (side.S @ basis)
    A[:r, :r] = (A[:r, :r] + A[:r, :r].T) / 2
    F_held[:r], F_heat[:r, network.free] = basis.T @ side.H, basis.T
    F_heat[:r, network.massless] = basis.T @ (side.into_junctions @ side.junctions)
    if nz:
        A[r:], F_held[r:] = readouts.state_T @ P, readouts.state_T @ P_held
        A[r:, r:] += readouts.state_z
        F_heat[r:] = readouts.state_T @ P_heat
    return Regime(A, P, P_held, P_heat, F_held, F_heat, not nz, side.K)


def _restrict(fine: LinearProblem, along: Array) -> LinearProblem:
    """The same reduced further, to the span of some columns in its basis."""
    U, size, _ = np.linalg.svd(along, full_matrices=False)
    Z = U[:, size > KEPT_COARSELY * size[0]]
    nz = fine.readouts.states
    wide = np.zeros((len(Z) + nz, Z.shape[1] + nz))
    wide[: len(Z), : Z.shape[1]], wide[len(Z) :, Z.shape[1] :] = Z, np.eye(nz)
    regimes = tuple(
        replace(r, A=wide.T @ r.A @ wide, P=r.P @ wide, F_held=wide.T @ r.F_held, F_heat=wide.T @ r.F_heat)
        for r in fine.regimes
    )
    assert fine.basis is not None
    return replace(
        fine, regimes=regimes, f0=fine.f0 @ wide, f1=fine.f1 @ wide, x0=wide.T @ fine.x0,
        scale=np.ones(wide.shape[1]), basis=fine.basis @ Z,
    )  # fmt: skip


def _difference(fine: LinearProblem, coarse: LinearProblem) -> float:
    """The largest between readings of the two, at some instants of output and just after all edges."""
    plan = fine.plan
    spread = np.linspace(0, len(plan.t) - 1, LOOKED_AT).astype(int)
    at = np.unique(np.concatenate([plan.bounds[:-1], spread]))
    some = replace(plan, t=plan.t[at[at < len(plan.t)]])
    a, b = (solve(replace(problem, plan=some)) for problem in (fine, coarse))
    return float("inf") if a is None or b is None else float(np.abs(a.courses.all() - b.courses.all()).max(initial=0))
