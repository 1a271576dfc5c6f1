"""Cross-validation: runs that are left out of a fit, told by it, alone and with latent heat beside it.

Of runs r told by what the others found, ln p(r | others) is that of `foretold_runs` and what heat of any course adds to
it, its place, σ and ℓ learned on the others: the joint log predictive density, but for a constant. The misfit of runs,
and the end of a single one, are told by the numbers as they stand; only those of findings move, as far as others leave
them free: what shows nowhere else, like a pump that runs in one run, is told by where it shows. Source: Vehtari, Gelman
& Gabry, Statistics and Computing 27 (2017) 1413; unverified.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain, repeat

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised, linearise
from network.analysis.calibration.misfit import strain_of
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.latent_heat.latent_rest import find_rest
from network.analysis.diagnosis.latent_heat.locate import predict_unknown
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.steps.foretold_runs import ForetoldRuns
from network.catalogue.declaration.declare import Array, Mask
from network.platform.parallel import run_all
from network.platform.refusal import Failed

LEFT_OUT_STEPS, FOLDS, BEGINNING = 4, 3, 0.6
"""Steps of a fit without some runs, from the fit to all; into how many parts the runs are parted, and what share of a
single run tells the rest."""
_Part = tuple[Hypothesis, range, UnknownHeat | None]
"""Of a hypothesis the runs that are left out together, and heat that may stand beside it there."""


@dataclass(frozen=True)
class Unseen:
    """What is left of readings that were told by others. misfit: Σ of squares in noise, with what the constants of
    these runs are strained by and numbers of findings moved; rows: how many; density: their log predictive density
    [nats]; heat: of any course, as it was learned on the others, if it was; parts: those that were told together, if
    there are several."""

    misfit: float
    rows: int
    density: float
    heat: UnknownHeat | None = None
    parts: tuple[Unseen, ...] = ()

    @classmethod
    def broken(cls) -> Unseen:
        """Of a run that breaks down."""
        return cls(np.inf, 1, -np.inf)

    @classmethod
    def together(cls, parts: Iterable[Unseen]) -> Unseen:
        parts = tuple(parts)
        misfits, rows, densities = zip(*((p.misfit, p.rows, p.density) for p in parts), strict=True)
        return cls(sum(misfits), sum(rows), sum(densities), None, parts)

    @property
    def heats(self) -> tuple[UnknownHeat | None, ...]:
        """Of its parts."""
        return tuple(part.heat for part in self.parts)

    @property
    def chi(self) -> float:
        """Rms in noise."""
        return float(np.sqrt(self.misfit / max(self.rows, 1)))

    def gain_over(self, other: Unseen) -> float:
        """How much more likely these readings are than as told by another [nats], each part in the noise that the
        better of both leaves there: what neither tells, like a sensor that comes loose in one run, speaks for neither
        with the weight of what is known."""
        if self.density == other.density:
            return 0.0
        if not np.isfinite([self.density, other.density]).all():
            return self.density - other.density
        pairs = zip(self.parts or (self,), other.parts or (other,), strict=True)
        return sum((a.density - b.density) / max(1.0, min(a.chi, b.chi)) ** 2 for a, b in pairs)


def unseen_misfit(hypothesis: Hypothesis, jobs: int = 1) -> float:
    """Rms in noise on runs that were left out of the fit, some at a time; of a single run on its end, told from its
    beginning; without bounds where a run breaks down."""
    return tell_unseen(hypothesis, jobs, False).chi


def tell_unseen(
    hypothesis: Hypothesis, jobs: int = 1, with_rest: bool = True, heats: Sequence[UnknownHeat | None] = ()
) -> Unseen:  # fmt: skip
    """The same with their density; with_rest: whether heat of any course stands beside the hypothesis; heats: by part,
    one that was learned beside another hypothesis and stands here, too, where that makes runs more likely."""
    return Unseen.together(run_all(partial(_tell_part, with_rest), _list_parts(hypothesis, heats), jobs))


def tell_all_unseen(hypotheses: Sequence[Hypothesis], jobs: int = 1, with_rest: bool = True) -> list[Unseen]:
    """The same of several, the parts of all side by side."""
    parted = [_list_parts(h) for h in hypotheses]
    told = iter(run_all(partial(_tell_part, with_rest), [*chain(*parted)], jobs))
    return [Unseen.together([next(told) for _ in parts]) for parts in parted]


def _list_parts(h: Hypothesis, heats: Sequence[UnknownHeat | None] = ()) -> list[_Part]:
    folds = _list_folds(len(h.case.recordings))
    return [*zip(repeat(h), folds, chain(heats, repeat(None)), strict=False)]


def _list_folds(count: int) -> list[range]:
    """Which runs are left out at a time; none of a single one."""
    return [range(k, count, FOLDS) for k in range(min(FOLDS, count))] if count > 1 else [range(0)]


def _tell_part(with_rest: bool, of: _Part) -> Unseen:
    h, left_out, beside = of
    try:
        return _tell_without(h, with_rest, left_out, beside) if left_out else _tell_end(h)
    except (Failed, np.linalg.LinAlgError):
        return Unseen.broken()


def _tell_without(
    h: Hypothesis, with_rest: bool, left_out: Sequence[int], beside: UnknownHeat | None
) -> Unseen:  # fmt: skip
    """Runs that are told by a fit to the others."""
    rest = h.case.of([k for k in range(len(h.case.recordings)) if k not in left_out])
    others = fit_hypothesis(rest, h.machine, h.found, h.own, h.values, steps=LEFT_OUT_STEPS)
    told = ForetoldRuns(_tell_by(others, h.case.of(left_out)), others.linearised.reduced[0])
    heat = find_rest(others, refit=False).heat if with_rest else None
    more = max((_add_rest(told, each) for each in (heat, beside) if each is not None), default=0.0)
    own, every = _list_own(h), np.ones(len(told.left), bool)
    known, pull = told.known[np.ix_(own, own)], told.seen.slopes[own] @ told.seen.left
    return Unseen(_misfit_of(told.seen, own, known, pull, every), len(every), told.density + more, heat)


def _list_own(h: Hypothesis) -> list[int]:
    """Where the numbers of findings stand among all."""
    paths = {p.path for p in h.own if not p.field.is_instant}
    return [i for i, p in enumerate(h.fit.problem.parameters) if p.path in paths]


def _misfit_of(seen: Linearised, own: Sequence[int], known: Array, pull: Array, counted: Mask) -> float:
    """Of some rows of runs at the numbers of others, those of findings (own) moved with the constants of these runs as
    far as others leave them free: |r − xᵀS|² + aᵀ Λ a and what constants are strained by, x of a and of constants;
    known: Λ; pull: what draws a. As they stand where that leaves less."""
    free, (mean, spread) = seen.free, seen.problem.prior
    stands = float(np.sum(seen.left[counted] ** 2)) + strain_of(seen)
    if not own:
        return stands
    S, n = seen.slopes[[*own, *range(free, len(seen.slopes))]], len(own)
    precision = S @ S.T + np.diag(np.concatenate([np.zeros(n), spread[free:] ** -2.0]))
    at = S[:n, counted]
    precision[:n, :n] = known + at @ at.T
    moved = np.linalg.solve(precision, np.concatenate([pull, np.zeros(len(S) - n)]))
    left = (seen.left - moved @ S)[counted]
    strain = np.sum(((seen.eta + moved[n:] - mean[free:]) / spread[free:]) ** 2) - len(seen.eta)
    return min(stands, float(left @ left + max(strain, 0.0) + moved[:n] @ known @ moved[:n]))


def _tell_by(h: Hypothesis, case: Case) -> Linearised:
    """Other runs at the numbers of a fit, the priors of their own constants narrowed by the misfit that it leaves:
    readings that it leaves at χ do not tell them better than that."""
    seen = linearise(case.problem(h.machine, h.fit.problem.parameters), h.fit.theta)
    return seen.temper(1.0, max(1.0, h.chi))


def _add_rest(told: ForetoldRuns, heat: UnknownHeat) -> float:
    """What heat of any course adds to the log probability of runs, learned on others."""
    return predict_unknown(told.seen, heat, told.precision, told.left) if heat.gain > 0 else 0.0


def _tell_end(h: Hypothesis) -> Unseen:
    """What follows the beginning of a run, told by a fit to that."""
    others = fit_hypothesis(h.case.until(BEGINNING), h.machine, h.found, h.own, h.values, steps=LEFT_OUT_STEPS)
    seen = _tell_by(others, h.case)
    late = np.concatenate([~d.ends_before(BEGINNING)[d.known] for d in seen.problem.data])
    own = _list_own(h)
    early = seen.slopes[own][:, ~late]
    known = early @ early.T + np.diag(seen.problem.prior[1][own] ** -2.0)
    misfit = _misfit_of(seen, own, known, seen.pull[own], late)
    return Unseen(misfit, int(late.sum()), -misfit / 2)
