"""Sensors that are mixed up: pairs and runs scored about the numbers of the file, the best confirmed by fits.

Which pair, and in which runs, is a choice among many, and nothing that a slope tells: it costs the log of their number.
A pair counts where a fit with the two exchanged explains more than that, in units of how long the misfit that is left
lasts; where hardly anything is left of their own excess; where every run in which they are said to be exchanged says so
by itself, beside all numbers refitted; and where neither the catalogue nor unknown heat or an unknown error of one
channel explains as much. Where more is left than noise, a search without it has the last word (search).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from network.analysis.calibration.gauss_newton import STEPS, Linearised, linearise
from network.analysis.calibration.misfit import lasting_misfit
from network.analysis.diagnosis.candidates.candidate import candidate
from network.analysis.diagnosis.exchange.exchange_fault import ExchangeFault, exchange_runs
from network.analysis.diagnosis.exchange.exchange_scan import ExchangeScan, Runs, Score
from network.analysis.diagnosis.exchange.exchanged_columns import Pair
from network.analysis.diagnosis.findings.finding import Rival
from network.analysis.diagnosis.findings.findings import why_not
from network.analysis.diagnosis.hypotheses.few_runs import list_worst_runs, on_few_runs
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis, theta_of
from network.analysis.diagnosis.intermittent.channel_fault import LEFT
from network.analysis.diagnosis.intermittent.channel_samples import excess_of
from network.analysis.diagnosis.latent_heat.locate import explain_unknown_at_most
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.sensors.sensor_swap import SensorSwap
from network.machine.machine import Machine
from network.platform.refusal import Failed, Refused

CONFIRMED, NEARLY = 3, 2.0
"""Best scores that are confirmed by fits at most, and how many times what the best leaves they may leave (budget)."""
BRIEF = 12
"""Steps of these fits; that of the best goes on (budget)."""


def find_exchange(h: Hypothesis, rival_gain: Callable[[], float]) -> tuple[ExchangeFault, Hypothesis] | None:
    """The two channels, and the hypothesis fitted to the readings put back; None where there are none. rival_gain: what
    the best of the catalogue scores about the same fit [nats]."""
    pairs = list_pairs(h.machine)
    about = _linearise_at_file(h)
    if not pairs or about is None:
        return None
    price = SETTINGS.least + float(np.log(len(pairs))) + len(h.case.recordings) * float(np.log(2))
    tried = [t for s in _likely(about, pairs, price) if (t := _try_exchanged(h, s))]
    ranked = sorted((t for t in tried if t.gain > 0), key=lambda t: -t.gain)
    best = _settle(ranked[0]) if ranked else None
    if best is None or best.worth <= price or not best.is_mended or not best.beats_unknown:
        return None
    rival = rival_gain() * max(1.0, h.chi) ** 2
    return (best.tell(ranked[1:], rival), best.after) if best.gain > rival else None


def _likely(about: Linearised, pairs: Sequence[Pair], price: float) -> list[Score]:
    """Those that are worth a fit."""
    scores = [s for s in ExchangeScan(about, pairs).best() if s.gain > price]
    return [s for s in scores if s.cost <= NEARLY * scores[0].cost][:CONFIRMED]


def list_pairs(machine: Machine) -> list[Pair]:
    """All that may be mixed up."""
    named = (tuple(patch["sensors"]) for patch in SensorSwap.proposes(machine))
    return [(a, b) for a, b in named]


@dataclass(frozen=True, eq=False)
class Exchanged:
    """Fits to the readings as they are and with a pair of channels exchanged in some runs."""

    before: Hypothesis
    after: Hypothesis
    pair: Pair
    runs: Runs

    @cached_property
    def firm(self) -> float:
        """What noise counts with beside what is left and how long that lasts."""
        return lasting_misfit(self.after.linearised)

    @property
    def gain(self) -> float:
        return self.after.evidence - self.before.evidence

    @property
    def worth(self) -> float:
        """The gain, where noise counts so."""
        return self.gain / self.firm**2

    @cached_property
    def told(self) -> dict[int, float]:
        """By run, what speaks against the other way there, all numbers refitted [nats]; runs without both channels are
        not in it."""
        ways = ExchangeScan(self.after.linearised, [self.pair]).ways(self.pair, self.firm)
        as_it_is = (False,) * len(self.runs)
        stays = ways.cost(as_it_is)
        return {runs.index(True): (cost - stays) / 2 / self.firm**2 for cost, runs in ways.flip(as_it_is)}

    @property
    def clear_runs(self) -> Runs | None:
        """The runs in which it is exchanged, by what each says: all that have both, where none says otherwise; None
        where no run says so."""
        says = {i: self.runs[i] == (d > 0) for i, d in self.told.items() if abs(d) > SETTINGS.least}
        if not any(says.values()):
            return None
        some = range(len(self.runs))
        return tuple(i in self.told for i in some) if all(says.values()) else tuple(says.get(i, False) for i in some)

    @property
    def is_mended(self) -> bool:
        """Whether hardly anything is left of the excess of the two where they are exchanged."""
        exchanged = [i for i, is_in in enumerate(self.runs) if is_in]
        before, after = (excess_of(h, self.pair, exchanged) for h in (self.before, self.after))
        return after <= LEFT * before

    @property
    def beats_unknown(self) -> bool:
        """Whether with unknown heat or an unknown error beside it it explains more than these alone."""
        alone, beside = (explain_unknown_at_most(h.linearised, h.machine) for h in (self.before, self.after))
        return self.gain + beside > alone

    def tell(self, others: Sequence[Exchanged], rival: float) -> ExchangeFault:
        """With its share of belief beside others and the best of the catalogue."""
        ends = [self.gain, 0.0, rival, *(o.gain for o in others)]
        share = np.exp((np.array(ends) - max(ends)) / (SETTINGS.softening * max(1.0, self.after.chi) ** 2))
        share /= share.sum()
        beside = tuple(_as_rival(o, self, float(p)) for o, p in zip(others, share[3:], strict=True))
        swap = candidate(self.before.machine, SensorSwap, _patch_of(self.before.machine, self.pair))
        assert swap is not None
        sure = min(float(share[0]), SETTINGS.most_sure)
        is_machines = all(self.runs[i] for i in self.told)
        return ExchangeFault(self.before.case.recordings, self.gain, swap, self.runs, is_machines, sure, beside)


def fit_exchanged(
    h: Hypothesis, pair: Pair, runs: Runs, begin: Mapping[str, float] | None = None, steps: int = STEPS
) -> Exchanged | None:
    """A pair exchanged in some runs, fitted from some numbers, by default those of the file; None where that fails."""
    case = replace(h.case, recordings=exchange_runs(h.case.recordings, pair, runs))
    try:
        after = fit_hypothesis(case, h.machine, h.found, h.own, begin or h.own_values, steps=steps)
    except (Failed, Refused, np.linalg.LinAlgError):
        return None
    return Exchanged(h, after, pair, runs)


def _try_exchanged(h: Hypothesis, score: Score) -> Exchanged | None:
    """A pair exchanged, fitted a few steps, to all runs only where that explains more of a few; None where it does
    not."""
    few, mine = on_few_runs(h), tuple(score.runs[i] for i in list_worst_runs(h))
    if few is h or not any(mine):
        return fit_exchanged(h, score.pair, score.runs, steps=BRIEF)
    begun = fit_exchanged(few, score.pair, mine, steps=BRIEF)
    if begun is None or begun.gain <= 0:
        return None
    return fit_exchanged(h, score.pair, score.runs, begun.after.values, BRIEF)


def _settle(tried: Exchanged) -> Exchanged | None:
    """Fitted to the end, in the runs that say so; None where none does."""
    whole = fit_exchanged(tried.before, tried.pair, tried.runs, tried.after.values)
    if whole is None or (runs := whole.clear_runs) is None:
        return None
    if runs == whole.runs:
        return whole
    return fit_exchanged(whole.before, whole.pair, runs, whole.after.values)


def _linearise_at_file(h: Hypothesis) -> Linearised | None:
    """About the numbers of the file, for those of a fit to readings that are not true are bent."""
    try:
        return linearise(h.fit.problem, theta_of(h.fit.problem.parameters, h.own_values))
    except (Failed, np.linalg.LinAlgError):
        return None


def _patch_of(machine: Machine, pair: Pair) -> Mapping[str, Any]:
    return next(patch for patch in SensorSwap.proposes(machine) if {*patch["sensors"]} == {*pair})


def _as_rival(other: Exchanged, best: Exchanged, share: float) -> Rival:
    h = other.after
    return Rival(SensorSwap.kind, (), other.pair, share, h.chi, other.gain, why_not(h, best.after))
