"""Figures: what they show is what was computed, every axis has its unit, no label covers another."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.cbook import is_math_text
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon, Rectangle
from matplotlib.text import Text

from network.analysis.comparison.compare import RecordingResidual, compare
from network.engine.simulation import simulate
from network.engine.trajectory import Trajectory
from network.machine.machine import Machine
from network.platform.quantities.number_format import number
from network.platform.quantities.unit_values import in_own_unit
from network.platform.refusal import Refused, Spot
from network.platform.yaml.document import Branch, tree_of
from network.recordings.columns import Column
from network.recordings.inputs import hold, linear
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario
from network.report.figures.canvas import PALETTE, gap_unit, look, save, shorten
from network.report.figures.comparison_figure import comparison_figure
from network.report.figures.labels import spread
from network.report.figures.lines import MOST_POINTS, alone, outline, thin, time_ticks, with_gaps
from network.report.figures.network_figure import network_figure
from network.report.figures.run_figure import run_figure
from network.report.figures.sources_figure import contributions_figure
from network.report.figures.symbols import examples

SHARED = Path(__file__).parents[2] / "shared" / "cases"
RPM = 2 * np.pi / 60


def machine_of(**sections: Any) -> Machine:
    """A spindle in a housing, cooled by air and a coolant; sections given take the place of these."""
    tree = {
        "machine": "Test mill",
        "reference": "22 degC",
        "nodes": {
            "shaft": {"heat_capacity": "4 kJ/K"},
            "housing": {"material": "steel", "length": "500 mm", "area": "150 cm^2"},
            "seat": {},
            "ambient": {"temperature": "ambient"},
            "coolant": {"temperature": "20 degC"},
        },
        "links": {
            "front bearing": {"kind": "conduction", "between": ["shaft", "housing"], "conductance": "20 W/K"},
            "rear bearing": {"kind": "conduction", "between": ["shaft", "housing"], "conductance": "10 W/K"},
            "to seat": {"kind": "conduction", "between": ["housing", "seat"], "conductance": "30 W/K"},
            "seat skin": {"kind": "convection", "between": ["seat", "ambient"], "conductance": "2 W/K"},
            "skin": {"kind": "convection", "between": ["housing", "ambient"], "conductance": "6 W/K"},
            "jacket": {"kind": "convection", "between": ["coolant", "housing"], "conductance": "8 W/K"},
        },
        "sources": {
            "friction": {
                "kind": "bearing_friction", "into": {"shaft": 0.5, "housing": 0.5}, "torque": "400 N mm",
            },
        },
        "tcp": {
            "z": {
                "housing grows": {"kind": "stretching", "of": "housing", "length": "300 mm", "direction": -1},
                "nose grows": {
                    "kind": "stretching", "of": "shaft", "length": "100 mm", "expansion": "1.1e-5 1/K", "direction": 1,
                },
            },
        },
        "sensors": {
            "T_shaft": {"measures": "shaft", "noise": "0.05 K"},
            "T_housing": {"measures": "housing", "noise": "0.05 K"},
            "T_seat": {"measures": "seat", "noise": "0.05 K"},
            "dz": {"measures": "tcp.z", "noise": "0.25 um"},
        },
    }  # fmt: skip
    merged = {key: value for key, value in {**tree, **sections}.items() if value is not None}
    laid = tree_of(merged, Spot("test"))
    assert isinstance(laid, Branch)
    return Machine.read(laid, "test")


WARM_UP = {"speed": [{"for": "2 h", "at": "6000 rpm"}, {"for": "2 h", "at": "0 rpm"}], "ambient": "21 degC"}


def run_of(machine: Machine, duration: str = "4 h", output: str = "60 s", **inputs: Any) -> Trajectory:
    needed = {name: value for name, value in {**WARM_UP, **inputs}.items() if name in machine.inputs}
    if isinstance(needed.get("speed"), list) and duration != "4 h":
        needed["speed"] = "6000 rpm"
    return simulate(machine, Scenario.of("warm up", duration, needed, output=output, start="22 degC"))


def recording_of(run: Trajectory, seed: int = 1, **more: Column) -> Recording:
    """The channels of a run with their noise, as a recording."""
    draw = np.random.default_rng(seed)
    columns = {name: Column(name, run.schedule.signals[name].unit, values) for name, values in run.inputs.items()}
    for name, values in run.sensors.items():
        sensor = run.machine.sensors[name]
        columns[name] = Column(name, sensor.unit, values + sensor.sigma * draw.standard_normal(len(values)))
    return Recording("test", "test.csv", run.t, {**columns, **more})


def residual_of(machine: Machine, recording: Recording) -> RecordingResidual:
    return compare(machine, [recording]).recordings[0]


@pytest.fixture(scope="module")
def mill() -> Machine:
    return machine_of()


@pytest.fixture(scope="module")
def run(mill: Machine) -> Trajectory:
    return run_of(mill)


def words(figure: Figure) -> list[str]:
    """Every text that is seen, as it is seen."""
    texts = [*figure.texts, *(text for axes in figure.axes for text in axes.texts)]
    return [text.get_text().replace(r"\$", "$") for text in texts if text.get_text()]


def dashes(line: Any) -> str:
    """Lengths of strokes and gaps; matplotlib tells them nowhere else."""
    return str(line._unscaled_dash_pattern[1])


def overlapping(figure: Figure, texts: list[Any]) -> list[tuple[str, str]]:
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    boxes = [(text.get_text(), text.get_window_extent(renderer)) for text in texts if text.get_text()]
    pairs = combinations(boxes, 2)
    return [(a, b) for (a, one), (b, two) in pairs if one.padded(-1).overlaps(two.padded(-1))]


def beyond_paper(figure: Figure) -> list[str]:
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    paper = figure.bbox.padded(1)
    texts = [*figure.texts, *(text for axes in figure.axes for text in axes.texts)]
    extents = [(text.get_text(), text.get_window_extent(renderer)) for text in texts if text.get_text()]
    return [text for text, box in extents if not (paper.x0 <= box.x0 and box.x1 <= paper.x1 and box.y1 <= paper.y1)]


def check_legible(figure: Figure, path: Path) -> None:
    """No labels on one another, none cut off, and it can be written."""
    for axes in figure.axes:
        assert not overlapping(figure, list(axes.texts))
    assert not beyond_paper(figure)
    assert save(figure, path).stat().st_size > 5000


def check_symbols_free(figure: Figure) -> None:
    """No label lies on the symbol of a node."""
    (axes,) = figure.axes
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    symbols = [p.get_window_extent(renderer).padded(-3) for p in axes.patches if isinstance(p, Circle | Rectangle)]
    texts = [(text.get_text(), text.get_window_extent(renderer)) for text in axes.texts]
    assert not [text for text, box in texts if any(box.overlaps(symbol) for symbol in symbols)]


# -- lines ----------------------------------------------------------------------------------------------------------
def test_thinned_keeps_every_spike_and_the_first_gap() -> None:
    t = np.arange(28_801.0)
    values = np.sin(t / 3000)
    values[[7001, 21_113]] = 5.0, -7.0
    values[12_000] = np.nan
    few, seen = thin(t, values)
    assert len(few) <= MOST_POINTS and (few[0], few[-1]) == (t[0], t[-1])
    assert {7001.0, 21_113.0, 12_000.0} <= set(few) and np.isnan(seen[few == 12_000]).all()
    np.testing.assert_allclose(np.interp(9000.5, few, seen), np.sin(9000.5 / 3000), atol=0.02)


def test_thinned_goes_by_time_where_samples_crowd() -> None:
    t = np.concatenate([np.linspace(0, 1, 20_000), np.linspace(2, 1000, 1500)])
    few, _seen = thin(t, np.sin(t))
    assert len(few) <= MOST_POINTS and (few > 1).sum() > 1000
    assert thin(t[:100], t[:100])[0] is not None and len(thin(t[:100], t[:100])[0]) == 100
    assert np.isnan(thin(t, np.full(len(t), np.nan))[1]).all()


def test_an_outline_has_upright_jumps_and_no_idle_points() -> None:
    times, values = outline(
        hold("speed", "rpm", np.array([0.0, 60, 120, 180]), np.array([1.0, 1, 4, 2])), np.array([0.0, 200])
    )
    assert list(zip(times, values, strict=True)) == [(0, 1), (120, 1), (120, 4), (180, 4), (180, 2), (200, 2)]
    times, values = outline(
        linear("ambient", "degC", np.array([0.0, 100]), np.array([20.0, 22])), np.array([50.0, 150])
    )
    assert list(zip(times, values, strict=True)) == [(50, 21), (100, 22), (150, 22)]


def test_gaps_stay_gaps() -> None:
    t, values = with_gaps(np.array([0.0, 1, 2, 3, 60, 61]), np.arange(6.0))
    assert np.isnan(values[4]) and t[4] == 31.5 and len(t) == 7
    assert list(alone(np.array([1.0, np.nan, 2, 3, np.nan, 4]))) == [True, False, False, False, False, True]


@pytest.mark.parametrize(
    ("start", "end", "name"), [(0, 2, "s"), (0, 100, "min"), (3, 4, "h"), (0, 240, "h"), (0, 5000, "h")]
)
def test_time_ticks_are_few_and_inside(start: float, end: float, name: str) -> None:
    ticks = time_ticks(start, end, name)
    assert 3 <= len(ticks) <= 13 and start <= ticks[0] and ticks[-1] <= end + 1e-9


def test_spread_moves_labels_apart_and_no_further() -> None:
    far = np.array([1.0, 30, 60])
    np.testing.assert_allclose(spread(far, 10, 0, 100), far)
    placed = spread(np.array([50.0, 50, 51, 99]), 10, 0, 100)
    assert (np.diff(np.sort(placed)) >= 10 - 1e-9).all() and placed.min() >= 0 and placed.max() <= 100
    assert abs(placed[:3].mean() - 151 / 3) < 1 and placed[3] == 99
    assert (np.diff(np.sort(spread(np.zeros(30), 10, 0, 100))) > 3).all()


def test_the_first_24_looks_differ() -> None:
    looks = [look(i) for i in range(24)]
    assert len(set(looks)) == 24 and all(a[0] != b[0] and a[1] != b[1] for a, b in pairwise(looks))


def test_numbers_and_names() -> None:
    assert [number(v, "um", 3, True) for v in (19.0, -0.05, 0, 1e-13)] == ["+19.0 µm", "−0.0500 µm", "0 µm", "0 µm"]
    assert (
        number(12_345.6, "rpm") == "12346 rpm"
        and number(float("nan"), "K") == "no value"
        and number(0.5, "1") == "0.5000"
    )
    assert shorten("a very long name of a front bearing", 20) == "a very long n…earing"
    assert gap_unit("degC").from_si(0.05) == 0.05 and gap_unit("um").from_si(1e-6) == pytest.approx(1)


# -- a run ----------------------------------------------------------------------------------------------------------
def test_a_run_shows_temperatures_displacement_and_speed(run: Trajectory, tmp_path: Path) -> None:
    figure = run_figure(run)
    assert [axes.get_ylabel() for axes in figure.axes] == ["temperature [°C]", "TCP displacement [µm]", "speed [rpm]"]
    assert [axes.get_xlabel() for axes in figure.axes] == ["", "", "time [h]"]
    top, middle, bottom = (
        [line for line in axes.lines if line.axes.transData == line.get_transform()] for axes in figure.axes
    )
    assert len(top) == 3 and {line.get_color() for line in top} == set(PALETTE[:3])
    np.testing.assert_allclose(top[0].get_ydata(), run.sensors["T_shaft"])
    np.testing.assert_allclose(top[0].get_xdata(), run.t / 3600)
    np.testing.assert_allclose(middle[0].get_ydata(), run.tcp["z"] * 1e6)
    steps = np.column_stack([bottom[0].get_xdata(), bottom[0].get_ydata()])
    np.testing.assert_allclose(steps, [[0, 6000], [2, 6000], [2, 0], [4, 0]], atol=1e-9)
    told = words(figure)
    assert "Test mill: warm up" in told and "ambient 21.00 °C throughout" in told
    assert f"T_shaft  {run.sensors['T_shaft'][-1]:.2f} °C" in told
    check_legible(figure, tmp_path / "run.png")


def test_inputs_that_vary_and_angles_have_their_own_panels(tmp_path: Path) -> None:
    supports = ["housing@0..0.2", "housing@0.8..1"]
    tilt = {"kind": "tilt", "between": supports, "distance": "300 mm", "direction": 1, "length": "200 mm"}
    stretching = {"kind": "stretching", "of": "housing", "direction": 1}
    machine = machine_of(tcp={"a": {"leans": tilt}, "z": {"g": stretching}}, sensors=None)
    figure = run_figure(run_of(machine, ambient=[{"for": "1 h", "at": "20 degC"}, {"for": "3 h", "at": "23 degC"}]))
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == ["temperature [°C]", "TCP displacement [µm]", "TCP angle [µrad]", "speed [rpm]", "ambient [°C]"]
    assert any(text.startswith("housing ") for text in words(figure)), "parts stand in for sensors"
    check_legible(figure, tmp_path / "run.png")


@pytest.mark.parametrize(
    ("duration", "output", "shown"), [("2 s", "1 s", "s"), ("40 min", "10 s", "min"), ("240 h", "10 min", "h")]
)
def test_short_and_long_runs(mill: Machine, tmp_path: Path, duration: str, output: str, shown: str) -> None:
    run = run_of(mill, duration, output)
    for figure in (run_figure(run), contributions_figure(run)):
        assert figure.axes[-1].get_xlabel() == f"time [{shown}]"
        check_legible(figure, tmp_path / "x.png")


def bare_machine() -> Machine:
    """One part, no sensor, no tool centre point, no input."""
    nodes = {"a": {"heat_capacity": "1 kJ/K"}, "room": {"temperature": "20 degC"}}
    links = {"skin": {"kind": "convection", "between": ["a", "room"], "conductance": "1 W/K"}}
    return machine_of(nodes=nodes, links=links, sources=None, tcp=None, sensors=None)


def test_a_machine_with_next_to_nothing(tmp_path: Path) -> None:
    machine = bare_machine()
    run = run_of(machine)
    assert [axes.get_ylabel() for axes in run_figure(run).axes] == ["temperature [°C]"]
    nothing = replace(run, parts={})
    assert any("nothing to show" in text for text in words(run_figure(nothing)))
    assert any("moves no tool centre point" in text for text in words(contributions_figure(run)))
    for figure in (run_figure(run), run_figure(nothing), contributions_figure(run), network_figure(machine, run)):
        check_legible(figure, tmp_path / "x.png")


def test_channels_without_any_value(run: Trajectory, tmp_path: Path) -> None:
    empty = replace(run, sensors={name: np.full(len(run.t), np.nan) for name in run.sensors})
    figure = run_figure(empty)
    assert "T_shaft  no value" in words(figure)
    check_legible(figure, tmp_path / "x.png")


def many_sensors(count: int, name: str = "T_{}") -> Machine:
    places = ["shaft", *(f"housing@{share:.2f}" for share in np.linspace(0.01, 0.99, count - 1))]
    sensors = {name.format(i): {"measures": place, "noise": "0.05 K"} for i, place in enumerate(places)}
    bar = {"material": "steel", "length": "500 mm", "area": "150 cm^2", "lumps": 12}
    return machine_of(nodes={**machine_of().to_plain()["nodes"], "housing": bar}, sensors=sensors)


def test_twelve_sensors_differ_and_twenty_are_cut_to_the_liveliest(tmp_path: Path) -> None:
    figure = run_figure(run_of(many_sensors(12)))
    lines = [line for line in figure.axes[0].lines if len(line.get_xdata()) > 3]
    assert len({(line.get_color(), dashes(line)) for line in lines}) == 12
    check_legible(figure, tmp_path / "a.png")
    figure = run_figure(run_of(many_sensors(20)))
    assert any("6 more that move less" in text for text in words(figure))
    check_legible(figure, tmp_path / "b.png")


def test_names_are_never_read_as_formulas(tmp_path: Path) -> None:
    name = "T_$x$_{}_of_a_rather_long_and_tedious_name"
    machine = many_sensors(4, name)
    run = run_of(machine)
    for figure in (
        run_figure(run),
        network_figure(machine, run),
        comparison_figure(residual_of(machine, recording_of(run))),
    ):
        texts = [*figure.texts, *(text for axes in figure.axes for text in (*axes.texts, axes.title, axes.yaxis.label))]
        assert not any(is_math_text(text.get_text()) for text in texts)
        assert any("…" in text and "$" in text for text in words(figure))
        check_legible(figure, tmp_path / "x.png")


def thermostat() -> Machine:
    cooler = {"kind": "thermostat_cooling", "into": {"housing": 1}, "watches": "shaft", "set": "24 degC",
              "hysteresis": "0.5 K", "power": "400 W"}  # fmt: skip
    return machine_of(sources={**machine_of().to_plain()["sources"], "the cooler": cooler})


def test_switching_instants_are_marked(tmp_path: Path) -> None:
    run = run_of(thermostat())
    figure = run_figure(run)
    count = len(run.switches)
    assert 2 < count <= 60
    marks = [c for c in figure.axes[0].collections if isinstance(c, LineCollection) and c.get_alpha() == 0.4]
    at = sorted(segment[0, 0] for mark in marks for segment in mark.get_segments())
    np.testing.assert_allclose(at, [t / 3600 for t, _, _ in run.switches])
    assert any(f"the cooler switches {count} times" in text for text in words(figure))
    many = replace(run, switches=run.switches * 30)
    assert len([c for c in run_figure(many).axes[1].collections if c.get_alpha() == 0.4]) == 0
    check_legible(figure, tmp_path / "x.png")


# -- contributions --------------------------------------------------------------------------------------------------
def test_contributions_add_up_to_the_displacement(run: Trajectory, tmp_path: Path) -> None:
    figure = contributions_figure(run)
    (axes,) = figure.axes
    assert axes.get_ylabel() == "TCP z [µm]"
    bands = [c for c in axes.collections if isinstance(c, PolyCollection)]
    up = max(b.get_paths()[0].vertices[:, 1].max() for b in bands)
    down = min(b.get_paths()[0].vertices[:, 1].min() for b in bands)
    parts = {name: values * 1e6 for (_, name), values in run.contributions.items()}
    assert up == pytest.approx(sum(np.maximum(v, 0) for v in parts.values()).max())
    assert down == pytest.approx(sum(np.minimum(v, 0) for v in parts.values()).min())
    black = next(line for line in axes.lines if line.get_color() == "black")
    np.testing.assert_allclose(black.get_ydata(), run.tcp["z"] * 1e6)
    assert f"{number(run.tcp['z'][-1] * 1e6, 'um', 3, True)}  sum" in words(figure)
    assert f"{number(parts['housing grows'][-1], 'um', 3, True)}  housing grows" in words(figure)
    check_legible(figure, tmp_path / "x.png")


def test_many_contributions_are_summed_up(tmp_path: Path) -> None:
    entries = {
        f"entry {i}": {"kind": "stretching", "of": "housing", "length": f"{10 * i + 5} mm", "direction": 1}
        for i in range(14)
    }
    figure = contributions_figure(run_of(machine_of(tcp={"z": entries, "y": entries})))
    assert [axes.get_ylabel() for axes in figure.axes] == ["TCP z [µm]", "TCP y [µm]"]
    assert sum("5 smaller ones" in text for text in words(figure)) == 2
    check_legible(figure, tmp_path / "x.png")


# -- comparison -----------------------------------------------------------------------------------------------------
def test_a_comparison_has_a_row_for_each_channel(mill: Machine, run: Trajectory, tmp_path: Path) -> None:
    residual = residual_of(machine_of(tcp=mill.to_plain()["tcp"]), recording_of(run))
    figure = comparison_figure(residual)
    assert len(figure.axes) == 2 * len(residual.channels) + 2
    assert [axes.get_ylabel() for axes in figure.axes[:-2:2]] == ["[°C]", "[°C]", "[°C]", "[µm]"]
    assert {axes.get_ylabel() for axes in figure.axes[1:-2:2]} == {"[σ]"}
    assert {axes.get_ylabel() for axes in figure.axes[-2:]} == {"[rpm]"}
    assert {text.get_text() for axes in figure.axes[-2:] for text in axes.texts} == {"speed"}
    assert [axes.get_xlabel() for axes in figure.axes] == [""] * 8 + ["time [h]"] * 2
    for channel, left, right in zip(residual.channels.values(), figure.axes[::2], figure.axes[1::2], strict=False):
        measured, simulated = left.lines
        np.testing.assert_allclose(measured.get_ydata(), in_own_unit(channel.measured, channel.unit))
        np.testing.assert_allclose(simulated.get_ydata(), in_own_unit(channel.simulated, channel.unit))
        assert (simulated.get_color(), measured.get_color()) == (PALETTE[0], "#6f6f6f")
        np.testing.assert_allclose(right.lines[-1].get_ydata(), channel.in_noise)
        (band,) = [p for p in right.patches if isinstance(p, Rectangle)]
        assert (band.get_y(), band.get_height()) == (-2, 4)
        assert left.texts[0].get_text().startswith(f"{channel.name}: rmse {channel.rmse_in_noise:.3g} σ (")
    assert "measured − simulated; σ = 0.05 K" in words(figure) and "measured − simulated; σ = 0.25 µm" in words(figure)
    check_legible(figure, tmp_path / "x.png")


def test_gaps_lone_samples_and_empty_channels(mill: Machine, run: Trajectory, tmp_path: Path) -> None:
    recording = recording_of(run)
    shaft, housing = (recording.columns[n].values.copy() for n in ("T_shaft", "T_housing"))
    shaft[100:150], housing[np.arange(len(housing)) % 3 > 0] = np.nan, np.nan
    changed = {"T_shaft": shaft, "T_housing": housing, "T_seat": np.full(len(shaft), np.nan)}
    columns = {**recording.columns, **{n: Column(n, "degC", v) for n, v in changed.items()}}
    figure = comparison_figure(residual_of(mill, replace(recording, columns=columns)))
    assert np.isnan(figure.axes[0].lines[0].get_ydata()).sum() == 50
    dots = figure.axes[2].lines[0]
    assert (
        dots.get_marker() == "o"
        and dots.get_linestyle() == "None"
        and len(dots.get_xdata()) == np.isfinite(housing).sum()
    )
    assert "T_seat: no readings" in words(figure) and len(figure.axes[4].lines) == 1
    check_legible(figure, tmp_path / "x.png")


@pytest.mark.parametrize("count", [1, 3, 12])
def test_comparisons_of_one_to_twelve_channels(count: int, tmp_path: Path) -> None:
    machine = many_sensors(max(count, 2))
    if count == 1:
        machine = machine_of(sensors={"T": {"measures": "shaft", "noise": "0.05 K"}})
    figure = comparison_figure(residual_of(machine, recording_of(run_of(machine))))
    assert len(figure.axes) == 2 * count + 2
    check_legible(figure, tmp_path / "x.png")


# -- network --------------------------------------------------------------------------------------------------------
def grown(count: int, seed: int = 3) -> Machine:
    """A network of many parts with long names, streams, relays, loops, islands and twelve sensors."""
    draw = np.random.default_rng(seed)
    names = [f"part_{i}" if i % 7 else f"a_rather_long_name_${i}" for i in range(count)]
    nodes: dict[str, Any] = {name: {"heat_capacity": f"{10 ** draw.uniform(2, 6):.4g} J/K"} for name in names}
    nodes |= {"seat": {}, "ambient": {"temperature": "ambient"}, "cool$ant_$_water": {"temperature": "20 degC"}}

    def conduction(a: str, b: str) -> dict[str, Any]:
        return {"kind": "conduction", "between": [a, b], "conductance": f"{10 ** draw.uniform(0, 2):.3g} W/K"}

    links = {"one": conduction("seat", names[0]), "two": conduction("seat", names[1])}
    links |= {f"j{i}": conduction(names[int(draw.integers(max(0, i - 6), i))], names[i]) for i in range(1, count)}
    links |= {f"x{i}": conduction(*draw.choice(names, 2, replace=False)) for i in range(count // 5)}
    links |= {
        f"s{i}": {"kind": "convection", "between": [names[i], "ambient"], "conductance": "4 W/K"}
        for i in range(0, count, 2)
    }
    links["stream"] = {
        "kind": "advection",
        "through": ["cool$ant_$_water", names[2], names[3]],
        "capacity_flow": "40 W/K",
    }
    sources: dict[str, Any] = {
        f"heat {i}": {"kind": "heat_source", "into": {names[i]: 1}, "power": "50 W", "with": "always"}
        for i in range(0, count, 4)
    }
    sources["cooler"] = {"kind": "thermostat_cooling", "into": {names[2]: 1}, "watches": names[4], "set": "60 degC",
                         "hysteresis": "5 K", "power": "8 W"}  # fmt: skip
    step = max(count // 12, 1)
    sensors = {f"T_{i}": {"measures": names[i * step], "noise": "0.05 K"} for i in range(min(count, 12))}
    return machine_of(nodes=nodes, links=links, sources=sources, tcp=None, sensors=sensors)


def labels(figure: Figure, start: str) -> dict[str, str]:
    """Texts of links (`link:`) or nodes (`node:`) by name; a node's lines are joined."""
    found: dict[str, str] = {}
    for text in figure.axes[0].texts:
        if str(text.get_gid()).startswith(start):
            name = str(text.get_gid()).removeprefix(start)
            found[name] = f"{found[name]}\n{text.get_text()}" if name in found else text.get_text()
    return found


def heads(figure: Figure) -> Iterator[np.ndarray[Any, Any]]:
    """Corners of every arrow head, the point first."""
    for patch in figure.axes[0].patches:
        if type(patch) is Polygon:
            yield patch.get_xy()[:3]


def test_a_network_shows_its_parts_and_conductances(mill: Machine, tmp_path: Path) -> None:
    figure = network_figure(mill)
    told = labels(figure, "link:")
    assert (
        told["front bearing"].endswith("20.0 W/K")
        and told["skin"].endswith("6.00 W/K")
        and set(told) == set(mill.links)
    )
    nodes = labels(figure, "node:")
    assert nodes["shaft"] == "shaft\n4.00 kJ/K\n▲ friction 50%\n◇ T_shaft"
    assert (
        nodes["coolant"] == "coolant\n20.0 °C" and nodes["ambient"] == "ambient" and nodes["seat"] == "seat\n◇ T_seat"
    )
    assert not list(heads(figure)), "no direction without a run"
    assert any("conductance" in text for text in words(figure))
    check_symbols_free(figure)
    check_legible(figure, tmp_path / "x.png")


def test_symbols_tell_parts_junctions_and_held_nodes_apart(mill: Machine) -> None:
    figure = network_figure(mill)
    patches = figure.axes[0].patches
    circles, squares = [p for p in patches if isinstance(p, Circle)], [p for p in patches if isinstance(p, Rectangle)]
    radii = sorted({round(c.radius, 6) for c in circles})
    assert len(squares) == 2 and len(radii) == 3, "a junction and two parts of different size"
    assert radii[0] < 4 < radii[1] < radii[2]
    legend = [text for text in words(figure) if text.endswith("kJ/K")]
    assert {"4.00 kJ/K"} <= set(legend) and any("□ held temperature" in text for text in words(figure))
    inner = np.array([c.center for c in circles[:3]])
    for square in squares:
        x, y = square.get_x() + square.get_width() / 2, square.get_y() + square.get_height() / 2
        (x0, y0), (x1, y1) = inner.min(axis=0), inner.max(axis=0)
        assert not (x0 < x < x1 and y0 < y < y1), "held nodes stand at the rim"


def test_a_run_gives_links_their_mean_heat_flow(mill: Machine, run: Trajectory, tmp_path: Path) -> None:
    figure = network_figure(mill, run)
    told, nodes = labels(figure, "link:"), labels(figure, "node:")
    hours = run.t[-1] - run.t[0]
    assert told["front bearing"].endswith(f"{abs(run.energy.carried['links.front bearing']) / hours:.0f} W")
    assert told["skin"].endswith(f"{abs(run.energy.by_mechanism['links.skin']) / hours:.0f} W")
    assert f"▲ friction {run.energy.by_mechanism['sources.friction'] / hours / 2:.0f} W" in nodes["shaft"]
    assert len(list(heads(figure))) == len(mill.links)
    assert any("mean heat flow over 4 h" in text for text in words(figure))
    check_legible(figure, tmp_path / "x.png")


@pytest.mark.parametrize("held_first", [True, False])
def test_arrows_point_the_way_the_heat_goes(held_first: bool) -> None:
    nodes = {"a": {"heat_capacity": "1 kJ/K"}, "room": {"temperature": "20 degC"}}
    between = ["room", "a"] if held_first else ["a", "room"]
    links = {"skin": {"kind": "convection", "between": between, "conductance": "1 W/K"}}
    machine = machine_of(nodes=nodes, links=links, sources=None, tcp=None, sensors=None)
    figure = network_figure(machine, run_of(machine))  # a begins at 22 degC and cools
    part = next(p for p in figure.axes[0].patches if isinstance(p, Circle)).center
    (head,) = heads(figure)
    point, back = head[0], head[1:].mean(axis=0)
    assert np.hypot(*(point - part)) > np.hypot(*(back - part))


def test_relays_streams_and_loops_have_signs_of_their_own(tmp_path: Path) -> None:
    bar = {"material": "steel", "length": "500 mm", "area": "150 cm^2", "lumps": 4}
    plain = thermostat().to_plain()
    loop = {"kind": "conduction", "between": ["housing@0", "housing@1"], "conductance": "5 W/K"}
    stream = {"kind": "advection", "through": ["coolant", "housing", "shaft"], "capacity_flow": "30 W/K"}
    machine = machine_of(nodes={**plain["nodes"], "housing": bar}, sources=plain["sources"],
                         links={**plain["links"], "loop": loop, "water": stream})  # fmt: skip
    run = run_of(machine)
    figure = network_figure(machine, run)
    nodes = labels(figure, "node:")
    assert "◐ the cooler −" in nodes["housing"] and "the cooler" not in nodes["shaft"]
    assert "loop" in labels(figure, "link:") and "water" in labels(figure, "link:")
    assert sum(dashes(line) != "None" for line in figure.axes[0].lines) == 1, "the watched node is joined by dots"
    green = [line for line in figure.axes[0].lines if line.get_color() == PALETTE[2]]
    assert len(green) == 2
    assert any("◐ relay" in text and "→ stream" in text for text in words(figure))
    check_legible(figure, tmp_path / "x.png")


@pytest.mark.parametrize("count", [8, 20, 50])
def test_labels_of_large_networks_do_not_overlap(count: int, tmp_path: Path) -> None:
    machine = grown(count)
    run = run_of(machine, "1 h")
    for figure in (network_figure(machine), network_figure(machine, run)):
        assert len({name.replace(r"\$", "$") for name in labels(figure, "node:")}) == len(machine.nodes)
        assert len(labels(figure, "link:")) > 0.8 * len(machine.links)
        assert figure.get_size_inches()[1] < 24
        check_symbols_free(figure)
        check_legible(figure, tmp_path / "x.png")


def test_a_network_in_pieces(tmp_path: Path) -> None:
    nodes = {f"n{i}": {"heat_capacity": "1 kJ/K"} for i in range(9)} | {"room": {"temperature": "20 degC"}}
    links = {
        f"skin {i}": {"kind": "convection", "between": [f"n{i}", "room"], "conductance": "1 W/K"} for i in range(9)
    }
    machine = machine_of(nodes=nodes, links=links, sources=None, tcp=None, sensors=None)
    figure = network_figure(machine)
    squares = [p for p in figure.axes[0].patches if isinstance(p, Rectangle)]
    assert len(squares) == 2, "a node that touches much is drawn more than once"
    names = [text for text in words(figure) if text == "room"]
    assert len(names) == 2
    check_legible(figure, tmp_path / "x.png")


def test_a_closed_loop_shows_its_capacity_flow() -> None:
    nodes = {"a": {"heat_capacity": "1 kJ/K"}, "b": {"heat_capacity": "2 kJ/K"}, "room": {"temperature": "20 degC"}}
    loop = {"kind": "advection", "through": ["a", "b", "a"], "capacity_flow": "30 W/K"}
    skin = {"kind": "convection", "between": ["b", "room"], "conductance": "1 W/K"}
    machine = machine_of(nodes=nodes, links={"loop": loop, "skin": skin}, sources=None, tcp=None, sensors=None)
    assert labels(network_figure(machine, run_of(machine)), "link:")["loop"].endswith("30.0 W/K")


def test_every_link_of_a_large_network_is_named_beside_its_line_or_below() -> None:
    root = Path(__file__).parents[1]
    machine = Machine.load(root / "machines" / "new_machine.yaml")
    for run in (None, simulate(machine, Scenario.load(root / "scenarios" / "new_machine_day.yaml"))):
        figure = network_figure(machine, run)
        told = " ".join(text.get_text() for text in figure.findobj(Text))
        assert all(name in told for name in machine.links) and "flow 350 W/K" in told
        keys = {key for key in re.findall(r"\(\d+\)", told) if f"{key} " in told}
        assert keys and all(told.count(key) == 2 for key in keys)


def test_a_relay_may_watch_a_held_node(tmp_path: Path) -> None:
    plain = thermostat().to_plain()
    cooler = {**plain["sources"]["the cooler"], "watches": "ambient"}
    figure = network_figure(machine_of(sources={**plain["sources"], "the cooler": cooler}))
    assert sum(dashes(line) != "None" for line in figure.axes[0].lines) == 1
    check_legible(figure, tmp_path / "x.png")


def test_the_same_network_gives_the_same_picture(mill: Machine, tmp_path: Path) -> None:
    pictures = [save(network_figure(mill), tmp_path / name).read_bytes() for name in ("a.png", "b.png")]
    assert pictures[0] == pictures[1]


# -- files and speed ------------------------------------------------------------------------------------------------
def test_pictures_are_written_whole_in_three_formats(mill: Machine, tmp_path: Path) -> None:
    figure = network_figure(mill)
    for name, start in {"a.png": b"\x89PNG", "a.svg": b"<?xml", "a.pdf": b"%PDF", "plain": b"\x89PNG"}.items():
        assert save(figure, tmp_path / name).read_bytes().startswith(start)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.pdf", "a.png", "a.svg", "plain"]
    with pytest.raises(Refused, match=r"is no picture that can be drawn; end it in \.png, \.svg, \.pdf"):
        save(figure, tmp_path / "a.jpeg")
    with pytest.raises(Refused, match="cannot be written"):
        save(figure, tmp_path / "nowhere" / "a.png")


def test_a_png_is_1200_pixels_wide(mill: Machine, tmp_path: Path) -> None:
    header = save(network_figure(mill), tmp_path / "a.png").read_bytes()[16:20]
    assert int.from_bytes(header, "big") == 1200


def test_matplotlib_is_loaded_with_the_first_figure_and_pyplot_never() -> None:
    code = (
        "import sys, network.report.files.pictures, network.report.words.words; "
        "assert 'matplotlib' not in sys.modules; "
        "from network.report.figures.canvas import new_figure; new_figure(2); "
        "assert 'matplotlib.pyplot' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.fixture(scope="module")
def long_run() -> Trajectory:
    machine = many_sensors(12)
    return run_of(
        machine,
        "80 h",
        "10 s",
        speed="6000 rpm",
        ambient={"sine": {"mean": "21 degC", "amplitude": "2 K", "period": "24 h"}},
    )


@pytest.mark.speed
@pytest.mark.parametrize("figure_of", [run_figure, contributions_figure, lambda run: network_figure(run.machine, run)])
def test_figures_of_28801_samples_are_quick(figure_of: Any, long_run: Trajectory) -> None:
    assert len(long_run.t) == 28_801
    assert min(_seconds(figure_of, long_run) for _ in range(3)) < 0.7


@pytest.mark.speed
def test_a_comparison_of_28801_samples_is_quick(long_run: Trajectory) -> None:
    residual = residual_of(long_run.machine, recording_of(long_run))
    assert min(_seconds(comparison_figure, residual) for _ in range(3)) < 0.7


def test_a_comparison_of_many_samples_draws_few_points(long_run: Trajectory) -> None:
    residual = residual_of(long_run.machine, recording_of(long_run))
    lines = [line for axes in comparison_figure(residual).axes for line in axes.lines]
    assert max(len(line.get_xdata()) for line in lines) <= MOST_POINTS


def _seconds(draw: Any, *arguments: Any) -> float:
    began = time.process_time()
    draw(*arguments)
    return time.process_time() - began


@pytest.mark.skipif(not SHARED.is_dir(), reason="the folder shared/ is not beside this repository")
@pytest.mark.parametrize("case", ["a-cooler", "c-windage"])
@pytest.mark.parametrize("lumps", [1, 5])
def test_shared_cases_are_legible(case: str, lumps: int, tmp_path: Path) -> None:
    machine = Machine.load(SHARED / case / "machine.yaml", lumps=[lumps])
    recording = Recording.load(SHARED / case / "train1.csv")
    run = simulate(machine, recording)
    figures = [run_figure(run), contributions_figure(run), network_figure(machine), network_figure(machine, run)]
    figures.append(comparison_figure(residual_of(machine, recording)))
    for i, figure in enumerate(figures):
        check_legible(figure, tmp_path / f"{i}.png")
    assert set(labels(figures[3], "link:")) == set(machine.links)


def test_the_legend_shows_no_size_twice() -> None:
    parts = {name: {"heat_capacity": "389 J/K"} for name in ("left", "right", "base")}
    parts["ambient"] = {"temperature": "ambient"}
    skins = {n: {"kind": "convection", "between": [n, "ambient"], "conductance": "1 W/K"} for n in list(parts)[:3]}
    assert len(examples(machine_of(nodes=parts, links=skins, sources={}, tcp={}, sensors={}))) == 1
    assert len(examples(machine_of())) == 2
