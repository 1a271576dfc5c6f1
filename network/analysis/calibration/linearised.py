"""A fit about some θ: residuals, slopes by everything that is uncertain, and what follows from these without a run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag

from network.analysis.calibration.arrow_matrix import Folded, OwnPart, Part
from network.analysis.calibration.estimate import Estimate, log_evidence
from network.analysis.calibration.problem import Problem
from network.analysis.calibration.projector import Projector
from network.analysis.calibration.slopes import Rows, Slopes
from network.catalogue.declaration.declare import Array
from network.engine.response.answers import Answers
from network.engine.response.input_slopes import input_slopes
from network.engine.response.prediction import Prediction, answer_together
from network.platform.printing import Brief
from network.platform.refusal import Failed


@dataclass(frozen=True, eq=False, repr=False)
class Linearised(Brief):
    """The problem about θ. rows: the whitened residual z − y(θ) and its slopes.

    made_at, eta_made_at: θ at which the slopes by θ and by η were found, where that is not here; bent: what bent laws
    add to the whitened slopes of every run by θ and its own nuisances, None where none is bent; is_rough: whether that
    was found elsewhere.
    """

    problem: Problem
    theta: Array
    predictions: tuple[Prediction, ...]
    rows: Rows
    made_at: Array | None = None
    eta_made_at: Array | None = None
    bent: tuple[Array, ...] | None = None
    is_rough: bool = False

    @property
    def free(self) -> int:
        return len(self.theta)

    @property
    def residual(self) -> Array:
        return self.rows.residual

    @property
    def slopes(self) -> Array:
        """Whitened ∂y/∂(θ, η), (parameters + nuisances, rows)."""
        return self.rows.slopes.matrix

    @property
    def normal(self) -> Array:
        """SᵀS without the prior."""
        return self.rows.slopes.normal

    @property
    def precision(self) -> Array:
        """Inverse posterior covariance of (θ, η), linearised."""
        return self.rows.slopes.precision(self.problem.prior[1])

    @property
    def folded(self) -> Folded:
        """The precision with the runs' own nuisances folded in."""
        return self.rows.slopes.fold(self.problem.prior[1])

    @property
    def whole_bent(self) -> tuple[Array, ...] | None:
        """What bent laws add to all slopes; None where that is not known of those by η."""
        runs = zip(self.bent or (), self.problem.data, strict=False)
        return self.bent if all(len(rows) == self.free + len(d.own) for rows, d in runs) else None

    def project(self, rows: Array) -> Array:
        """What of whitened rows (…, rows) parameters and nuisances cannot take up, given their priors."""
        return Projector(self.slopes, self.precision).project(rows)

    def weigh_runs(self, rows: Sequence[Array]) -> tuple[Array, Array]:
        """R M Rᵀ and R r of whitened rows R that each belong to one run (own rows, rows of the run), r `unexplained`:
        run by run, for the other runs' rows are zero."""
        slopes = self.rows.slopes
        left = np.split(self.unexplained, [own.stop for own, _ in slopes.blocks[:-1]])
        along = slopes.against(rows)
        among = block_diag(*(r @ r.T for r in rows)) - along @ np.linalg.solve(self.precision, along.T)
        return among, np.concatenate([r @ own for r, own in zip(rows, left, strict=True)])

    @cached_property
    def gradient(self) -> Array:
        """−½ ∂J/∂(θ, η) at θ and η = η₀."""
        mean, spread = self.problem.prior
        total = self.rows.toward.copy()
        total[: self.free] += (mean[: self.free] - self.theta) / spread[: self.free] ** 2
        return total

    @cached_property
    def _solved(self) -> tuple[Array, float, Array, Array]:
        slopes = self.rows.slopes
        return self.folded.solve(self.gradient[: slopes.shared], [self.gradient[own] for _, own in slopes.blocks])

    @property
    def reduced(self) -> tuple[Array, Array]:
        """Precision and −½ gradient of J in θ alone, with the nuisances at their most probable all along."""
        return self._solved[2:]

    @cached_property
    def covariance(self) -> Array:
        """Posterior covariance of (θ, η), linearised."""
        return np.asarray(np.linalg.inv(self.precision))

    @cached_property
    def eta(self) -> Array:
        """Most probable nuisances at this θ."""
        return np.asarray(self.problem.prior[0][self.free :] + self._solved[0])

    @cached_property
    def left(self) -> Array:
        """Whitened residual with the nuisances at their most probable."""
        return np.asarray(self.residual - self.rows.slopes.apply(self.eta))

    @cached_property
    def unexplained(self) -> Array:
        """Whitened residual that a full step to the least of J leaves, r − Sᵀ(SSᵀ + V⁻¹)⁻¹(S r − V⁻¹(x − x₀)).

        At the least of J that is r, whose way along S is what the priors of bent numbers hold back.
        """
        return np.asarray(self.left - np.linalg.solve(self.precision, self.pull) @ self.slopes)

    @property
    def pull(self) -> Array:
        """−½ ∂J/∂(θ, η) at θ and the most probable η: what still draws the numbers."""
        mean, spread = self.problem.prior
        return np.asarray(self.slopes @ self.left + (mean - np.concatenate([self.theta, self.eta])) / spread**2)

    @cached_property
    def cost(self) -> float:
        """J at this θ, least over η."""
        (mean, spread), at_mean = (p[: self.free] for p in self.problem.prior), self.rows.at_mean
        return float(at_mean @ at_mean - self._solved[1] + np.sum(((self.theta - mean) / spread) ** 2))

    @cached_property
    def misfit(self) -> float:
        """|left|², from the normal equations."""
        mean, spread = self.problem.prior
        at = np.concatenate([self.theta, self.eta])
        return max(self.cost - float(np.sum(((at - mean) / spread) ** 2)), 0.0)

    def temper(self, firm_theta: float, firm_eta: float) -> Linearised:
        """The same with the widths of the priors narrowed by other factors."""
        if (firm_theta, firm_eta) == (self.problem.firm_theta, self.problem.firm_eta):
            return self
        return replace(self, problem=self.problem.temper(firm_theta, firm_eta))

    def beside(self, theta: Array, residual: Array, predictions: tuple[Prediction, ...]) -> Linearised:
        """The same slopes at another θ."""
        made_at, eta_made_at = (self.theta if at is None else at for at in (self.made_at, self.eta_made_at))
        rows = replace(self.rows, residual=residual)
        return replace(self, theta=theta, predictions=predictions, rows=rows, made_at=made_at, eta_made_at=eta_made_at)

    @property
    def stated_prior(self) -> tuple[Array, Array]:
        """Prior means and 1σ of (θ, η) as stated, not narrowed as while a fit is under way."""
        return self.problem.stated_prior

    @property
    def log_evidence(self) -> float:
        return log_evidence(self.problem, self.cost, self.folded)

    @property
    def estimate(self) -> Estimate:
        """What is kept of it without the runs and slopes behind it."""
        problem = replace(self.problem, model=self.problem.model.afresh())
        return Estimate(problem, self.theta, self.eta, self.left, self.cost, self.covariance, self.folded)


def linearise(problem: Problem, theta: Array, bent: Sequence[Array] | None = None) -> Linearised:
    """The problem about θ; bent: as in `with_slopes`. Raises Failed where a run runs away."""
    return with_slopes(problem, theta, problem.model.predict(theta), bent=bent)


def with_slopes(
    problem: Problem, theta: Array, predictions: tuple[Prediction, ...], near: Linearised | None = None,
    bent: Sequence[Array] | None = None,
) -> Linearised:  # fmt: skip
    """The problem about θ from its predictions; the slopes by η are those of `near`, if it is given. bent: what bent
    laws add to the slopes, as it was found nearby: it changes far less than they do, and takes longer to find."""
    parts, n, is_rough = [], len(theta), bent is not None
    told = divide_mean_slopes(problem, theta, predictions, near is None, is_rough)
    if bent is None and any(slopes.bent is not None for slopes in told):
        bent = [whiten(slopes.added) for whiten, slopes in zip(problem.whiteners, told, strict=True)]
    for i, (whiten, slopes) in enumerate(zip(problem.whiteners, told, strict=True)):
        whitened = whiten(slopes.straight)
        if bent is not None:
            whitened += bent[i][: len(whitened)]
        if near is None:
            parts.append(Part(whitened[:n], OwnPart(problem.by_offset[i], whitened[n:])))
        else:
            parts.append(Part(whitened, near.rows.slopes.parts[i].eta))
    made_at = None if near is None else near.theta if near.eta_made_at is None else near.eta_made_at
    mean, _ = problem.prior
    whole = Slopes(tuple(parts), n, n + len(problem.offsets), len(mean))
    rows = Rows(whole, residual_of(problem, predictions), mean[n:])
    kept = None if bent is None else tuple(bent)
    return Linearised(problem, theta, predictions, rows, None, made_at, kept, is_rough)


def weigh_anew(at: Linearised, problem: Problem) -> Linearised:
    """The same in a problem of the same runs under another noise; no run is followed again for that."""
    mean, before, parts = problem.prior[0], at.rows.slopes, []
    for old, new, offsets, part in zip(
        at.problem.whiteners, problem.whiteners, problem.by_offset, before.parts, strict=True
    ):
        by_theta, by_own = (new.again(old.colour(rows)) for rows in (part.by_theta, part.by_own))
        parts.append(Part(by_theta, OwnPart(offsets, by_own)))
    slopes = Slopes(tuple(parts), at.free, at.free + len(problem.offsets), len(mean))
    rows = Rows(slopes, residual_of(problem, at.predictions), mean[at.free :])
    return Linearised(problem, at.theta, at.predictions, rows, at.made_at, at.eta_made_at)


def divide_mean_slopes(
    problem: Problem, theta: Array, predictions: tuple[Prediction, ...], is_whole: bool = True, is_rough: bool = False
) -> list[Answers]:
    """∂(cells' means)/∂(θ, own nuisances) of every run (unknowns, channels · cells), not whitened, apart by laws; by θ
    alone where it is not whole; is_rough: without what bent laws add."""
    pushes = [d.pushes(p.course) for d, p in zip(problem.data, predictions, strict=True)] if is_whole else None
    means = problem.model.divide_slopes(theta, predictions, pushes, is_rough)
    steps = [{n.name: n.spread for n in d.inputs} if is_whole else {} for d in problem.data]
    by_inputs = input_slopes(predictions, steps)
    return [slopes.beside(rows) for slopes, rows in zip(means, by_inputs, strict=True)]


def with_nuisance_slopes(at: Linearised) -> Linearised:
    """The same with slopes by η from here, those by θ as they are."""
    problem, before = at.problem, at.rows.slopes
    by_inputs = input_slopes(at.predictions, [{n.name: n.spread for n in d.inputs} for d in problem.data])
    pushes = [d.pushes(p.course) for d, p in zip(problem.data, at.predictions, strict=True)]
    answers = answer_together(at.predictions, pushes)
    runs = zip(problem.whiteners, problem.by_offset, answers, by_inputs, before.parts, strict=True)
    parts = []
    for whiten, offsets, answer, others, part in runs:
        own = whiten(np.concatenate([answer, others]))
        parts.append(Part(part.by_theta, OwnPart(offsets, own)))
    rows = replace(at.rows, slopes=Slopes(tuple(parts), before.free, before.shared, before.count))
    return replace(at, rows=rows, eta_made_at=None)


def residual_of(problem: Problem, predictions: Sequence[Prediction]) -> Array:
    """Whitened z − y of all runs."""
    runs = zip(problem.data, problem.whiteners, predictions, strict=True)
    return np.concatenate([whiten(data.means - prediction.cells) for data, whiten, prediction in runs])


def move_beside(about: Linearised, theta: Array) -> Linearised | None:
    """The problem at another θ with the slopes from nearby; None where a run breaks down."""
    try:
        predictions = about.problem.model.predict(theta)
    except Failed:
        return None
    residual = residual_of(about.problem, predictions)
    return about.beside(theta, residual, predictions) if np.isfinite(residual).all() else None


def residual_cost(about: Linearised, theta: Array) -> float:
    """J at another θ, with the nuisances' columns taken from nearby; infinite where a run breaks down."""
    moved = move_beside(about, theta)
    return np.inf if moved is None else moved.cost
