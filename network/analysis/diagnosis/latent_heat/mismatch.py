"""Where a hypothesis and the recordings differ, told at the numbers that stand beside the heat that explains most.

Those that were fitted without it are bent to it: seen from there, it may sit in another part, and lean the other way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.latent_heat.latent_rest import Rest, find_rest, refit_together, rest_at
from network.analysis.diagnosis.latent_heat.locate import explain_unknown, locate, trace
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat


@dataclass(frozen=True, eq=False)
class Mismatch:
    """places: where unknown heat would explain most, the most probable first; about: the numbers that they are told at;
    left: χ² that is left there beside such heat."""

    places: tuple[UnknownHeat, ...]
    about: Linearised
    left: float

    def trace(self, of: UnknownHeat) -> UnknownHeat:
        """The course of one of them, fine enough to show steps."""
        return trace(self.about, of, self.left)


def locate_mismatch(h: Hypothesis, likely: UnknownHeat | None = None) -> Mismatch:
    """Of a hypothesis; likely: the heat that explains most of one that is much the same. All that it leaves without
    such heat counts as noise where places are compared."""
    first = find_rest(h, refit=False) if likely is None else rest_at(h, likely)
    rest = _free_starts(refit_together(first))
    about = rest.beside.linearised
    noise = max(1.0, float(np.mean(h.fit.left**2)))
    return Mismatch(locate(about, rest.beside.machine, noise), about, rest.left)


def _free_starts(rest: Rest) -> Rest:
    """With priors of starts as narrow as what is left beside the heat has them, not what was left without it."""
    about = rest.beside.linearised.temper(1.0, float(np.sqrt(rest.left)))
    return Rest(replace(rest.beside, fit=about), explain_unknown(about, rest.heat))
