"""Relays that a mismatch shows: what heat is missing at one part, on or off, tells when each of them switched.

No reading has to show what it watches, and no number is drawn: the instants are read off all channels at once
(switched_heat), the relay's heat is fitted as that of a source that follows them, and its levels are then the
temperatures at which it went on and off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.latent_heat.location import Location
from network.analysis.diagnosis.latent_heat.switched_heat import SwitchedHeat, trace_switched
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.switching.shown_relays import ShownRelay, find_relay
from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.entry_path import EntryPath
from network.catalogue.declaration.fields import Place
from network.catalogue.declaration.patch import Patch
from network.catalogue.mechanisms.base import Source
from network.catalogue.mechanisms.mechanism import Relay
from network.engine.response.followed_relays import TRACED
from network.engine.response.prediction import Prediction
from network.machine.lumps import weights
from network.platform.parallel import run_all
from network.platform.refusal import Refused
from network.recordings.relay_mode import RelayMode

MOST = 3
"""Relays that are followed."""
SAME = 1e-6
"""s: an instant is at an edge of an interval that is no farther."""


class _Switched(NamedTuple):
    """A candidate, the path of its relay, and the part that this heats (sign 1) or cools (−1)."""

    candidate: Candidate
    path: EntryPath
    part: str
    sign: float

    @property
    def relay(self) -> Relay:
        relay = self.candidate.machine.by_path[self.path]
        assert isinstance(relay, Relay)
        return relay


def trace_relays(null: Hypothesis, switched: Sequence[Candidate], jobs: int) -> list[ShownRelay]:
    """Those of some candidates whose heat explains most where it may be on or off at any time, each half of what the
    best does at least, without levels; null: under the noise of the file."""
    able = [found for c in switched if (found := _find_place(c)) is not None]
    parts = list(dict.fromkeys(of.part for of in able))
    told_of = dict(zip(parts, run_all(partial(_trace, null), parts, jobs), strict=True))
    traced = [told_of[of.part][of.sign > 0] for of in able]
    told = sorted(zip(traced, able, strict=True), key=lambda each: -each[0].gain)[:MOST]
    least = SETTINGS.half * told[0][0].gain if told else 0.0
    shown = (_follow(of, heat) for heat, of in told if heat.worth > SETTINGS.least and heat.gain >= least)
    return [s for s in shown if s is not None]


def _trace(null: Hypothesis, part: str) -> tuple[SwitchedHeat, SwitchedHeat]:
    """Cold, then heat, that goes on and off in a part."""
    null.case.budget.check()
    return trace_switched(null.linearised, Location((part,)))


def _find_place(c: Candidate) -> _Switched | None:
    """None where its relay does not heat or cool one part that is there without it."""
    only = find_relay(c)
    if only is None:
        return None
    path, relay = only
    levels, into = relay.levels(), {place.node for place, _ in relay.into} if isinstance(relay, Source) else set[str]()
    if levels is None or len(into) != 1:
        return None
    (part,) = into
    is_there = part in c.base.nodes and c.base.nodes[part].is_part
    return _Switched(c, path, part, -float(np.sign(levels[1] - levels[2]))) if is_there else None


def _follow(of: _Switched, heat: SwitchedHeat) -> ShownRelay | None:
    """The relay with levels that stand for those to be read; None where it goes neither on nor off."""
    levels = of.relay.levels()
    modes = {i: _list_modes(of, heat, i) for i in range(len(heat.t))}
    if levels is None or not any(len(mode.spread) for mode in modes.values()):
        return None
    try:
        keys = of.relay.keep_between(*sorted(levels[1:]))
        machine = of.candidate.machine.patched(Patch.of([(of.path, keys)]))
    except Refused:
        return None
    own = tuple(p for p in of.candidate.own if not (p.entry == of.path and p.field.key in keys))
    return ShownRelay(of.candidate, replace(of.candidate, machine=machine, own=own), {}, modes)


def _list_modes(of: _Switched, heat: SwitchedHeat, run: int) -> RelayMode:
    at, t = heat.list_switchings(run), heat.t[run]
    spread = np.full(len(at), float(t[1] - t[0]))
    return RelayMode(TRACED + of.path.name, np.array([t[0], *at]), spread, float(heat.on[run][0]))


def read_levels(followed: Hypothesis, shown: ShownRelay) -> dict[str, float]:
    """The levels of a relay that was followed, by path: of the temperatures at which it went on and off, the two
    between which it would have been on for as much of the time in which it was, and off as much; nothing where it did
    not do both, not the way that such a relay does, or at temperatures that it may not have."""
    of = _find_place(shown.candidate)
    levels = of and of.relay.levels()
    if of is None or levels is None:
        return {}
    place, on, off = levels
    way = float(np.sign(on - off))
    runs = zip(followed.predictions, shown.modes.values(), strict=True)
    pair = _match_levels([_watch(p, m, place, way) for p, m in runs])
    if pair is None:
        return {}
    keys = of.relay.keep_between(*sorted(way * level for level in pair))
    try:
        relay = of.candidate.machine.patched(Patch.of([(of.path, keys)])).by_path[of.path]
    except Refused:
        return {}
    own = [p for p in of.candidate.own if p.entry == of.path and p.field.key in keys]
    return {p.path: float(getattr(relay, p.attribute)) for p in own}


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


def _watch(prediction: Prediction, mode: RelayMode, place: Place, way: float) -> _Course:
    plan = prediction.course.problem.plan
    own = plan.network.parts[place.node]
    watched = way * prediction.course.T[0][:, own] @ weights(place, own.stop - own.start)
    count = np.searchsorted(mode.t[1:], plan.edges[:-1] + SAME, side="right")
    return _Course(plan.edges, watched, np.abs(mode.first - count % 2))


def _match_levels(courses: Sequence[_Course]) -> tuple[float, float] | None:
    """The levels of a relay that goes on above the first and off below the second."""
    above, below = (np.unique(np.concatenate([c.switched(to) for c in courses])) for to in (1.0, 0.0))
    pairs = np.array([(on, off) for on in above for off in below if on > off])
    if not len(pairs):
        return None
    wrong = np.sum([_mistaken(c, pairs) for c in courses], axis=0)
    on, off = pairs[int(np.argmin(wrong))].tolist()
    return on, off


def _mistaken(course: _Course, pairs: Array) -> Array:
    """For how long relays of some levels would not have been as this one was [s]."""
    now, wrong = course.watched[0] >= pairs[:, 0], np.zeros(len(pairs))
    for lasting, T, was in zip(np.diff(course.edges), course.watched, course.on > 0, strict=True):
        now = np.where(now, pairs[:, 1] < T, pairs[:, 0] <= T)
        wrong += lasting * (now != was)
    return wrong
