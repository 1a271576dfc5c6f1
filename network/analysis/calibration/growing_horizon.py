"""Numbers of a machine with relays from the beginning of its recordings, and then ever more of them.

Over many cycles a model whose relays cycle a little too fast is soon out of step, and no step downhill leads back: J
has as many minima as there are cycles. Over the first few it cannot fall out of step; what is found there is good
enough for somewhat longer. How much longer is told by the misfit: where it leaps the fit has slipped a cycle, and less
is added to where it had not. Where it is known what one that keeps step leaves over any share, it leaps beyond that,
and the longest share over which it does not is looked for first, from the whole down. Continuation with a step that
follows what happened: Allgower & Georg, Numerical Continuation Methods (1990), ch. 6; unverified.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np

from network.analysis.calibration.expansion_point import move_points
from network.analysis.calibration.gauss_newton import STEPS as MOST
from network.analysis.calibration.gauss_newton import minimise
from network.analysis.calibration.linearised import Linearised, linearise
from network.analysis.calibration.measured_means import Measured, RunPoint, weigh_recording
from network.analysis.calibration.misfit import chi_of
from network.analysis.calibration.problem import Problem, make_problem
from network.catalogue.declaration.declare import Array
from network.catalogue.mechanisms.mechanism import Relay
from network.engine.response.parameters import Parameter, at_prior_centres, centres
from network.machine.machine import Machine
from network.platform.refusal import Failed, Refused
from network.platform.stages import Told, say
from network.recordings.inputs import Start
from network.recordings.recording import Recording

FIRST, GROWTH, LEAST_GROWTH = 1 / 16, 2.0, 1.15
"""Share of the recordings that is fitted first, by how much the next is longer, and at least: what slips then lacks
more than its numbers, and is not waited for."""
LEAST_GROWTH_KNOWN = GROWTH**0.5
"""The same where it is known what is left: the search stands on modes that were read, and does not wait for more."""
FEWEST = 8
"""Samples of every recording that are fitted first, at least."""
LEAP = 1.25
"""Ratio of misfits χ from one share to the next, or to what is known to be left, from which a cycle was slipped: one
that slips leaves its whole swing, many times the noise, in all that follows."""
STEPS, ROUNDS_ON_THE_WAY, CLOSE_ON_THE_WAY = 3, 8, 0.02
"""Of a fit on the way: steps before it looks at its starts anew, how often it does, and the least share of J that once
more must bring: as much moves χ by a hundredth, and a leap is a quarter."""
ROUNDS, CLOSE = 4, 1.0
"""How often a fit is repeated about the starts it finds, and the least that another time must better J, in squares of
the misfit: less moves no number by its standard error."""


def has_relays(machine: Machine) -> bool:
    """Whether something in it switches."""
    return any(isinstance(entry, Relay) for entry in machine.by_path.values())


@dataclass(frozen=True, eq=False)
class InStep:
    """Where relays are in step over whole recordings: θ and the constants of each run. left_over: the misfit χ over a
    first share of the recordings that one leaves which is in step with them, where it is known."""

    theta: Array
    points: tuple[RunPoint, ...]
    left_over: Callable[[float], float] | None = None

    @classmethod
    def of(cls, at: Linearised) -> InStep:
        """Where a fit came to."""
        return cls(at.theta, move_points(at))


def begin_in_step(
    machine: Machine, parameters: Sequence[Parameter], data: Sequence[Measured], start: Start | None,
    is_late: Callable[[], bool], tell: Told = lambda share: None, about: InStep | None = None,
) -> InStep | None:  # fmt: skip
    """Where relays stay in step over whole recordings; None for a machine without relays, or where it always breaks
    down. about: from where, by default from the priors' centres; where it is known what is left there, it begins with
    the most of the recordings over which they are in step at once."""
    if not parameters or not has_relays(machine):
        return None
    about = about or InStep(centres(parameters), tuple(d.point for d in data))
    fit = partial(_fit_share, machine, parameters, data, start)
    first = max(FIRST, *(FEWEST / len(d.recording.t) for d in data))
    found, done = _find_longest(fit, about, first, is_late, tell)
    left, growth, is_patient = 1.0, GROWTH, True
    while done < 1 and not is_late():
        share = min(max(done * growth, first), 1.0)
        _say_share(tell, share)
        most = LEAP * max(_expect(about, share, left), 1.0) if done and is_patient else np.inf
        at = fit(share, found or about, most)
        if most < np.inf and (at is None or chi_of(at) > most):
            growth = float(np.sqrt(growth))
            is_patient = growth > (LEAST_GROWTH if about.left_over is None else LEAST_GROWTH_KNOWN)
            continue
        if at is not None:
            found, left = InStep.of(at), chi_of(at)
        done, growth = share, min(GROWTH, growth**1.5) if is_patient else GROWTH
    return found


def know_left_over(
    machine: Machine, parameters: Sequence[Parameter], recordings: Sequence[Recording], start: Start | None,
    about: InStep,
) -> Callable[[float], float]:  # fmt: skip
    """The misfit χ of a machine over any first share of recordings, each worked out once."""
    return cache(partial(_leave_over, machine, parameters, recordings, start, about))


def _leave_over(
    machine: Machine, parameters: Sequence[Parameter], recordings: Sequence[Recording], start: Start | None,
    about: InStep, share: float,
) -> float:  # fmt: skip
    """Over one share; infinite where it breaks down."""
    try:
        problem = lay_out_share(machine, parameters, recordings, start, share)
        at = linearise(problem.about(about.points), about.theta)
        return chi_of(at.temper(1.0, max(1.0, chi_of(at))))
    except (Failed, Refused, np.linalg.LinAlgError):
        return np.inf


def _find_longest(
    fit: Callable[[float, InStep, float], Linearised | None], about: InStep, first: float,
    is_late: Callable[[], bool], tell: Told,
) -> tuple[InStep | None, float]:  # fmt: skip
    """Where relays are in step at once over the longest share of the recordings, and that share, from the whole down;
    none where it is not known what is left there, or they are in step over none that is longer than the first."""
    share = 1.0
    while share > first and about.left_over is not None and not is_late():
        _say_share(tell, share)
        most = LEAP * max(about.left_over(share), 1.0)
        at = fit(share, about, most) if most < np.inf else None
        if at is not None and chi_of(at) <= most:
            return InStep.of(at), share
        share /= GROWTH
    return None, 0.0


def _expect(about: InStep, share: float, before: float) -> float:
    """What may be left over a share: as is known, or as over the share before it."""
    return before if about.left_over is None else about.left_over(share)


def _say_share(tell: Told, share: float) -> None:
    some = "all" if share == 1 else f"the first {100 * share:.2g} %"
    say(tell, f"what switches falls into step: {some} of the recordings")


def lay_out_share(
    machine: Machine, parameters: Sequence[Parameter], recordings: Sequence[Recording], start: Start | None,
    share: float,
) -> Problem:  # fmt: skip
    """The problem of a first share of the recordings, without constant errors of sensors."""
    known = at_prior_centres(machine, parameters)
    some = [weigh_recording(known, r if share >= 1 else r.until(share), start) for r in recordings]
    return replace(make_problem(machine, parameters, some), offsets=())


def _fit_share(
    machine: Machine, parameters: Sequence[Parameter], data: Sequence[Measured], start: Start | None, share: float,
    about: InStep, most: float,
) -> Linearised | None:  # fmt: skip
    """A few steps from there, about the starts that these lead to, unless more than a leap lies between the first of
    them and the `most` that χ may be; None where it breaks down."""
    try:
        problem = lay_out_share(machine, parameters, [d.recording for d in data], start, share).about(about.points)
        at = minimise(problem, about.theta, STEPS)
        if chi_of(at) > LEAP * most:
            return at
        for _ in range(ROUNDS_ON_THE_WAY):
            before, at = at, _fit_about_its_starts(at, STEPS)
            if not before.cost - at.cost > CLOSE_ON_THE_WAY * before.cost:
                break
        return at
    except (Failed, Refused, np.linalg.LinAlgError):
        return None


def settle_starts(at: Linearised, steps: int = MOST, is_late: Callable[[], bool] = lambda: False) -> Linearised:
    """A minimum about the starts and rooms that it finds, as often as that lowers J: what switches hangs on them, and
    not along a straight line. The same of a machine without relays; once it is late, what there is."""
    for _ in range(ROUNDS if has_relays(at.problem.model.machine) else 0):
        if is_late():
            break
        before, at = at, _fit_about_its_starts(at, steps)
        if not before.cost - at.cost > CLOSE * max(1.0, chi_of(at)) ** 2:
            break
    return at


def _fit_about_its_starts(at: Linearised, steps: int) -> Linearised:
    """The better of a fit and another that begins there, about the starts that it finds."""
    return min(at, minimise(at.problem.about(move_points(at)), at.theta, steps), key=lambda fit: fit.cost)
