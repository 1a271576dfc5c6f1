"""Readings of what a relay watches: where they bend, it switched.

A temperature under hysteresis goes up and down between two levels, and bends at every switching by as much as the heat
that goes on or off makes its rate change. A switching is looked for from where the readings come near a level, and
lies where a line with a bend in it fits them best (two-phase regression; Hinkley, Biometrika 56 (1969) 495;
unverified). Levels are those of the file, moved by what the sensor and the file may both be off: the middle between
the highest and the lowest turning points.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from network.catalogue.declaration.declare import Array, Mask

NEAR = 0.25
"""Share of the half width before a level from which a switching is looked for: what noise and a level that is off by
less leave of it is on the safe side."""
MOST_NEAR = 0.75
"""The same at most, where means of readings that are rare do not reach the level: the middle is approached by both."""
FEWEST = 4
"""Samples of an approach to a level from which a bend can be told from noise."""
AFTER = 2
"""Times as long as an approach that a bend is looked for after it."""
LEAST = 0.5
"""Share of the turn that most bends have below which one is none: as near to nothing as to a switching."""
OFTEN = 3
"""Turns at a level from which it shows."""
QUARTILES = (25.0, 75.0)
INSTANTS, NUMBERS = 60, 4
"""Instants at which a bend is tried, and what is fitted: two rates, a level and the instant."""
RANK = 1e-12
"""Relative eigenvalue of normal equations below which two rates are one."""


@dataclass(frozen=True, eq=False)
class Swing:
    """Readings of what a relay watches, counted so that it goes on when they rise: t [s], x [K], and the levels at
    which it goes on and off."""

    t: Array
    x: Array
    on: float
    off: float

    @property
    def near(self) -> float:
        return NEAR * (self.on - self.off) / 2

    @cached_property
    def smooth(self) -> Array:
        """Means of three samples."""
        return _smooth(self.x)

    @cached_property
    def turns(self) -> tuple[list[float], list[float]]:
        """Highest and lowest means of three samples between which it goes through half of the hysteresis or more."""
        return _list_turns(self.smooth, (self.on - self.off) / 2)

    @cached_property
    def close(self) -> tuple[Mask, Mask]:
        """Which means of three samples come near the level at which it goes on, and near the other, or beyond the
        middle near a turn of their own before it: noise may hide the rest of the way, and their bend has to tell
        whether it switched. None comes near both."""
        smooth, (on, off) = self.smooth, self.approaches
        high, low, since, middle = smooth > on, smooth < off, 0, (self.on + self.off) / 2
        for k, is_high in _find_turns(smooth, (self.on - self.off) / 2):
            own = smooth[since : k + 1]
            beyond = own > middle if is_high else own < middle
            (high if is_high else low)[since : k + 1] |= beyond & (np.abs(own - smooth[k]) < self.near)
            since = k
        return high, low

    @property
    def approaches(self) -> tuple[float, float]:
        """Where means of three samples come near each level, of which they reach as much as readings are frequent."""
        high, low = self.turns
        cut = max(self.on - float(np.median(high or [self.on])), float(np.median(low or [self.off])) - self.off, 0.0)
        room = min(self.near + cut, MOST_NEAR * (self.on - self.off) / 2)
        return self.on - room, self.off + room

    def centred(self) -> Swing | None:
        """About the middle between the turning points, where there are two of either kind; None where that lies further
        off than a half width: then it is something else that makes them turn."""
        high, low = self.turns
        if min(len(high), len(low)) < 2:
            return self
        by = (np.median(high) + np.median(low) - self.on - self.off) / 2
        is_near = abs(by) <= (self.on - self.off) / 2
        return replace(self, on=self.on + by, off=self.off + by) if is_near else None


@dataclass(frozen=True)
class Bend:
    """t, spread: an instant and its 1σ [s]; x: the readings there; turn: by how much their rate changes there the way
    it should [K/s]; goes_on: whether it goes on there, or off."""

    t: float
    spread: float
    x: float
    turn: float
    goes_on: bool


class _Crossing(NamedTuple):
    """Where the readings come near a level that switches. begin, near, stop: samples from which they approach it, at
    which they come near it, and the next one; way: 1 on, −1 off; is_whole: whether they come from the middle, which
    those of a run that begins beyond it do not."""

    begin: int
    near: int
    stop: int
    way: float
    is_whole: bool

    @property
    def last(self) -> int:
        """The sample before which a bend is looked for: twice as long after they come near the level as they took to
        get there from the middle, at most, for they may slow down before it; up to the next one where that says
        nothing, for the run began on the way or came near it at once."""
        took = self.near - self.begin
        return min(self.near + AFTER * took, self.stop) if self.is_whole and took >= FEWEST else self.stop


def find_levels(runs: Sequence[tuple[Array, Array]], least: float) -> tuple[float, float] | None:
    """The lower and the upper level between which readings x at t go up and down by at least so much: where they bend.
    None where they do not turn often enough, or where the middle half of the turns is wider than half of what lies
    between both: what turns at no level is none."""
    read = [(t[kept], x[kept]) for t, x in runs if (kept := np.isfinite(x)).sum() >= FEWEST]
    told = [_list_turns(_smooth(x), least) for _, x in read]
    high, low = (np.array([x for turns in told for x in turns[i]]) for i in range(2))
    if min(len(high), len(low)) < OFTEN:
        return None
    (bottom, lower), (upper, top) = np.percentile(low, QUARTILES), np.percentile(high, QUARTILES)
    if max(lower - bottom, top - upper) >= (upper - lower) / 2:
        return None
    swings = (Swing(t, x, float(np.median(high)), float(np.median(low))) for t, x in read)
    bends = [bend.x for swing in swings for bend in find_switchings(swing) or ()]
    up, down = ([x for x in bends if (x > (upper + lower) / 2) == is_up] for is_up in (True, False))
    return (float(np.median(down)), float(np.median(up))) if up and down else None


def find_switchings(swing: Swing) -> list[Bend] | None:
    """Bends where it switched; None where the readings do not show it. Between its levels it may be on or off when a
    run begins: as it shows more bends, for the other way the first one passes for none."""
    find_bend = cache(partial(_find_bend, swing))
    told = [_find_from(swing, find_bend, is_on) for is_on in _list_beginnings(swing)]
    return max((bends for bends in told if bends is not None), key=len, default=None)


def _list_beginnings(swing: Swing) -> tuple[bool, ...]:
    """Whether it may be on when a run begins, the likelier first."""
    begin = float(swing.smooth[0])
    is_on = begin > swing.on
    is_certain = begin > swing.on + swing.near or begin < swing.off - swing.near
    return (is_on,) if is_certain else (is_on, not is_on)


def _find_from(swing: Swing, find_bend: Callable[..., Bend], is_on: bool) -> list[Bend] | None:
    """The same of one that is on or off when the run begins. All turn by as much, the relay's heat over what it heats:
    where they come near a level and turn by less than half of that, the load kept them from it."""
    refused = set[int]()
    while True:
        crossings = _list_crossings(swing, refused, is_on)
        told = _find_bends(find_bend, crossings)
        least = LEAST * float(np.median([bend.turn for bend in told])) if told else 0.0
        faint = [c.near for c, bend in zip(crossings, told, strict=True) if bend.turn < least]
        if not faint:
            break
        refused.add(faint[0])
    follow = all(a.t < b.t for a, b in pairwise(told))
    return told if follow and least >= 0 else None


def _find_bends(find_bend: Callable[..., Bend], crossings: Sequence[_Crossing]) -> list[Bend]:
    """A bend near every crossing, at the levels at which most of them lie."""
    rough = [(c.way, find_bend(c).x) for c in crossings]
    levels = {way: float(np.median([x for other, x in rough if other == way])) for way, _ in rough}
    return [find_bend(c, levels[c.way]) for c in crossings]


def _list_crossings(swing: Swing, refused: Container[int], is_on: bool) -> list[_Crossing]:
    """Of every switching in turn. refused: samples at which it was no switching that brought the readings near; is_on:
    when the run begins."""
    smooth, middle, k, since = swing.smooth, (swing.on + swing.off) / 2, 0, 0
    found: list[_Crossing] = []
    high, low = swing.close
    while True:
        way, close = (-1.0, low) if is_on else (1.0, high)
        if not (close := close[k:]).any():
            break
        k += int(close.argmax())
        if k in refused:
            k += int(np.argmin(np.append(close[close.argmax() :], False)))
            continue
        before = np.flatnonzero(way * smooth[since:k] < way * middle)
        begin = since + int(before[-1]) if len(before) else since
        found.append(_Crossing(begin, k, len(smooth), way, bool(len(before))))
        is_on, since = not is_on, k
    return [*(c._replace(stop=following.near) for c, following in pairwise(found)), *found[-1:]]


def _find_bend(swing: Swing, at: _Crossing, level: float | None = None) -> Bend:
    """Where the readings bend. 1σ is how far off the instant may be for as much more as noise leaves; level: what they
    read there, where that is known."""
    t, x = swing.t[at.begin : at.last], swing.x[at.begin : at.last]
    if at.last - at.near < FEWEST:
        return Bend(float(swing.t[at.near]), float(t[-1] - t[0]), float(x[-1]), 0.0, at.way > 0)
    tried = np.linspace(swing.t[at.near], t[-2], INSTANTS)
    left, there, turns = _fit_bends(t, x, tried, level)
    best = int(np.argmin(left))
    like = tried[left - left[best] <= left[best] / max(len(t) - NUMBERS, 1)]
    spread = max(np.ptp(like) / 2, tried[1] - tried[0])
    turn = float(-at.way * turns[best])
    return Bend(float(tried[best]), float(spread), float(there[best]), turn, at.way > 0)


def _fit_bends(t: Array, x: Array, at: Array, level: float | None) -> tuple[Array, Array, Array]:
    """Squares left by a line that bends at each of some instants, at a level if one is given; what it reads there, and
    how much its rate changes. Where nothing lies before one both rates are half of it, as of least norm."""
    length = float(t[-1] - t[0])
    since = (t - at[:, None]) / length
    A = np.stack([np.ones_like(since), since, np.maximum(since, 0.0)], axis=2)
    free = A if level is None else A[:, :, 1:]
    right = x if level is None else x - level
    normal, toward = free.transpose(0, 2, 1) @ free, right @ free
    found = (np.linalg.pinv(normal, rcond=RANK, hermitian=True) @ toward[:, :, None])[:, :, 0]
    c = found if level is None else np.column_stack([np.full(len(at), level), found])
    left = x - (A @ c[:, :, None])[:, :, 0]
    return np.einsum("ij,ij->i", left, left), c[:, 0], c[:, 2] / length


def _smooth(x: Array) -> Array:
    """Means over three samples."""
    wide = np.pad(x, 1, mode="edge")
    return np.asarray((wide[:-2] + wide[1:-1] + wide[2:]) / 3)


def _list_turns(smooth: Array, least: float) -> tuple[list[float], list[float]]:
    """Highest and lowest values between which it goes up and down by at least so much."""
    turns = _find_turns(smooth, least)
    high, low = ([float(smooth[k]) for k, is_high in turns if is_high == of_high] for of_high in (True, False))
    return high, low


def _find_turns(smooth: Array, least: float) -> list[tuple[int, bool]]:
    """At which samples these are, and whether they are high."""
    turns, top, bottom, rises = list[tuple[int, bool]](), 0, 0, True
    for k, value in enumerate(smooth.tolist()):
        top, bottom = (k if value > smooth[top] else top), (k if value < smooth[bottom] else bottom)
        if rises and value < smooth[top] - least:
            turns, rises, bottom = [*turns, (top, True)], False, k
        elif not rises and value > smooth[bottom] + least:
            turns, rises, top = [*turns, (bottom, False)], True, k
    return turns
