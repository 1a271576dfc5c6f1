"""What is long, wide or many: read in a time that grows like its size, or refused with the size and the limit.

Twice the size may take twice the time and no more: where it takes the square, an input of a size that nobody minds
hangs a command. Times are those of the processor, so that what runs beside costs nothing.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import cast

import numpy as np
import pytest
from build import machine

from network import Failed, Machine, Recording, Refused, Scenario, compare, simulate
from network.catalogue.mechanisms.base import Link
from network.catalogue.nodes import MOST_IN_ALL, MOST_NODES
from network.engine.assembly import build
from network.engine.simulation import check_length
from network.machine.size_checks import count_pairs
from network.recordings.inputs import Start
from network.recordings.recording import Column

BLOCK = """machine: m
reference: 20 degC
nodes: {{block: {{heat_capacity: {0}}}, bar: {{material: steel, length: 1 m, area: 1 cm^2}}, air: {{temperature: {1}}}}}
links: {{skin: {{kind: convection, between: [{2}, air], conductance: {3}}}}}
sources: {{heater: {{kind: heat_source, into: {{block: 1, bar@0.1..0.2: 0}}, power: {4}}}}}
"""
FIELDS = ("1 kJ/K", "ambient", "bar@0.1..0.2", "5 W/K ± 20 %", "unknown 1..50 W")
GROWTH = 2.8
"""For twice the size: between 2, where the time is linear, and 4, where it is quadratic; what comes once on top only
lowers it."""


def seconds(work: Callable[[], object]) -> float:
    """The shortest of three."""
    taken = []
    for _ in range(3):
        began = time.process_time()
        with suppress(Refused):
            work()
        taken.append(time.process_time() - began)
    return min(taken)


def grows(work: Callable[[int], object], size: int) -> float:
    """How much longer twice the size takes; 0.1 s and less is no time."""
    small, large = seconds(lambda: work(size)), seconds(lambda: work(4 * size))
    return float(np.sqrt(large / max(small, 0.1)))


@pytest.mark.parametrize("at", range(len(FIELDS)))
@pytest.mark.parametrize("filling", [" ", " x", "1", "1 ", ".", "± ", "..", "@ "])
def test_a_value_may_be_as_long_as_it_likes(at: int, filling: str, tmp_path: Path) -> None:
    def load(size: int) -> None:
        half = len(FIELDS[at]) // 2
        text = FIELDS[at][:half] + filling * (size // len(filling)) + FIELDS[at][half:]
        path = tmp_path / "m.yaml"
        path.write_text(BLOCK.format(*(repr(text) if k == at else field for k, field in enumerate(FIELDS))))
        Machine.load(path)

    assert grows(load, 15_000) < GROWTH


@pytest.mark.parametrize("filling", [" ", "[", "(", "] [", " ["])
def test_a_heading_may_be_as_long_as_it_likes(filling: str, tmp_path: Path) -> None:
    def load(size: int) -> None:
        path = tmp_path / "r.csv"
        path.write_text(f"time [s],T{filling * (size // len(filling))}x [degC]\n0,1\n10,2\n")
        Recording.load(path)

    assert grows(load, 10_000) < GROWTH


def test_a_table_may_be_as_wide_as_it_likes(tmp_path: Path) -> None:
    def load(size: int) -> None:
        names, cells = (f"T{i} [degC]" for i in range(size)), ",".join(["20"] * size)
        path = tmp_path / "r.csv"
        path.write_text(f"time [s],{','.join(names)}\n0,{cells}\n10,{cells}\n")
        assert len(Recording.load(path).columns) == size

    assert grows(load, 3_000) < GROWTH


def chain(count: int, folder: Path) -> Path:
    """Parts in a row, each linked to the next and the last to air."""
    names = [*(f"n{i}" for i in range(count)), "air"]
    nodes = [f"  n{i}: {{heat_capacity: 1 kJ/K}}\n" for i in range(count)]
    links = [
        f"  l{i}: {{kind: conduction, between: [{names[i]}, {names[i + 1]}], conductance: 1 W/K}}\n"
        for i in range(count)
    ]
    path = folder / "chain.yaml"
    head = f"machine: c\nreference: 20 degC\nnodes:\n{''.join(nodes)}  air: {{temperature: ambient}}\n"
    path.write_text(f"{head}links:\n{''.join(links)}")
    return path


def test_a_machine_is_checked_in_a_time_like_its_size(tmp_path: Path) -> None:
    assert grows(lambda size: Machine.load(chain(size, tmp_path)), 400) < GROWTH


def test_a_machine_too_large_to_compute_with_is_refused_with_its_size(tmp_path: Path) -> None:
    told = f"chain.yaml:3: nodes has 3001 entries; give it at most {MOST_NODES}"
    with pytest.raises(Refused, match=told):
        Machine.load(chain(3_000, tmp_path))
    bars = {f"b{i}": {"material": "steel", "length": "1 m", "area": "1 cm^2", "lumps": 2000} for i in range(60)}
    skin = {f"s{i}": {"kind": "convection", "between": [f"b{i}", "air"], "conductance": "1 W/K"} for i in range(60)}
    with pytest.raises(Refused, match=f"has 120001 lumps in all; give it at most {MOST_IN_ALL}"):
        machine({**bars, "air": {"temperature": "20 degC"}}, links=skin)


def joined_bars(lumps: int, at: tuple[str, str] = ("", "")) -> Machine:
    bar = {"material": "steel", "length": "1 m", "area": "1 cm^2", "lumps": lumps}
    joint = {"kind": "conduction", "between": [f"a{at[0]}", f"b{at[1]}"], "conductance": "1 W/K"}
    skin = {"kind": "convection", "between": ["b", "air"], "conductance": "1 W/K"}
    return machine({"a": bar, "b": bar, "air": {"temperature": "20 degC"}}, links={"joint": joint, "skin": skin})


def test_bars_that_touch_all_along_have_as_many_flows_as_can_be_held() -> None:
    told = "join 1001000 pairs of lumps, links.joint 1000000 of them; at most 500000 can be computed: give fewer lumps"
    with pytest.raises(Refused, match=told):
        joined_bars(1000)
    assert joined_bars(1000, ("@0.2..0.4", "@1")).lumps == joined_bars(1000, ("", "@0..0.3")).lumps == 2000
    made = joined_bars(7, ("@0.2..0.9", "@0.5"))
    assert count_pairs(made, cast(Link, made.links["joint"])) == 6
    built = build(made)
    assert sum(len(flows.a) for flows in built.flows) == 6 + 7 + 2 * 6


def test_tables_that_do_not_fit_are_refused_with_their_size() -> None:
    bar = {"material": "steel", "length": "1 m", "area": "1 cm^2", "lumps": 2000}
    nodes = {**{f"b{i}": bar for i in range(30)}, "air": {"temperature": "20 degC"}}
    skins = {f"s{i}": {"kind": "convection", "between": [f"b{i}@0", "air"], "conductance": "1 W/K"} for i in range(30)}
    heats = {f"q{i}": {"kind": "heat_source", "into": {"b0": 1}, "power": "1 W"} for i in range(1200)}
    with pytest.raises(Refused, match="needs 1231 rows over 60001 lumps, 74 million numbers; give it fewer lumps or"):
        machine(nodes, links=skins, sources=heats)


def test_a_run_of_more_values_than_can_be_held_is_refused_and_without_parts_is_not() -> None:
    long = Scenario.of("long", "1200000 s", {}, output="0.1 s")
    with pytest.raises(Refused, match="12000001 samples of 3 courses are 36 million values; at most 32 million"):
        simulate(joined_bars(1), long)
    with pytest.raises(Refused, match="12000001 samples of 8 courses are 96 million values; at most 32 million"):
        simulate(joined_bars(1), long, method="rosenbrock")
    check_length(joined_bars(1), long.schedule, parts=False)
    less = Scenario.of("less", "800000 s", {}, output="0.1 s").schedule
    check_length(joined_bars(1), less, lazy=True)
    with pytest.raises(Refused, match="64 million"):
        check_length(joined_bars(1), less)


@pytest.mark.parametrize("method", ["auto", "solve_ivp:LSODA"])
def test_a_jump_in_time_does_not_let_a_relay_switch_for_ever(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    import network.engine.solvers.relay_modes as counting

    monkeypatch.setattr(counting, "MOST_UNSEEN", 100)
    cooled = machine(
        {"tank": {"heat_capacity": "20 kJ/K"}, "air": {"temperature": "30 degC"}},
        links={"skin": {"kind": "convection", "between": ["tank", "air"], "conductance": "20 W/K"}},
        sources={"chiller": {"kind": "thermostat_cooling", "into": {"tank": 1}, "watches": "tank", "set": "20 degC",
                             "hysteresis": "1 K", "power": "500 W"}},
        sensors={"T": {"measures": "tank", "noise": "0.1 K"}},
    )  # fmt: skip
    t = np.concatenate([np.arange(0, 1000, 10.0), 1e8 + np.arange(0, 1000, 10.0)])
    jumps = Recording("r", "r.csv", t, {"T": Column("T", "degC", np.full(len(t), 20.0))})
    with pytest.raises(Failed, match=r"switches more than 100 times between 990 s and 100000000 s.* a jump in time"):
        simulate(cooled, jumps, method=method)
    seen = simulate(cooled, Scenario.of("s", "10 h", output="1 min"), method="switched")
    assert len(seen.switches) > 100


def test_what_is_told_of_many_names_is_short(tmp_path: Path) -> None:
    """Of a chain without ambient, and of a table whose columns are no sensors."""
    names = [f"n{k}" for k in range(300)]
    nodes = {name: {"heat_capacity": "1 kJ/K"} for name in names}
    links = {f"l{k}": {"kind": "conduction", "between": names[k : k + 2], "conductance": "1 W/K"} for k in range(299)}
    chain = machine(nodes, links=links, sensors={"T": {"measures": "n0", "noise": "0.1 K"}})
    (warning,) = chain.warnings
    assert "no path from n0, n1, " in str(warning) and "and 260 more to a held node" in str(warning)
    columns = {name: Column(name, "degC", np.full(9, 20.0)) for name in names}
    told = Recording("wide", "wide", np.arange(9.0), columns, {}, Start())
    with pytest.raises(Refused, match=r"there are: n0, n1, .*, n39 and 260 more\)") as refused:
        compare(chain, told)
    assert len(str(refused.value)) < 500
