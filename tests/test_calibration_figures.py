"""Figures of a calibration: before and after, what is left, shifts of parameters, posterior bands."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from network.analysis.comparison.channel_residual import ChannelResidual
from network.analysis.comparison.compare import RecordingResidual, compare
from network.engine.simulation import simulate
from network.machine.machine import Machine
from network.platform.refusal import Spot
from network.platform.yaml.document import tree_of
from network.recordings.columns import Column
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario
from network.report.figures.calibration_figure import band_figure, shift_figure
from network.report.figures.canvas import PALETTE, save
from network.report.figures.fit_figure import fit_figure
from network.report.figures.residual_figure import residual_figure

BLUE, ORANGE = PALETTE[0], PALETTE[1]


def machine_of(skin: str) -> Machine:
    tree = {
        "machine": "Test mill",
        "reference": "22 degC",
        "nodes": {
            "shaft": {"heat_capacity": "2 kJ/K"},
            "bed": {"material": "steel", "length": "500 mm", "area": "50 cm^2"},
            "ambient": {"temperature": "ambient"},
        },
        "links": {
            "bearing": {"kind": "conduction", "between": ["shaft", "bed"], "conductance": "6 W/K"},
            "skin": {"kind": "convection", "between": ["bed", "ambient"], "conductance": skin},
        },
        "sources": {"friction": {"kind": "bearing_friction", "into": {"shaft": 1}, "torque": "300 N mm"}},
        "tcp": {"z": {"bed grows": {"kind": "stretching", "of": "bed", "length": "300 mm", "direction": -1}}},
        "sensors": {
            "T_shaft": {"measures": "shaft", "noise": "0.05 K"}, "T_bed": {"measures": "bed", "noise": "0.05 K"},
            "dz": {"measures": "tcp.z", "noise": "0.25 um"},
        },
    }  # fmt: skip
    return Machine.read(tree_of(tree, Spot("test")), "test")  # type: ignore[arg-type]


def laid(duration: str, step: str) -> tuple[RecordingResidual, RecordingResidual]:
    """Before: with half the convection; after: with what made the recording."""
    true = machine_of("8 W/K")
    inputs = {"speed": [{"for": "1 h", "at": "6000 rpm"}, {"at": "0 rpm"}], "ambient": "21 degC"}
    run = simulate(true, Scenario.of("steps", duration, inputs, output=step, start="22 degC"))
    draw = np.random.default_rng(1)
    columns = {name: Column(name, run.schedule.signals[name].unit, values) for name, values in run.inputs.items()}
    for name, values in run.sensors.items():
        sensor = true.sensors[name]
        columns[name] = Column(name, sensor.unit, values + sensor.sigma * draw.standard_normal(len(values)))
    recording = Recording("morning", "morning.csv", run.t, columns)
    before, after = (compare(m, recording, start=Start(others=22.0)) for m in (machine_of("4 W/K"), true))
    return before.recordings[0], after.recordings[0]


@pytest.fixture(scope="module")
def pair() -> tuple[RecordingResidual, RecordingResidual]:
    return laid("4 h", "10 s")


def texts_of(figure: Figure) -> list[Any]:
    """Every text that is drawn, tick labels and names of axes included."""
    figure.canvas.draw()
    texts = list(figure.texts)
    for axes in figure.axes:
        texts += [*axes.texts, *(axis.label for axis in (axes.xaxis, axes.yaxis) if axis.get_visible())]
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            for tick in axis.get_major_ticks() if axis.get_visible() else ():
                if low <= tick.get_loc() <= high and tick.label1.get_visible():
                    texts.append(tick.label1)
    return [text for text in texts if text.get_visible() and text.get_text().strip()]


def check_legible(figure: Figure, path: Path) -> None:
    """No text on another, none beyond the paper, and it can be written."""
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    boxes = [(text.get_text(), text.get_window_extent(renderer)) for text in texts_of(figure)]
    clashes = [(a, b) for (a, one), (b, two) in combinations(boxes, 2) if one.padded(-1.5).overlaps(two.padded(-1.5))]
    assert not clashes
    paper = figure.bbox.padded(1)
    beyond = [t for t, box in boxes if not (paper.x0 <= box.x0 and box.x1 <= paper.x1 and paper.y0 <= box.y0)]
    assert not beyond
    assert save(figure, path).stat().st_size > 5000


def headlines(figure: Figure) -> list[str]:
    return [axes.texts[0].get_text() for axes in figure.axes if axes.texts]


def line_of(axes: Any, colour: str) -> Any:
    return next(line for line in axes.lines if line.get_color() == colour)


# -- before and after -----------------------------------------------------------------------------------------------
def test_a_fit_shows_both_runs_the_worst_channel_first(
    pair: tuple[RecordingResidual, RecordingResidual], tmp_path: Path
) -> None:
    before, after = pair
    figure = fit_figure(before, after, "Test mill: morning")
    worst = max(before.channels.values(), key=lambda channel: channel.rmse_in_noise)
    told = headlines(figure)[0]
    assert told.startswith(f"{worst.name}: rmse {worst.rmse_in_noise:.3g} → 0.9") or "→ 1" in told
    heights = [axes.get_position().height for axes in figure.axes[:-2:2]]
    assert heights == sorted(heights, reverse=True) and heights[0] > 1.2 * heights[-1]
    given = after.channels[worst.name]
    for colour, channel in ((ORANGE, worst), (BLUE, given)):
        line = line_of(figure.axes[0], colour)
        scale = 1e6 if channel.unit == "um" else 1.0
        np.testing.assert_allclose(line.get_ydata()[-1], channel.simulated[-1] * scale)
        np.testing.assert_allclose(line_of(figure.axes[1], colour).get_ydata()[-1], channel.in_noise[-1])
    assert f"{before.rmse_in_noise:.3g} → {after.rmse_in_noise:.3g} σ" in figure.texts[1].get_text()
    assert figure.axes[1].get_yscale() == "symlog" and figure.axes[1].get_ylim()[1] >= 4
    check_legible(figure, tmp_path / "x.png")


def test_a_constant_error_that_only_one_of_both_has_moves_its_line(
    pair: tuple[RecordingResidual, RecordingResidual],
) -> None:
    """Readings are drawn once: a line that was compared with others keeps its distance from them."""
    before, after = pair
    offset = {n: replace(c, measured=c.measured + 0.4 * c.sigma) for n, c in before.channels.items()}
    plain, moved = (fit_figure(b, after, "x").axes[0] for b in (before, replace(before, channels=offset)))
    worst = max(offset.values(), key=lambda channel: channel.rmse_in_noise)
    given = 1e6 if worst.unit == "um" else 1.0
    down = line_of(plain, ORANGE).get_ydata()[5] - line_of(moved, ORANGE).get_ydata()[5]
    assert down == pytest.approx(0.4 * worst.sigma * given, rel=1e-3)


def test_the_held_out_recording_is_drawn_larger(
    pair: tuple[RecordingResidual, RecordingResidual], tmp_path: Path
) -> None:
    small, large = fit_figure(*pair, "x"), fit_figure(*pair, "x", large=True)
    assert large.get_size_inches()[1] > 1.15 * small.get_size_inches()[1]
    check_legible(large, tmp_path / "x.png")


def test_gaps_and_empty_channels_do_no_harm(pair: tuple[RecordingResidual, RecordingResidual], tmp_path: Path) -> None:
    def torn(residual: RecordingResidual) -> RecordingResidual:
        channels = dict(residual.channels)
        holed = np.where((residual.trajectory.t > 3000) & (residual.trajectory.t < 5000), np.nan, 1.0)
        channels["T_bed"] = replace(channels["T_bed"], measured=channels["T_bed"].measured * holed)
        channels["dz"] = replace(channels["dz"], measured=channels["dz"].measured * np.nan)
        return replace(residual, channels=channels)

    before, after = torn(pair[0]), torn(pair[1])
    figure = fit_figure(before, after, "torn")
    assert "dz: no readings" in headlines(figure)
    check_legible(figure, tmp_path / "x.png")
    left = residual_figure(before, after)
    assert len(left.axes) == 4
    check_legible(left, tmp_path / "x.png")


# -- what is left ---------------------------------------------------------------------------------------------------
def test_what_is_left_stands_against_white_noise(
    pair: tuple[RecordingResidual, RecordingResidual], tmp_path: Path
) -> None:
    figure = residual_figure(*pair)
    lags, powers = figure.axes[0], figure.axes[1]
    assert len(figure.axes) == 6 and [axes.get_ylabel() for axes in figure.axes[:2]] == ["r [–]", "[σ²]"]
    assert figure.axes[-2].get_xlabel() == "lag [min]" and figure.axes[-1].get_xlabel() == "period [min]"
    after, before = line_of(lags, BLUE).get_ydata(), line_of(lags, ORANGE).get_ydata()
    n = pair[1].channels["T_shaft"].n
    assert after[0] == before[0] == 1 and np.mean(np.abs(after[1:200]) < 1.96 / np.sqrt(n)) > 0.88
    assert before[1] > 0.9
    np.testing.assert_allclose(np.median(line_of(powers, BLUE).get_ydata()), 1.0, rtol=0.25)
    check_legible(figure, tmp_path / "x.png")


def test_the_band_of_the_spectrum_holds_19_of_20(pair: tuple[RecordingResidual, RecordingResidual]) -> None:
    residual, draw, inside = pair[1], np.random.default_rng(5), []
    channels = {}
    for k in range(12):
        noise = draw.standard_normal(len(residual.trajectory.t))
        channels[f"c{k}"] = ChannelResidual(f"c{k}", "K", residual.trajectory.t, noise, 0 * noise, 1.0)
    figure = residual_figure(*[replace(residual, channels=channels)] * 2)
    for axes in figure.axes[1::2]:
        period, power = line_of(axes, BLUE).get_data()
        corners = axes.collections[0].get_paths()[0].vertices
        for x, y in zip(period, power, strict=True):
            ends = corners[np.isclose(corners[:, 0], x), 1]
            inside.append(ends.min() <= y <= ends.max())
    assert 0.91 < np.mean(inside) < 0.985


# -- shifts and bands -----------------------------------------------------------------------------------------------
def test_shifts_are_sorted_and_far_ones_marked(tmp_path: Path) -> None:
    names = [f"links.part {k}.conductance" for k in range(6)]
    shift, std = np.array([0.1, -2.5, 0.4, 3.0, -1.0, 0.0]), np.array([0.2, 0.3, np.nan, 0.1, 0.9, 1.0])
    figure = shift_figure(names, shift, std)
    axes = figure.axes[0]
    order = [names[k] for k in (3, 1, 4, 2, 0, 5)]
    assert [tick.get_text() for tick in axes.get_yticklabels()] == order
    assert [text.get_text() for text in axes.texts][:3] == ["+3.00 ± 0.10", "−2.50 ± 0.30", "−1.00 ± 0.90"]
    assert "+0.40, at its bound" in [text.get_text() for text in axes.texts]
    marked = [line for line in axes.lines if line.get_marker() == "D"]
    assert len(marked) == 2 and all(line.get_color() == ORANGE for line in marked)
    assert "2 of 6 moved by more than twice their ±: links.part 3.conductance" in figure.texts[1].get_text()
    assert sorted(float(line.get_xdata()[0]) for line in axes.lines if len(set(line.get_xdata())) == 1 and
                  line.get_linestyle() == "--") == [-2, 2]  # fmt: skip
    check_legible(figure, tmp_path / "x.png")


@pytest.mark.parametrize("count", [0, 1, 40])
def test_few_and_many_parameters(count: int, tmp_path: Path) -> None:
    draw = np.random.default_rng(0)
    names = [f"sources.a friction with quite a long name {k}.reference_temperature" for k in range(count)]
    figure = shift_figure(names, 6 * draw.standard_normal(count), draw.uniform(0, 1, count))
    check_legible(figure, tmp_path / "x.png")


def test_a_band_holds_95_percent_in_its_unit(tmp_path: Path) -> None:
    t = np.arange(0, 7200, 10.0)
    centre, std = 40e-6 * np.exp(-t / 2000), np.full(len(t), 1e-6)
    measured = centre + 1.5e-6 * np.sin(t / 300)
    measured[100:140] = np.nan
    figure = band_figure(t, centre, std, measured, "um", "tcp.z", 0.947)
    values, apart = figure.axes
    assert values.get_ylabel() == "tcp.z [µm]" and apart.get_ylabel() == "measured − mean [µm]"
    np.testing.assert_allclose(line_of(values, BLUE).get_ydata()[0], 40.0)
    edges = apart.collections[0].get_paths()[0].vertices[:, 1]
    np.testing.assert_allclose([edges.min(), edges.max()], [-1.96, 1.96], rtol=1e-4)
    assert "±1.96 µm at most" in figure.texts[1].get_text() and "94.7 % of it" in figure.texts[1].get_text()
    check_legible(figure, tmp_path / "x.png")
    bare = band_figure(t, centre + 20, std, None, "degC", "T_bed")
    assert bare.axes[0].get_ylabel() == "T_bed [°C]" and bare.axes[1].get_ylabel() == "measured − mean [K]"
    check_legible(bare, tmp_path / "y.png")


# -- speed ----------------------------------------------------------------------------------------------------------
@pytest.mark.speed
@pytest.mark.parametrize("figure_of", [lambda pair: fit_figure(*pair, "x"), lambda pair: residual_figure(*pair)])
def test_figures_of_28801_samples_are_quick(figure_of: Callable[[Any], Figure]) -> None:
    long, seconds = laid("80 h", "10 s"), []
    for _ in range(3):
        began = time.process_time()
        figure_of(long)
        seconds.append(time.process_time() - began)
    assert min(seconds) < 0.9
