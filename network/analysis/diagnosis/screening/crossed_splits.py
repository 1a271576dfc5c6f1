"""Whether what explains one half of the recordings best explains the other half, too, that it was not chosen on.

Of all shapes that were screened the one with the best linear score on half A, everything else refitted to A alone, is
tested with its sign on what half B adds to A; then the other way round. With g, κ the score of the shape d about a
refit to all rows, g_A, κ_A about one to A, r₁ what is left of B with d, p_B = p − p_A,

    t = (g − g_A) / √((κ − κ_A) |r₁|² / ν),   ν = n_eff − p_B − 1,

is Student's with ν degrees of freedom where nothing is missing, however greedy the choice: g − g_A is the score of B's
innovations given A, and independent of A. (Refits to B alone are not: a number that is far from its prior pulls both
halves alike.) The two p-values are not independent, as both halves may choose shapes that are alike, so that neither
Fisher's sum nor a product may be taken; twice their mean is valid under any dependence, and small only where both are.
Sources: Cox, Biometrika 62 (1975) 441 (chosen on some data, tested on others); LISDD, arXiv 2606.23215 (n_eff);
Rüschendorf, Adv. Appl. Prob. 14 (1982) 623, and Vovk & Wang, Biometrika 107 (2020) 791 (twice the mean); unverified.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.stats import t as student

from network.analysis.calibration.gauss_newton import Linearised
from network.analysis.diagnosis.screening.refitted_half import RefittedHalf, effective_samples
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.declaration.declare import Array, Mask

if TYPE_CHECKING:
    from network.analysis.diagnosis.candidates.candidate import Candidate

SEEN = 1e-6
"""κ from which a shape changes something that can be seen."""


@dataclass(frozen=True)
class UnseenTest:
    """p_values: chosen on A and tested on B, and the other way round; chosen: kind, places and channels of what A and B
    choose; of_one: whether the halves are those of one recording."""

    p_values: tuple[float, float]
    chosen: tuple[tuple[str, ...], tuple[str, ...]]
    of_one: bool = False

    @property
    def p_value(self) -> float:
        return min(1.0, sum(self.p_values))

    @property
    def halves_agree(self) -> bool:
        """Whether both halves choose the same kind at the same place."""
        return self.chosen[0] == self.chosen[1]

    @property
    def rejects(self) -> bool:
        """Whether chance would not have it."""
        return self.p_value <= 1 - SETTINGS.quantile

    @property
    def speaks_against(self) -> bool:
        """Whether chance alone is more likely than not to show as much in recordings that did not choose."""
        return not self.of_one and self.p_value > SETTINGS.half

    @property
    def shows_again(self) -> bool:
        """Whether what is looked for beside a finding shows where it was not chosen: both halves choose the same, or
        chance would not have it twice over, for it was looked for twice."""
        return self.of_one or self.halves_agree or self.p_value <= (1 - SETTINGS.quantile) ** 2

    @property
    def doubt(self) -> str:
        """Why what was found is not sure; empty where that is not so, or it is of one recording and not sure anyhow."""
        if self.rejects or self.of_one:
            return ""
        return f"what one half of the recordings picks out does not show in the other (p = {self.p_value:.2g})"

    def summary(self) -> dict[str, Any]:
        return {"p_unseen": self.p_value, "halves_agree": self.halves_agree}


@dataclass(frozen=True, eq=False)
class _Chosen:
    gain: float
    sign: float
    name: tuple[str, ...]
    shape: Array


@dataclass(eq=False)
class CrossedSplits:
    """Two halves and both together, and what explains each half best of all that was looked at so far."""

    halves: tuple[RefittedHalf, RefittedHalf]
    whole: RefittedHalf
    of_one: bool = False
    best: list[_Chosen | None] = field(default_factory=lambda: [None, None])

    def look(self, candidates: Sequence[Candidate], shapes: Array, most: float) -> None:
        """Looks at shapes (candidates, rows of all recordings; whitened) at strengths up to a multiple of the usual."""
        told = [half.score(shapes) for half in self.halves]
        is_seen = np.logical_and(*(kappa > SEEN for _, kappa in told))
        least = np.array([-most if c.is_signed else 0.0 for c in candidates])
        for k, (g, kappa) in enumerate(told):
            a = np.clip(g / np.maximum(kappa, SEEN), least, most)
            gain = np.where(is_seen, a * g - a * a * kappa / 2, -np.inf)
            i, before = int(np.argmax(gain)), self.best[k]
            if is_seen[i] and (before is None or gain[i] > before.gain):
                sign = -1.0 if a[i] < 0 else 1.0
                self.best[k] = _Chosen(float(gain[i]), sign, name_of(candidates[i]), shapes[i].copy())

    def test(self) -> UnseenTest | None:
        """None where nothing was looked at."""
        of_a, of_b = self.best
        if of_a is None or of_b is None:
            return None
        p = self._test(0, of_a), self._test(1, of_b)
        return UnseenTest(p, (of_a.name, of_b.name), self.of_one)

    def _test(self, k: int, best: _Chosen) -> float:
        """p-value, on what the other half adds, of what half k chose."""
        a, b = self.halves[k], self.halves[1 - k]
        (g,), (kappa,) = (x - y for x, y in zip(*(of.score(best.shape[None]) for of in (self.whole, a)), strict=True))
        rest = self.whole.rest(best.shape)[b.rows]
        free = effective_samples([rest[own] for own in b.series]) - (self.whole.taken - a.taken) - 1
        spread = np.sqrt(max(kappa, SEEN) * float(rest @ rest) / max(free, 1.0))
        return float(student.sf(best.sign * g / spread, max(free, 1.0)))


def name_of(c: Candidate) -> tuple[str, ...]:
    return (c.kind.kind, *sorted({*c.places}), *c.channels)


def halve(fit: Linearised, further: Array | None = None) -> CrossedSplits | None:
    """Every second recording against the others; of a single one the first half of its cells against the second. None
    where a half has no readings, or cannot be fitted. further: whitened shapes (·, rows) that are refitted besides, of
    a size with a prior 1σ of one."""
    halves, series = _first_half(fit), _label_series(fit)
    if halves.all() or not halves.any():
        return None
    (mean, spread), at = fit.problem.prior, np.concatenate([fit.theta, fit.eta])
    more = np.empty((0, len(series))) if further is None else further
    slopes, wide = np.vstack([fit.slopes, more]), np.append(spread, np.ones(len(more)))
    strain = np.append((mean - at) / spread, np.zeros(len(more)))
    try:
        every = halves, ~halves, halves | ~halves
        a, b, whole = (RefittedHalf.of(rows, slopes, fit.left, strain, wide, series) for rows in every)
    except np.linalg.LinAlgError:
        return None
    return CrossedSplits((a, b), whole, len(fit.problem.data) < 2)


def _first_half(fit: Linearised) -> Mask:
    """Which rows are of the first half."""
    data = fit.problem.data
    if len(data) < 2:
        cells = data[0].run.knots.cells
        return np.asarray(np.tile(np.arange(cells) < cells / 2, len(data[0].run.channels))[data[0].known])
    return np.concatenate([np.full(int(d.known.sum()), k % 2 == 0) for k, d in enumerate(data)])


def _label_series(fit: Linearised) -> Array:
    """A label for each channel of each run, by row."""
    sizes = [len(root) for whiten in fit.problem.whiteners for root in whiten.roots]
    return np.repeat(np.arange(len(sizes)), sizes)
