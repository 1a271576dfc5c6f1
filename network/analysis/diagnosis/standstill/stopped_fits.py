"""Fits to recordings as they are and with a driver stopped in some windows, and what the second explains."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from network.analysis.calibration.linearised import linearise
from network.analysis.calibration.misfit import channel_misfits, chi_of, list_channel_residuals
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.intermittent.change_points import Windows
from network.analysis.diagnosis.intermittent.channel_fault import FAULTY
from network.analysis.diagnosis.latent_heat.locate import explain_unknown_at_most
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.standstill.driver import Driver
from network.analysis.diagnosis.standstill.standstill_edges import Edges
from network.analysis.diagnosis.standstill.standstill_fault import StandstillFault
from network.analysis.diagnosis.steps.ranking import belief_in_nothing
from network.platform.refusal import Failed, Refused
from network.recordings.recording import Recording

Stops = tuple[Windows, ...]


@dataclass(frozen=True, eq=False)
class Stopped:
    """Fits to the recordings as they are and with a driver stopped in some windows; tried: stretches that one of them
    was chosen from; edges: how well those of the windows are known."""

    before: Hypothesis
    after: Hypothesis
    driver: Driver
    stops: Stops
    tried: int
    edges: Edges | None = None

    @property
    def gain(self) -> float:
        return self.after.evidence - self.before.evidence

    @cached_property
    def worth(self) -> float:
        """What it explains of the channels, where each counts by what is left of it and how long that lasts [nats]."""
        left = channel_misfits(self.after.fit)
        before, after = (square_channels(h) for h in (self.before, self.after))
        return sum((before[n] - after[n]) / 2 / left[n].factor(is_whole=True) ** 2 for n in left)

    @property
    def price(self) -> float:
        """What chance reaches where each window was chosen from so many."""
        return SETTINGS.least + sum(map(len, self.stops)) * float(np.log(self.tried))

    @property
    def lasts(self) -> bool:
        """Whether every stop lasts for more than its edges leave open; a relay that begins out of step seems to stand
        for next to nothing."""
        if self.edges is None:
            return True
        windows = (window for own in self.stops for window in own)
        pairs = zip(windows, self.edges.lasts, strict=True)
        return all(end - begin > SETTINGS.errors * std for (begin, end), std in pairs)

    @property
    def beats_unknown(self) -> bool:
        """Whether with unknown heat or an unknown error beside it it explains more than these alone."""
        alone, beside = (explain_unknown_at_most(h.linearised, h.machine) for h in (self.before, self.after))
        return self.gain + beside > alone

    def tell(self, recordings: tuple[Recording, ...]) -> StandstillFault:
        """As a fault of the recordings as they are."""
        belief = 1 - belief_in_nothing(self.worth - self.price)
        std = (0.0, 0.0) if self.edges is None else (self.edges.begins[0], self.edges.lasts[0])
        sure, gain = min(belief, FAULTY), self.gain - self.price
        return StandstillFault(recordings, gain, self.driver, self.stops, std, sure)


def square_channels(h: Hypothesis) -> dict[str, float]:
    """Σ of the squares of what is left of every channel, in noise."""
    squares: dict[str, float] = {}
    for name, left in list_channel_residuals(h.fit):
        squares[name] = squares.get(name, 0.0) + float(left @ left)
    return squares


def fit_stopped(h: Hypothesis, driver: Driver, stops: Stops, tried: int, like: Stopped | None = None) -> Stopped | None:
    """Fits to recordings with the stops in them and without; like: an earlier one, to begin from. None where they
    fail."""
    try:
        before = _fit_as_it_is(h, driver, driver.correct(h.case, stops, False))
        right = driver.correct(h.case, stops)
        after = _fit(h, driver, right, None if like is None else like.after)
        if after.evidence < before.evidence:
            after = max(after, _fit(h, driver, right, before), key=lambda fit: fit.evidence)
    except (Failed, Refused, np.linalg.LinAlgError):
        return None
    return Stopped(before, after, driver, stops, tried)


def _fit(h: Hypothesis, driver: Driver, case: Case, begin: Hypothesis | None) -> Hypothesis:
    """From the numbers of a fit, or from those of the file: of a fit to what is not true they are bent."""
    values = h.own_values if begin is None else begin.values
    return fit_hypothesis(case, driver.put_in(h.machine), h.found, h.own, values)


def _fit_as_it_is(h: Hypothesis, driver: Driver, case: Case) -> Hypothesis:
    """A fit to recordings laid out as they are with stops in them: fitted only where readings do not count there."""
    if driver.list_gated(h.machine):
        return _fit(h, driver, case, h)
    machine, fit = driver.put_in(h.machine), h.fit
    at = linearise(case.problem(machine, fit.problem.parameters), fit.theta)
    return replace(h, case=case, machine=machine, fit=at.temper(1.0, max(1.0, chi_of(at))))
