"""Readings set right: what a channel does by fits and starts, channels that are mixed up, stops that nobody logged."""

from __future__ import annotations

from functools import cache, partial

from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.exchange.find_exchange import find_exchange, find_exchange_on_lumps
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.intermittent.find_fault import find_reading_fault
from network.analysis.diagnosis.lumps.coarse_surrogate import build_surrogate
from network.analysis.diagnosis.lumps.lump_refinement import MANY
from network.analysis.diagnosis.reading_fault import ReadingFault
from network.analysis.diagnosis.screening.screen import screen
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.standstill.find_standstill import find_standstill
from network.analysis.sweep.finer_lumps import bars_of


def set_right(h: Hypothesis, jobs: int, is_finest: bool = False) -> tuple[ReadingFault | None, Hypothesis]:
    """The fault of a reading that explains most, and the fit to the readings set right; the same fit without one.
    is_finest: whether lumps were refined as far as readings with a fault let them be."""
    if h.chi <= SETTINGS.noise:
        return None, h
    score = cache(partial(_best_score, jobs))
    rival_gain, is_refined = partial(score, h), is_finest or bool(h.found) or not bars_of(h.machine)
    told = (
        find_reading_fault(h, rival_gain, is_finest),
        find_exchange(h, score, is_refined),
        find_standstill(h, rival_gain),
    )
    return max((pair for pair in told if pair is not None), key=lambda pair: pair[0].gain, default=(None, h))


def set_right_on_lumps(
    written: Hypothesis, finest: Hypothesis, jobs: int
) -> tuple[ReadingFault | None, Hypothesis]:  # fmt: skip
    """The same on finer lumps than those of the machine as written, where readings were looked at before: on those that
    the readings as they are take (finest), or that they take once two channels are put back."""
    if finest is not written and (coarse := build_surrogate(finest)).machine.lumps <= MANY:
        fault, mended = set_right(coarse, jobs, is_finest=True)
        if fault is not None:
            return fault, mended
    if finest.chi <= SETTINGS.doubtful:
        return None, finest
    score = cache(partial(_best_score, jobs))
    told = find_exchange(finest, score) if finest is written else None
    return told or find_exchange_on_lumps(written, finest, score, jobs) or (None, finest)


def _best_score(jobs: int, h: Hypothesis) -> float:
    """What the best of the catalogue scores about a fit [nats]."""
    proposed = candidates(h.machine, h.case.drivers, runs=h.case.runs)
    return max((s.gain for s in screen(h.linearised, proposed, h.values, jobs)), default=0.0)
