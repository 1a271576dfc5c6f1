"""Where a hypothesis and the recordings differ, told at the numbers that stand beside the heat that explains most.

Those that were fitted without it are bent to it: seen from there, it may sit in another part, and lean the other way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.latent_heat.latent_rest import find_rest
from network.analysis.diagnosis.latent_heat.locate import locate, trace
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


def locate_mismatch(h: Hypothesis) -> Mismatch:
    """Of a hypothesis. All that it leaves without such heat counts as noise where places are compared."""
    rest = find_rest(h)
    about = rest.beside.linearised
    noise = max(1.0, float(np.mean(h.fit.left**2)))
    return Mismatch(locate(about, rest.beside.machine, noise), about, rest.left)
