"""Tests of residuals against what is known of noise, drift, periods and drivers made here with other means."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy import signal, stats

from network.analysis.comparison.candidate_drivers import lag_series
from network.analysis.comparison.channel_residual import ChannelResidual
from network.analysis.comparison.compare import Comparison, RecordingResidual, compare
from network.analysis.comparison.cycles import cycles_by_regime
from network.analysis.comparison.drivers import correlation, probability
from network.analysis.comparison.examine import ChannelTests
from network.analysis.comparison.lags import autocorrelations, independent
from network.analysis.comparison.periodicity import Periodicity, periodicity
from network.analysis.comparison.resample import Grid, fill_gaps
from network.analysis.comparison.sentences import telling
from network.analysis.comparison.speed_levels import Regimes, cluster
from network.analysis.comparison.whiteness import Whiteness, cumulative_distance, kolmogorov, ljung_box, whiteness
from network.engine.simulation import simulate
from network.engine.trajectory import Trajectory
from network.machine.machine import Machine
from network.platform.refusal import Spot
from network.platform.yaml.document import tree_of
from network.recordings.columns import Column
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario
from network.report.words.words import tell_worst

STEP = 10.0


def autoregressive(rho: float, shape: tuple[int, int], seed: int = 0) -> np.ndarray[Any, Any]:
    """AR(1) of variance 1 in every row."""
    noise = np.random.default_rng(seed).standard_normal(shape) * np.sqrt(1 - rho**2)
    noise[:, 0] /= np.sqrt(1 - rho**2)
    return np.asarray(signal.lfilter([1], [1, -rho], noise, axis=1))


def white(shape: tuple[int, int], seed: int = 1) -> np.ndarray[Any, Any]:
    return np.random.default_rng(seed).standard_normal(shape)


def channel(values: np.ndarray[Any, Any], sigma: float = 1.0, unit: str = "K") -> ChannelResidual:
    t = STEP * np.arange(len(values))
    return ChannelResidual("T", unit, t, values * sigma, np.zeros(len(values)), sigma)


def judged(rows: np.ndarray[Any, Any]) -> list[Whiteness]:
    values, there = fill_gaps(rows)
    r, pairs = autocorrelations(values, there)
    found = [whiteness(channel(row), values[k], r[k], pairs[k], STEP) for k, row in enumerate(rows)]
    return [w for w in found if w is not None]


def periods(rows: np.ndarray[Any, Any], sigma: float = 1.0) -> list[Periodicity | None]:
    values, there = fill_gaps(rows)
    return [periodicity("T", "K", sigma, v, mask, STEP) for v, mask in zip(values, there, strict=True)]


def holes(rows: np.ndarray[Any, Any], share: float = 0.15) -> np.ndarray[Any, Any]:
    """A long gap in every row and single ones all over."""
    gaps = np.random.default_rng(9).random(rows.shape) < share
    gaps[:, 300:380] = True
    return np.where(gaps, np.nan, rows)


# -- whiteness ------------------------------------------------------------------------------------------------------
NOISES: dict[str, Callable[[np.ndarray[Any, Any]], np.ndarray[Any, Any]]] = {
    "plain": lambda x: x, "with gaps": holes, "rounded to 2 sigma": lambda x: np.round(x / 2) * 2,
    "skew": lambda x: np.exp(0.5 * x),
}  # fmt: skip


@pytest.mark.parametrize("kind", NOISES)
def test_white_noise_is_called_something_else_at_the_nominal_rate(kind: str) -> None:
    found = judged(NOISES[kind](white((600, 1081))))
    wrong = np.mean([not w.is_white for w in found])
    assert 0.02 < wrong < 0.08, "nominal 0.05, standard error 0.009"


def test_ljung_box_is_that_of_the_book_without_gaps() -> None:
    (row,) = white((1, 300))
    x = row - row.mean()
    rho = np.array([x[k:] @ x[: len(x) - k] for k in range(11)]) / (x @ x)
    q = 300 * 302 * sum(rho[k] ** 2 / (300 - k) for k in range(1, 11))
    r, pairs = autocorrelations(*fill_gaps(row[None]))
    assert ljung_box(r[0, :11], pairs[0, :11]) == pytest.approx(q, rel=1e-9)


def test_autocorrelations_with_gaps_are_those_of_the_pairs() -> None:
    values, there = fill_gaps(holes(autoregressive(0.8, (1, 600))))
    r, pairs = autocorrelations(values, there)
    for lag in (1, 7, 100):
        both = (there[0, lag:] * there[0, :-lag]).astype(bool)
        mean = (values[0, lag:] * values[0, :-lag])[both].mean()
        assert pairs[0, lag] == both.sum()
        assert r[0, lag] == pytest.approx(mean / (values[0] ** 2).sum() * there[0].sum(), abs=1e-9)


def test_the_probability_of_a_distance_is_kolmogorovs() -> None:
    for distance in (0.03, 0.05, 0.08):
        assert kolmogorov(distance, 400) == pytest.approx(stats.kstwo.sf(distance, 399), abs=0.01)
    assert kolmogorov(0.0, 400) == 1.0


def test_the_cumulative_periodogram_of_a_sine_is_a_step() -> None:
    assert cumulative_distance(np.sin(2 * np.pi * 30 * np.arange(1000) / 1000)) == pytest.approx(1 - 29 / 499, abs=0.01)


@pytest.mark.parametrize("rho", [0.3, 0.9, 0.999])
def test_coloured_noise_is_not_white_and_lasts(rho: float) -> None:
    found = judged(autoregressive(rho, (60, 1081)))
    assert not any(w.is_white for w in found)
    if rho == 0.9:
        assert np.mean([w.lasting for w in found]) == pytest.approx(STEP * (1 + 1 / -np.log(rho)), rel=0.2)
        assert "not white noise" in found[0].sentence


def test_white_noise_that_is_not_as_declared_says_so() -> None:
    values = 2 * white((1, 800))[0] + 5
    r, pairs = autocorrelations(*fill_gaps(values[None]))
    found = whiteness(channel(values, 0.05), fill_gaps(values[None])[0][0], r[0], pairs[0], STEP)
    assert found is not None
    assert found.sentence.startswith("T: residuals look like white noise of 0.09") or "of 0.10" in found.sentence
    assert "instead of 0.0500 K around +0.2" in found.sentence


# -- periods --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9, 0.99, 0.999, 0.9999])
@pytest.mark.parametrize("noise", [0.0, 0.3, 3.0])
def test_drift_is_not_called_periodic(rho: float, noise: float) -> None:
    rows = autoregressive(rho, (150, 1081)) * 3 + noise * white((150, 1081))
    assert sum(found is not None for found in periods(rows)) <= 2, "nominal 1 in 10 000"


def test_steps_that_settle_are_not_periodic() -> None:
    draw, t = np.random.default_rng(2), np.arange(1081.0)
    rows = white((200, 1081))
    for row in rows:
        for begin, tau in zip(draw.integers(0, 1081, 6), draw.uniform(20, 200, 6), strict=True):
            row += 5 * draw.normal() * -np.expm1(-np.maximum(t - begin, 0) / tau)
    assert sum(found is not None for found in periods(rows)) <= 5


def test_warming_up_is_not_periodic() -> None:
    t = np.arange(1081) * STEP
    rows = np.stack([20 * np.exp(-t / tau) + 8 * (1 - np.exp(-t / 5000)) for tau in np.geomspace(100, 1e4, 60)])
    assert not any(periods(rows + white((60, 1081))))


@pytest.mark.parametrize("period", [45.0, 233.0, 1380.0, 2400.0])
def test_a_swing_is_found_with_its_period_and_size(period: float) -> None:
    t = np.arange(1441) * STEP
    found = periods(4 * np.sin(2 * np.pi * t / period + 1.0) + autoregressive(0.9, (20, 1441)), sigma=0.05)
    assert all(found)
    assert [f.period for f in found if f] == pytest.approx([period] * 20, rel=0.02)
    assert [f.amplitude for f in found if f] == pytest.approx([0.2] * 20, rel=0.15)


def test_a_swing_is_found_through_gaps_and_rounding() -> None:
    t = np.arange(1441) * STEP
    row = np.round(2 * np.sin(2 * np.pi * t / 1380) + white((1, 1441)))
    (found,) = periods(holes(row))
    assert found is not None and found.period == pytest.approx(1380, rel=0.02)
    assert found.sentence.startswith("T swings by ±") and re.search(
        r"with a period of 2[23][.\d]* min$", found.sentence
    )


def test_a_period_that_changes_with_the_speed_is_told() -> None:
    n, which = 2881, np.repeat([0, 1], [1440, 1441])
    phase = np.cumsum(2 * np.pi * STEP / np.where(which == 0, 1080.0, 1620.0))
    row = 5 * np.sign(np.sin(phase)) + white((1, n))[0]
    regimes = Regimes("speed", "rpm", (0.0, 8000 * 2 * np.pi / 60), which)
    (found,) = periods(row[None])
    assert found is not None
    slow, fast = cycles_by_regime(row, STEP, found.period, regimes)
    assert slow.period == pytest.approx(1080, rel=0.05) and fast.period == pytest.approx(1620, rel=0.05)
    told = replace(found, by_regime=(slow, fast)).sentence
    assert "min at standstill, 27" in told and told.endswith("min at 8000 rpm)")


def test_a_period_that_stays_is_told_once() -> None:
    which = np.repeat([0, 1], [1440, 1441])
    row = 5 * np.sin(2 * np.pi * np.arange(2881) * STEP / 1200) + white((1, 2881))[0]
    assert cycles_by_regime(row, STEP, 1200, Regimes("speed", "rpm", (0.0, 100.0), which)) == ()


# -- drivers --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("rho", [0.0, 0.9, 0.99, 0.999])
def test_strangers_are_called_related_no_more_often_than_said(rho: float) -> None:
    x, z = autoregressive(rho, (40, 1081), 1), autoregressive(rho, (40, 1081), 2)
    (v, v_there), (w, w_there) = fill_gaps(x), fill_gaps(z)
    r, pairs = correlation(v, v_there, w, w_there)
    worth = independent(autocorrelations(v, v_there)[0], autocorrelations(w, w_there)[0], pairs)
    chance = probability(r, worth)
    assert np.mean(chance < 0.05) < 0.08 and np.mean(chance < 0.001) < 0.004


def test_independent_samples_are_bartletts() -> None:
    """n (1 − ρ²)/(1 + ρ²) for two AR(1) series of the same ρ."""
    v, there = fill_gaps(autoregressive(0.9, (40, 4000)))
    r, _ = autocorrelations(v, there)
    worth = independent(r, r, np.full((40, 40), 4000.0))
    assert np.median(worth) == pytest.approx(4000 * (1 - 0.81) / (1 + 0.81), rel=0.1)


def test_correlations_with_gaps_are_those_of_common_samples() -> None:
    a, b = holes(white((1, 500), 3)), holes(white((1, 500), 4))[:, ::-1] + np.nan_to_num(a_part := white((1, 500), 3))
    both = np.isfinite(a[0]) & np.isfinite(b[0])
    (v, v_there), (w, w_there) = fill_gaps(a), fill_gaps(b)
    r, pairs = correlation(v, v_there, w, w_there)
    assert pairs[0, 0] == both.sum() and a_part.shape == (1, 500)
    assert r[0, 0] == pytest.approx(np.corrcoef(a[0, both], b[0, both])[0, 1], abs=0.02)


def test_a_lag_is_that_of_a_first_order_filter() -> None:
    x = np.repeat([0.0, 5.0, 1.0], 400)
    (y,) = lag_series(x, STEP, [600.0])
    decay = np.exp(-STEP / 600)
    exact = signal.lfilter([1 - decay], [1, -decay], x)
    np.testing.assert_allclose(y[5:-5], exact[5:-5], atol=0.06)


# -- levels of the speed --------------------------------------------------------------------------------------------
def test_speeds_are_clustered_into_standing_still_and_levels() -> None:
    speed = np.repeat([0.0, 3000, 3010, 8000, 12000], [100, 200, 200, 300, 50])
    levels, which = cluster(speed)
    assert levels == pytest.approx((0.0, 3005, 8000, 12000))
    assert np.bincount(which).tolist() == [100, 400, 300, 50]


def test_a_speed_that_never_rests_gets_six_levels_at_most() -> None:
    levels, _ = cluster(np.concatenate([np.zeros(400), np.linspace(500, 9000, 5000)]))
    assert 5 <= len(levels) <= 7 and levels[0] == 0 and list(levels) == sorted(levels)
    assert cluster(np.repeat([0.0, 5000, 8000], [1000, 5, 1000]))[1].min() == -1, "too short to count"


def test_uneven_samples_are_laid_on_even_steps() -> None:
    even = Grid.of(np.arange(50) * 10.0)
    assert even.is_identity and even.step == 10
    t = np.concatenate([np.arange(20) * 10.0, 400 + np.arange(40) * 10.0, [791.0]])
    grid = Grid.of(t)
    assert grid.n == 80 and np.isnan(grid.put(t)[25:35]).all() and grid.put(t)[79] == pytest.approx(790.5)
    assert grid.hold(t)[30] == 190
    assert Grid.of(np.arange(200_000) * 1.0).n <= 65536


def test_as_many_short_steps_as_long_ones_are_no_even_grid() -> None:
    """Their median is their mean, so there are as many steps as samples; each still stands where it was read."""
    t = np.concatenate([[0.0], np.cumsum([10.0] * 100 + [40.0] * 100)])
    grid = Grid.of(t)
    assert not grid.is_identity
    placed = grid.put(t)
    there = np.isfinite(placed)
    np.testing.assert_allclose(placed[there], grid.t[there], atol=grid.step / 2)


def test_each_step_takes_as_many_of_shorter_ones() -> None:
    t = np.concatenate([np.arange(0.0, 4000.0, 10.0), np.arange(4000.0, 40_000.0, 40.0)])
    counts = np.bincount(Grid.of(t).index)[1:99]
    assert (counts == 4).all()


def test_white_noise_is_told_of_samples_and_not_of_their_means() -> None:
    t = np.concatenate([np.arange(0.0, 4000.0, 10.0), np.arange(4000.0, 40_000.0, 40.0)])
    noise = white((1, len(t)))
    grid = Grid.of(t)
    values, there = fill_gaps(grid.put(noise[0])[None])
    r, pairs = autocorrelations(values, there)
    found = whiteness(channel(noise[0]), values[0], r[0], pairs[0], grid.step)
    assert found is not None and found.scatter == pytest.approx(1.0, rel=0.05)


# -- a whole recording ----------------------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def mill() -> Machine:
    tree = {
        "machine": "Test mill",
        "reference": "22 degC",
        "nodes": {
            "shaft": {"heat_capacity": "2 kJ/K"}, "bed": {"heat_capacity": "9 kJ/K"},
            "ambient": {"temperature": "ambient"},
        },
        "links": {
            "bearing": {"kind": "conduction", "between": ["shaft", "bed"], "conductance": "6 W/K"},
            "skin": {"kind": "convection", "between": ["bed", "ambient"], "conductance": "8 W/K"},
        },
        "sources": {"friction": {"kind": "bearing_friction", "into": {"shaft": 1}, "torque": "300 N mm"}},
        "sensors": {
            "T_shaft": {"measures": "shaft", "noise": "0.05 K"}, "T_bed": {"measures": "bed", "noise": "0.05 K"},
            "T_skin": {"measures": "bed", "noise": "0.1 K"},
        },
    }  # fmt: skip
    return Machine.read(tree_of(tree, Spot("test")), "test")  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def run(mill: Machine) -> Trajectory:
    speeds = [{"for": "20 min", "at": f"{rpm} rpm"} for rpm in (6000, 0, 3000, 6000, 0, 6000, 3000, 0) * 3]
    scenario = Scenario.of("steps", "8 h", {"speed": speeds, "ambient": "21 degC"}, output="10 s", start="22 degC")
    return simulate(mill, scenario)


def laid_beside(run: Trajectory, added: dict[str, Any], seed: int = 3, **more: Column) -> RecordingResidual:
    """The run's own channels with noise, and what is added to them [K], compared to the run."""
    draw = np.random.default_rng(seed)
    columns = {name: Column(name, run.schedule.signals[name].unit, values) for name, values in run.inputs.items()}
    for name, values in run.sensors.items():
        noise = run.machine.sensors[name].sigma * draw.standard_normal(len(values))
        columns[name] = Column(name, "degC", values + noise + added.get(name, 0.0))
    recording = Recording("shift", "shift.csv", run.t, {**columns, **more})
    return compare(run.machine, recording, start=Start(others=22.0)).recordings[0]


def noisy(cleaned: RecordingResidual, added: Any) -> dict[str, Column]:
    """T_bed with what is added to the run."""
    column = cleaned.recording.columns["T_bed"]
    draw = np.random.default_rng(4).standard_normal(len(column.values))
    return {"T_bed": replace(column, values=cleaned.channels["T_bed"].simulated + 0.05 * draw + added)}


def test_results_show_themselves_at_the_prompt(mill: Machine, run: Trajectory) -> None:
    """Also what holds entries stacked to arrays, as networks do."""
    assert "bearing" in repr(run.network) and len(repr(run.network)) > 100
    assert repr(Comparison(mill, (laid_beside(run, {}),))).startswith("<comparison of Test mill on 1")


def test_noise_alone_is_told_in_one_sentence(run: Trajectory) -> None:
    told = [telling(laid_beside(run, {}, seed).tests) for seed in range(12)]
    assert told.count(["All residuals look like white noise."]) >= 8


def test_a_few_readings_far_apart_are_told_and_the_rest_is_judged_without_them(run: Trajectory) -> None:
    spikes = np.zeros(len(run.t))
    spikes[100:2300:200] = 40.0 * (-1.0) ** np.arange(11)
    cleaned = laid_beside(run, {"T_bed": spikes})
    (aside,) = cleaned.recording.excluded or ()
    assert (aside.channel, aside.readings) == ("T_bed", 11) and abs(aside.size) == pytest.approx(40, abs=0.5)
    assert telling(cleaned.tests) == ["All residuals look like white noise."]
    as_it_is = replace(cleaned.recording, columns=cleaned.recording.columns | noisy(cleaned, spikes))
    residual = compare(run.machine, as_it_is, start=Start(others=22.0)).recordings[0]
    told = telling(residual.tests)
    assert told[0].startswith("T_bed: 11 readings lie up to 40 K apart from the rest, which is judged without them")
    assert "look like white noise" in told[1] and len(told) == 2
    assert residual.tests["T_bed"].whiteness is not None and residual.tests["T_bed"].whiteness.scatter < 0.06
    assert tell_worst(residual).startswith("Every channel agrees within its noise")


def test_slow_swings_steps_and_many_outliers_are_no_spikes(run: Trajectory) -> None:
    hours = run.t / 3600
    steps, often = np.where(hours > 3, 5.0, 0.0), np.where(np.arange(len(run.t)) % 20 == 0, 9.0, 0.0)
    for added in (3 * np.sin(6 * hours), steps, often):
        assert laid_beside(run, {"T_bed": added}).tests["T_bed"].spikes is None


def test_a_relay_is_told_with_its_period_and_company(run: Trajectory) -> None:
    square = 0.3 * signal.square(2 * np.pi * run.t / 1380 + 0.3)
    tests = laid_beside(run, {"T_shaft": square, "T_bed": 0.5 * square}).tests
    found = tests["T_shaft"].period
    assert found is not None and found.period == pytest.approx(1380, rel=0.02)
    told = telling(tests)
    assert told[0].startswith("T_shaft swings by ±0.3") and "23 min" in told[0] and told[0].endswith("so does T_bed.")
    assert any(s.startswith("T_shaft and T_bed are off together") for s in told)
    assert told[-1] == "T_skin: residuals look like white noise."


def test_the_speed_as_a_driver_is_told_and_no_period(run: Trajectory) -> None:
    (warm,) = lag_series(run.inputs["speed"], 10.0, [900.0])
    residual = laid_beside(run, {"T_bed": 0.002 * warm})
    tests = residual.tests["T_bed"]
    driver = tests.drivers[0]
    assert (driver.of, driver.form, driver.lag) == ("speed", "lagged", 900) and driver.r > 0.9
    assert driver.independent < 200 and driver.p < 1e-6
    assert tests.period is None, "what an input explains is no period of its own"
    assert telling(residual.tests)[0].startswith("T_bed follows speed with a lag of 15 min (r = 0.9")


def test_an_unused_column_is_named_as_the_driver(run: Trajectory) -> None:
    (door,) = (autoregressive(0.98, (1, len(run.t)), 5) > 0.5).astype(float)
    idle = white((1, len(run.t)), 8)[0]
    more = {"door": Column("door", "1", door), "idle": Column("idle", "W", idle)}
    residual = laid_beside(run, {"T_shaft": -0.2 * door}, **more)
    assert [d.of for d in residual.tests["T_shaft"].drivers] == ["door"]
    assert telling(residual.tests)[0].startswith("T_shaft runs against door (r = −0.")


def test_a_rate_of_change_is_named(run: Trajectory) -> None:
    flow = np.cumsum(autoregressive(0.97, (1, len(run.t)), 6)[0])
    residual = laid_beside(run, {"T_shaft": 0.3 * np.gradient(flow)}, flow=Column("flow", "W", flow))
    assert residual.tests["T_shaft"].drivers[0].words == "the rate of change of flow"


def test_levels_of_speed_that_differ_are_told(run: Trajectory) -> None:
    wild = 0.45 * white((1, len(run.t)), 7)[0] * (run.inputs["speed"] > 500)
    residual = laid_beside(run, {"T_bed": wild})
    regimes = residual.tests["T_bed"].regimes
    assert regimes is not None and regimes.differs and len(regimes.levels) == 3
    assert regimes.sentence.startswith("T_bed: rms 0.4") and "at 6000 rpm, 0.0" in regimes.sentence, regimes.sentence
    other = residual.tests["T_shaft"].regimes
    assert other is not None and not other.differs


def test_a_dead_a_frozen_and_an_empty_channel(run: Trajectory) -> None:
    residual = laid_beside(run, {"T_bed": np.nan, "T_skin": np.where(run.t < 200, 0.0, np.nan)})
    frozen = replace(residual.channels["T_shaft"], measured=residual.channels["T_shaft"].simulated)
    tests = replace(residual, channels={**residual.channels, "T_shaft": frozen}).tests
    assert "T_bed" not in tests and tests["T_skin"].whiteness is None
    assert tests["T_shaft"].whiteness is None and tests["T_shaft"].period is None and not tests["T_shaft"].drivers
    assert telling(tests) == []


def test_rounding_a_slope_makes_no_period(run: Trajectory) -> None:
    residual = laid_beside(run, {})
    channel = residual.channels["T_shaft"]
    slope = 0.5 * np.round((20 + 0.002 * run.t + 0.02 * white((1, len(run.t)))[0]) / 0.5)
    rounded = replace(channel, measured=slope, simulated=20 + 0.002 * run.t)
    assert periods(rounded.in_noise[None])[0] is not None, "a sawtooth it is"
    assert replace(residual, channels={"T_shaft": rounded}).tests["T_shaft"].period is None


def test_a_recording_of_three_samples(run: Trajectory) -> None:
    t = run.t[:3]
    columns = {name: Column(name, "degC", v[:3] + 0.01) for name, v in run.sensors.items()}
    columns |= {name: Column(name, run.schedule.signals[name].unit, v[:3]) for name, v in run.inputs.items()}
    comparison = compare(run.machine, Recording("short", "short.csv", t, columns), start=Start(others=22.0))
    assert "shift" not in str(comparison) and comparison.summary()["recordings"][0]["channels"]["T_bed"]["n"] == 3


def test_json_carries_the_tests_beside_the_contract(run: Trajectory) -> None:
    square = 0.3 * signal.square(2 * np.pi * run.t / 1380 + 0.3)
    residual = laid_beside(run, {"T_shaft": square})
    summary = Comparison(run.machine, (residual,)).summary()["recordings"][0]["channels"]["T_shaft"]
    assert list(summary) == ["rmse", "unit", "rmse_in_noise", "max", "n", "tests"]
    tests = summary["tests"]
    assert set(tests) == {"whiteness", "period", "regimes", "worst", "drivers", "companions"}
    assert tests["period"]["amplitude"] == pytest.approx(0.38, abs=0.03), "4/π of a square wave"
    assert not tests["whiteness"]["white"] and [level["level"] for level in tests["regimes"]["levels"]] == [
        0, pytest.approx(3000), pytest.approx(6000),
    ]  # fmt: skip


def test_sentences_are_few_and_end_with_a_stop(run: Trajectory) -> None:
    (warm,) = lag_series(run.inputs["speed"], 10.0, [900.0])
    added = {
        name: 0.002 * warm + np.sin(2 * np.pi * run.t / p)
        for name, p in zip(run.sensors, (600, 900, 1300), strict=True)
    }
    tests = laid_beside(run, added).tests
    told = telling(tests)
    assert 3 <= len(told) <= 5 and all(s.endswith(".") for s in told) and len(set(told)) == len(told)
    assert all(isinstance(t, ChannelTests) for t in tests.values())
    assert all(any((t.spikes, t.whiteness, t.period, *t.drivers, *t.companions)) for t in tests.values())


# -- speed ----------------------------------------------------------------------------------------------------------
@pytest.mark.speed
def test_eight_channels_of_28801_samples_are_quick(run: Trajectory) -> None:
    t = np.arange(28_801) * 10.0
    few = laid_beside(run, {})
    wide = replace(
        few.trajectory, t=t, inputs={name: np.resize(v, len(t)) for name, v in few.trajectory.inputs.items()}
    )
    noise = white((8, len(t)))
    channels = {f"c{k}": ChannelResidual(f"c{k}", "K", t, noise[k], np.zeros(len(t)), 1.0) for k in range(8)}
    residual = replace(few, trajectory=wide, channels=channels)
    seconds = []
    for _ in range(3):
        began = time.process_time()
        _ = replace(residual).tests
        seconds.append(time.process_time() - began)
    assert min(seconds) < 0.3


def test_nothing_of_it_is_loaded_with_the_package() -> None:
    code = (
        "import sys, network, network.analysis.comparison.compare; "
        "assert 'network.analysis.comparison.examine' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
