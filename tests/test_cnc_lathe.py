"""The CNC lathe's score: its grid and mask, what a prediction may see, and the ridge that it is measured against."""

from __future__ import annotations

import re
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
from bench import cnc_lathe_told as told
from bench.cnc_lathe_figures import Fold, Tell, folds, grid, miss, over_days, score, spread
from bench.cnc_lathe_pages import as_json, markdown
from bench.cnc_lathe_picture import Told
from bench.cnc_lathe_runs import CLIMATE_OF, CLIMATES, DISPLACEMENTS, FOLDER, INPUTS, MAPPING, Day, for_fit, runs
from bench.ridge import Run, fit_ridge, lagged

from network import Machine, Recording, compare
from network.catalogue.declaration.declare import Array
from network.recordings.recording import Column

here = pytest.mark.skipif(not FOLDER.is_dir(), reason="the recordings in ../shared/recordings are not here")
PREDICTIONS = {"written": told.as_written, "ridge": told.ridge_on_schedule, "nothing": told.nothing}


@cache
def days() -> tuple[Day, ...]:
    return runs()


def made(t: Array, speed: Array, x: Array, z: Array) -> Day:
    """A day by hand; x and z in µm."""
    values = {"speed": ("rad/s", speed), "feed": ("m/s", speed), "ambient": ("degC", 20 + 0 * t)}
    values |= {"T": ("degC", 20 + t / 100), "disp_x": ("um", x * 1e-6), "disp_z": ("um", z * 1e-6)}
    columns = {name: Column(name, unit, read) for name, (unit, read) in values.items()}
    return Day("0101", "none", Recording("made", "made.csv", t, columns))


def always(value: float) -> Tell:
    """Tells the same [µm] at all times."""
    return lambda day: np.full((len(day.recording.t), 2), value * 1e-6)


# -- figures --------------------------------------------------------------------------------------------------------
def test_the_grid_takes_the_last_sample_before_each_of_its_points() -> None:
    t = np.array([30.0, 100, 149, 151, 270, 389])  # points at 30, 150, 270
    assert grid(t).tolist() == [0, 2, 4]


def test_standstill_and_false_readings_do_not_count() -> None:
    t = 120.0 * np.arange(5)
    speed = np.array([1.0, 1, 1, 0, 0])
    day = made(t, speed, np.array([3.0, 3, 300, 50, 50]), np.array([-4.0, -4, -4, 60, 60]))
    found = miss(day, always(0)(day))
    assert found.absolute == pytest.approx([3, 4]) and found.mean_out == pytest.approx([0, 0])


def test_the_mean_is_taken_out_of_what_is_left_over() -> None:
    """Left over 1 and 5 µm: rms √13, 2 µm about their mean."""
    day = made(np.array([0.0, 120]), np.ones(2), np.array([2.0, 6]), np.array([0.0, 0]))
    found = miss(day, always(1)(day))
    assert found.absolute == pytest.approx([13**0.5, 1]) and found.mean_out == pytest.approx([2, 0])


def test_a_long_day_counts_as_much_as_a_short_one() -> None:
    both = [made(120.0 * np.arange(n), np.ones(n), np.full(n, x), np.zeros(n)) for n, x in ((2, 3.0), (50, 4.0))]
    found = over_days(score(lambda _: always(0), [Fold("all", tuple(both), ())]))
    assert found.absolute == pytest.approx([12.5**0.5, 0])


def test_training_runs_are_thinned_evenly() -> None:
    one = made(np.array([0.0, 1]), np.ones(2), np.zeros(2), np.zeros(2))
    some = [Day(str(k), "", one.recording) for k in range(9)]
    assert [day.name for day in spread(some, 3)] == ["0", "4", "8"] and len(spread(some, None)) == 9


def test_a_fit_is_given_no_frozen_displacement_and_every_switching() -> None:
    t = 40.0 * np.arange(20)
    speed = np.where((t > 200) & (t < 400), 1.0, 0)
    fit = for_fit(made(t, speed, np.arange(20.0), np.arange(20.0)))
    assert {240.0, 400.0} <= set(fit.t) and len(fit.t) < 12
    assert np.isfinite(fit.columns["disp_x"].values).tolist() == (np.interp(fit.t, t, speed) > 0).tolist()
    assert np.isfinite(fit.columns["T"].values).all()


def test_a_band_holds_for_the_share_of_readings_within_it() -> None:
    """Of four instants x counts at three, and one of these lies outside; z is told exactly."""
    measured = np.array([[0.0, 1], [5, 1], [np.nan, 1], [1, 1]])
    told = np.array([[0.0, 1]] * 4)
    day = made(np.zeros(4), np.ones(4), np.zeros(4), np.zeros(4))
    assert Told(day, np.zeros(4), measured, told, told - 2, told + 2).covered == pytest.approx([2 / 3, 1])


# -- ridge ----------------------------------------------------------------------------------------------------------
def test_lags_are_exact_at_any_spacing() -> None:
    """A step held from 0 on: 1 − e^(−t/τ). A ramp from 0: t − τ (1 − e^(−t/τ))."""
    t = np.array([0.0, 10, 400, 1000, 5000])
    step = lagged(t, np.ones((5, 1)), np.zeros(1), held=True, time_constants=[300])
    ramp = lagged(t, t[:, None], np.zeros(1), time_constants=[300])
    approach = 1 - np.exp(-t / 300)
    assert step[:, 1] == pytest.approx(approach) and ramp[:, 1] == pytest.approx(t - 300 * approach)
    assert step[:, 0].tolist() == [1] * 5


def test_ridge_recovers_a_known_linear_system() -> None:
    """Two inputs, lags of 15 and 135 min, noise of 0.1: told on a run that was left out to a tenth of its size."""
    rng = np.random.default_rng(1)
    t = np.arange(0, 6 * 3600, 120.0)
    made_of = []
    for _ in range(6):
        u = np.repeat(rng.integers(0, 3, size=(6, 2)), 30, axis=0).astype(float)
        F = lagged(t, u, np.zeros(2), held=True)
        y = np.stack([5 * F[:, 2] - 3 * F[:, 10], 4 * F[:, 4] + F[:, 6]], axis=1)
        made_of.append(Run(F, y + 0.1 * rng.standard_normal(y.shape)))
    fit = fit_ridge(made_of[:-1])
    left = fit.predict(made_of[-1].features) - made_of[-1].targets
    assert (np.sqrt(np.mean(left**2, axis=0)) < 0.13).all()


def test_ridge_leaves_out_what_is_not_known_and_what_never_moves() -> None:
    F = np.stack([np.arange(9.0), np.ones(9)], axis=1)
    y = np.where(np.arange(9)[:, None] == 4, np.nan, 2 * F[:, :1] + 1)
    assert fit_ridge([Run(F, y)], [1e-9]).predict(F)[4] == pytest.approx([9])


# -- the recordings -------------------------------------------------------------------------------------------------
@here
def test_climates_cover_all_runs_once() -> None:
    assert sorted(name for names in CLIMATES.values() for name in names) == [day.name for day in days()]
    left_out = [day.name for fold in folds(days(), "climate") for day in fold.left_out]
    assert sorted(left_out) == sorted(CLIMATE_OF)
    for fold in folds(days(), "climate"):
        assert fold.name not in {day.climate for day in fold.training}


@here
@pytest.mark.parametrize("name", [path.stem for path in sorted(FOLDER.glob("run_*.csv"))])
def test_the_mapping_serves_every_run_by_its_line_of_file_alone(name: str, tmp_path: Path) -> None:
    """As a user does it: the file is copied, one line of the mapping changed, and the machine told along it."""
    (tmp_path / f"{name}.csv").write_bytes((FOLDER / f"{name}.csv").read_bytes())
    lines = MAPPING.read_text(encoding="utf-8").splitlines()
    changed = [re.sub("^file: .*", f"file: {name}.csv", line) for line in lines]
    assert sum(a != b for a, b in zip(lines, changed, strict=True)) == 1
    (tmp_path / "run.yaml").write_text("\n".join(changed), encoding="utf-8")
    recording, machine = Recording.load(tmp_path / "run.yaml"), Machine.load(told.MACHINE)
    assert set(machine.sensors) | set(INPUTS) <= set(recording.columns) and recording.starts is False
    channels = compare(machine, recording).recordings[0].channels
    assert set(channels) == set(machine.sensors)
    assert all(channel.n > 200 and np.isfinite(channel.rmse_in_noise) for channel in channels.values())


@here
def test_each_day_is_left_out_once_and_told_from_all_others() -> None:
    for fold in folds(days(), "day"):
        assert len(fold.left_out) == 1 and len(fold.training) == len(days()) - 1
        assert fold.left_out[0] not in fold.training


@here
@pytest.mark.parametrize("name", PREDICTIONS)
def test_blanking_every_measurement_after_the_first_minute_changes_nothing(name: str) -> None:
    fold = Fold("some", days()[8:9], days()[:4])
    day, tell = fold.left_out[0], PREDICTIONS[name](fold)
    with_all, with_first = tell(day), tell(day.blanked())
    assert np.array_equal(with_all, with_first)
    assert np.isfinite(with_all).all() and with_all.shape == (len(day.recording.t), 2)


@here
def test_every_sixth_day_is_left_out_at_once() -> None:
    over = folds(days(), "sixth")
    assert [len(fold.left_out) for fold in over] == [4, 4, 4, 4, 3, 3]
    assert sorted(day.name for fold in over for day in fold.left_out) == [day.name for day in days()]
    assert all(day not in fold.training for fold in over for day in fold.left_out)


@here
def test_blanked_is_blank() -> None:
    day = days()[0].blanked()
    assert day.measurements[-2:] == DISPLACEMENTS and len(day.measurements) == 25
    assert np.isnan(day.values(*day.measurements)[~day.begins]).all()
    assert np.isfinite(day.values("speed", "feed", "ambient")).all()


@here
def test_temperatures_tell_nothing_of_the_displacement_that_they_did_not_see() -> None:
    """The ridge on temperatures reads them, and not the displacement that it is to tell."""
    fold = Fold("some", days()[8:9], days()[:4])
    tell, day = told.ridge_on_temperatures(fold), fold.left_out[0]
    assert np.array_equal(tell(day), tell(day.blanked(*day.temperatures)))
    assert not np.array_equal(tell(day), tell(day.with_values(day.temperatures, day.values(*day.temperatures) ** 1.1)))


@here
def test_ridges_beat_nothing_and_stand_in_the_table() -> None:
    over = folds(days(), "day")[::11]
    some = {"nothing": score(told.nothing, over), "ridge": score(told.ridge_on_schedule, over)}
    assert (over_days(some["ridge"]).absolute < 0.7 * over_days(some["nothing"]).absolute).all()
    text = markdown({"day": some}, days=True)
    assert text.count("| ridge") == len(over) + 1 and '"x_mean_out"' in as_json({"day": some})


@here
def test_a_kept_calibration_is_read_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fold = Fold("some", days()[1:2], days()[2:3])
    first = told.Machine.load(told.MACHINE)
    kept = tmp_path / f"{told.mark(fold.training, told.MACHINE)}.yaml"
    kept.write_text(told.dump(first.patched({"machine": "Kept"}).to_plain()), encoding="utf-8")
    monkeypatch.setattr(told, "calibrate", None)
    assert told.calibrated_machine(fold.training, resume=tmp_path).name == "Kept"
    tell = partial(told.calibrated, resume=tmp_path)(fold)
    assert np.array_equal(tell(days()[1]), told.as_written(fold)(days()[1]))
