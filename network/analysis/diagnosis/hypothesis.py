"""A case: a machine, its recordings laid out for fits, and hypotheses about what is missing, each fitted."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from network.analysis.calibration.estimate import Estimate
from network.analysis.calibration.expansion_point import move_points
from network.analysis.calibration.gauss_newton import STEPS, Linearised, Problem, linearise, make_problem, minimise
from network.analysis.calibration.growing_horizon import settle_starts
from network.analysis.calibration.linearised import weigh_anew
from network.analysis.calibration.measured_means import Measured, RunPoint, weigh_recording
from network.analysis.calibration.misfit import channel_misfits, chi_of, strain_of
from network.analysis.calibration.noise import Noise
from network.analysis.diagnosis.additive_correction import AdditiveCorrection
from network.analysis.diagnosis.candidates import Candidate, lay_over
from network.analysis.diagnosis.recorded_powers import gather_runs
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.time_budget import TimeBudget
from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.proposals import Runs
from network.engine.assembly import build
from network.engine.response.model import Prediction
from network.engine.response.parameters import Parameter, at_values, centres, free_parameters, values_at
from network.machine.machine import Machine
from network.platform.refusal import Failed
from network.recordings.inputs import Start
from network.recordings.recording import Recording

Until = Callable[[Linearised], bool]

CONTINUATION, CONTINUATION_STEPS = (0.25, 0.4, 0.6, 0.8), 3
"""Shares of the runs over which relays are led back into step, and the steps of the fits there."""


def never(at: Linearised) -> bool:
    """A fit that is not given up."""
    return False


@dataclass(frozen=True, eq=False)
class Case:
    """Recordings of a machine. sigma: white 1σ of a sample by channel where it was told from residuals; noise: coloured
    noise beside it; lacking: of each run, what its channels have more on finer lumps than on those of the machine,
    which stands in for them; began: of each run, the constants about which it is linear."""

    machine: Machine
    recordings: tuple[Recording, ...]
    start: Start | None = None
    noise: Noise = field(default_factory=Noise)
    sigma: Mapping[str, float] = field(default_factory=dict)
    lacking: tuple[AdditiveCorrection, ...] = ()
    began: tuple[RunPoint, ...] = ()
    budget: TimeBudget = field(default_factory=TimeBudget)

    @cached_property
    def drivers(self) -> tuple[str, ...]:
        """Columns of all recordings that are no channel of the machine: inputs, and what may drive missing physics."""
        shared = set.intersection(*(({*r.columns, *r.constants}) for r in self.recordings))
        return tuple(sorted(shared - {*self.machine.sensors}))

    @cached_property
    def runs(self) -> Runs:
        """What the recordings bring to proposals."""
        return gather_runs(self.machine, self.recordings, self.drivers)

    def of(self, runs: Sequence[int]) -> Case:
        """The case of some of its recordings."""
        lacking = tuple(self.lacking[i] for i in runs) if self.lacking else ()
        began = tuple(self.began[i] for i in runs) if self.began else ()
        return replace(self, recordings=tuple(self.recordings[i] for i in runs), lacking=lacking, began=began)

    def on(self, recordings: tuple[Recording, ...]) -> Case:
        """The case on other recordings, of which nothing is known beforehand."""
        return replace(self, recordings=recordings, start=None, lacking=(), began=())

    def until(self, share: float) -> Case:
        """The case of the beginnings of its recordings."""
        return replace(self, recordings=tuple(r.until(share) for r in self.recordings))

    def lay_out(self, machine: Machine) -> tuple[Measured, ...]:
        """The recordings for fits of one machine (this one, refined or with something added)."""
        network = build(machine)
        data = [weigh_recording(machine, r, self.start, self._usable(r), network) for r in self.recordings]
        laid = [replace(d, sigma={n: self.sigma.get(n, s) for n, s in d.sigma.items()}) for d in data]
        if self.lacking:
            laid = [replace(d, means=d.means - lack.at(d)) for d, lack in zip(laid, self.lacking, strict=True)]
        if self.began:
            laid = [d.about(point) for d, point in zip(laid, self.began, strict=True)]
        return tuple(laid)

    def _usable(self, recording: Recording) -> list[str]:
        """Drivers without gaps."""
        gaps = {n for n, c in recording.columns.items() if not np.isfinite(c.values).all()}
        return [n for n in self.drivers if n in recording.constants or n not in gaps]

    def problem(self, machine: Machine, parameters: Sequence[Parameter], offsets: bool = True) -> Problem:
        problem = make_problem(machine, parameters, self.lay_out(machine), self.noise)
        return problem if offsets else replace(problem, offsets=())


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A machine with what is supposed to be missing in it, fitted.

    found: the patches laid over it, in their order; own: their numbers, free along with those of the file; fit: an
    estimate where it is only compared with others; beside: its log evidence with heat of any course beside it, where
    that was weighed.
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
        return self.fit.log_evidence

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


def fit_hypothesis(
    case: Case, machine: Machine, candidates: Sequence[Candidate] = (), further: Sequence[Parameter] = (),
    start: Mapping[str, float] | None = None, offsets: bool = True, steps: int = STEPS, until: Until = never,
) -> Hypothesis:  # fmt: skip
    """Fits a machine with the patches already in it; `start`: numbers by path to begin from; until: where it is given
    up. Raises BudgetReached."""
    case.budget.check()
    parameters = parameters_of(machine, further)
    theta = theta_of(parameters, start or {})
    fit = minimise(case.problem(machine, parameters, offsets), theta, steps, case.budget.check, until)
    return Hypothesis(case, machine, tuple(candidates), tuple(further), fit)


def theta_of(parameters: Sequence[Parameter], values: Mapping[str, float]) -> Array:
    """Numbers by path as a fit has them, those that are not told at the centres of their priors."""
    theta = centres(parameters)
    for i, p in enumerate(parameters):
        value = values.get(p.path)
        if value is not None and (value > 0 or not p.is_log):
            theta[i] = np.log(value) if p.is_log else value
    return theta


def state(case: Case, machine: Machine, values: Mapping[str, float]) -> Hypothesis:
    """A machine at some numbers, nothing fitted."""
    parameters = parameters_of(machine, ())
    fit = linearise(case.problem(machine, parameters), theta_of(parameters, values))
    return Hypothesis(case, machine, (), (), fit.temper(1.0, max(1.0, chi_of(fit))))


def fit_lasting(h: Hypothesis) -> Hypothesis:
    """A hypothesis fitted anew without constant errors of sensors, each channel counting by its misfit and how long
    that lasts."""
    misfit, data = channel_misfits(h.fit), h.fit.problem.data
    sigma = {n: s * misfit[n].factor(is_whole=True) for d in data for n, s in d.sigma.items()}
    return fit_hypothesis(replace(h.case, sigma=sigma), h.machine, h.found, h.own, h.values, offsets=False)


def settle_hypothesis(h: Hypothesis, is_late: Callable[[], bool] = lambda: False) -> Hypothesis:
    """The hypothesis about the starts that it finds, where relays switch; once it is late, what there is."""
    at = settle_starts(h.linearised, is_late=is_late)
    return replace(h, case=replace(h.case, began=tuple(d.point for d in at.problem.data)), fit=at)


def fit_findings(
    case: Case, machine: Machine, candidates: Sequence[Candidate], values: Mapping[str, float], in_step: bool = True,
    steps: int = STEPS, until: Until = never,
) -> Hypothesis | None:  # fmt: skip
    """Findings laid over a machine one after the other, fitted from some numbers; None where they do not fit. in_step:
    whether relays switch at these numbers as they did; else they are led over ever more of the runs."""
    over = lay_over(machine, candidates)
    if over is None:
        return None
    machine, laid = over
    further = [p for c in laid for p in c.own]
    try:
        if not in_step and any(c.switches for c in laid):
            values = fit_by_continuation(case, machine, laid, further, values, CONTINUATION).values
        return fit_hypothesis(case, machine, laid, further, values, steps=steps, until=until)
    except (Failed, np.linalg.LinAlgError):
        return None


def fit_by_continuation(
    case: Case, machine: Machine, candidates: Sequence[Candidate], further: Sequence[Parameter],
    values: Mapping[str, float], shares: Sequence[float],
) -> Hypothesis:  # fmt: skip
    """A hypothesis fitted a few steps over ever more of the runs, to the last of some shares of them."""
    fit = fit_hypothesis(case.until(shares[0]), machine, candidates, further, values, steps=CONTINUATION_STEPS)
    for share in shares[1:]:
        fit = fit_hypothesis(case.until(share), machine, candidates, further, fit.values, steps=CONTINUATION_STEPS)
    return fit


def parameters_of(machine: Machine, own: Sequence[Parameter]) -> tuple[Parameter, ...]:
    """The uncertain numbers of the file and those of what is supposed."""
    paths = {p.path for p in own}
    return (*(p for p in free_parameters(machine) if p.path not in paths), *own)


def start_from(case: Case, hypothesis: Hypothesis) -> Case:
    """The case about the starts that a hypothesis finds: where relays switch, the way there is not a straight one."""
    return replace(case, began=move_points(hypothesis.fit))


def reweight(case: Case, hypothesis: Hypothesis) -> Hypothesis:
    """The same hypothesis under another noise, numbers and starts as they are."""
    case = replace(case, began=hypothesis.case.began or case.began)
    before, problem = hypothesis.fit, case.problem(hypothesis.machine, hypothesis.fit.problem.parameters)
    if isinstance(before, Linearised) and problem.follows(before.problem):
        fit = weigh_anew(before, problem)
    else:
        fit = linearise(problem, before.theta)
    return replace(hypothesis, case=case, fit=fit.temper(1.0, max(1.0, chi_of(fit))))
