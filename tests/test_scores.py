"""Linear scores of what could be missing, beside the full fits that they stand in for."""

from __future__ import annotations

from functools import cache

import pytest
from fits import ANOTHER, USUAL, recorded, speeds, two_blocks

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.latent_heat.locate import locate
from network.analysis.diagnosis.screening.screen import Score, screen

LIES = 1.2
"""K: twelve times what a thermometer is taken to be off."""


@cache
def bent(sign: int) -> Hypothesis:
    """The null where a thermometer lies: its constant error and the numbers beside it are bent against their priors."""
    runs = [speeds(*steps, every=30.0) for steps in (USUAL, ANOTHER)]
    told = [recorded(two_blocks(), s, i, {"T_body": s.t * 0 + sign * LIES}) for i, s in enumerate(runs)]
    case = Case(two_blocks(), tuple(told))
    return fit_hypothesis(case, case.machine)


def lies(c: Candidate) -> bool:
    return c.kind.kind == "sensor_offset" and c.channels == ("T_body",)


def score_of(null: Hypothesis) -> Score:
    found = [c for c in candidates(null.machine, null.case.drivers) if lies(c)]
    return screen(null.linearised, found, null.values)[0]


@pytest.mark.parametrize("sign", [1, -1])
def test_what_relieves_a_bent_number_gains_by_that_whichever_way_it_goes(sign: int) -> None:
    null, score = bent(sign), score_of(bent(sign))
    c = score.candidate
    told = fit_hypothesis(null.case, c.machine, (c,), c.own, null.values | score.best)
    after = told.fit.temper(null.fit.problem.firm_theta, null.fit.problem.firm_eta)
    chi2 = max(1.0, float(null.fit.left @ null.fit.left) / len(null.fit.left))
    assert null.offset_pull > 5 > told.offset_pull
    assert score.gain == pytest.approx((null.fit.cost - after.cost) / 2 / chi2, rel=0.15)
    assert score.best[c.own[0].path] == pytest.approx(sign * LIES, abs=0.3)


@pytest.mark.parametrize("sign", [1, -1])
def test_what_a_bent_number_hides_is_at_its_channel(sign: int) -> None:
    null = bent(sign)
    assert locate(null.linearised, null.machine)[0].at.channel == "T_body"
    everything = screen(null.linearised, candidates(null.machine, null.case.drivers), null.values)
    assert lies(everything[0].candidate)
