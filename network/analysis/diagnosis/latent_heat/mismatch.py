"""Where a hypothesis and the recordings differ, told at the numbers that stand beside the heat that explains most.

Those that were fitted without it are bent to it: seen from there, it may sit in another part, and lean the other way.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from network.analysis.calibration.gauss_newton import narrow_priors
from network.analysis.diagnosis.hypotheses.compact_fit import expand
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.latent_heat.latent_rest import Rest, find_rest, find_rest_at, refit_together
from network.analysis.diagnosis.latent_heat.locate import locate, trace
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.settings import SETTINGS


@dataclass(frozen=True, eq=False)
class Mismatch:
    """places: where unknown heat would explain most, the most probable first; about: at whose numbers they are told."""

    places: tuple[UnknownHeat, ...]
    about: Hypothesis

    def trace(self, of: UnknownHeat) -> UnknownHeat:
        """The course of one of them, fine enough to show steps, where as much counts as noise as is left beside it."""
        return trace(self.about.linearised, of, find_rest_at(self.about, of).left)


def locate_mismatch(h: Hypothesis, is_late: Callable[[], bool] = lambda: False) -> Mismatch:
    """Of a hypothesis. All that it leaves without such heat counts as noise where places are compared; once it is late,
    at its own numbers, and only the course at those beside the heat."""
    rest = None if is_late() or h.chi <= SETTINGS.noise else find_rest(h, refit=False)
    if rest is None or is_late():
        return _tell_briefly(h)
    mismatch = _compare_places(h, _temper(refit_together(_temper(rest))).beside)
    first = mismatch.places[0]
    if first.at == rest.heat.at or is_late():
        return mismatch
    moved = refit_together(_temper(find_rest_at(mismatch.about, first)))
    return _compare_places(h, _temper(moved).beside)


def locate_beside(h: Hypothesis, rest: Rest) -> Mismatch:
    """Of a hypothesis, at the numbers that stand beside some heat."""
    return _compare_places(h, _temper(rest).beside)


def _tell_briefly(h: Hypothesis) -> Mismatch:
    """Places as its own numbers have them, and the numbers beside the heat at the first."""
    own = _compare_places(h, expand(h))
    if h.chi <= SETTINGS.noise:
        return own
    rest = refit_together(_temper(find_rest_at(own.about, own.places[0])))
    return replace(own, about=_temper(rest).beside)


def _compare_places(h: Hypothesis, about: Hypothesis) -> Mismatch:
    """At some numbers of a hypothesis."""
    noise = max(1.0, float(np.mean(h.fit.left**2)))
    return Mismatch(locate(about.linearised, about.machine, noise), about)


def _temper(rest: Rest) -> Rest:
    """With priors as narrow as what is left beside the heat has them in a fit, not what was left without it."""
    about = narrow_priors(rest.beside.linearised, float(np.sqrt(rest.left)))
    return find_rest_at(replace(rest.beside, fit=about), rest.heat)
