"""The null: the machine as it is written, its uncertain numbers at their most probable, before any physics is added.

`calibrate` tells it and `diagnose` begins from it: one estimate, so that "calibrated" means one thing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from network.analysis.calibration.estimated_constants import Numbers
from network.analysis.calibration.expansion_point import points_by_file
from network.analysis.calibration.gauss_newton import make_problem
from network.analysis.calibration.generalisation import with_numbers, with_standard_errors
from network.analysis.calibration.growing_horizon import begin_in_step, settle_starts
from network.analysis.calibration.measured_means import Measured
from network.analysis.calibration.misfit import channel_misfits, chi_of
from network.analysis.calibration.multistart import Found, best_start
from network.analysis.calibration.read_beginning import begin_beside_modes
from network.analysis.calibration.robust_fit import Fit, fit_robustly
from network.analysis.calibration.uncertainty import Uncertainty, uncertainty, uncertainty_by_curvature
from network.analysis.calibration.unit_mistakes import misread
from network.engine.response.parameters import Parameter, values_at
from network.machine.machine import Machine
from network.platform.printing import Brief
from network.platform.refusal import Complaints
from network.platform.stages import Stage, say
from network.recordings.inputs import Start


@dataclass(frozen=True, eq=False, repr=False)
class Null(Brief):
    """original: the machine as given; found: beginnings tried; fit: the minimum."""

    original: Machine
    parameters: tuple[Parameter, ...]
    found: Found
    fit: Fit

    @cached_property
    def known(self) -> Uncertainty:
        """How well each number is known, by profiles."""
        return uncertainty(self.fit.at)

    @cached_property
    def fitted(self) -> Machine:
        """With value ± standard error for each number."""
        return with_standard_errors(self.original, uncertainty_by_curvature(self.fit.at))

    @cached_property
    def machine(self) -> Machine:
        """The same, with how far it holds, which takes fits that leave runs out."""
        return self.state_numbers()

    def state_numbers(self, is_late: Callable[[], bool] = lambda: False) -> Machine:
        """The same, these fits brief once it is late."""
        return with_numbers(self.original, uncertainty_by_curvature(self.fit.at), is_late)

    @property
    def values(self) -> dict[str, float]:
        """The numbers by their paths [SI]."""
        return values_at(self.parameters, self.fit.at.theta)

    def numbers(self, start: Start | None) -> Numbers:
        """What runs are compared with."""
        at = self.fit.at
        misfit, points = channel_misfits(at), points_by_file(at)
        return Numbers(self.fitted, self.original, self.parameters, at.theta, start, misfit, points)


def estimate_null(
    machine: Machine, parameters: tuple[Parameter, ...], data: Sequence[Measured], start: Start | None = None,
    seed: int = 0, tell: Callable[[float], None] = lambda share: None, is_late: Callable[[], bool] = lambda: False,
    is_enough: Callable[[], bool] = lambda: False,
) -> Null:  # fmt: skip
    """The null of a machine on recordings laid out for it; seed: of further beginnings; tell: told the share done;
    is_late: whether one beginning that came to an end has to do; is_enough: whether no others are drawn.
    Raises Refused where a channel is in another unit than told, Failed where every run breaks down."""
    problem = make_problem(machine, parameters, data)
    read = begin_beside_modes(machine, parameters, data, start, is_late)
    begin = begin_in_step(machine, parameters, data, start, is_late, tell, read)
    alone, theta = replace(problem, offsets=()), None
    if begin is not None:
        alone, theta = alone.about(begin.points), begin.theta
    found = best_start(alone, seed, Stage(tell, 0.0, 0.6), is_late, theta, is_enough)
    found = replace(found, at=settle_starts(found.at, is_late=is_late))
    complaints = Complaints([*misread(found.at, is_late)])
    complaints.raise_if_any()
    tell(0.6)
    say(tell, f"{chi_of(found.at):.3g} σ left; weighing readings, finding their noise")
    fit = fit_robustly(problem.offsets, found.at, is_late)
    tell(0.9)
    return Null(machine, parameters, found, fit)
