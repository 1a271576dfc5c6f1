"""`while:` and `input:`: entries that are there only while an input runs, and entries that read another input."""

from __future__ import annotations

from typing import Any

import build as small
import numpy as np
import pytest
from catalogue import FLOWS, TYPES, Draw, arguments, entry_in, evaluated, machine, names, patch_of, surroundings

from network import Machine
from network.catalogue.declaration.declare import Effect
from network.catalogue.declaration.fields import InputField
from network.catalogue.mechanisms.mechanism import Mechanism
from network.catalogue.suspects.base import Suspect
from network.engine.assembly import build
from network.engine.balance import heat_balance
from network.engine.response.batch import serves
from network.engine.simulation import simulate
from network.platform.refusal import Refused
from network.recordings.columns import Column
from network.recordings.inputs import Schedule, Start, constant, hold, linear
from network.recordings.recording import Recording

C, G, Q = 5000.0, 8.0, 120.0
HEATER = {"kind": "heat_source", "into": {"tank": 1}, "power": f"{Q} W"}
HOSE = {"kind": "convection", "between": ["tank", "air"], "conductance": f"{G} W/K", "while": "pump"}
T_TANK = {"measures": "tank", "noise": "0.05 K"}
BAR = {"material": "steel", "length": "300 mm", "area": "20 cm^2", "lumps": 4}


def tank(sources: Any = None, **links: Any) -> Machine:
    return small.machine(
        {"tank": {"heat_capacity": f"{C} J/K"}, "air": {"temperature": "20 degC"}}, links={"hose": HOSE, **links},
        sources={"heater": HEATER, **(sources or {})}, sensors={"T": T_TANK},
    )  # fmt: skip


def tank_and_bar() -> Machine:
    """A link, a link of a massless seat, a stream, constant heat, heat that reads a temperature and one that goes with
    a square, each there while its own input runs; a single window besides."""
    joint = {"kind": "conduction", "between": ["tank", "seat"], "conductance": "9 W/K"}
    coil = {"kind": "heat_source", "into": {"bar@0.9": 1}, "power": "30 W", "with": "current", "at": "3 A"}
    winding = {"kind": "copper_temperature", "into": {"tank": 1}, "power": "40 W", "slope": "0.0039 1/K", "input": "n2"}
    window = {"kind": "timed_source", "into": {"tank": 1}, "power": "55 W", "begins": "17 min", "ends": "31.5 min"}
    return small.machine(
        {
            "tank": {"heat_capacity": f"{C} J/K"}, "bar": BAR, "seat": {},
            "air": {"temperature": "20 degC"}, "supply": {"temperature": "15 degC"},
        },
        links={
            "hose": HOSE,
            "skin": {"kind": "convection", "between": ["bar", "air"], "conductance": "1 W/K", "while": "door"},
            "joint": joint, "foot": {**joint, "between": ["seat", "bar@0..0.5"], "while": "valve"},
            "floor": {**joint, "between": ["seat", "air"], "conductance": "0.5 W/K"},
            "stream": {"kind": "advection", "through": ["supply", "tank"], "capacity_flow": "6 W/K", "while": "valve"},
        },
        sources={
            "coil": {**coil, "exponent": 2, "while": "valve"}, "winding": {**winding, "while": "pump"},
            "heater": HEATER, "window": window,
            "lamp": {"kind": "heat_source", "into": {"bar": 1}, "power": "15 W", "while": "door"},
        },
        sensors={"T": T_TANK, "T_bar": {"measures": "bar@0.9", "noise": "0.05 K"}},
    )  # fmt: skip


def switched(every: float = 60.0) -> Schedule:
    """Switches that fall on no instant of output, a current that goes through zero, a speed that stands at times."""
    t = np.arange(0.0, 5401.0, every)
    held = {
        "pump": [(0, 1), (713, 0), (1900, 2), (4001, 0)], "door": [(0, 0), (401, 1), (2222, 0)],
        "valve": [(0, 1), (1234, 0), (2345, 1)],
    }  # fmt: skip
    signals = [hold(name, "1", *np.array(steps, float).T.copy()) for name, steps in held.items()]
    n2 = hold("n2", "rpm", np.array([0.0, 900.0, 3000.0]), np.array([50.0, 0.0, -80.0]))
    current = hold("current", "A", np.array([0.0, 1500.0, 3300.0]), np.array([3.0, -2.0, 4.5]))
    return small.schedule(t, *signals, n2, current, start=Start(others=20.0))


# -- while ----------------------------------------------------------------------------------------------------------
def test_a_link_is_there_only_while_its_input_is_not_zero() -> None:
    """On: T∞ = 20 + Q/G, decay G/C; off: T rises by Q/C a second."""
    t = np.arange(0.0, 3601.0, 10.0)
    pump = hold("pump", "1", np.array([0.0, 1200.0, 2400.0]), np.array([1.0, 0.0, -3.0]))
    made = simulate(tank(), small.schedule(t, pump, start=Start(others=20.0)))
    on = Q / G * (1 - np.exp(-G / C * 1200))
    off = on + Q / C * 1200
    pieces = [Q / G * (1 - np.exp(-G / C * t)), on + Q / C * (t - 1200)]
    rise = np.select([t <= 1200, t <= 2400], pieces, Q / G + (off - Q / G) * np.exp(-G / C * (t - 2400)))
    assert made.method == "modal"
    np.testing.assert_allclose(made.shown("T") - 20, rise, rtol=1e-11, atol=1e-10)


def test_exact_paths_and_a_reference_agree() -> None:
    here = tank_and_bar()
    exact = simulate(here, switched())
    assert exact.method == "modal" and abs(exact.energy.closure) < 1e-9
    for method, rtol in (("expm", None), ("solve_ivp:RK45", 1e-11)):
        other = simulate(here, switched(), method=method, rtol=rtol)
        for name in ("T", "T_bar"):
            np.testing.assert_allclose(other.shown(name), exact.shown(name), rtol=1e-9)


def test_a_network_that_is_bent_switches_too() -> None:
    glow = {"kind": "radiation", "between": ["tank", "air"], "emissivity_area": "0.6 m^2", "while": "door"}
    here = tank_and_bar().patched({"links": {"glow": glow}})
    fast = simulate(here, switched())
    slow = simulate(here, switched(), method="solve_ivp:Radau", rtol=1e-8)
    assert fast.method == "rosenbrock"
    np.testing.assert_allclose(fast.shown("T"), slow.shown("T"), atol=2e-5)
    assert np.abs(fast.shown("T") - simulate(tank_and_bar(), switched()).shown("T")).max() > 0.1


def test_a_relay_gives_its_heat_only_while_its_input_runs() -> None:
    boiler = {
        "kind": "thermostat_heating", "into": {"tank": 1}, "watches": "tank", "set": "40 degC", "hysteresis": "1 K",
        "power": "600 W", "delay": "20 s", "while": "valve",
    }  # fmt: skip
    here = tank({"boiler": boiler})
    assert not serves(build(here))
    exact = simulate(here, switched(20.0))
    slow = simulate(here, switched(20.0), method="solve_ivp:RK45", rtol=1e-11)
    assert exact.method == "switched" and len(exact.switches) == len(slow.switches) > 4
    np.testing.assert_allclose(exact.shown("T"), slow.shown("T"), atol=1e-6)


def test_the_integral_of_a_chiller_waits_while_it_is_off() -> None:
    chiller = {"kind": "pi_cooling", "into": {"tank": 1}, "watches": "tank", "set": "22 degC", "gain": "10 W/K",
               "reset_time": "400 s", "while": "valve"}  # fmt: skip
    here = tank({"chiller": chiller})
    exact = simulate(here, switched())
    slow = simulate(here, switched(), method="solve_ivp:RK45", rtol=1e-12)
    z = exact.states["sources.chiller.reset"]
    assert np.ptp(z[(exact.t > 1234) & (exact.t < 2345)]) < 1e-9 < np.ptp(z)
    np.testing.assert_allclose(exact.shown("T"), slow.shown("T"), rtol=1e-9)


def test_an_input_that_ramps_from_zero_switches_at_once() -> None:
    """As a source that is on `while` a ramped input is not zero: Q while it climbs, too."""
    lamp = {"kind": "heat_source", "into": {"tank": 1}, "power": "50 W", "while": "level"}
    here = tank({"lamp": lamp})
    level = linear("level", "W", np.array([0.0, 600.0, 1200.0, 1800.0, 2400.0]), np.array([0.0, 0.0, 5.0, 0.0, 0.0]))
    t, pump = np.arange(0.0, 3001.0, 20.0), constant("pump", "1", 0.0)
    made = simulate(here, small.schedule(t, level, pump, start=Start(others=20.0)))
    rise = Q / C * t + 50 / C * np.clip(t - 600, 0, 1200)
    np.testing.assert_allclose(made.shown("T") - 20, rise, atol=1e-9)


@pytest.mark.parametrize("cls", FLOWS, ids=names)
def test_every_flow_can_be_switched_by_an_input(cls: type[Mechanism]) -> None:
    body = next(b for seed in range(99) if is_read(cls, b := Draw(cls, seed).body()))
    bare, gated = (machine().patched(patch_of(cls, b)) for b in (body, {**body, "while": "pump"}))
    assert entry_in(cls, gated).needs() == {**entry_in(cls, bare).needs(), "pump": ""}
    assert "while pump is not zero" in entry_in(cls, gated).said()
    assert entry_in(cls, gated).to_plain()["while"] == "pump"
    without, u = build(machine()), surroundings(5)
    T = np.random.default_rng(3).uniform(20, 60, build(bare).size)
    seen = 0
    for minute in (1.0, 12.0, 29.0, 41.0, 200.0):
        at = {**u, "time": np.array(60 * minute)}
        there, off, on = (heat_into(m, T, {**at, "pump": np.array(p)}) for m, p in ((bare, 1), (gated, 0), (gated, 9)))
        np.testing.assert_array_equal(there, on)
        np.testing.assert_allclose(off[: without.size], heat_into(machine(), T[: without.size], at), rtol=1e-12)
        assert not off[without.size :].any()
        seen += not np.array_equal(on, off)
    assert seen


def heat_into(of: Machine, T: np.ndarray, u: Any) -> np.ndarray:
    """Heat into the lumps and states, relays on."""
    network = build(of)
    return heat_balance(network, T, u, np.ones(sum(group.into.shape[1] for group in network.relays))).into


def is_read(cls: type[Effect], body: Any) -> bool:
    """Whether the machine of the tests takes it."""
    try:
        machine().patched(patch_of(cls, body))
    except Refused:
        return False
    return True


def test_a_column_that_switches_is_held_whatever_its_unit() -> None:
    t = np.arange(0.0, 601.0, 60.0)
    power = Column("power", "W", np.where(t < 200, 0.0, 900.0 + 1e-6 * t))  # it creeps, so that it runs straight
    recording = Recording("run", "run.csv", t, {"power": power})
    assert not recording.schedule(["power"]).signals["power"].is_held
    here = tank().patched({"links": {"hose": {**HOSE, "while": "power"}}})
    assert here.switches == {"power"} and here.inputs == {"power": ""}
    assert recording.schedule(here.inputs, here.switches).signals["power"].is_held
    made = simulate(here, recording, start=Start(others=20.0))
    np.testing.assert_allclose(made.shown("T")[t <= 240] - 20, Q / C * t[t <= 240], rtol=1e-9)


def test_what_takes_a_place_keeps_its_switch_and_its_input() -> None:
    friction = {"kind": "bearing_friction", "into": {"shaft": 1}, "torque": "1 N m", "while": "pump", "input": "n2"}
    here = machine().patched({"sources": {"friction": friction}})
    for kind in ("viscous_friction", "preload_friction"):
        cls = next(cls for cls in TYPES if cls.kind == kind)
        for patch in cls.proposes(here):
            assert (patch["sources"]["friction"]["while"], patch["sources"]["friction"]["input"]) == ("pump", "n2")


# -- input ----------------------------------------------------------------------------------------------------------
def reads_by_default(cls: type[Effect]) -> InputField | None:
    fields = (f for f in cls.fields.values() if isinstance(f, InputField) and f.default is not None)
    return next(fields, None)


READERS = [cls for cls in TYPES if not issubclass(cls, Suspect) and reads_by_default(cls)]


def test_speed_feed_cutting_power_and_current_are_read_by_default() -> None:
    assert {reads_by_default(cls).default for cls in READERS} == {"speed", "feed", "cutting_power", "current"}
    assert len(READERS) > 10


@pytest.mark.parametrize("cls", READERS, ids=names)
def test_another_input_takes_the_place_of_the_default(cls: type[Effect]) -> None:
    field = reads_by_default(cls)
    assert field is not None and field.key == "input"
    body = next(b for seed in range(99) if is_read(cls, b := Draw(cls, seed).body()))
    usual, other = (entry_in(cls, machine().patched(patch_of(cls, b))) for b in (body, {**body, "input": "other"}))
    assert field.default in usual.needs() and field.default not in other.needs()
    assert other.needs()["other"] == field.unit
    u, x = surroundings(4), arguments(usual, 4)
    u = {**u, field.default: np.array(1000.0)}  # rad/s, fast enough to stir a gap
    moved = {**u, "other": u[field.default], field.default: np.array(0.0)}
    assert float(evaluated(usual, u, *x)) == float(evaluated(other, moved, *x)) != 0
    assert float(evaluated(other, {**moved, "other": np.array(0.0)}, *x)) != float(evaluated(usual, u, *x))


def test_heat_while_something_else_turns() -> None:
    entry = {"kind": "heat_source", "into": {"tank": 1}, "power": "20 W", "with": "running", "input": "n2"}
    here = tank({"rub": entry})
    assert here.inputs == {"n2": "rpm", "pump": ""}
    assert [float(here.sources["rub"].heat({"n2": np.array(n)})) for n in (0.0, -3.0)] == [0.0, 20.0]


def test_heat_goes_with_a_power_of_an_input() -> None:
    """Joule: 30 W at 3 A are 30 (I/3)² at I, either way; without an exponent the sign counts."""
    coil = {"kind": "heat_source", "into": {"tank": 1}, "power": "30 W", "with": "current", "at": "3 A"}
    square, straight = (tank({"coil": c}).sources["coil"] for c in ({**coil, "exponent": 2}, coil))
    heats = [[float(s.heat({"current": np.array(i)})) for i in (-6.0, 0.0, 1.5)] for s in (square, straight)]
    assert heats[0] == pytest.approx([120, 0, 7.5]) and heats[1] == pytest.approx([-60, 0, 15])


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ({"with": "always", "exponent": 2}, "has 'exponent' with `with: always`; drop `exponent`"),
        ({"with": "running", "exponent": 2}, "has 'exponent' with `with: running`"),
        ({"with": "current", "at": "3 A", "input": "n2"}, "has 'input' with `with: current`; name the input in `with`"),
        ({"with": "always", "input": "n2"}, "has 'input' with `with: always`"),
        ({"with": "current", "at": "3 A", "while": "time"}, "reads an input named 'time'"),
    ],
)
def test_what_says_nothing_is_refused(body: dict[str, Any], told: str) -> None:
    with pytest.raises(Refused) as refused:
        tank({"it": {"kind": "heat_source", "into": {"tank": 1}, "power": "1 W", **body}})
    assert told in str(refused.value)


def test_a_switch_may_be_an_input_that_others_read_in_a_unit() -> None:
    here = machine().patched({"links": {"it": {"kind": "convection", "between": ["shaft", "air"],
                                               "conductance": "2 W/K", "while": "speed"}}})  # fmt: skip
    assert here.inputs["speed"] == "rpm"
    with pytest.raises(Refused, match="the machine needs the input `pump`, which is not there; add `pump: …` to its"):
        simulate(tank(), small.schedule([0.0, 60.0]))


class Noting(dict[str, Any]):
    """Inputs of an instant, which note the names that are asked for."""

    def __init__(self) -> None:
        super().__init__()
        self.asked: set[str] = set()

    def __missing__(self, name: str) -> Any:
        self.asked.add(name)
        return np.array(0.07)


@pytest.mark.parametrize("cls", [c for c in TYPES if not issubclass(c, Suspect)], ids=names)
def test_no_kind_reads_an_input_that_its_entry_cannot_name(cls: type[Effect]) -> None:
    default = reads_by_default(cls)
    body = next(b for seed in range(99) if is_read(cls, b := Draw(cls, seed).body()))
    own = {**body, default.key: "mine"} if default is not None else body
    entry = entry_in(cls, machine().patched(patch_of(cls, own)))
    u = Noting()
    evaluated(entry, u, *arguments(entry, 4))
    assert u.asked - {"time"} <= {str(value) for value in own.values()}
