"""The machines and scenarios of the project: each runs, closes its energy, and gives a number got by hand."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.optimize import fsolve

from network.analysis.comparison.compare import compare
from network.catalogue.mechanisms.palmgren_friction import PalmgrenFriction
from network.engine.assembly import build
from network.engine.simulation import simulate
from network.engine.trajectory import Trajectory
from network.machine.machine import Machine
from network.platform.refusal import Refused
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario

ROOT = Path(__file__).resolve().parents[1]
CASES = ROOT.parent / "shared" / "cases"
MACHINES = sorted(path.stem for path in (ROOT / "machines").glob("*.yaml"))
SCENARIOS = sorted(path.stem for path in (ROOT / "scenarios").glob("*.yaml"))
FAST = ("constant_6000", "constant_8000", "warm_up_and_stop", "day_of_work", "new_machine_day")
TOO_FAST = {("belt_lathe", name) for name in FAST}
TOO_FAST |= {("cnc_lathe_plain", "day_of_work"), ("cnc_lathe", "day_of_work")}
BY_CORRELATIONS = {"described_spindle": {"constant_6000", "constant_8000"}}
"""Machines whose films take tens of milliseconds a step, and what they are run by."""
TO_CALIBRATE = {"lathe_warm_up"}
"""Machines with numbers that are `unknown`."""
HOTTEST = {"two_heater_rig": 80, "toaster_oven": 600, "heated_building": 80}
COLDEST = {"heated_building": 0}
RPM, STEFAN_BOLTZMANN, KELVIN = 2 * pi / 60, 5.670374419e-8, 273.15


@cache
def machine(name: str, level: str | None = None) -> Machine:
    return Machine.load(ROOT / "machines" / f"{name}.yaml", level=level)


@cache
def scenario(name: str) -> Scenario:
    return Scenario.load(ROOT / "scenarios" / f"{name}.yaml")


def drives(scenario_name: str, machine_name: str) -> bool:
    return machine(machine_name).inputs.keys() <= scenario(scenario_name).schedule.signals.keys()


DRIVEN = [(m, s) for m in MACHINES for s in SCENARIOS if drives(s, m) and (m, s) not in TOO_FAST]
PAIRS = [(m, s) for m, s in DRIVEN if m not in TO_CALIBRATE and s in BY_CORRELATIONS.get(m, {s})]
LEVELS = [(m, level) for m in MACHINES for level in machine(m).to_plain().get("levels", ())]


@cache
def run(machine_name: str, scenario_name: str) -> Trajectory:
    return simulate(machine(machine_name), scenario(scenario_name))


def settled(machine_name: str, **inputs: Any) -> Trajectory:
    """After 400 hours of the same inputs."""
    return simulate(machine(machine_name), Scenario.of("long", "400 h", inputs, output="1 h"))


def assert_closed(result: Trajectory) -> None:
    """What went in less what went out is what is stored: exactly in modes, to the integrator's tolerance elsewhere."""
    assert abs(result.energy.closure) < (1e-9 if result.method in ("modal", "switched", "expm") else 1e-5)


def test_every_machine_is_driven_and_every_scenario_drives() -> None:
    assert {m for m, _ in DRIVEN} == set(MACHINES)
    assert {s for _, s in DRIVEN} == set(SCENARIOS)


@pytest.mark.parametrize(("name", "by"), PAIRS)
def test_it_runs_and_closes_its_energy(name: str, by: str) -> None:
    result = run(name, by)
    assert_closed(result)
    assert result.warnings == () and machine(name).warnings == ()
    for _, _, values in result.columns():
        assert np.isfinite(values).all()
    parts = [values for part, values in result.parts.items() if machine(name).nodes[part].is_part]
    assert min(map(np.min, parts)) > COLDEST.get(name, 15) and max(map(np.max, parts)) < HOTTEST.get(name, 60)


@pytest.mark.parametrize(("name", "level"), LEVELS)
def test_its_levels_run_and_keep_heat_capacity(name: str, level: str) -> None:
    other = machine(name, level)
    total, kept = (sum(node.capacity for node in m.nodes.values()) for m in (machine(name), other))
    assert kept == pytest.approx(total, rel=1e-12)
    by = next(s for m, s in PAIRS if m == name)
    assert_closed(simulate(other, scenario(by)))


# -- gantry mill ----------------------------------------------------------------------------------------------------
def gantry_losses(rpm: float) -> tuple[float, float, float]:
    """Front bearings, rear bearing, motor [W]: |ω| M, and copper + iron (n/10000)^1.5."""
    return rpm * RPM * 0.240, rpm * RPM * 0.065, 70 + 230 * (rpm / 10_000) ** 1.5


@pytest.mark.parametrize("rpm", [6000, 8000])
def test_gantry_spindle_takes_up_the_losses(rpm: int) -> None:
    result = run("gantry_spindle", f"constant_{rpm}")
    heat = {name: E for name, E in result.energy.by_mechanism.items() if name.startswith("sources.")}
    hours = 4 * 3600
    expected = dict(zip(("front friction", "rear friction", "motor loss"), gantry_losses(rpm), strict=True))
    assert heat == pytest.approx({f"sources.{name}": power * hours for name, power in expected.items()}, rel=1e-12)


def test_gantry_spindle_grows_with_the_heat_it_absorbed() -> None:
    """ΔL = α E/(ρ c S) of the heat-quantity method, E from heat flows, on shares of housing and beam."""
    result = run("gantry_spindle", "constant_8000")
    for axis, name, part, of_it, alpha, capacity_per_length in (
        ("z", "housing grows", "housing", 0.65, 1.13e-5, 7850 * 477 * 335e-4),
        ("y", "beam grows", "beam", -0.4, 1.08e-5, 7200 * 500 * 1050e-4),
    ):
        growth = of_it * alpha * result.energy.absorbed[part] / capacity_per_length
        assert result.contributions[axis, name][-1] == pytest.approx(growth, rel=1e-9)


def test_gantry_spindle_settles_where_its_conductances_say() -> None:
    """Unknown: shaft, stator, housing, headstock, beam over 21.6 °C, the air's and the coolant's temperature."""
    front, rear, gap, seat, jacket, flange, guide = 26, 9, 7, 95, 29, 48, 14
    nose, skin, head, beam = 1.4, 2.8, 12, 52
    bearings = front + rear
    G = np.array([
        [bearings + gap + nose, -gap, -bearings, 0, 0],
        [-gap, gap + seat, -seat, 0, 0],
        [-bearings, -seat, bearings + seat + jacket + flange + skin, -flange, 0],
        [0, 0, -flange, flange + guide + head, -guide],
        [0, 0, 0, -guide, guide + beam],
    ])  # fmt: skip
    front_q, rear_q, motor = gantry_losses(8000)
    rise = np.linalg.solve(G, [(front_q + rear_q) / 2, motor, (front_q + rear_q) / 2, 0, 0])
    result = settled("gantry_spindle", speed="8000 rpm", ambient="21.6 degC")
    parts = ("shaft", "stator", "housing", "headstock", "beam")
    assert [result.parts[part][-1] - 21.6 for part in parts] == pytest.approx(list(rise), rel=1e-9)


def test_gantry_spindle_is_the_machine_of_the_method() -> None:
    """δz = i e^(−t/τ) + j with τ near 3400 s at either speed, tens of µm; the housing some 10 K above the shop."""
    for rpm in (6000, 8000):
        result = run("gantry_spindle", f"constant_{rpm}")
        decay = np.exp(-result.t / 3400)
        assert np.corrcoef(result.tcp["z"], decay)[0, 1] < -0.997
        T = result.parts["housing"]
        at_63 = result.t[np.searchsorted(T - T[0], (1 - np.exp(-1)) * (T[-1] - T[0]))]
        assert at_63 == pytest.approx(3400, rel=0.1)
    assert 30e-6 < result.tcp["z"][360] < result.tcp["z"][720] < 100e-6
    assert 7 < T[-1] - 21.6 < 13


# -- the spindle by its drawing -------------------------------------------------------------------------------------
def test_described_spindle_settles_where_its_correlations_say() -> None:
    """Gnielinski in the helix, Palmgren in the front bearing's grease, and no offset left by the chiller."""
    result = settled("described_spindle", speed="8000 rpm", ambient="21.6 degC")
    shaft, housing = (result.T_end[build(result.machine).parts[name]] for name in ("shaft", "housing"))
    tank, jacket = (result.parts[name][-1] for name in ("tank", "jacket"))
    assert tank == pytest.approx(21.6, abs=1e-4)

    rho, k, mu = 997.7, 0.604, 9.45e-4  # water near 23 °C
    Re, Pr = 8 / 60e3 / 72e-6 * 8e-3 * rho / mu, mu * 4182 / k
    f = (0.79 * np.log(Re) - 1.64) ** -2 / 8
    Nu = f * (Re - 1000) * Pr / (1 + 12.7 * np.sqrt(f) * (Pr ** (2 / 3) - 1)) * (1 + (8e-3 / 6) ** (2 / 3))
    washed = housing @ (np.array([1 / 3 - 0.1, 1 / 3, 0.75 - 2 / 3]) / 0.65)
    assert Nu * k / 8e-3 * 0.22 * (washed - jacket) == pytest.approx(557 * (jacket - tank), rel=0.02)

    known = [[1, -np.log10(T + KELVIN)] for T in (40, 100)], [np.log10(np.log10(v + 0.7)) for v in (22, 4.3)]
    A, B = np.linalg.solve(*known)
    nu = 10**10 ** (A - B * np.log10(shaft[0] + KELVIN)) - 0.7
    torque = 1e-7 * 1.1 * (nu * 8000) ** (2 / 3) * 90**3 + 0.0003 * 600 * 90
    by_hand, front = 8000 * RPM * torque / 1e3, result.machine.sources["front friction"]
    assert isinstance(front, PalmgrenFriction)
    assert float(front.heat({"speed": np.array(8000 * RPM)}, shaft[0])) == pytest.approx(by_hand, rel=1e-6)
    assert 150 < by_hand < 400


# -- the cooler -----------------------------------------------------------------------------------------------------
def last_cycle(result: Trajectory) -> tuple[float, float]:
    """Time on and whole period of the last complete cycle of the cooler [s]."""
    last = [switch for switch in result.switches if switch[1] == "cooler"]
    begin = max(i for i in range(len(last) - 2) if last[i][2])
    return last[begin + 1][0] - last[begin][0], last[begin + 2][0] - last[begin][0]


@pytest.mark.parametrize("rpm", [6000, 8000])
def test_chilled_spindle_cycles_as_its_tank_says(rpm: int) -> None:
    """Tank and jacket swing together: 2 h C/(P D (1 − D)), D the share of time on; the load hardly changes."""
    result = run("chilled_spindle", f"constant_{rpm}")
    on, period = last_cycle(result)
    D = on / period
    assert period == pytest.approx(2 * 0.8 * (90e3 + 5.4e3) / (1100 * D * (1 - D)), rel=0.03)
    assert np.all((result.parts["tank"] > 20.8 - 1e-3) & (result.parts["tank"] < 22.4 + 1e-3))


def test_chilled_spindle_cools_for_as_long_as_it_is_on() -> None:
    result = run("chilled_spindle", "warm_up_and_stop")
    ends = [t for t, name, _ in result.switches if name == "cooler"]
    ends += [result.t[-1]] if len(ends) % 2 else []
    on = sum(off - begin for begin, off in zip(ends[::2], ends[1::2], strict=True))
    assert result.energy.by_mechanism["sources.cooler"] == pytest.approx(-1100 * on, rel=1e-6)
    assert result.energy.by_mechanism["sources.pump"] == pytest.approx(60 * 2 * 3600, rel=1e-9)


def test_chilled_spindle_cycles_faster_with_more_load() -> None:
    slow, fast = (last_cycle(run("chilled_spindle", f"constant_{rpm}"))[1] for rpm in (6000, 8000))
    assert fast < 0.95 * slow


# -- vertical mill --------------------------------------------------------------------------------------------------
def test_vertical_mill_settles_where_losses_leave_through_its_skins() -> None:
    result = settled("vertical_mill", speed="8000 rpm", ambient="21.6 degC")
    T = {part: values[-1] for part, values in result.parts.items()}
    rise = {part: value - 21.6 for part, value in T.items()}

    def glow(part: str, area: float) -> float:
        return area * STEFAN_BOLTZMANN * ((T[part] + KELVIN) ** 4 - (21.6 + KELVIN) ** 4)

    skins = 1.58 * 1.1 * rise["head"] ** 1.25
    skins += 1.31 * 1.0 * rise["column front"] ** 1.33 + 1.31 * 1.5 * rise["column back"] ** 1.33
    glows = glow("head", 0.95) + glow("column front", 0.6) + glow("column back", 1.3)
    films = 0.15 * (1 + 6 * 0.8**0.67) * rise["shaft"] + 7 * rise["motor"] + 0.8 * rise["screw"] + 24 * rise["base"]
    losses = 8000 * RPM * (0.095 + 0.045) + 45 + 140 * (8000 / 12_000) ** 1.5
    assert skins + glows + films == pytest.approx(losses, rel=1e-6)
    nod = 1.08e-5 * 0.6 * 1.6 * (T["column front"] - T["column back"]) / 0.45
    assert result.tcp["a"][-1] == pytest.approx(nod, rel=1e-9)


# -- belt-driven lathe ----------------------------------------------------------------------------------------------
def lathe_losses(rpm: float) -> dict[str, float]:
    """[W]: Palmgren's torques in N mm, ν = 20 mm²/s; belt and motor by their powers of n."""
    stirred = 1e-7 * (20 * rpm) ** (2 / 3)
    front, rear = 2 * stirred * 125**3 + 0.0003 * 1500 * 125, 1 * stirred * 112**3 + 0.0003 * 800 * 112
    belt, motor = 120 * (rpm / 3000) ** 1.3, 80 + 200 * (rpm / 3000) ** 1.5
    friction = {"front friction": rpm * RPM * front / 1e3, "rear friction": rpm * RPM * rear / 1e3}
    return friction | {"belt loss": belt, "motor loss": motor}


def test_belt_lathe_takes_up_the_losses_and_warms_its_headstock() -> None:
    result = run("belt_lathe", "constant_3000")
    expected = {f"sources.{name}": power * 4 * 3600 for name, power in lathe_losses(3000).items()}
    heat = {name: E for name, E in result.energy.by_mechanism.items() if name.startswith("sources.")}
    assert heat == pytest.approx(expected, rel=1e-9)
    assert 10 < result.parts["headstock"][-1] - 21.6 < 15
    assert -50 < result.shown("tcp.y")[-1] < -20 and -30 < result.shown("tcp.x")[-1] < -10


@pytest.mark.parametrize("rpm", [1500, 3000])
def test_belt_lathe_settles_where_losses_leave_through_its_skins(rpm: int) -> None:
    """One lump for each part; chuck, pulley and spindle turn as one."""
    inputs = {"speed": f"{rpm} rpm", "ambient": "21.6 degC"}
    result = simulate(machine("belt_lathe", "coarse"), Scenario.of("long", "800 h", inputs, output="1 h"))
    T = {part: values[-1] for part, values in result.parts.items()}
    rise = {part: value - 21.6 for part, value in T.items()}

    def glow(part: str, area: float) -> float:
        return area * STEFAN_BOLTZMANN * ((T[part] + KELVIN) ** 4 - (21.6 + KELVIN) ** 4)

    fanned = (rpm / 3000) ** 0.67
    out = (1.3 * (1 + 10 * fanned) + 0.5 * (1 + 7 * fanned)) * rise["turning parts"]
    out += 1.73 * 1.1 * rise["headstock"] ** 1.25 + glow("headstock", 1) + 12 * rise["motor"] + glow("motor", 0.35)
    out += 7.7 * rise["bed top"] + 6.3 * rise["bed bottom"] + 6.3 * rise["saddle"] + 1.5 * rise["motor foot"]
    out += 8 * rise["sump"]
    assert out == pytest.approx(sum(lathe_losses(rpm).values()), rel=1e-6)


# -- ball screw axis ------------------------------------------------------------------------------------------------
def test_ball_screw_axis_takes_up_force_times_way() -> None:
    """A mean of 12 m/min for 3 h is 2160 m; 2.6 W/(m/min) are 156 N."""
    result = run("ball_screw_axis", "axis_back_and_forth")
    way = 12 * 180
    for name, force in (("nut friction", 156), ("bearing friction", 96), ("guide friction", 60)):
        assert result.energy.by_mechanism[f"sources.{name}"] == pytest.approx(force * way, rel=1e-12)


def test_ball_screw_axis_shares_what_its_nut_rubs_between_nut_and_screw() -> None:
    carried = run("ball_screw_axis", "axis_back_and_forth").energy.carried
    to_nut, to_screw = -carried["links.nut on balls"], carried["links.balls on screw"]
    assert to_nut + to_screw == pytest.approx(156 * 12 * 180, rel=1e-9)
    assert to_nut > 0.3 * to_screw > 0


@pytest.mark.parametrize(("level", "moved"), [("encoder", -19.21 + 43.74), ("scale", 7.2)])
def test_ball_screw_axis_follows_what_its_control_measures(level: str, moved: float) -> None:
    """All 5 K warm, at 150 mm: 340 mm of screw between bearing and nut are 19.21 µm, 810 mm of bed between bearing and
    column 43.74 µm; the reading head is 180 mm of glass short of where the scale is held, 7.2 µm."""
    warm = Scenario.of(
        "warm", "10 s", {"feed": "0 m/min", "position": "150 mm", "ambient": "26.6 degC"}, start="26.6 degC"
    )
    assert simulate(machine("ball_screw_axis", level), warm).shown("tcp.x")[-1] == pytest.approx(moved, rel=1e-9)


# -- bench rigs -----------------------------------------------------------------------------------------------------
def test_two_blocks_follow_their_closed_solution() -> None:
    """Equal blocks: the sum of the rises has the time constant C/G, their difference C/(G + 2 G_joint)."""
    result = run("two_blocks", "constant_8000")
    C, G, joint, P, t = 2700 * 900 * 0.1 * 16e-4, 0.4, 3.0, 12.0, result.t
    both = P / G * (1 - np.exp(-G * t / C))
    apart = P / (G + 2 * joint) * (1 - np.exp(-(G + 2 * joint) * t / C))
    assert result.sensors["T_hot"] == pytest.approx(21.6 + (both + apart) / 2, abs=1e-9)
    assert result.sensors["T_cold"] == pytest.approx(21.6 + (both - apart) / 2, abs=1e-9)
    assert result.tcp["z"] == pytest.approx(2.34e-5 * 0.1 * both, abs=1e-14)


def test_two_heater_rig_settles_where_film_and_glow_balance_the_heaters() -> None:
    result = settled("two_heater_rig", Q1="60 %", Q2="40 %", ambient="21 degC")

    def left_over(T: np.ndarray) -> list[float]:
        def glow(a: float, b: float, area: float) -> float:
            return area * STEFAN_BOLTZMANN * ((a + KELVIN) ** 4 - (b + KELVIN) ** 4)

        out = [10 * 10e-4 * (x - 21) + glow(x, 21, 9e-4) for x in T]
        across = 10 * 2e-4 * (T[0] - T[1]) + glow(T[0], T[1], 1.8e-4)
        return [0.6 * 1 - out[0] - across, 0.4 * 0.75 - out[1] + across]

    T = fsolve(left_over, [50, 50], xtol=1e-12)
    assert [result.sensors["T1"][-1], result.sensors["T2"][-1]] == pytest.approx(list(T), abs=1e-5)


def test_three_blocks_settle_where_their_skins_lose_what_the_heater_gives() -> None:
    """Films, glow and feet at each cylinder's mean, 1 K from its ends; the last loses what comes through its pad."""
    result = settled("three_blocks", heater="10 W", ambient="23.6 degC")
    at = {part: values[-1] for part, values in result.parts.items()}
    lost = {
        i: 2.57 * area * (at[f"cylinder {i}"] - 23.6) ** 1.25
        + 0.2 * area * STEFAN_BOLTZMANN * ((at[f"cylinder {i}"] + KELVIN) ** 4 - (at["walls"] + KELVIN) ** 4)
        + foot * (at[f"cylinder {i}"] - at["support"])
        for i, area, foot in ((1, 330e-4, 0.1), (2, 220e-4, 0.07), (3, 110e-4, 0.05))
    }
    assert sum(lost.values()) == pytest.approx(10, rel=1e-4)
    assert 0.22 * (result.sensors["NTC10"][-1] - result.sensors["NTC11"][-1]) == pytest.approx(lost[3], rel=1e-2)


def test_heated_gantry_settles_between_its_bed_and_the_room() -> None:
    result = settled("heated_gantry", bed="105 degC", ambient="22 degC")
    bed_glow = (105 + KELVIN) ** 4

    def left_over(T: np.ndarray) -> list[float]:
        frame, chamber, panels = T
        warming = 1.76 * 0.245 * (105 - chamber) ** 1.25
        glow = [STEFAN_BOLTZMANN * area * (bed_glow - (x + KELVIN) ** 4) for area, x in ((0.02, frame), (0.18, panels))]
        return [
            glow[0] + 1.5 * (chamber - frame) + 1.4 * (panels - frame) - 2.2 * (frame - 22),
            warming - 6.3 * (chamber - panels) - 1.5 * (chamber - frame),
            glow[1] + 6.3 * (chamber - panels) - 1.4 * (panels - frame) - 11 * (panels - 22),
        ]

    frame, chamber, _ = fsolve(left_over, [35, 45, 35], xtol=1e-12)
    assert result.sensors["T_frame"][-1] == pytest.approx(frame, abs=1e-5)
    assert result.sensors["T_chamber"][-1] == pytest.approx(chamber, abs=1e-5)
    assert result.sensors["dz"][-1] == pytest.approx(-23.4e-6 * 0.53 * (frame - 22), abs=1e-10)


def test_toaster_oven_settles_where_its_walls_and_leaks_lose_what_its_elements_take() -> None:
    result = settled("toaster_oven", level="50 %", ambient="26 degC")

    def left_over(T: np.ndarray) -> list[float]:
        elements, air, walls = T
        inside = 0.05 * STEFAN_BOLTZMANN * ((elements + KELVIN) ** 4 - (walls + KELVIN) ** 4)
        outside = 0.15 * STEFAN_BOLTZMANN * ((walls + KELVIN) ** 4 - (26 + KELVIN) ** 4) + 0.75 * (walls - 26) ** 1.25
        film, wall, leaks = 0.9 * (elements - air), 3.5 * (walls - air), 20 * 12e-4 * (air - 26) ** 1.5
        return [650 - film - inside, film + wall - leaks, inside - wall - outside]

    T = fsolve(left_over, [450, 250, 200], xtol=1e-12)
    assert [result.parts[name][-1] for name in ("elements", "air", "walls")] == pytest.approx(list(T), abs=1e-4)
    assert 150 < result.sensors["T_air"][-1] < 300


def test_heated_building_settles_on_40_kW() -> None:
    """Windows 0.8 kW/K beside walls of 10 and 1 kW/K in a row; 5 kW of people; the pipe between radiators and cold."""
    cold = Scenario.of("cold", "3000 h", {"P_heating": "40 kW", "outdoor": "4 degC"}, output="10 h")
    result = simulate(machine("heated_building"), cold)
    lost, films, pipe = 0.8 + 10 / 11, 1.3, 0.02 / 1.02
    radiators, room = np.linalg.solve([[films + pipe, -films], [-films, films + lost]], [40, 5]) + 4
    assert result.sensors["T_indoor"][-1] == pytest.approx(room, abs=1e-6)
    assert result.sensors["T_return"][-1] == pytest.approx(4 + (radiators - 4) / 1.02, abs=1e-6)


def test_lathe_warm_up_asks_for_its_unknown_lengths_first() -> None:
    with pytest.raises(Refused) as refused:
        run("lathe_warm_up", "bearing_warms")
    told = [refusal.wrong for refusal in refused.value.refusals]
    assert told == [f"tcp.x.{part} grows: length is unknown" for part in ("headstock", "bed")]


def test_lathe_warm_up_follows_its_front_bearing() -> None:
    """Settled, front bearing at 30, air at 24 °C: four parts between them and a floor as warm as the bed; the gauge
    sees 0.3 m of headstock less 0.2 m of bed."""
    lengths = {"tcp.x.headstock grows.length": "300 mm", "tcp.x.bed grows.length": "200 mm"}
    path = ROOT / "machines" / "lathe_warm_up.yaml"
    lathe = Machine.load(path, sets=[f"{key}={value}" for key, value in lengths.items()])
    inputs = {"front_bearing": "30 degC", "ambient": "24 degC"}
    result = simulate(lathe, Scenario.of("long", "1000 h", inputs, output="1 h", start="24 degC"))
    G = np.array([[59, -15, 0, 0], [-15, 85, -15, -15], [0, -15, 25, 0], [0, -15, 0, 25]])
    rise = np.linalg.solve(G, [40 * 6 + 100, 15 * 6, 40, 60])
    parts = ("rear bearing", "bed", "coolant wall", "transformer bed")
    assert [result.parts[part][-1] - 24 for part in parts] == pytest.approx(list(rise), rel=1e-6)
    grown = 1.1e-5 * (0.3 * 10 - 0.2 * (4 + rise[1]))
    assert result.tcp["x"][-1] == pytest.approx(grown, rel=1e-6)
    assert result.sensors["dx"][-1] == pytest.approx(grown - result.tcp["x"][0], rel=1e-6)


# -- turning centre -------------------------------------------------------------------------------------------------
def between(ends: dict[tuple[int, int], float], skins: list[float]) -> np.ndarray:
    """Conductances [W/K] between parts, and of each to the air, as a matrix."""
    G = np.diag(np.array(skins, dtype=float))
    for (a, b), conductance in ends.items():
        G[[a, b], [a, b]] += conductance
        G[[a, b], [b, a]] -= conductance
    return G


def test_cnc_lathe_plain_settles_where_its_conductances_say() -> None:
    """2000 rpm, both axes at 5 m/min, air at the reference; z: the spindle pushes towards the tool, the bed away."""
    turning, feeding = ("spindle motor", "spindle", "headstock"), ("x feed motor", "z feed motor", "feed screw")
    parts = (*turning, *feeding, "saddle", "turret", "bed")
    joints = {(0, 2): 8, (1, 2): 15, (2, 8): 20, (5, 6): 3, (3, 6): 2, (4, 8): 2, (7, 6): 15, (6, 8): 30}
    friction, guides = 2000 * RPM * 1.5, 5 * 30
    heat = [150, friction, 0, 20, 20, 5 * 6, 0.6 * guides, 0.2 * guides, 0.2 * guides]
    rise = np.linalg.solve(between(joints, [6, 3, 8, 2, 2, 2, 8, 12, 25]), heat)
    result = settled("cnc_lathe_plain", speed="2000 rpm", feed="5 m/min", ambient="20 degC")
    assert [result.parts[part][-1] - 20 for part in parts] == pytest.approx(list(rise), rel=1e-9)
    spindle, head, turret, bed = rise[[1, 2, 7, 8]]
    z = 1.1e-5 * (0.8 * bed - 0.3 * spindle - 0.2 * head - 0.2 * turret)
    x = 1.1e-5 * (0.2 * head + 0.5 * bed - 0.1 * spindle - 0.4 * turret)
    assert [result.tcp[axis][-1] for axis in "xz"] == pytest.approx([x, z], rel=1e-8)


# -- scenarios ------------------------------------------------------------------------------------------------------
def test_day_of_work_warms_the_shop_by_3_K_in_8_hours_with_pauses() -> None:
    day = scenario("day_of_work")
    speed, ambient = (day.schedule.signals[name].at(day.schedule.t) for name in ("speed", "ambient"))
    assert day.duration == 8 * 3600 and ambient[-1] - ambient[0] == pytest.approx(3)
    stops = sum(a > 0 and b == 0 for a, b in pairwise(speed))
    assert stops == 5 and speed[-1] == 0


def test_warm_up_and_stop_stops_after_two_hours() -> None:
    result = run("gantry_spindle", "warm_up_and_stop")
    assert result.t[np.argmax(result.tcp["z"])] == 7200
    assert [len(scenario(f"constant_{rpm}").schedule.t) for rpm in (6000, 8000)] == [1441, 1441]


def air_of_shop_day(t: np.ndarray) -> np.ndarray:
    """[°C] at t [h], as the head of the file says."""
    heating = np.interp(t, [6, 7, 17, 20], [0, 1.5, 1.5, 0])
    return np.asarray(21.6 + 3 * np.sin(2 * pi * (t - 10) / 24) + heating)


def test_shop_day_is_a_sine_and_a_heating() -> None:
    """Straight lines of an hour: at most 3 K (2π/24)²/8 = 0.026 K off, and 0.005 K of rounding."""
    day = scenario("shop_day").schedule
    assert day.signals["ambient"].at(day.t) == pytest.approx(air_of_shop_day(day.t / 3600), abs=0.032)
    assert all(day.signals[name].at(day.t).max() == 0 for name in ("speed", "feed"))


def test_a_saddle_alone_follows_shop_day_with_the_gain_and_lag_of_first_order() -> None:
    """τ = ρ c S L/G = 12 000 s, ωτ = 0.873: gain 1/√(1 + (ωτ)²) = 0.753, lag atan(ωτ)/ω = 2.74 h. The first harmonic of
    τ dT/dt = A − T over one day is (1 + iωτ) T₁ = A₁ − 2 τ (T(24 h) − T(0))/24 h."""
    alone = machine("belt_lathe").patched({"links": {"guides": None}})
    result = simulate(alone, scenario("shop_day"))
    t, T = result.t / 3600, result.parts["saddle"]

    def harmonic(values: np.ndarray) -> complex:
        return complex(trapezoid(values * np.exp(-2j * pi * t / 24), t) / 12)

    tau = 7200 * 500 * 500e-4 * 0.42 / 6.3 / 3600
    driven = harmonic(air_of_shop_day(t)) - 2 * tau * (T[-1] - T[0]) / 24
    followed = harmonic(T) / driven
    assert abs(followed) == pytest.approx(0.753, rel=0.01)
    assert -np.angle(followed) * 24 / (2 * pi) == pytest.approx(2.74, abs=0.05)


# -- concealed cases ------------------------------------------------------------------------------------------------
FOLDERS = sorted(path.parent for path in CASES.glob("*/machine.yaml"))


@pytest.mark.skipif(not FOLDERS, reason="the concealed cases in ../shared/cases are not here")
@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.name)
def test_a_case_loads_and_compares_along_its_recordings(folder: Path) -> None:
    recordings = [Recording.load(path) for path in sorted(folder.glob("*.csv"))]
    comparison = compare(Machine.load(folder / "machine.yaml"), recordings)
    assert len(comparison.recordings) == len(recordings) > 0
    for residual in comparison.recordings:
        assert_closed(residual.trajectory)
        assert set(residual.channels) == set(comparison.machine.sensors)
        for channel in residual.channels.values():
            assert channel.n == len(residual.recording.t) and np.isfinite(channel.residual).all()
            assert 0.5 < channel.rmse_in_noise < 1000


def test_cnc_lathe_settles_where_its_conductances_say() -> None:
    """2000 rpm, both axes at 5 m/min: what turns stirs the air about three parts, and the air is 6 K above the room."""
    parts = ("shaft", "spindle", "headstock", "base", "bed", "guides", "saddle", "turret", "bed rear", "chuck")
    joints = {(0, 1): 100, (1, 2): 200, (2, 4): 15, (2, 3): 25, (3, 4): 50, (8, 4): 10, (8, 6): 3, (5, 4): 20,
              (6, 5): 10, (6, 4): 4, (7, 6): 20, (9, 0): 20}  # fmt: skip
    skins = [0, 10, 3, 20 * 1.7, 80, 6 * 1.7, 5 * 1.7, 30, 10, 5 * 1.7]
    heat = np.array([400, 0, 0, 0, 5 * 40, 50, 5 * 16, 5 * 10, 0, 0])
    air = 6 + heat.sum() / 1000
    rise = air + np.linalg.solve(between(joints, skins), heat)
    result = settled("cnc_lathe", speed="2000 rpm", feed="5 m/min", ambient="20 degC")
    assert [result.parts[part][-1] - 20 for part in parts] == pytest.approx(list(rise), rel=1e-9)
    x = 1e-6 * rise @ [0, 0, -10, 50, -20, 0, 20, 0, -30, -5]
    z = 1e-6 * rise @ [0, 0, 0, 0, 25, -5, 0, 6, -20, -5]
    assert [result.tcp[axis][-1] for axis in "xz"] == pytest.approx([x, z], rel=1e-8)
