"""The paper's closed form against hand calculations, and against the network where both must agree."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from build import RPM, machine, schedule

from network import Machine, Refused, Scenario, simulate
from network.engine.paper.closed_form import closed_form
from network.recordings.inputs import Start, constant, hold, linear

ROOT = Path(__file__).parent.parent
C, G_AIR, G_COOLANT, G_BEAM, POWER = 50e3, 4.0, 10.0, 6.0, 120.0
L, ALPHA, C_BEAM = 0.4, 1.1e-5, 2e6
T = np.arange(0, 7201, 30.0)
RUN = hold("speed", "rpm", np.array([0, 3600.0]), np.array([6000 * RPM, 0.0]))


def spindle_and_beam(**changes: Any) -> Machine:
    """A spindle of one lump between air, coolant and beam, with the beam behind a junction."""
    sections: dict[str, Any] = {
        "closed_form": {"spindle": "spindle", "beam": "beam"},
        "links": {
            "skin": {"kind": "convection", "between": ["spindle", "air"], "conductance": f"{G_AIR} W/K"},
            "jacket": {"kind": "convection", "between": ["spindle", "coolant"], "conductance": f"{G_COOLANT} W/K"},
            "guideway": {"kind": "conduction", "between": ["spindle", "joint"], "conductance": f"{2 * G_BEAM} W/K"},
            "seat": {"kind": "conduction", "between": ["joint", "beam"], "conductance": f"{2 * G_BEAM} W/K"},
            "beam skin": {"kind": "convection", "between": ["beam", "air"], "conductance": "50 W/K"},
        },
        "sources": {"loss": {"kind": "heat_source", "into": {"spindle": 1}, "power": f"{POWER} W", "with": "running"}},
        "tcp": {
            "z": {"grows": stretching("spindle", 1)},
            "y": {"beam": stretching("beam", -1), "spindle": stretching("spindle", 1)},
        },
    }
    nodes = {
        "spindle": {"heat_capacity": f"{C} J/K"}, "joint": {}, "beam": {"heat_capacity": f"{C_BEAM} J/K"},
        "air": {"temperature": "20 degC"}, "coolant": {"temperature": "20 degC"},
    }  # fmt: skip
    return machine(nodes | changes.pop("nodes", {}), **(sections | changes))


def stretching(part: str, direction: int) -> dict[str, Any]:
    return {"kind": "stretching", "of": part, "length": f"{L} m", "expansion": f"{ALPHA} 1/K", "direction": direction}


def without_beam(**changes: Any) -> Machine:
    """The same with nothing that joins spindle and beam: there the closed form is exact."""
    full = spindle_and_beam(**changes)
    taken = {"guideway": None, "seat": None, "beam skin": None}
    return full.patched({"nodes": {"joint": None}, "links": taken, "sources": {
        "into beam": {"kind": "heat_source", "into": {"beam": 1}, "power": "15 W", "with": "running"}}})  # fmt: skip


def test_constants_by_hand() -> None:
    """τ = C₁/(K′S + G_beam), f = q/(K′S + G_beam); δz = α L (f − T₀)(1 − e^(−t/τ)); k = α L q_in2/C₂, l = α L f."""
    form = closed_form(spindle_and_beam(), schedule(T, RUN))
    running, resting = form.laws
    loss = G_AIR + G_COOLANT + G_BEAM
    rise = POWER / loss
    assert running.tau == resting.tau == pytest.approx(C / loss, rel=1e-12)
    assert running.q_in2 == pytest.approx(G_BEAM * rise, rel=1e-12)
    assert resting.q_in2 == pytest.approx(0, abs=1e-9)
    assert running.exponential["z"] == pytest.approx((-ALPHA * L * rise, ALPHA * L * rise), rel=1e-12)
    slope, start = running.linear["y"]
    assert slope == pytest.approx(-ALPHA * L * G_BEAM * rise / C_BEAM, rel=1e-9)
    assert start == pytest.approx(ALPHA * L * rise, rel=1e-12)
    assert resting.linear["y"] == pytest.approx((0, 3600 * slope), rel=1e-9, abs=1e-18)


def test_laws_draw_the_same_curve() -> None:
    """i e^(−t/τ) + j and k t + l of every piece, t from its beginning, are what the form gives over time."""
    form = closed_form(Machine.load(ROOT / "machines/gantry_spindle.yaml"), schedule(
        T, RUN, constant("ambient", "degC", 23.0)))  # fmt: skip
    for n, law in enumerate(form.laws):
        mine = (law.start <= T) & ((law.stop > T) if n == 0 else (law.stop >= T))
        since = T[mine] - law.start
        i, j = law.exponential["z"]
        slope, at_start = law.linear["y"]
        assert form.tcp["z"][mine] == pytest.approx(i * np.exp(-since / law.tau) + j, rel=1e-9, abs=1e-15)
        assert form.tcp["y"][mine] == pytest.approx(slope * since + at_start, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("speed", [6000, 8000])
def test_equals_the_network_where_the_beam_gives_nothing_back(speed: int) -> None:
    """One lump of spindle, a beam with a heat flow of its own and no loss: the network is the closed form."""
    built = without_beam()
    signal = constant("speed", "rpm", speed * RPM)
    form, run = closed_form(built, schedule(T, signal)), simulate(built, schedule(T, signal))
    assert run.parts["spindle"] == pytest.approx(form.T, rel=1e-12)
    assert form.tcp["z"] == pytest.approx(run.tcp["z"], rel=1e-9, abs=1e-15)
    assert form.Q_in2 == pytest.approx(run.heat["beam"], rel=1e-9, abs=1e-9)


def test_state_goes_from_step_to_step() -> None:
    """Over a schedule of steps, and from a warm start, T̄ still is that of the network."""
    built, steps = without_beam(), np.array([0, 700.0, 2000, 3333, 5000])
    speed = hold("speed", "rpm", steps, np.array([1.0, 0, 2, 0, 1]))
    driven = schedule(T, speed, start=Start(nodes={"spindle": 31.0}, others=22.0))
    form, run = closed_form(built, driven), simulate(built, driven)
    assert run.parts["spindle"] == pytest.approx(form.T, rel=1e-12)
    assert form.tcp["z"] == pytest.approx(run.tcp["z"], rel=1e-9)


@pytest.mark.parametrize(("speed", "i", "k"), [(6000, 14.04, 5.44e-4), (8000, 8.39, 3.87e-4)])
def test_papers_fits(speed: int, i: float, k: float) -> None:
    """Eq. 24 to 27: δz = −i e^(−t/3400) + i and δy = −k t on the shipped machines of the paper (µm, s)."""
    built = Machine.load(ROOT / f"machines/paper_{speed}.yaml")
    (law,) = closed_form(built, Scenario.load(ROOT / f"scenarios/constant_{speed}.yaml")).laws
    assert law.tau == pytest.approx(3400, rel=1e-3)
    assert law.exponential["z"] == pytest.approx((-i * 1e-6, i * 1e-6), rel=1e-3)
    assert law.linear["y"] == pytest.approx((-k * 1e-6, 0), rel=1e-3)


def with_shaft(**changes: Any) -> Machine:
    """A housing that a heated shaft stands in; only the housing loses heat, 5 W/K; 8 W/K between them."""
    sections: dict[str, Any] = {
        "closed_form": {"spindle": "housing"},
        "links": {
            "bearing": {"kind": "conduction", "between": ["shaft", "housing"], "conductance": "8 W/K"},
            "skin": {"kind": "convection", "between": ["housing", "air"], "conductance": "5 W/K"},
        },
        "sources": {"loss": {"kind": "heat_source", "into": {"shaft": 1}, "power": f"{POWER} W", "with": "running"}},
        "tcp": {"z": {"grows": stretching("housing", 1)}},
    }
    nodes = {
        "shaft": {"heat_capacity": "10 kJ/K"}, "housing": {"heat_capacity": f"{C} J/K"},
        "air": {"temperature": "ambient"},
    }  # fmt: skip
    return machine(nodes | changes.pop("nodes", {}), **(sections | changes))


AIR = constant("ambient", "degC", 20.0)


def test_heat_source_inside_stands_at_once() -> None:
    """While it runs, T_s = T₀ + q/5 + q/8, the shaft's steady temperature, from the first instant; at rest T_s is T̄."""
    form = closed_form(with_shaft(), schedule(T, RUN, AIR))
    assert form.jumps and form.tau == pytest.approx((60e3 / 5, 60e3 / 5))
    assert form.tcp["z"][0] == pytest.approx(ALPHA * L * (POWER / 5 + POWER / 8) / 2, rel=1e-12)
    running, resting = form.laws
    assert running.exponential["z"][0] == pytest.approx(-ALPHA * L * POWER / 5 / 2, rel=1e-12)
    assert sum(resting.exponential["z"]) == pytest.approx(ALPHA * L * (form.T[T == 3600][0] - 20), rel=1e-12)


def test_ramped_air_counts_with_its_mean() -> None:
    """Air that warms by 3 K in two hours: one lump follows within what 30 s steps leave, and no law is written."""
    skin = {"kind": "convection", "between": ["housing", "air"], "conductance": "25 W/K"}
    plain = with_shaft(sources={}).patched({"nodes": {"shaft": None}, "links": {"bearing": None, "skin": skin}})
    driven = schedule(T, linear("ambient", "degC", np.array([0, 7200.0]), np.array([20.0, 23.0])))
    form, run = closed_form(plain, driven), simulate(plain, driven)
    assert form.laws == () and not form.jumps
    assert form.tcp["z"] == pytest.approx(run.tcp["z"], abs=2e-5 * np.abs(run.tcp["z"]).max())


def test_coolant_and_thermostat_are_outside() -> None:
    """The gantry mill with its real cooler has the unit, and the time constant, of the one with a perfect cooler."""
    scenario = Scenario.load(ROOT / "scenarios/constant_8000.yaml")
    gantry, chilled = (
        closed_form(Machine.load(ROOT / f"machines/{name}_spindle.yaml"), scenario) for name in ("gantry", "chilled")
    )
    assert chilled.unit.parts == gantry.unit.parts == ("shaft", "stator", "housing", "headstock")
    assert chilled.tau == pytest.approx(gantry.tau)
    assert gantry.left_out == ("tcp.z.table bends",)
    assert chilled.left_out == ("tcp.z.table bends", "sources.cooler")


def test_bent_laws_are_taken_at_one_temperature() -> None:
    """Radiation counts with its secant at 10 K over the reference, friction of warm oil with that at the reference."""
    curved = with_shaft(
        links={
            "bearing": {"kind": "conduction", "between": ["shaft", "housing"], "conductance": "8 W/K"},
            "skin": {"kind": "radiation", "between": ["housing", "air"], "emissivity_area": "1 m^2"},
        },
        sources={
            "oil": {
                "kind": "viscous_friction", "into": {"housing": 1}, "torque": "0.2 N m", "thinning": "0.03 1/K",
                "reads": "housing",
            },
        },
    )  # fmt: skip
    form = closed_form(curved, schedule(T, RUN, AIR))
    G = 5.670374419e-8 * (303.15**4 - 293.15**4) / 10
    assert form.tau[0] == pytest.approx(60e3 / G, rel=1e-9)
    end = form.laws[0].exponential["z"][1]
    assert end == pytest.approx(ALPHA * L * 0.2 * 6000 * RPM / G, rel=1e-9)
    told = ("links.skin: conductance at 10 K over the reference", "sources.oil: heat at the reference")
    assert form.simplified == told


def test_summary_is_in_seconds_and_micrometres() -> None:
    told = closed_form(spindle_and_beam(), schedule(T, RUN)).summary()
    assert told["spindle"] == ["spindle"] and told["beam"] == "beam"
    assert told["heat_capacity"] == {"value": C, "unit": "J/K"}
    assert [*told["laws"][0]] == ["start", "stop", "tau", "q_in2", "tcp"]
    assert told["laws"][0]["tcp"]["z"]["j"] == pytest.approx(1e6 * ALPHA * L * POWER / 20)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"closed_form": {}}, "needs to know which part is the spindle"),
        ({"closed_form": {"spindle": "housing", "beam": "housing"}}, "housing is both spindle and beam"),
        ({"closed_form": {"spindle": "air"}}, "air has no heat capacity"),
        ({"links": {"bearing": {"kind": "conduction", "between": ["shaft", "housing"], "conductance": "8 W/K"}}},
         "the spindle unit loses its heat to nothing"),
    ],
)  # fmt: skip
def test_refusals(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(Refused, match=said):
        closed_form(with_shaft(**changes), schedule(T, RUN, AIR))
