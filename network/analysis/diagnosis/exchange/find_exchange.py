"""Sensors that are mixed up: pairs and runs scored about the numbers of the file, the best confirmed by fits.

Which pair, and in which runs, is a choice among many, and nothing that a slope tells: it costs the log of their number.
A pair counts where a fit with the two exchanged explains more than that, in units of how long the misfit that is left
lasts; where hardly anything is left of their own excess (half of it at most after the first steps); where every run in
which they are said to be exchanged says so by itself, beside all numbers refitted; and where neither the catalogue nor
unknown heat or an unknown error of one channel explains as much. Where much is left on all lumps, it is asked on those
that the readings put back take. Where more is left than noise, a search without it has the last word (search).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from network.analysis.diagnosis.exchange.exchange_fault import ExchangeFault
from network.analysis.diagnosis.exchange.exchange_scan import ExchangeScan, Score
from network.analysis.diagnosis.exchange.exchanged_columns import Pair
from network.analysis.diagnosis.exchange.exchanged_fits import Exchanged, fit_exchanged
from network.analysis.diagnosis.hypotheses.few_runs import list_worst_runs, on_few_runs
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis, SameFit
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis, linearise_at_file
from network.analysis.diagnosis.lumps.lump_refinement import MANY, refine_lumps
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.sensors.sensor_swap import SensorSwap
from network.machine.machine import Machine
from network.platform.refusal import Failed, Refused

CONFIRMED, NEARLY = 3, 2.0
"""Best scores that are confirmed by fits at most, and how many times what the best leaves they may leave, or it what
is not doubtful on lumps that may be too coarse (budget)."""
BRIEF = 12
"""Steps of these fits; that of the best goes on (budget)."""
RivalGain = Callable[[Hypothesis], float]
"""What the best of the catalogue scores about a fit [nats]."""


def find_exchange(
    h: Hypothesis, rival_gain: RivalGain, is_refined: bool = True
) -> tuple[ExchangeFault, Hypothesis] | None:  # fmt: skip
    """The two channels, and the hypothesis fitted to the readings put back; None where there are none. is_refined:
    whether lumps are as fine as they will be; else none is told that leaves much, for lumps may tell all of it."""
    price = price_of(h)
    ranked = _rank_pairs(h)
    if not is_refined and ranked and ranked[0].after.chi > NEARLY * SETTINGS.doubtful:
        return None
    best = _settle(ranked[0]) if ranked and ranked[0].mends(SETTINGS.half) else None
    if best is None or (best.after.chi > SETTINGS.doubtful and not is_refined):
        return None
    return _tell_if_worth(best, h.machine, ranked[1:], price, rival_gain)


def find_exchange_on_lumps(
    coarse: Hypothesis, finest: Hypothesis, rival_gain: RivalGain, jobs: int
) -> tuple[ExchangeFault, Hypothesis] | None:  # fmt: skip
    """The same of a machine as written, on the lumps that readings put back take: as they are they may take none.
    finest: on the lumps that the readings as they are take."""
    price = price_of(coarse)
    ranked = _rank_pairs(coarse)
    best = _refine(ranked[0], finest, jobs) if ranked else None
    return None if best is None else _tell_if_worth(best, coarse.machine, ranked[1:], price, rival_gain)


def _rank_pairs(h: Hypothesis) -> Sequence[Exchanged]:
    """The pairs that come near the best, as a few steps of a fit tell them; asked again on finer lumps."""
    return [replace(t, before=h, after=_within_time_of(h, t.after)) for t in _rank_once(SameFit(h))]


def _within_time_of(h: Hypothesis, other: Hypothesis) -> Hypothesis:
    return replace(other, case=replace(other.case, budget=h.case.budget))


@lru_cache(maxsize=2)
def _rank_once(same: SameFit) -> Sequence[Exchanged]:
    h = same.of
    price = price_of(h)
    scores = [s for s in scan_pairs(h) if s.gain > price]
    likely = [s for s in scores if s.cost <= NEARLY * scores[0].cost][:CONFIRMED]
    tried = [t for s in likely if (t := _try_exchanged(h, s))]
    return tuple(sorted((t for t in tried if t.gain > 0), key=lambda t: -t.gain))


def _tell_if_worth(
    best: Exchanged, machine: Machine, others: Sequence[Exchanged], price: float, rival_gain: RivalGain
) -> tuple[ExchangeFault, Hypothesis] | None:  # fmt: skip
    """An exchange that is worth its price and explains more than the best of the catalogue, as it is told of a
    machine."""
    if not best.holds(price):
        return None
    rival = rival_gain(best.before) * max(1.0, best.before.chi) ** 2
    return (best.tell(machine, others, rival), best.after) if best.gain > rival else None


def _refine(coarse: Exchanged, finest: Hypothesis, jobs: int) -> Exchanged | None:
    """Both readings on the lumps that those put back take, in the runs that say so; those as they are on their own
    where these explain more. None where those put back take no more, or too many, or no run says so."""
    try:
        after = max(refine_lumps(coarse.after.case, coarse.after, jobs), key=lambda h: h.evidence)
        if after is coarse.after or after.machine.lumps > MANY:
            return None
        before = fit_hypothesis(coarse.before.case, after.machine, start=after.values)
    except (Failed, Refused, np.linalg.LinAlgError):
        return None
    return _keep_clear(replace(coarse, before=max(before, finest, key=lambda h: h.evidence), after=after))


def scan_pairs(h: Hypothesis) -> list[Score]:
    """All pairs, each in the runs in which it leaves least, the best first."""
    pairs, about = list_pairs(h.machine), linearise_at_file(h)
    return ExchangeScan(about, pairs).best() if pairs and about is not None else []


def price_of(h: Hypothesis) -> float:
    """Evidence that a choice among all pairs and runs costs [nats]."""
    pairs, runs = max(1, len(list_pairs(h.machine))), len(h.case.recordings)
    return SETTINGS.least + float(np.log(pairs) + runs * np.log(2))


def list_pairs(machine: Machine) -> list[Pair]:
    """All that may be mixed up."""
    named = (tuple(patch["sensors"]) for patch in SensorSwap.proposes(machine))
    return [(a, b) for a, b in named]


def _try_exchanged(h: Hypothesis, score: Score) -> Exchanged | None:
    """A pair exchanged, fitted a few steps, to all runs only where that explains more of a few, and a quarter of
    what is left of the two there, for coarse lumps hide the rest; None where it does not."""
    few, mine = on_few_runs(h), tuple(score.runs[i] for i in list_worst_runs(h))
    if few is h or not any(mine):
        return fit_exchanged(h, score.pair, score.runs, steps=BRIEF)
    begun = fit_exchanged(few, score.pair, mine, steps=BRIEF)
    if begun is None or begun.gain <= 0 or not begun.mends(1 - SETTINGS.half**2):
        return None
    return fit_exchanged(h, score.pair, score.runs, begun.after.values, BRIEF)


def _settle(tried: Exchanged) -> Exchanged | None:
    """Fitted to the end, in the runs that say so; None where none does."""
    whole = fit_exchanged(tried.before, tried.pair, tried.runs, tried.after.values)
    return whole and _keep_clear(whole)


def _keep_clear(whole: Exchanged) -> Exchanged | None:
    """In the runs that say so; None where none does."""
    runs = whole.clear_runs
    if runs is None or runs == whole.runs:
        return whole if runs else None
    return fit_exchanged(whole.before, whole.pair, runs, whole.after.values, machine=whole.after.machine)
