"""Where a fit is linear about: temperatures of the parts at the start of every run, and constants that drive it.

With N(θ) the slopes by η about η₀, a step in θ takes y(θ) + N η for the run, N held. What it neglects, ∂N/∂θ · η, is
nothing where η is small; a room that is 10 K from where it was stated makes it the larger part of the slope by θ. Then
the run is laid out anew about the η that is most probable, and that part is in y(θ).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from network.analysis.calibration.estimate import Estimate
from network.analysis.calibration.linearised import Linearised, linearise
from network.analysis.calibration.measured_means import Measured, RunPoint
from network.catalogue.declaration.declare import Array
from network.platform.refusal import Failed


def move_points(at: Linearised | Estimate) -> tuple[RunPoint, ...]:
    """The constants of every run as a fit finds them."""
    return tuple(RunPoint(*of) for of in zip(move_starts(at), move_inputs(at), strict=True))


def points_by_file(at: Linearised | Estimate) -> dict[str, RunPoint]:
    """The same by the file of the run."""
    return dict(zip((d.recording.file for d in at.problem.data), move_points(at), strict=True))


def move_starts(at: Linearised | Estimate) -> tuple[Mapping[str, float], ...]:
    """Temperatures of the parts at the start of every run as a fit finds them [°C]."""
    return tuple(d.move_start(own[: len(d.starts)]) for d, own in _own_constants(at))


def move_inputs(at: Linearised | Estimate) -> tuple[Mapping[str, float], ...]:
    """Uncertain constants that drive every run as a fit finds them [SI]."""
    return tuple(d.move_inputs(own[len(own) - len(d.inputs) :]) for d, own in _own_constants(at))


def move_edges(at: Linearised | Estimate) -> tuple[Array, ...]:
    """How much later than recorded a fit finds every jump, then every switching, of each run [s]."""
    return tuple(own[len(d.starts) : len(d.starts) + len(d.edges)] for d, own in _own_constants(at))


def expand_anew(at: Linearised) -> Linearised:
    """The same θ, linear about the starts and inputs that are most probable there, bent laws by what they added nearby;
    as it is where that runs away."""
    try:
        problem = replace(at.problem.about(move_points(at)), moves=True)
        return linearise(problem, at.theta, at.whole_bent)
    except Failed:
        return at


def _own_constants(at: Linearised | Estimate) -> Iterator[tuple[Measured, Array]]:
    """Every run with what is most probable of its own constants."""
    first = len(at.problem.offsets)
    for d in at.problem.data:
        yield d, at.eta[first : first + len(d.own)]
        first += len(d.own)
