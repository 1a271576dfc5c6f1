"""Random networks: trees, meshes, streams, junctions, held inputs. All methods agree, energy closes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from build import RPM, machine, schedule
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from network import Machine, simulate
from network.recordings.inputs import hold, linear

conductances = st.floats(0.5, 80).map(lambda G: f"{G:.4f} W/K")
capacities = st.floats(800, 60_000).map(lambda C: f"{C:.3f} J/K")


@st.composite
def machines(draw: Any) -> Machine:
    """A tree over 2–8 parts with junctions on some links, cross links, a stream perhaps, and losses to held nodes."""
    size = draw(st.integers(2, 8))
    names = [f"n{i}" for i in range(size)]
    nodes: dict[str, Any] = {n: {"heat_capacity": draw(capacities)} for n in names}
    nodes |= {"ambient": {"temperature": "ambient"}, "floor": {"temperature": "18 degC"}}
    links: dict[str, Any] = {}
    for i in range(1, size):
        parent = names[draw(st.integers(0, i - 1))]
        if draw(st.booleans()):
            nodes[f"j{i}"] = {}
            links[f"in {i}"] = {"kind": "conduction", "between": [parent, f"j{i}"], "conductance": draw(conductances)}
            parent = f"j{i}"
        links[f"tree {i}"] = {"kind": "conduction", "between": [parent, names[i]], "conductance": draw(conductances)}
    for i in range(draw(st.integers(0, 3))):
        a, b = draw(st.permutations(names))[:2]
        links[f"mesh {i}"] = {"kind": "conduction", "between": [a, b], "conductance": draw(conductances)}
    for name in draw(st.lists(st.sampled_from(names), min_size=1, unique=True)):
        to = draw(st.sampled_from(["ambient", "floor"]))
        links[f"skin {name}"] = {"kind": "convection", "between": [name, to], "conductance": draw(conductances)}
    if draw(st.booleans()):
        through = ["ambient", *draw(st.permutations(names))[: draw(st.integers(1, 3))]]
        links["stream"] = {"kind": "advection", "through": through, "capacity_flow": draw(conductances)}
    a, b = draw(st.permutations(names))[:2]
    sources = {"bearing": {"kind": "bearing_friction", "into": {a: 0.5, b: 0.5}, "torque": "400 N mm"}}
    sensors = {n: {"measures": n, "noise": "0.1 K"} for n in nodes if n not in ("ambient", "floor")}
    return machine(nodes, links=links, sources=sources, sensors=sensors)


@st.composite
def inputs(draw: Any) -> Any:
    """Held speed steps, an ambient that runs straight between knots, and an uneven output grid."""
    knots = np.cumsum(draw(st.lists(st.floats(5, 900), min_size=2, max_size=6)))
    speeds = np.array([draw(st.sampled_from([0, 3000, -6000, 9000])) for _ in range(len(knots))]) * RPM
    ambient = np.array([draw(st.floats(15, 28)) for _ in range(len(knots))])
    t = np.linspace(0, float(knots[-1]), draw(st.integers(2, 40)))
    return schedule(
        t, hold("speed", "rpm", knots - knots[0], speeds), linear("ambient", "degC", knots - knots[0], ambient)
    )


def quiet(examples: int) -> settings:
    return settings(
        max_examples=examples, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
    )


@quiet(25)
@given(machines(), inputs())
def test_modes_equal_matrix_exponentials(drawn: Machine, driver: Any) -> None:
    exact, other = (simulate(drawn, driver, method=m) for m in ("modal", "expm"))
    for name, values in exact.sensors.items():
        np.testing.assert_allclose(other.sensors[name], values, atol=1e-8, rtol=0)
    assert abs(exact.energy.closure) < 1e-9
    assert abs(other.energy.closure) < 1e-9


@quiet(8)
@pytest.mark.parametrize("method", ["LSODA", "BDF", "Radau", "RK45"])
@given(drawn=machines(), driver=inputs())
def test_solve_ivp_agrees(method: str, drawn: Machine, driver: Any) -> None:
    exact, other = simulate(drawn, driver), simulate(drawn, driver, method=f"solve_ivp:{method}")
    for name, values in exact.sensors.items():
        np.testing.assert_allclose(other.sensors[name], values, atol=5e-5, rtol=0)


@quiet(25)
@given(machines(), inputs())
def test_a_part_stays_between_its_surroundings_without_sources(drawn: Machine, driver: Any) -> None:
    """No heat: no part gets warmer than the warmest or colder than the coldest held node or start."""
    tree = drawn.to_plain() | {"sources": {}}
    still = machine(tree["nodes"], links=tree["links"], sensors=tree["sensors"])
    run = simulate(still, driver)
    held_values = np.concatenate([driver.signals["ambient"].start, driver.signals["ambient"].end, [18.0, 20.0]])
    everything = np.concatenate([*run.sensors.values()])
    assert everything.min() >= held_values.min() - 1e-9
    assert everything.max() <= held_values.max() + 1e-9
