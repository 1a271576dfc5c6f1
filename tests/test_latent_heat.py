"""Parts that melt, in fits: against the reference solver, slopes against differences, refusals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from fits import USUAL, problem_of, recorded, speeds, two_blocks

from network import Machine
from network.engine.response.parameters import centres
from network.platform.refusal import Refused

STORE = {"heat_capacity": "15 kJ/K"}
BAR = {"material": "steel", "length": "400 mm", "area": "60 cm^2", "lumps": 3}


def melting(latent_heat: str, body: dict[str, Any], **melts: str) -> Machine:
    given = {"at": "26 degC", "over": "2 K", "latent_heat": latent_heat, **melts}
    return two_blocks(nodes={"body": {**body, "melts": given}})


@pytest.mark.parametrize(("latent_heat", "body"), [("20 kJ", STORE), ("180 kJ", STORE), ("60 kJ", BAR)])
def test_a_fit_runs_as_the_reference_does(latent_heat: str, body: dict[str, Any]) -> None:
    """To a tenth of the noise of 0.05 K, where without melting whole kelvins would be left."""
    machine, plain = melting(latent_heat, body), two_blocks(nodes={"body": body})
    problem = problem_of(machine, recorded(machine, speeds(*USUAL), None))
    cells = problem.model.predict(centres(problem.parameters))[0].cells
    data, without = problem.data[0], problem_of(plain, recorded(plain, speeds(*USUAL), None)).data[0]
    assert np.abs(cells - data.means).max() < 0.005
    assert np.abs(without.means - data.means).max() > 0.5


def test_slopes_are_those_of_differences() -> None:
    machine = melting("100 kJ", STORE)
    problem = problem_of(machine, recorded(machine, speeds(*USUAL), None))
    theta = centres(problem.parameters)
    predictions = problem.model.predict(theta)
    slopes = problem.model.mean_slopes(theta, predictions)[0]
    for j, p in enumerate(problem.parameters):
        ends = []
        for step in (1e-3, -1e-3):
            there = theta.copy()
            there[j] += step
            ends.append(problem.model.predict(there)[0].cells)
        difference = (ends[0] - ends[1]) / 2e-3
        assert np.linalg.norm(slopes[j] - difference) < 0.02 * np.linalg.norm(difference), p.path


def test_a_part_that_melts_beside_a_relay_is_refused() -> None:
    cooler = {"kind": "thermostat_cooling", "into": {"body": 1}, "watches": "body", "set": "26 degC",
              "hysteresis": "1 K", "power": "300 W"}  # fmt: skip
    machine = melting("100 kJ", STORE)
    recording = recorded(machine, speeds(*USUAL), None)
    with pytest.raises(Refused, match="body melts, which a fit cannot follow beside a relay; take the relay out"):
        problem_of(machine.patched({"sources": {"cooler": cooler}}), recording)
