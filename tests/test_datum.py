"""Where parts are held and how far axes have moved: growth by hand, by every method, written and refused."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from build import machine, position, schedule

from network import Machine, simulate
from network.machine.lumps import level_patch
from network.platform.refusal import Refused
from network.recordings.inputs import Start, hold, linear
from network.recordings.scenario import Scenario

ALPHA, L, MM = 1.13e-5, 2.0, 1e-3
METHODS = ("modal", "expm", "solve_ivp:LSODA", "solve_ivp:Radau")


def beam(lumps: int = 10, **stretching: Any) -> Machine:
    """A steel beam of 2 m, heated at its beginning; a sensor on every lump."""
    ends = [i / lumps for i in range(lumps + 1)]
    return machine(
        {
            "beam": {"material": "steel", "length": "2 m", "area": "100 cm^2", "lumps": lumps},
            "air": {"temperature": "20 degC"},
        },
        links={"skin": {"kind": "convection", "between": ["beam", "air"], "conductance": "8 W/K"}},
        sources={"motor": {"kind": "heat_source", "into": {"beam@0..0.1": 1}, "power": "300 W"}},
        tcp={"x": {"grows": {"kind": "stretching", "of": "beam", "direction": 1, **stretching}}},
        sensors={f"T{i}": {"measures": f"beam@{a}..{b}", "noise": "0.1 K"} for i, (a, b) in enumerate(pairwise(ends))},
    )  # fmt: skip


# -- where a part is held -------------------------------------------------------------------------------------------
def test_a_part_grows_away_from_where_it_is_held() -> None:
    """10 K on 2 m of steel: half a length from 0.2 to 0.7 is α · 1 m · 10 K = 113 µm, and −45.2 µm from 0.2 to 0."""
    for at, growth in ((0.7, 113e-6), (0.2, 0), (0, -45.2e-6)):
        run = simulate(beam(fixed=0.2, at=at), schedule([0, 1e-6], start=Start(others=30.0)))
        assert run.tcp["x"][0] == pytest.approx(growth, rel=1e-12, abs=1e-18)


def test_only_what_lies_between_counts() -> None:
    """Halves 10 K and 4 K warm, from 0.2 to 0.7: 2 m · (0.3 · 10 + 0.2 · 4) K = 7.6 K m; back again it is −7.6 K m."""
    rises = np.array(10.0), np.array(4.0)
    for fixed, at, sign in ((0.2, 0.7, 1), (0.7, 0.2, -1)):
        grows = beam(2, fixed=fixed, at=at).tcp["x"]["grows"]
        assert grows.movement({}, *rises) == pytest.approx(sign * ALPHA * 7.6, rel=1e-12)


@pytest.mark.parametrize("method", ["temperature", "heat"])
def test_the_same_as_a_range_with_its_own_length(method: str) -> None:
    """Held at 0.2 as far as 0.7 is the mean over 0.2..0.7 times that length, from temperatures and from heat."""
    by_datum = beam(fixed=0.2, at="1400 mm", method=method)
    ranged = {"kind": "stretching", "of": "beam@0.2..0.7", "direction": 1, "method": method}
    by_range = by_datum.patched({"tcp": {"x": {"grows": ranged}}})
    runs = [simulate(m, schedule(np.arange(0, 3601, 600.0))) for m in (by_datum, by_range)]
    assert runs[0].tcp["x"][-1] > 1e-6
    assert runs[0].tcp["x"] == pytest.approx(runs[1].tcp["x"], rel=1e-9, abs=1e-18)


def test_a_mass_takes_its_length_from_the_entry() -> None:
    """A 400 mm slide of aluminium, 5 K warm, held at its front: α · 0.3 m · 5 K = 35.1 µm at three quarters."""
    slide = machine(
        {"slide": {"heat_capacity": "9 kJ/K", "material": "aluminium"}},
        sources={"none": {"kind": "heat_source", "into": {"slide": 1}, "power": "0 W"}},
        tcp={
            "z": {
                "g": {"kind": "stretching", "of": "slide", "length": "400 mm", "fixed": 0, "at": 0.75, "direction": 1}
            }
        },
    )
    run = simulate(slide, schedule([0, 1.0], start=Start(others=25.0)))
    assert run.tcp["z"] == pytest.approx(35.1e-6, rel=1e-9)


# -- the position of an axis ----------------------------------------------------------------------------------------
def by_hand(T: np.ndarray, fixed: float, at: np.ndarray) -> np.ndarray:
    """∫ α ΔT dx over lumps of equal length, T (lumps × samples), places in metres."""
    edges = np.linspace(0, L, len(T) + 1)
    integral = np.vstack([np.zeros(T.shape[1]), np.cumsum((T - 20) * L / len(T), axis=0)])
    return ALPHA * np.array([
        np.interp(x, edges, column) - np.interp(fixed, edges, column) for x, column in zip(at, integral.T, strict=True)
    ])  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("ramped", [False, True])
def test_the_tool_sits_where_the_axis_is(method: str, ramped: bool) -> None:
    """A position that jumps, or runs, at every sample: the growth is exact at each of them."""
    t = np.arange(0, 3601, 60.0)
    x = 900 * MM * (1 + np.sin(t / 500))
    signal = linear("position", "mm", t, x) if ramped else hold("position", "mm", t, x)
    run = simulate(beam(fixed=0.1, at="100 mm + position"), schedule(t, signal), method=method)
    T = np.array([run.sensors[f"T{i}"] for i in range(10)])
    assert run.tcp["x"] == pytest.approx(by_hand(T, 0.2, 0.1 + x), rel=1e-11, abs=1e-16)
    assert run.method == method and np.ptp(run.tcp["x"]) > 50e-6


def test_the_three_ways_to_name_a_moving_place() -> None:
    """Counted from the beginning, from the other end, and as a share of the length."""
    t = np.array([0.0, 1800.0, 3600.0])
    x = position((0, 200), (1800, 1500))
    forward = simulate(beam(fixed=0, at="position"), schedule(t, x)).tcp["x"]
    back = hold("position", "mm", t, 2 - x.at(t))
    assert simulate(beam(fixed=0, at="2 m - position"), schedule(t, back)).tcp["x"] == pytest.approx(forward)
    share = hold("position", "1", t, x.at(t) / 2 - 0.05)
    assert simulate(beam(fixed=0, at="0.05 + position"), schedule(t, share)).tcp["x"] == pytest.approx(forward)
    assert beam(fixed="position", at=1).inputs["position"] == "m"
    assert beam(fixed=0, at="0 + position").inputs["position"] == "1"


def test_beyond_its_ends_nothing_grows_and_the_run_says_so() -> None:
    warm = schedule([0, 60.0, 90.0], position((0, -100), (60, 2300)), start=Start(others=30.0))
    run = simulate(beam(fixed=0.5, at="position"), warm)
    assert run.tcp["x"][0] == pytest.approx(-ALPHA * 1 * 10, rel=1e-6)
    (warning,) = run.warnings
    assert warning == (
        "tcp.x.grows: `position` goes from -100 mm to 2300 mm along the 2000 mm of beam; it counts as its end"
    )


# -- what stands in a file ------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "at", ["0.7", "350 mm", "position", "220 mm + position", "900 mm - x axis", "0.2 + position", "0 + position"]
)
def test_what_is_written_reads_back(at: str) -> None:
    built = beam(fixed=0.1, at=at)
    again = Machine.read(built.tree, "again")
    assert dict(again.entries()) == dict(built.entries())
    assert again.tcp["x"]["grows"].to_plain()["at"] == at


def test_levels_keep_it() -> None:
    """A merged part keeps its growth: 10 K on the 1 m from 0.5 to the end."""
    patch = {
        "nodes": {"foot": {"heat_capacity": "1 J/K"}},
        "links": {"joint": {"kind": "conduction", "between": ["beam@0", "foot"], "conductance": "1 W/K"}},
        "levels": {"coarse": {"merge": {"whole": ["beam", "foot"]}}},
    }
    built = beam(fixed=0.5, at="position").patched(patch)
    merged = Machine.read(level_patch(built, "coarse"), "coarse")
    run = simulate(merged, schedule([0, 1e-3], position((0, 2000)), start=Start(others=30.0)))
    assert run.tcp["x"][0] == pytest.approx(ALPHA * 1 * 10, rel=1e-9)


REFUSED = [
    ({"fixed": 0.2, "at": 1.2}, "at '1.2' is above what is possible; at goes from 0 to 1"),
    ({"fixed": -0.1, "at": 0.5}, "fixed '-0.1' is below what is possible"),
    ({"fixed": 0.2}, "has `fixed` alone; give `fixed`, where the part is held, and `at`"),
    ({"at": 0.2}, "has `at` alone"),
    ({"fixed": 0.2, "at": 0.7, "of": "beam@0..0.5"}, "beam@0..0.5 is a range beside `fixed`; write `of: beam`"),
    ({"fixed": 0.2, "at": "2100 mm"}, "at: `2100 mm` is 2100 mm along the 2000 mm of beam; name a place on it"),
    ({"fixed": 0.2, "at": "30 W"}, "at '30 W' is no place along a part; give a share from 0 to 1, a length, an input"),
    ({"fixed": 0.2, "at": "200 mm ± 5 mm"}, "is a length with a spread; give an uncertain place as a share"),
    ({"fixed": 0.2, "at": "x + y"}, "at 'x + y': 'x' is not a number; give a share from 0 to 1"),
    ({"fixed": 0.2, "at": "3 foo + y"}, "at '3 foo + y': unknown unit 'foo'; give a share"),
    ({"fixed": 0.2, "at": "nan"}, "at 'nan' is not a number"),
    ({"fixed": 0.2, "at": "unknown 2..3"}, "is above what is possible"),
]  # fmt: skip


@pytest.mark.parametrize(("given", "told"), REFUSED)
def test_a_place_that_is_none_is_refused(given: dict[str, Any], told: str) -> None:
    with pytest.raises(Refused) as refused:
        beam(**given)
    assert told in str(refused.value)


def test_a_part_without_a_length_is_refused() -> None:
    nodes = {"head": {"heat_capacity": "9 kJ/K", "material": "steel"}}
    none = {"kind": "heat_source", "into": {"head": 1}, "power": "0 W"}
    grows = {"kind": "stretching", "of": "head", "fixed": 0.2, "at": 0.7, "direction": 1}
    with pytest.raises(Refused, match="the length of head is not known; give `length`"):
        machine(nodes, sources={"none": none}, tcp={"z": {"grows": grows}})


def test_a_position_in_another_unit_is_refused() -> None:
    with pytest.raises(Refused, match="the input `position` is in degC, and the machine reads it in m; give it"):
        simulate(beam(fixed=0, at="position"), Scenario.of("wrong", "1 min", {"position": "20 degC"}))
