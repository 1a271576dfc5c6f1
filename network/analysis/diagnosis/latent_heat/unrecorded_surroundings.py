"""Surroundings of which the file states a temperature, and that had another course in every run.

No number of a machine tells such courses, so no candidate does, and numbers that are fitted without them are bent to
them, far from where slopes lead back. So they are looked for beside the numbers of the file, where a fit starts: heat
of any course at one place, the numbers refitted together with it (latent_rest).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING

from network.analysis.diagnosis.hypotheses.falling_short import leaves_little_of
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import reweight
from network.analysis.diagnosis.latent_heat.latent_rest import Rest, find_rest, refit_together, state_at_file
from network.analysis.diagnosis.latent_heat.locate import has_stated, locate
from network.analysis.diagnosis.settings import SETTINGS

if TYPE_CHECKING:
    from network.analysis.diagnosis.search_record import Search

ROUNDS = 6
"""Steps of the numbers together with such a course: from those of the file more than from fitted ones."""


def find_unrecorded(h: Hypothesis) -> Rest | None:
    """The machine of a hypothesis beside surroundings of any course; None where it leaves little, nothing is stated, or
    that explains no more than heat elsewhere, or less than three quarters of what is left."""
    if h.chi <= SETTINGS.doubtful or not has_stated(h.linearised, h.machine):
        return None
    about = state_at_file(h)
    if about is None:
        return None
    first, *others = sorted(locate(about.linearised, h.machine, 1.0), key=lambda u: -u.gain)
    if not first.is_room or first.gain - others[0].gain < SETTINGS.alike:
        return None
    rest = refit_together(Rest(about, first), ROUNDS)
    return rest if leaves_little_of(h, rest.left) else None


def weigh_unrecorded(unrecorded: Rest, states: Iterator[Search]) -> Iterator[Search]:
    """States of a search as long as nothing is found, and on from the first that explains more than surroundings of any
    course do; where it does not, no more is looked for."""
    for now in states:
        if now.best.found:
            if explains_more(reweight(now.null.case, now.best), unrecorded):
                yield from (replace(each, unrecorded=None) for each in chain([now], states))
            return
        yield now


def explains_more(h: Hypothesis, unrecorded: Rest) -> bool:
    """Whether a hypothesis does without such surroundings and, with heat of any course beside it, has more evidence
    under the priors as stated."""
    rest = find_rest(replace(h, fit=h.linearised.temper(1.0, 1.0)))
    needs_them = rest.heat.is_room and rest.heat.gain > SETTINGS.alike
    return rest.evidence > unrecorded.evidence and not needs_them
