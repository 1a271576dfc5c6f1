"""Fits to readings as they are and with a pair of channels exchanged, and what they say of the pair."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from network.analysis.calibration.gauss_newton import STEPS
from network.analysis.calibration.misfit import lasting_misfit
from network.analysis.diagnosis.candidates.candidate import candidate
from network.analysis.diagnosis.exchange.exchange_fault import ExchangeFault, exchange_runs
from network.analysis.diagnosis.exchange.exchange_scan import ExchangeScan, Runs
from network.analysis.diagnosis.exchange.exchanged_columns import Pair
from network.analysis.diagnosis.findings.finding import Rival
from network.analysis.diagnosis.findings.findings import why_not
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.intermittent.channel_fault import LEFT
from network.analysis.diagnosis.intermittent.channel_samples import excess_of
from network.analysis.diagnosis.latent_heat.locate import explain_unknown_at_most
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.sensors.sensor_swap import SensorSwap
from network.machine.machine import Machine
from network.platform.refusal import Failed, Refused


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
        return self.mends(LEFT)

    def mends(self, share: float) -> bool:
        """Whether no more than a share is left of that."""
        exchanged = [i for i, is_in in enumerate(self.runs) if is_in]
        before, after = (excess_of(h, self.pair, exchanged) for h in (self.before, self.after))
        return after <= share * before

    @property
    def beats_unknown(self) -> bool:
        """Whether with unknown heat or an unknown error beside it it explains more than these alone."""
        alone, beside = (explain_unknown_at_most(h.linearised, h.machine) for h in (self.before, self.after))
        return self.gain + beside > alone

    def holds(self, price: float) -> bool:
        """Whether it explains more than the price of the choice [nats], so that hardly anything is left, and more than
        what is unknown would."""
        return self.worth > price and self.is_mended and self.beats_unknown

    def tell(self, machine: Machine, others: Sequence[Exchanged], rival: float) -> ExchangeFault:
        """With its share of belief beside others and the best of the catalogue. machine: that it is told of."""
        ends = [self.gain, 0.0, rival, *(o.gain for o in others)]
        share = np.exp((np.array(ends) - max(ends)) / (SETTINGS.softening * max(1.0, self.after.chi) ** 2))
        share /= share.sum()
        beside = tuple(_as_rival(o, self, float(p)) for o, p in zip(others, share[3:], strict=True))
        swap = candidate(machine, SensorSwap, _patch_of(machine, self.pair))
        assert swap is not None
        sure = min(float(share[0]), SETTINGS.most_sure)
        is_machines = all(self.runs[i] for i in self.told)
        return ExchangeFault(self.before.case.recordings, self.gain, swap, self.runs, is_machines, sure, beside)


def fit_exchanged(
    h: Hypothesis, pair: Pair, runs: Runs, begin: Mapping[str, float] | None = None, steps: int = STEPS,
    machine: Machine | None = None,
) -> Exchanged | None:  # fmt: skip
    """A pair exchanged in some runs, fitted from some numbers, by default those of the file, on the lumps of the
    hypothesis or of another machine; None where that fails."""
    case = replace(h.case, recordings=exchange_runs(h.case.recordings, pair, runs))
    try:
        after = fit_hypothesis(case, machine or h.machine, h.found, h.own, begin or h.own_values, steps=steps)
    except (Failed, Refused, np.linalg.LinAlgError):
        return None
    return Exchanged(h, after, pair, runs)


def _patch_of(machine: Machine, pair: Pair) -> Mapping[str, Any]:
    return next(patch for patch in SensorSwap.proposes(machine) if {*patch["sensors"]} == {*pair})


def _as_rival(other: Exchanged, best: Exchanged, share: float) -> Rival:
    h = other.after
    return Rival(SensorSwap.kind, (), other.pair, share, h.chi, other.gain, why_not(h, best.after))
