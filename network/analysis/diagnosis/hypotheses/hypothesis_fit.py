"""How hypotheses are fitted, stated at some numbers, and weighed anew under another noise."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from network.analysis.calibration.expansion_point import move_points
from network.analysis.calibration.gauss_newton import STEPS, Linearised, Problem, linearise, minimise
from network.analysis.calibration.growing_horizon import settle_starts
from network.analysis.calibration.linearised import weigh_anew
from network.analysis.calibration.misfit import channel_misfits, chi_of
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.candidates.candidates import lay_over
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.catalogue.declaration.declare import Array
from network.engine.response.parameters import Parameter, centres, free_parameters
from network.machine.machine import Machine
from network.platform.refusal import Failed

Until = Callable[[Linearised], bool]

CONTINUATION, CONTINUATION_STEPS = (0.25, 0.4, 0.6, 0.8), 3
"""Shares of the runs over which relays are led back into step, and the steps of the fits there."""


def never(at: Linearised) -> bool:
    """A fit that is not given up."""
    return False


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


def linearise_at_file(h: Hypothesis) -> Linearised | None:
    """A hypothesis about the numbers of the file, those of what was found as they are, for fitted ones are bent to what
    is missing or not true; None where a run breaks down."""
    try:
        return linearise(h.fit.problem, theta_of(h.fit.problem.parameters, h.own_values))
    except (Failed, np.linalg.LinAlgError):
        return None


def linearise_narrowed(problem: Problem, theta: Array) -> Linearised | None:
    """A problem about some numbers, with priors narrowed by the misfit there; None where it breaks down."""
    try:
        at = linearise(problem, theta)
    except (Failed, np.linalg.LinAlgError):
        return None
    chi = max(1.0, chi_of(at))
    return at.temper(chi, chi)


def fit_lasting(h: Hypothesis) -> Hypothesis:
    """A hypothesis fitted anew without constant errors of sensors, each channel counting by its misfit and how long
    that lasts."""
    misfit, data = channel_misfits(h.fit), h.fit.problem.data
    sigma = {n: s * misfit[n].factor(is_whole=True) for d in data for n, s in d.sigma.items()}
    return fit_hypothesis(replace(h.case, sigma=sigma), h.machine, h.found, h.own, h.values, offsets=False)


def settle_hypothesis(h: Hypothesis, is_late: Callable[[], bool] = lambda: False, steps: int = STEPS) -> Hypothesis:
    """The hypothesis about the starts that it finds, where relays switch; once it is late, or where runs break down
    there, what there is."""
    if not h.fit.problem.model.switches:
        return h
    try:
        at = settle_starts(h.linearised, steps, is_late)
    except (Failed, np.linalg.LinAlgError):
        return h
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


def lead_into_step(
    case: Case, h: Hypothesis, values: Mapping[str, float], shares: Sequence[float]
) -> Hypothesis | None:  # fmt: skip
    """A hypothesis fitted to the whole of the runs of a case, from some numbers over ever more of them; None where it
    runs away."""
    try:
        led = fit_by_continuation(case, h.machine, h.found, h.own, values, shares)
        return fit_hypothesis(case, h.machine, h.found, h.own, led.values)
    except (Failed, np.linalg.LinAlgError):
        return None


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
