"""The levels of a relay that was followed: the temperatures between which it would have been on as it was."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.switching.certain_levels import find_relay, make_certain
from network.analysis.diagnosis.switching.shown_relays import ShownRelay
from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import Place
from network.engine.response.prediction import Prediction
from network.machine.lumps import weights
from network.recordings.relay_mode import RelayMode

SAME = 1e-6
"""s: an instant is at an edge of an interval that is no farther."""


def read_levels(followed: Hypothesis, shown: ShownRelay) -> dict[str, float]:
    """The levels of a relay that was followed, by path: of the temperatures at which it went on and off, the two
    between which it would have been on for as much of the time in which it was, and off as much; of one that only went
    on, or only off, the other level is as far from it as is usual, and so far that it was not met. Nothing where it did
    not do so the way that such a relay does, or at temperatures that it may not have."""
    only = find_relay(shown.candidate)
    levels = only and only[1].levels()
    if levels is None:
        return {}
    place, on, off = levels
    way = float(np.sign(on - off))
    runs = zip(followed.predictions, shown.modes.values(), strict=True)
    pair = _match_levels([_watch(p, m, place, way) for p, m in runs], abs(on - off))
    certain = pair and make_certain(shown.candidate, *sorted(way * level for level in pair))
    return dict(certain.levels) if certain else {}


@dataclass(frozen=True, eq=False)
class _Course:
    """Of a run: the edges of its intervals [s], what is watched at the begin of each [°C; −°C of a heater], and whether
    it was on (1 or 0)."""

    edges: Array
    watched: Array
    on: Array

    def switched(self, to: float) -> Array:
        """What was watched where it went on (1) or off (0)."""
        return np.asarray(self.watched[1:][(np.diff(self.on) != 0) & (self.on[1:] == to)])

    def stayed(self, at: float) -> Array:
        """What was watched while it was on (1) or off (0)."""
        return np.asarray(self.watched[self.on == at])


def _watch(prediction: Prediction, mode: RelayMode, place: Place, way: float) -> _Course:
    plan = prediction.course.problem.plan
    own = plan.network.parts[place.node]
    watched = way * prediction.course.T[0][:, own] @ weights(place, own.stop - own.start)
    count = np.searchsorted(mode.t[1:], plan.edges[:-1] + SAME, side="right")
    return _Course(plan.edges, watched, np.abs(mode.first - count % 2))


def _match_levels(courses: Sequence[_Course], width: float) -> tuple[float, float] | None:
    """The levels of a relay that goes on above the first and off below the second; width: how far these usually are
    apart."""
    pairs = np.array([(on, off) for on, off in _list_pairs(courses, width) if on > off])
    if not len(pairs):
        return None
    wrong = np.sum([_mistaken(c, pairs) for c in courses], axis=0)
    on, off = pairs[int(np.argmin(wrong))].tolist()
    return on, off


def _list_pairs(courses: Sequence[_Course], width: float) -> list[tuple[float, float]]:
    above, below = (np.unique(np.concatenate([c.switched(to) for c in courses])).tolist() for to in (1.0, 0.0))
    if not below:
        lowest = float(np.concatenate([c.stayed(1.0) for c in courses]).min(initial=np.inf))
        return [(on, min(lowest, on) - width) for on in above]
    if not above:
        highest = float(np.concatenate([c.stayed(0.0) for c in courses]).max(initial=-np.inf))
        return [(max(highest, off) + width, off) for off in below]
    return [(on, off) for on in above for off in below]


def _mistaken(course: _Course, pairs: Array) -> Array:
    """For how long relays of some levels would not have been as this one was [s]."""
    now, wrong = course.watched[0] >= pairs[:, 0], np.zeros(len(pairs))
    for lasting, T, was in zip(np.diff(course.edges), course.watched, course.on > 0, strict=True):
        now = np.where(now, pairs[:, 1] < T, pairs[:, 0] <= T)
        wrong += lasting * (now != was)
    return wrong
