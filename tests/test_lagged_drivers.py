"""What a slow part follows late is named; what drifts by itself follows nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from build import machine
from scipy.signal import lfilter

from network import Machine, Recording, Scenario, compare, simulate
from network.analysis.comparison.candidate_drivers import Candidate
from network.analysis.comparison.drivers import SURE
from network.analysis.comparison.lagged_drivers import block_means, find_lagging, granger, is_smooth
from network.analysis.comparison.resample import Grid
from network.recordings.columns import Column
from network.report.figures.shown_inputs import choose_inputs

STEP, N = 30.0, 1440


def table(pile: str) -> Machine:
    """A table that may be warmed by chips, on a bed that feeds and a spindle warm."""
    return machine(
        {"table": {"heat_capacity": "120 kJ/K"}, "bed": {"heat_capacity": "600 kJ/K"},
         "room": {"temperature": "ambient"}},
        links={"joint": {"kind": "conduction", "between": ["table", "bed"], "conductance": "25 W/K"},
               "skin": {"kind": "convection", "between": ["table", "room"], "conductance": "10 W/K"},
               "skirt": {"kind": "convection", "between": ["bed", "room"], "conductance": "25 W/K"}},
        sources={"guides": {"kind": "heat_source", "into": {"bed": 1}, "power": "120 W", "with": "feed",
                            "at": "10 m/min"},
                 "chips": {"kind": "heat_source", "into": {"table": 1}, "power": pile, "with": "cutting_power",
                           "at": "1 kW"},
                 "spindle": {"kind": "bearing_friction", "into": {"bed": 1}, "torque": "50 N mm"}},
        sensors={"T_table": {"measures": "table", "noise": "0.05 K"}, "T_bed": {"measures": "bed", "noise": "0.05 K"}},
    )  # fmt: skip


def day(seed: int) -> Scenario:
    draw = np.random.default_rng(seed)

    def steps(levels: list[float], unit: str, count: int) -> list[dict[str, str]]:
        lasts = draw.dirichlet(np.ones(count) * 2) * 720
        return [{"for": f"{m:.3f} min", "at": f"{draw.choice(levels)} {unit}"} for m in lasts]

    inputs: dict[str, Any] = {
        "speed": steps([0, 3000, 6000, 9000], "rpm", 14), "feed": steps([0, 4, 8], "m/min", 14),
        "cutting_power": steps([0, 0, 1, 2, 3], "kW", 10),
        "ambient": {"sine": {"mean": "20.5 degC", "amplitude": "0.7 K", "period": "24 h"}},
    }  # fmt: skip
    return Scenario.of("a day", "12 h", inputs, output="30 s")


def recorded(seed: int) -> Recording:
    run = simulate(table("80 W"), day(seed), noise_seed=seed)
    columns = {name: Column(name, unit, values) for name, unit, values in run.columns_in_si()}
    return Recording("a day", "day.csv", run.t, columns)


@pytest.mark.parametrize("seed", range(8))
def test_what_warms_a_slow_part_is_named(seed: int) -> None:
    """A pile of chips on the table: its residual follows the cutting power about an hour late, in every schedule."""
    residual = compare(table("0 W"), recorded(seed)).recordings[0]
    drivers = residual.tests["T_table"].drivers
    assert [driver.of for driver in drivers] == ["cutting_power"]
    assert drivers[0].form == "lagged" and drivers[0].r > 0.3 and drivers[0].p < 0.01
    assert "T_table follows cutting_power with a lag of " in drivers[0].sentence
    assert residual.summary()["channels"]["T_table"]["tests"]["drivers"][0]["name"] == "cutting_power"
    assert [signal.name for signal in choose_inputs(residual)] == ["cutting_power", "speed"]


@pytest.mark.parametrize("lasting", [60.0, 600.0, 3600.0, 10800.0, 1e9])
def test_what_drifts_by_itself_follows_nothing(lasting: float) -> None:
    """Autoregressive residuals beside steps that they have nothing to do with: 150 pairs for each time constant."""
    draw = np.random.default_rng(int(lasting))
    a, found = np.exp(-STEP / lasting), 0
    for noise in (0.0, 0.3, 3.0):
        for _ in range(50):
            push = draw.standard_normal(N) * (np.sqrt(1 - a * a) if lasting < 1e8 else 0.05)
            e = lfilter([1.0], [1.0, -a], push) + noise * draw.standard_normal(N)
            u = np.repeat(draw.choice([0.0, 1.0, 2.0], N // 60), 60)
            found += granger(block_means(e, 10), block_means(u, 10))[0] < SURE
    assert found <= 1


def test_the_lag_and_the_way_are_those_of_the_part() -> None:
    grid = Grid.of(np.arange(N) * STEP)
    draw = np.random.default_rng(1)
    u = np.repeat(draw.choice([0.0, 1.0, 2.0], N // 60), 60)
    u[:60] = 0.0  # at rest
    a = np.exp(-STEP / 3600)
    e = -lfilter([1 - a], [1.0, -a], u) + 0.02 * draw.standard_normal(N)
    found = find_lagging(e, np.ones(N), Candidate("u", "value", 0.0, True, u), grid, SURE)
    assert found is not None and found.r < -0.99 and found.lag == pytest.approx(3600, rel=0.2)


def test_what_goes_on_as_it_went_is_no_driver() -> None:
    """A room over a day would follow any drift."""
    t = np.arange(144.0)
    assert is_smooth(np.sin(t / 50)) and is_smooth(t) and not is_smooth(np.repeat([0.0, 1.0, 0.0, 2.0], 36))


def test_gaps_leave_out_blocks() -> None:
    e = np.sin(np.arange(200.0) / 9)
    e[50:60] = np.nan
    assert granger(e, np.repeat([0.0, 1.0], 100))[2] == 197 - 13
