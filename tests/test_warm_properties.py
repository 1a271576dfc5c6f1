"""Properties that change with temperature: conductivity along a bar, specific heat of a part."""

from __future__ import annotations

from typing import Any

import build as small
import numpy as np
import pytest
from fits import USUAL, problem_of, recorded, speeds, two_blocks
from scipy.integrate import solve_ivp

from network import Machine, simulate
from network.analysis.correction.linear_model import linearise
from network.engine.assembly import build
from network.engine.response.parameters import centres
from network.platform.refusal import Refused
from network.recordings.inputs import constant

PLAIN = {
    "density": "7850 kg/m^3", "specific_heat": "480 J/(kg K)", "conductivity": "50 W/(m K)", "expansion": "1.1e-5 1/K",
}  # fmt: skip
AIR = constant("ambient", "degC", 20.0)


def bar(lumps: int = 1, held: bool = False, **slopes: str) -> Machine:
    nodes: dict[str, Any] = {
        "bar": {"material": "it", "length": "400 mm", "area": "20 cm^2", "lumps": lumps},
        "air": {"temperature": "ambient"},
    }
    links: dict[str, Any] = {"skin": {"kind": "convection", "between": ["bar", "air"], "conductance": "2 W/K"}}
    if held:
        nodes["hot"], nodes["cold"] = {"temperature": "220 degC"}, {"temperature": "20 degC"}
        links = {
            "in": {"kind": "conduction", "between": ["hot", "bar@0"], "conductance": "1e6 W/K"},
            "out": {"kind": "conduction", "between": ["bar@1", "cold"], "conductance": "1e6 W/K"},
        }
    heater = {"kind": "heat_source", "into": {"bar": 1}, "power": "400 W"}
    sources = {} if held else {"heater": heater}
    return small.machine(nodes, materials={"it": {**PLAIN, **slopes}}, links=links, sources=sources,
                         sensors={"T": {"measures": "bar", "noise": "0.1 K"}})  # fmt: skip


def test_a_part_that_takes_more_heat_as_it_warms() -> None:
    """C (1 + b (T − 20)) dT/dt = P − G (T − 20), by another solver."""
    machine = bar(specific_heat_slope="0.001 1/K")
    made = simulate(machine, small.schedule(np.linspace(0, 7200, 61), AIR))
    C = 7850 * 480 * 0.4 * 20e-4
    other = solve_ivp(lambda _, x: (400 - 2 * x) / (C * (1 + 0.001 * x)), (0, 7200), [0.0], t_eval=made.t, rtol=1e-10,
                      atol=1e-10)  # fmt: skip
    assert made.shown("T") - 20 == pytest.approx(other.y[0], abs=2e-5)
    assert abs(made.energy.closure) < 1e-6 and "changes its heat capacity as it warms" in made.why
    x = made.shown("T")[-1] - 20
    assert made.energy.absorbed["bar"] == pytest.approx(C * (x + 0.001 * x**2 / 2), rel=1e-7)


def test_what_it_stores_is_found_back() -> None:
    stored = bar(specific_heat_slope="-0.002 1/K").nodes["bar"].stored
    assert stored is not None
    T = np.linspace(-50, 200, 51)
    capacity = bar().nodes["bar"].capacity
    heat = T + stored.compute_latent_heat(T) / capacity
    assert stored.temperature(heat, capacity) == pytest.approx(T, abs=1e-10)
    step = (stored.compute_latent_heat(T + 1e-3) - stored.compute_latent_heat(T - 1e-3)) / 2e-3
    assert stored.apparent_capacity(T) == pytest.approx(step, rel=1e-6, abs=1e-6)


def test_a_steady_bar_is_kirchhoffs() -> None:
    """θ = ∫k dT is straight along a bar: Q = S/L ∫k dT = S k/L ΔT (1 + a (T_m − 20)), at any number of lumps."""
    mean = 1 - 0.001 * 100
    flow = 20e-4 * 50 / 0.4 * 200 * mean
    for lumps in (5, 40):
        machine = bar(lumps, held=True, conductivity_slope="-0.001 1/K")
        made = simulate(machine, small.schedule(np.linspace(0, 20 * 3600, 11), AIR))
        T = np.array(made.T_end)[build(machine).parts["bar"]]
        assert np.abs(made.energy.closure) < 1e-4
        between = -np.diff((T - 20) - 0.001 * (T - 20) ** 2 / 2) * 20e-4 * 50 / 0.4 * lumps
        assert between == pytest.approx(np.full(lumps - 1, flow * lumps / (lumps - 1)), rel=1e-3)
        if lumps == 5:  # its third lump is the middle: x − 0.0005 x² = 90 K
            assert T[2] == pytest.approx(20 + (1 - np.sqrt(1 - 4 * 0.0005 * 90)) / 0.001, abs=0.01)


def test_without_slopes_nothing_changes() -> None:
    plain, zero = bar(3), bar(3, conductivity_slope="0 1/K", specific_heat_slope="0 1/K")
    runs = [simulate(m, small.schedule(np.linspace(0, 3600, 11), AIR)) for m in (plain, zero)]
    assert runs[0].method == runs[1].method == "modal"
    assert np.array_equal(runs[0].shown("T"), runs[1].shown("T"))


WARM = {"materials": {"it": {**PLAIN, "specific_heat_slope": "0.002 1/K", "conductivity_slope": "-0.002 1/K"}}}
BODY = {"body": {"material": "it", "length": "400 mm", "area": "100 cm^2", "lumps": 3}}


def test_a_fit_runs_as_the_simulation_does() -> None:
    """Concealed: recordings of a machine whose properties change, which the same without is far from."""
    machine, plain = two_blocks(nodes=BODY, **WARM), two_blocks(nodes=BODY, materials={"it": PLAIN})
    problem = problem_of(machine, recorded(machine, speeds(*USUAL), None))
    cells = problem.model.predict(centres(problem.parameters))[0].cells
    data, without = problem.data[0], problem_of(plain, recorded(plain, speeds(*USUAL), None)).data[0]
    assert np.abs(cells - data.means).max() < 0.005
    assert np.abs(without.means - data.means).max() > 0.1


def test_what_cannot_follow_it_says_so() -> None:
    cooler = {"kind": "thermostat_cooling", "into": {"body": 1}, "watches": "body", "set": "26 degC",
              "hysteresis": "1 K", "power": "300 W"}  # fmt: skip
    machine = two_blocks(nodes=BODY, sources={"cooler": cooler}, **WARM)
    recording = recorded(machine, speeds(*USUAL), None)
    with pytest.raises(Refused, match="body changes its heat capacity as it warms, which a fit cannot follow beside"):
        problem_of(machine, recording)
    with pytest.raises(Refused, match="changes its heat capacity as it warms, which no linear model does; leave its"):
        linearise(two_blocks(nodes=BODY, **WARM), [], [])
