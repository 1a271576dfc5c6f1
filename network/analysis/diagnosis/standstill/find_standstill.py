"""A stop that recordings do not tell: stretches scored about a fit, the best confirmed by fits to recordings set right.

Numbers that were fitted to a stop are bent, so it is found again about the fit without it, and further ones of the same
driver are looked for there. What counts in the end is what the fit explains of each channel in units of how large the
misfit that it leaves there is and how long that lasts: beyond the log of as many stretches as were tried for each stop,
all of them at full strength, and where neither the catalogue nor unknown heat explains as much; a source of which
nothing is recorded, and what would have stood in every recording, also has to leave hardly anything.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from network.analysis.calibration.linearised import Linearised, linearise
from network.analysis.diagnosis.hypotheses.falling_short import explains_half, leaves_too_much
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.intermittent.change_points import Windows
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.standstill.driver import list_drivers
from network.analysis.diagnosis.standstill.standstill_edges import FARTHEST, refine_edges
from network.analysis.diagnosis.standstill.standstill_fault import StandstillFault
from network.analysis.diagnosis.standstill.standstill_scan import Stretch, scan_stretches
from network.analysis.diagnosis.standstill.stopped_fits import Stopped, Stops, fit_stopped
from network.platform.refusal import Failed, Refused

CONFIRMED, NEARLY = 2, 0.5
"""Best drivers that are confirmed by fits, and the share of the best score that they need (budget)."""
ROUNDS, REFINED = 5, 2
"""Times that their stretches, then the edges of these, are found again about the better fit (budget)."""
SETTLED = 5.0
"""s by which edges have to move for a further fit."""

EDGES = 2
"""Of a stop."""
PROMISING = 0.25
"""Share of what chance reaches, and of what the best of the catalogue scores, that a fit has to explain for its stops
to be found again (budget)."""

RivalGain = Callable[[], float]
"""What the best of the catalogue scores about the fit to recordings as they are [nats]."""


def find_standstill(h: Hypothesis, rival_gain: RivalGain) -> tuple[StandstillFault, Hypothesis] | None:
    """The stops, and the hypothesis fitted to the recordings set right; None where there are none."""
    try:
        best = _find_best(h, rival_gain)
        if best is None or not (best.lasts and _spans_steps(h, best)):
            return None
        if not _is_full(h, best) or not best.beats_unknown:
            return None
    except (Failed, Refused, np.linalg.LinAlgError):
        return None
    return (best.tell(h.case.recordings), best.after) if _beats_catalogue(h, best, rival_gain) else None


def _beats_catalogue(h: Hypothesis, now: Stopped, rival_gain: RivalGain, share: float = 1.0) -> bool:
    """Whether stops explain more than a share of what the best of the catalogue scores."""
    return now.gain > share * rival_gain() * max(1.0, h.chi) ** 2


def _is_plain(now: Stopped) -> bool:
    """Whether an input stood, of which a recording tells when it moved; or, where hardly anything is left, a source of
    which none tells anything, or what would have stood in each of several recordings: else that may as well be
    something else, and what happens every time a law of the machine."""
    is_open = bool(now.driver.source) or _stands_always(now)
    return not is_open or now.after.chi <= SETTINGS.adequate


def _stands_always(now: Stopped) -> bool:
    """Whether an input would have stood in each of several recordings in which it moves."""
    runs = zip(now.before.case.recordings, now.stops, strict=True)
    stood = [bool(own) for r, own in runs if any(r.columns[n].values.any() for n in now.driver.inputs)]
    return len(stood) > 1 and all(stood)


def _is_hopeless(h: Hypothesis, now: Stopped) -> bool:
    """Whether too much is left beside a stop of a source."""
    return bool(now.driver.source) and leaves_too_much(h, now.after)


def _is_vain(h: Hypothesis, now: Stopped, stops: Stops, rival_gain: RivalGain) -> bool:
    """Whether stops of a source explain less than half, or stops of anything far less than the best of the catalogue,
    and no further ones show beside them."""
    if any(len(new) > len(old) for new, old in zip(stops, now.stops, strict=True)):
        return False
    is_half = not now.driver.source or explains_half(h, now.after)
    return not is_half or not _beats_catalogue(h, now, rival_gain, PROMISING)


def _spans_steps(h: Hypothesis, now: Stopped) -> bool:
    """Whether every stop lasts for more steps of the fit than its two edges take: an edge of an input that is stamped
    early or late is none."""
    steps = [float(np.median(np.diff(p.run.knots.t))) for p in h.predictions]
    return all(end - begin > EDGES * step for step, own in zip(steps, now.stops, strict=True) for begin, end in own)


def _find_best(h: Hypothesis, rival_gain: RivalGain) -> Stopped | None:
    """The stops of one driver that explain most, settled."""
    scores = scan_stretches(h.linearised, [*list_drivers(h)])
    likely = [s for s in scores if s.gain > SETTINGS.alike and s.is_strong]
    return _settle_best(h, likely, sum(s.tried for s in scores), rival_gain)


def _settle_best(h: Hypothesis, likely: Sequence[Stretch], tried: int, rival_gain: RivalGain) -> Stopped | None:
    """The driver whose stops explain most: of the likely ones, as long as none leaves little."""
    best: Stopped | None = None
    drivers = dict.fromkeys(s.driver for s in likely if s.gain > NEARLY * likely[0].gain)
    for driver in list(drivers)[:CONFIRMED]:
        now = _settle(h, [s for s in likely if s.driver is driver], tried, rival_gain)
        if now is not None and _is_plain(now) and (best is None or now.worth - now.price > best.worth - best.price):
            best = now
        if best is not None and best.after.chi <= SETTINGS.adequate:
            break
    return best


def _settle(h: Hypothesis, first: Sequence[Stretch], tried: int, rival_gain: RivalGain) -> Stopped | None:
    """Stops of one driver in some runs found again, and further ones, until nothing is new; their edges to less than a
    step."""
    driver, stops = first[0].driver, tuple(_join([s for s in first if s.run == i]) for i in range(len(h.predictions)))
    now, seen = fit_stopped(h, driver, stops, tried), {stops}
    for _ in range(ROUNDS):
        if now is None or now.worth < PROMISING * now.price or _is_hopeless(h, now):
            return None
        stops = tuple(_find_again(h, now))
        if not any(stops) or _is_vain(h, now, stops, rival_gain):
            return None
        if _is_alike(stops, now.stops) or stops in seen:
            break
        now = fit_stopped(h, driver, stops, tried, now)
        seen.add(stops)
    return _refine(h, now) if now is not None and now.worth > now.price else None


def _is_alike(one: Stops, other: Stops) -> bool:
    """Whether stops are the same but for a step at their edges."""
    if [len(w) for w in one] != [len(w) for w in other]:
        return False
    edges = [np.array([edge for own in stops for w in own for edge in w]) for stops in (one, other)]
    return bool(np.abs(edges[0] - edges[1]).max(initial=0.0) <= FARTHEST)


def _linearise(h: Hypothesis, now: Stopped, stops: Sequence[Windows]) -> Linearised:
    """About the numbers of a fit, with other stops in the recordings."""
    case, fit = now.driver.correct(h.case, tuple(stops)), now.after.fit
    return linearise(case.problem(now.after.machine, fit.problem.parameters), fit.theta)


def _find_again(h: Hypothesis, now: Stopped) -> Iterator[Windows]:
    """Of every run its stops as they show beside the others, and a further one where that explains more than chance."""
    price = float(np.log(now.tried))
    for run, windows in enumerate(now.stops):
        found = [s for w in windows for s in _scan_without(h, now, run, w)]
        kept = [s for s in found if s.gain > SETTINGS.alike]
        more = [s for s in scan_stretches(now.after.linearised, [now.driver], [run]) if s.gain > price and s.is_strong]
        yield _join([*kept, *more])


def _is_full(h: Hypothesis, now: Stopped) -> bool:
    """Whether every stop is one at full strength, by the numbers that were fitted beside it."""
    windows = [(run, w) for run, own in enumerate(now.stops) for w in own]
    return all(s.is_full for run, w in windows for s in _scan_without(h, now, run, w))


def _scan_without(h: Hypothesis, now: Stopped, run: int, window: tuple[float, float]) -> list[Stretch]:
    others = [tuple(w for w in own if i != run or w != window) for i, own in enumerate(now.stops)]
    return scan_stretches(_linearise(h, now, others), [now.driver], [run])


def _join(found: Sequence[Stretch]) -> Windows:
    """Stretches one after the other; those that touch are one."""
    joined: list[tuple[float, float]] = []
    for s in sorted(found, key=lambda s: s.begin):
        if joined and s.begin <= joined[-1][1] + s.width:
            joined[-1] = (joined[-1][0], max(s.end, joined[-1][1]))
        else:
            joined.append((s.begin, s.end))
    return tuple(joined)


def _refine(h: Hypothesis, now: Stopped) -> Stopped:
    """Its edges where the readings, and no step, say that they are, found again about the fit that has them."""
    for _ in range(REFINED):
        told = refine_edges(partial(_linearise, h, now), now.stops)
        again = fit_stopped(h, now.driver, told.stops, now.tried, now)
        if again is None:
            break
        now = replace(again, edges=told)
        if told.moved < SETTLED:
            break
    return now
