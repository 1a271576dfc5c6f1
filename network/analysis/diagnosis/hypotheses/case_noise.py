"""The noise under which hypotheses of a case are compared: of the file, or as residuals show it."""

from __future__ import annotations

from dataclasses import replace

from network.analysis.calibration.coloured_noise import estimate_colours
from network.analysis.calibration.noise import Noise
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis

LOUDER = 1.15
"""White noise over the declared from which the file is not believed."""


def estimate_noise(case: Case, hypothesis: Hypothesis) -> Case:
    """The case with the noise that the residuals of a hypothesis show over short lags."""
    told = estimate_colours(hypothesis.fit.problem.data, hypothesis.predictions)
    tinted = {n: (s, tau) for n, (_, s, tau) in told.items() if s > 0}
    declared = hypothesis.fit.problem.data[0].declared
    more = {n: s > 0 or white > LOUDER * declared.get(n, 0) for n, (white, s, _) in told.items()}
    sigma = {n: white for n, (white, _, _) in told.items() if white > 0 and more[n]}
    return replace(case, noise=Noise(tinted), sigma=sigma)


def use_file_noise(case: Case) -> Case:
    """The case under the noise of the file: what a relay does over minutes must not pass for coloured noise."""
    return replace(case, noise=Noise(), sigma={})


def have_same_noise(one: Case, other: Case) -> bool:
    return (one.noise, one.sigma) == (other.noise, other.sigma)
