"""Readings set right: what a channel does by fits and starts, channels that are mixed up, stops that nobody logged."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial

from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.exchange.find_exchange import find_exchange, find_exchange_on_lumps
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis, SameFit
from network.analysis.diagnosis.intermittent.find_fault import find_reading_fault
from network.analysis.diagnosis.lumps.coarse_surrogate import build_surrogate
from network.analysis.diagnosis.lumps.lump_refinement import MANY, hardly_matter
from network.analysis.diagnosis.reading_fault import ReadingFault
from network.analysis.diagnosis.screening.screen import screen
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.standstill.find_standstill import find_standstill
from network.analysis.sweep.finer_lumps import bars_of
from network.platform.parallel import run_all

KEPT = 4
"""Fits of which it is kept what the best of the catalogue scores about them: several faults are weighed against it."""

Found = tuple[ReadingFault, Hypothesis] | None
Score = Callable[[Hypothesis], float]


def set_right(h: Hypothesis, jobs: int, is_finest: bool = False) -> tuple[ReadingFault | None, Hypothesis]:
    """The fault of a reading that explains most, and the fit to the readings set right; the same fit without one.
    is_finest: whether lumps were refined as far as readings with a fault let them be."""
    if h.chi <= SETTINGS.noise:
        return None, h
    told = run_all(partial(_look_for, h, is_finest), (_find_fault, _find_exchanged, _find_stopped), jobs)
    return max((pair for pair in told if pair is not None), key=lambda pair: pair[0].gain, default=(None, h))


def _look_for(h: Hypothesis, is_finest: bool, find: Callable[[Hypothesis, bool, Score], Found]) -> Found:
    return find(h, is_finest, partial(_best_score, 1))


def _find_fault(h: Hypothesis, is_finest: bool, score: Score) -> Found:
    """None that leaves much beside it, for finer lumps may take that away, before there are finer ones."""
    told = _find_fault_once(SameFit(h))
    return told if is_finest or told is None or not told[0].competes else None


@lru_cache(maxsize=1)
def _find_fault_once(same: SameFit) -> Found:
    """Of a fit that is looked at before lumps were refined and, where they stay as they are, after."""
    return find_reading_fault(same.of, partial(_best_score, 1, same.of))


def _find_exchanged(h: Hypothesis, is_finest: bool, score: Score) -> Found:
    return find_exchange(h, score, is_finest or bool(h.found) or not bars_of(h.machine))


def _find_stopped(h: Hypothesis, is_finest: bool, score: Score) -> Found:
    return _find_stopped_once(SameFit(h))


@lru_cache(maxsize=1)
def _find_stopped_once(same: SameFit) -> Found:
    """Looked for as often as `_find_fault_once`."""
    return find_standstill(same.of, partial(_best_score, 1, same.of))


def set_right_on_lumps(
    written: Hypothesis, finest: Hypothesis, jobs: int
) -> tuple[ReadingFault | None, Hypothesis]:  # fmt: skip
    """The same on finer lumps than those of the machine as written, where readings were looked at before: on those that
    the readings as they are take (finest), or that they take once two channels are put back. Where lumps hardly matter
    those of the machine as written stand for them. Nothing is looked for where only noise is left."""
    if finest.chi <= SETTINGS.noise:
        return None, finest
    is_alike = hardly_matter(finest, written)
    if finest is not written and (coarse := written if is_alike else build_surrogate(finest)).machine.lumps <= MANY:
        fault, mended = set_right(coarse, jobs, is_finest=True)
        if fault is not None:
            return fault, mended
    if finest.chi <= SETTINGS.doubtful:
        return None, finest
    score = partial(_best_score, jobs)
    told = find_exchange(finest, score) if finest is written else None
    return told or find_exchange_on_lumps(written, finest, score, jobs) or (None, finest)


def _best_score(jobs: int, h: Hypothesis) -> float:
    """What the best of the catalogue scores about a fit [nats]."""
    return _score_once(jobs, SameFit(h))


@lru_cache(maxsize=KEPT)
def _score_once(jobs: int, same: SameFit) -> float:
    h = same.of
    proposed = candidates(h.machine, h.case.drivers, runs=h.case.runs)
    return max((s.gain for s in screen(h.linearised, proposed, h.values, jobs)), default=0.0)
