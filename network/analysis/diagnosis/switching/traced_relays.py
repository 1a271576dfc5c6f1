"""Relays that a mismatch shows: what heat is missing at one part, on or off, tells when each of them switched.

No reading has to show what it watches, and no number is drawn: the instants are read off all channels at once
(switched_heat), the relay's heat is fitted as that of a source that follows them, and its levels are then the
temperatures at which it went on and off.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.hypotheses.compact_fit import fit_with
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.latent_heat.location import Location
from network.analysis.diagnosis.latent_heat.switched_heat import SwitchedHeat, trace_switched
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.switching.certain_levels import find_relay, make_certain
from network.analysis.diagnosis.switching.relay_fits import RelayStart
from network.analysis.diagnosis.switching.shown_relays import ShownRelay
from network.analysis.diagnosis.switching.written_numbers import write_numbers
from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.entry_path import EntryPath
from network.catalogue.mechanisms.base import Source
from network.engine.response.followed_relays import TRACED
from network.platform.parallel import run_all
from network.platform.refusal import Refused
from network.recordings.relay_mode import RelayMode

MOST = 3
"""Relays that are followed in parts that are there, and as many in those that come with one."""
IDLE = 8
"""Steps of the fit beside a part that comes with a relay, its numbers held."""


class _Switched(NamedTuple):
    """A candidate, the path of its relay, the part that this heats (sign 1) or cools (−1), and the same with levels
    that are certain, which stand for those to be read."""

    candidate: Candidate
    path: EntryPath
    part: str
    sign: float
    followed: Candidate

    @property
    def is_there(self) -> bool:
        """Whether its part is one without it."""
        nodes = self.candidate.base.nodes
        return self.part in nodes and nodes[self.part].is_part

    def mode(self, t: Array, at: Sequence[float] = (), first: float = 0.0) -> RelayMode:
        """That it switches at some instants between knots of a run; off all the time without."""
        return RelayMode(TRACED + self.path.name, np.array([t[0], *at]), np.full(len(at), float(t[1] - t[0])), first)


def trace_relays(null: Hypothesis, switched: Sequence[Candidate], jobs: int) -> list[ShownRelay]:
    """Those of some candidates whose heat explains most where it may be on or off at any time, without levels: in parts
    that are there, and in those that come with a relay, which are compared among themselves, for these are traced
    beside usual numbers. null: under the noise of the file."""
    able = [found for c in switched if (found := _find_place(c)) is not None]
    there, brought = [of for of in able if of.is_there], [of for of in able if not of.is_there]
    parts = list(dict.fromkeys(of.part for of in there))
    told_of = dict(zip(parts, run_all(partial(_trace_there, null), parts, jobs), strict=True))
    own = run_all(partial(_trace_brought, null, null.values), brought, jobs)
    return [
        *_follow_best([(of, told_of[of.part][of.sign > 0]) for of in there]),
        *_follow_best([(of, heat) for of, heat in zip(brought, own, strict=True) if heat is not None]),
    ]


def trace_again(null: Hypothesis, starts: Sequence[RelayStart], jobs: int) -> list[ShownRelay]:
    """The same in parts that come with a relay, beside the numbers that these took when they were followed."""
    return [shown for shown in run_all(partial(_trace_about, null), starts, jobs) if shown is not None]


def _trace_about(null: Hypothesis, start: RelayStart) -> ShownRelay | None:
    of = _find_place(start.candidate)
    heat = None if of is None or of.is_there else _trace_brought(null, start.values, of)
    shown = None if of is None or heat is None or heat.worth <= SETTINGS.least else _follow(of, heat)
    return shown and replace(shown, beside=start.values)


def _follow_best(traced: Sequence[tuple[_Switched, SwitchedHeat]]) -> list[ShownRelay]:
    """The best, each worth its instants, and half of what the best of all explains. At one part cold that comes and
    heat that goes may both be among them: they differ by what is constant, which other numbers take up."""
    told = sorted(traced, key=lambda each: -each[1].gain)[:MOST]
    least = SETTINGS.half * told[0][1].gain if told else 0.0
    shown = (_follow(of, heat) for of, heat in told if heat.worth > SETTINGS.least and heat.gain >= least)
    return [s for s in shown if s is not None]


def _trace_there(null: Hypothesis, part: str) -> tuple[SwitchedHeat, SwitchedHeat]:
    """Cold, then heat, that goes on and off in a part that is there."""
    null.case.budget.check()
    return trace_switched(null.linearised, Location((part,)))


def _trace_brought(null: Hypothesis, values: Mapping[str, float], of: _Switched) -> SwitchedHeat | None:
    """The heat in a part that comes with the relay, about the machine with that part and the relay off, at some numbers
    or else usual ones; None where that runs away."""
    runs = (replace(r, modes={**r.modes, (off := of.mode(r.t)).name: off}) for r in null.case.recordings)
    case = replace(null.case, recordings=tuple(runs), began=())
    told = {p.path: values[p.path] for p in of.followed.own if p.path in values}
    held = _write(of.followed, told)
    idle = None if held is None else fit_with(case, null, held, values, IDLE)
    idle = None if idle is None else fit_with(case, null, of.followed, {**idle.values, **told}, 0)
    return None if idle is None else trace_switched(idle.linearised, Location((of.part,)))[of.sign > 0]


def _write(c: Candidate, told: Mapping[str, float]) -> Candidate | None:
    """The candidate with some of its numbers as if the file had them, and none free; None where they may not be so."""
    try:
        return replace(c, machine=write_numbers(c.machine, c.own, told), own=())
    except Refused:
        return None


def _find_place(c: Candidate) -> _Switched | None:
    """None where its relay does not heat or cool one part, its own or one that is there."""
    only = find_relay(c)
    if only is None:
        return None
    path, relay = only
    levels, into = relay.levels(), {place.node for place, _ in relay.into} if isinstance(relay, Source) else set[str]()
    if levels is None or len(into) != 1:
        return None
    certain = make_certain(c, *sorted(levels[1:]))
    sign = -float(np.sign(levels[1] - levels[2]))
    return None if certain is None else _Switched(c, path, into.pop(), sign, certain.candidate)


def _follow(of: _Switched, heat: SwitchedHeat) -> ShownRelay | None:
    """The relay with levels that stand for those to be read; None where it goes neither on nor off."""
    runs = enumerate(zip(heat.t, heat.on, strict=True))
    modes = {i: of.mode(t, heat.list_switchings(i), float(on[0])) for i, (t, on) in runs}
    switches = any(len(mode.spread) for mode in modes.values())
    return ShownRelay(of.candidate, of.followed, {}, modes) if switches else None
