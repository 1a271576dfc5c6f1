"""What moves the tool centre point, scored about numbers that thermometers alone tell.

It changes no thermometer; but a fit to all channels bends the numbers of heat until they imitate it, and about these
nothing shows as it is. Numbers that thermometers alone tell are not bent by it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from network.analysis.calibration.misfit import channel_misfits
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis, linearise_narrowed
from network.analysis.diagnosis.screening.screen import Score, score_candidates
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.declaration.sections import TCP
from network.platform.refusal import Failed

BLIND = 1e4
"""Times the noise of a channel at which it tells a fit nothing."""
BRIEF = 7
"""Steps of the fit to thermometers alone (budget)."""


@dataclass(frozen=True, eq=False)
class ByThermometers:
    """Scores of what moves the tool centre point, by key, about the numbers that thermometers tell, by path."""

    scores: Mapping[tuple[str, ...], Score]
    values: Mapping[str, float]


def score_by_thermometers(h: Hypothesis, candidates: Sequence[Candidate], jobs: int) -> ByThermometers | None:
    """None where no displacement leaves much, nothing is proposed that moves it, or thermometers alone run away."""
    moving = [c for c in candidates if c.section == TCP]
    alone = fit_thermometers(h) if moving else None
    at = None if alone is None else linearise_narrowed(h.linearised.problem, alone.fit.theta)
    if alone is None or at is None:
        return None
    scores = score_candidates(at, moving, alone.values, jobs)
    return ByThermometers({s.candidate.key: s for s in scores}, alone.values)


def fit_thermometers(h: Hypothesis) -> Hypothesis | None:
    """A hypothesis fitted a few steps from the numbers of the file to thermometers alone, displacements being as good
    as not read; None where none of these leaves much, or that runs away."""
    told = {n: s for d in h.linearised.problem.data for n, s in d.sigma.items()}
    blind = {n: BLIND * told[n] for n in _list_displaced(h)}
    if not blind:
        return None
    case = replace(h.case, sigma={**h.case.sigma, **blind})
    try:
        return fit_hypothesis(case, h.machine, h.found, h.own, h.own_values, steps=BRIEF)
    except (Failed, np.linalg.LinAlgError):
        return None


def leaves_heat(alone: Hypothesis) -> bool:
    """Whether one of the thermometers leaves more than noise in a fit to these alone."""
    misfits = channel_misfits(alone.linearised)
    return any(m.chi > SETTINGS.further for n, m in misfits.items() if _is_thermometer(alone, n))


def _list_displaced(h: Hypothesis) -> set[str]:
    """Channels of displacements, where one of them leaves much; none where no thermometer is there."""
    misfits = channel_misfits(h.linearised)
    moved = {n for n in misfits if h.machine.sensors[n].axis is not None}
    is_much = any(misfits[n].chi > SETTINGS.adequate for n in moved)
    return moved if is_much and any(_is_thermometer(h, n) for n in misfits) else set()


def _is_thermometer(h: Hypothesis, channel: str) -> bool:
    return h.machine.sensors[channel].quantity == "temperature"
