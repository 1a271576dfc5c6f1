"""Where the movement comes from: shares against runs without a source, sums, laws that bend, what is told."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from build import machine
from fit_networks import machines
from test_figures import check_legible

from network import Machine, Recording, Refused, Scenario, simulate, superpose
from network.catalogue.declaration.declare import Array
from network.catalogue.sensors.sensor import Sensor
from network.cli import main
from network.engine.superposition.frozen_network import FrozenRun
from network.engine.superposition.superpose import ALONG, AT_ONCE, EXACTLY, freeze
from network.engine.trajectory import Trajectory
from network.report.figures.sources_figure import sources_figure

ROOT = Path(__file__).parents[1]
GANTRY, WARM_UP = ROOT / "machines" / "gantry_spindle.yaml", ROOT / "scenarios" / "warm_up_and_stop.yaml"
DAY = {"speed": [{"for": "40 min", "at": "8000 rpm"}, {"at": "0 rpm"}], "air": "23 degC", "ambient": "23 degC"}


def day(start: Any = "21 degC") -> Scenario:
    return Scenario.of("a run", "80 min", DAY, output="20 s", start=start)


def test_a_source_moved_what_a_run_without_it_lacks() -> None:
    """Exact superposition, against the difference of two simulations."""
    schedule = Scenario.load(WARM_UP)
    whole = simulate(Machine.load(GANTRY), schedule)
    shares = superpose(whole)
    assert shares.how == EXACTLY
    for source in whole.machine.sources:
        without = simulate(Machine.load(GANTRY, sets=[f"sources.{source}=null"]), schedule)
        for axis in whole.tcp:
            own = shares.sum_by(axis, "cause")[(source,)]
            np.testing.assert_allclose(own, whole.tcp[axis] - without.tcp[axis], atol=1e-15)


@pytest.mark.parametrize("name", machines())
def test_shares_add_up_to_the_movement(name: str) -> None:
    """Bars, junctions, streams with delay, fans, relays to rounding; radiation and viscosity to less than is told."""
    run = simulate(machines()[name], day({"motor": "25 degC", "others": "21 degC"}))
    shares = superpose(run)
    assert shares.how == (ALONG if name == "bent" else EXACTLY)
    total = sum(share.values for share in shares.shares)
    allowed = 5e-4 * np.abs(run.tcp["z"]).max() if name == "bent" else 1e-14
    np.testing.assert_allclose(total, run.tcp["z"], atol=allowed)
    np.testing.assert_allclose(total + shares.remainder["z"], run.tcp["z"], atol=1e-18)
    assert {share.cause for share in shares.shares} >= {"start", "air", *run.machine.sources}


def test_a_large_machine_is_told_without_zeros_and_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    run = simulate(machines()["bent"], day({"motor": "25 degC", "others": "21 degC"}))
    whole = superpose(run)
    monkeypatch.setattr("network.engine.superposition.frozen_network.FULL", 1)
    thin = superpose(run)
    assert whole.how == thin.how == ALONG
    for one, other in zip(whole.shares, thin.shares, strict=True):
        np.testing.assert_allclose(other.values, one.values, atol=1e-15)


def test_the_larger_a_machine_the_fewer_steps_it_is_told_in(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lumps times steps are bounded, so that it takes no longer; 200 steps are left to the largest."""
    counts = list[int]()

    def counted(run: Trajectory, edges: Array) -> FrozenRun:
        counts.append(len(edges) - 1)
        return freeze(run, edges)

    run = simulate(machines()["bent"], day())
    assert len(run.t) == 241
    monkeypatch.setattr("network.engine.superposition.superpose.freeze", counted)
    monkeypatch.setattr("network.engine.superposition.superpose.MOST_ANSWERS", 210 * run.network.size)
    superpose(run)
    monkeypatch.setattr("network.engine.superposition.superpose.MOST_ANSWERS", 1)
    superpose(run)
    superpose(run)
    assert len(counts) == 3 and all(100 <= count <= 210 for count in counts)
    assert counts[0] >= counts[1] == counts[2]


GROWS = {"kind": "stretching", "of": "plate", "length": "400 mm", "expansion": "1.1e-5 1/K", "direction": 1}


def odd(**sections: Any) -> Machine:
    """A motor on a plate in a room; the sections are laid over it."""
    given: dict[str, Any] = {
        "links": {
            "foot": {"kind": "conduction", "between": ["motor", "plate"], "conductance": "9 W/K"},
            "skin": {"kind": "convection", "between": ["plate", "air"], "conductance": "4 W/K"},
        },
        "sources": {"rub": {"kind": "heat_source", "into": {"motor": 1}, "power": "90 W", "with": "running"}},
        "tcp": {"z": {"grows": GROWS}},
    }
    nodes = {"motor": {"heat_capacity": "6 kJ/K"}, "plate": {"heat_capacity": "20 kJ/K"}, "air": {"temperature": "air"}}
    merged = {key: {**given.get(key, {}), **sections.get(key, {})} for key in given}
    return machine({**nodes, **sections.get("nodes", {})}, **merged)


WAX = {"heat_capacity": "5 kJ/K", "melts": {"at": "26 degC", "over": "2 K", "latent_heat": "60 kJ"}}
CHILLER = {"kind": "pi_cooling", "into": {"plate": 1}, "watches": "plate", "set": "22 degC", "gain": "30 W/K",
           "reset_time": "10 min"}  # fmt: skip
COOLER = {"kind": "thermostat_cooling", "into": {"plate": 1}, "watches": "plate", "set": "24 degC",
          "hysteresis": "0.5 K", "power": "200 W"}  # fmt: skip
GLOW = {"kind": "radiation", "between": ["plate", "air"], "emissivity_area": "0.5 m^2"}
BEND = {"kind": "bending", "between": ["motor", "plate"], "distance": "200 mm", "length": "2 m", "direction": 1,
        "expansion": "1.1e-5 1/K"}  # fmt: skip
SPIN = {"kind": "centrifugal_growth", "displacement": "9 um", "reference_speed": "8000 rpm", "direction": -1}
ODD = {
    "melts": odd(nodes={"motor": WAX}), "chiller": odd(sources={"chiller": CHILLER}),
    "radiates and switches": odd(links={"glow": GLOW}, sources={"cooler": COOLER}),
    "bends": odd(tcp={"z": {"grows": GROWS, "bends": BEND}}), "spins": odd(tcp={"z": {"grows": GROWS, "spins": SPIN}}),
}  # fmt: skip


@pytest.mark.parametrize("name", ODD)
def test_odd_machines_are_told_with_what_is_left(name: str) -> None:
    run = simulate(ODD[name], day())
    shares = superpose(run)
    assert shares.is_told_whole
    assert shares.how == (EXACTLY if name in ("bends", "spins") else ALONG)
    if name == "spins":
        at_once = shares.sum_by("z", "kind", "cause")["centrifugal_growth", AT_ONCE]
        np.testing.assert_allclose(at_once[:100], -9e-6, rtol=1e-12)
        assert not at_once[-100:].any()


def test_two_heats_into_one_part_share_as_their_watts_whatever_its_losses_do() -> None:
    """One part that radiates: both rises obey the same balance, so their ratio is that of the powers at all times."""
    two = {name: {"kind": "heat_source", "into": {"plate": 1}, "power": f"{watts} W"}
           for name, watts in (("weak", 30), ("strong", 120))}  # fmt: skip
    links = {"glow": GLOW, "skin": None, "foot": None}
    alone = machine({"plate": {"heat_capacity": "20 kJ/K"}, "air": {"temperature": "air"}},
                    links={name: link for name, link in links.items() if link}, sources=two,
                    tcp={"z": {"grows": GROWS}})  # fmt: skip
    sums = superpose(simulate(alone, day())).sum_by("z", "cause")
    np.testing.assert_allclose(sums["strong",][1:] / sums["weak",][1:], 4.0, rtol=1e-9)


def test_a_machine_in_a_warm_room_is_moved_by_neither_room_nor_start() -> None:
    """Warm all through: 3 K over the reference is displaced at the start, and nothing of it is movement."""
    rest = Scenario.of("rest", "1 h", {**DAY, "speed": "0 rpm"}, start="23 degC")
    run = simulate(odd(), rest)
    sums = superpose(run).sum_by("z", "cause")
    np.testing.assert_allclose(sums["start",], 3 * 400e-3 * 1.1e-5, rtol=1e-12)
    np.testing.assert_allclose([sums["air",], sums["rub",]], 0.0, atol=1e-15)


def test_pieces_of_a_recording_are_told_one_by_one(tmp_path: Path) -> None:
    """A gap parts it: the shares run on the clock of the file, begun anew."""
    times = np.concatenate([np.arange(0, 3000, 30), np.arange(20000, 23000, 30)])
    rows = [f"{t},{8000 if t < 20000 else 3000},{23 if t < 20000 else 27}" for t in times]
    (tmp_path / "r.csv").write_text("time [s],speed [rpm],air [degC]\n" + "\n".join(rows))
    recording = Recording.load(tmp_path / "r.csv")
    assert recording.cuts
    run = simulate(odd(), recording)
    shares = superpose(run)
    np.testing.assert_allclose(sum(s.values for s in shares.shares), run.tcp["z"], atol=1e-14)


def test_the_command_tells_writes_and_draws_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The words add up to what they say; the columns of parts.csv to the axis."""
    main(["simulate", str(GANTRY), str(WARM_UP), "-o", str(tmp_path)])
    sentence = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("Of ") and " z " in line)
    assert sentence in (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
    whole, *parts = (float(n.replace("−", "-")) for n in re.findall(r"[+−][\d.]+(?= µm| from)", sentence))
    assert whole == pytest.approx(sum(parts), abs=0.11) and "motor loss" in sentence
    told = json.loads((tmp_path / "summary.json").read_text())["from"]["z"]
    assert told["sentence"] == sentence and told["remainder"] < 1e-6
    assert sum(told["by_part"].values()) == pytest.approx(told["moved"]) == pytest.approx(whole, abs=0.05)
    columns = Recording.load(tmp_path / "parts.csv").columns
    z = simulate(Machine.load(GANTRY), Scenario.load(WARM_UP)).tcp["z"]
    for family in ("from.z.", "through.z.", "by.z.", "share.z.", "tcp.z."):
        total = sum(column.values for name, column in columns.items() if name.startswith(family))
        np.testing.assert_allclose(total, z, atol=2e-11)
    assert (tmp_path / "sources.png").stat().st_size > 10_000


@pytest.mark.parametrize("name", ["bends", "spins"])
def test_the_picture_is_legible(name: str, tmp_path: Path) -> None:
    """Also with kinds of movement in a panel of their own."""
    shares = superpose(simulate(ODD[name], day()))
    figure = sources_figure(shares)
    assert len(figure.axes) == 2
    check_legible(figure, tmp_path / "x.png")


def many(count: int, tcp: bool) -> Any:
    nodes: dict[str, Any] = {f"n{i}": {"heat_capacity": "100 J/K"} for i in range(count)}
    moves = {"z": {"grows": {"kind": "stretching", "of": "bar", "direction": 1}}} if tcp else {}
    bar = {"material": "steel", "length": "100 mm", "area": "1 cm^2"}
    return machine(
        nodes | {"bar": bar, "room": {"temperature": "20 degC"}},
        links={
            name: {"kind": "convection", "between": [name, "room"], "conductance": "1 W/K"} for name in (*nodes, "bar")
        },
        sources={name: {"kind": "heat_source", "into": {name: 1}, "power": "1 W"} for name in nodes},
        sensors={name: {"measures": name, "noise": "0.1 K"} for name in nodes},
        tcp=moves,
    )


def test_more_causes_than_can_be_told_apart_are_refused_and_none_are_computed_where_nothing_moves(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """2900 sources in as many parts: hours, for nothing where no tool centre point is described."""
    scenario = Scenario.of("a run", "10 min", {}, output="1 min", start="20 degC")
    monkeypatch.setattr("network.engine.superposition.superpose.MOST_PRODUCTS", 7 * 6**2)
    assert {share.cause for share in superpose(simulate(many(5, True), scenario)).shares} >= {"n0", "n4"}
    with pytest.raises(Refused, match="8 causes in 7 lumps; at most 5 can be"):
        superpose(simulate(many(6, True), scenario))
    still = superpose(simulate(many(6, False), scenario))
    assert not still.shares and not still.remainder


def test_sensors_are_looked_up_once_however_many_there_are(monkeypatch: pytest.MonkeyPatch) -> None:
    asked, real = [0], Sensor.exchanged.fget

    def counted(sensor: Sensor) -> str:
        asked[0] += 1
        return str(real(sensor))  # type: ignore[misc]

    monkeypatch.setattr(Sensor, "exchanged", property(counted))
    many(200, False)
    assert asked[0] <= 10 * 200


def test_parts_of_less_than_a_digit_each_are_not_named() -> None:
    """One source through eight bars of 0.3 µm each, beside another one of 100 µm."""
    bar = {"material": "steel", "length": "100 mm", "area": "1 cm^2"}
    small = [f"b{i}" for i in range(8)]
    run = simulate(
        machine(
            dict.fromkeys(("large", *small), bar) | {"room": {"temperature": "20 degC"}},
            links={
                n: {"kind": "convection", "between": [n, "room"], "conductance": "1 W/K"} for n in ("large", *small)
            },
            sources={
                "strong": {"kind": "heat_source", "into": {"large": 1}, "power": "100 W"},
                "weak": {"kind": "heat_source", "into": dict.fromkeys(small, 0.125), "power": "2.4 W"},
            },
            tcp={"z": {name: {"kind": "stretching", "of": name, "direction": 1} for name in ("large", *small)}},
        ),
        Scenario.of("a run", "10 min", {}, output="1 min", start="20 degC"),
    )
    told = str(superpose(run))
    assert " from strong through large" in told and re.search(r" from weak[,.]", told), told
