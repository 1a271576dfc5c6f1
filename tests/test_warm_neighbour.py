"""What keeps a temperature of its own beside a part, far from the machine's: told with that temperature, not as heat.

Seen and not touched it exchanges heat by T⁴: what is told of it is straight about the mean of both.
"""

from __future__ import annotations

import numpy as np
import pytest
from build import machine
from test_diagnosis import HELD_OUT, LINKS, NODES, SENSORS, SOURCES, plant, recorded

from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.diagnose import diagnose
from network.machine.machine import Machine

LADDERS = ((0, 3000, 6000, 2000), (5000, 0, 8000, 4000), (1000, 9000, 3000))


def beside(temperature: str) -> Machine:
    """The machine, its column before a wall that it sees (ε A = 2 m²)."""
    sees = {"wall": {"kind": "radiation", "between": ["column", "wall"], "emissivity_area": "2 m^2"}}
    nodes = {**NODES, "wall": {"temperature": temperature}}
    return machine(nodes, links={**LINKS, **sees}, sources=SOURCES, sensors=SENSORS)


@pytest.mark.parametrize("degrees", [8.0, 40.0])
def test_a_part_before_a_wall_is_told_with_the_wall_s_temperature(degrees: float) -> None:
    truth = beside(f"{degrees} degC")
    runs = [recorded(truth, ladder, i) for i, ladder in enumerate(LADDERS)]
    d = diagnose(plant(), runs, [recorded(truth, HELD_OUT, 9)], seed=1)
    assert [(f.kind, f.places) for f in d.findings] == [("foundation", ("column",))]
    told = d.findings[0].parameters
    mean = (273.15 + degrees + 273.15 + float(np.mean([r.columns["T_column"].values.mean() for r in runs]))) / 2
    assert told["temperature"].value == pytest.approx(degrees, abs=2)
    assert told["conductance"].value == pytest.approx(4 * 2 * 5.67e-8 * mean**3, rel=0.15)
    assert d.fits.holdout_after is not None and d.fits.holdout_after.rmse_in_noise < 1.5


def test_surroundings_that_are_proposed_may_be_as_far_off_as_an_oven() -> None:
    (found,) = (c for c in candidates(plant(), plant().inputs) if c.name == "foundation (column)")
    temperature = next(p for p in found.own if p.field.unit == "degC")
    assert (temperature.spread, temperature.high - temperature.centre) == (6.0, 24.0)
