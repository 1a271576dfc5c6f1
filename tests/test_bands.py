"""Bands of 95 % on every run of a calibrated machine, and warnings where a schedule leaves its range."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from fits import ANOTHER, USUAL, recorded, speeds, two_blocks

from network import Machine, Recording, calibrate, simulate
from network.analysis.calibration.band_coverage import measure_coverage, pool_coverage
from network.analysis.calibration.calibrate import Calibration
from network.analysis.calibration.calibrated_patch import patch_text, with_fitted_numbers
from network.analysis.calibration.gauss_newton import linearise
from network.analysis.calibration.generalisation import estimate_left
from network.analysis.calibration.left_out import refit_without
from network.analysis.calibration.tcp_bands import Posterior, bands_of
from network.analysis.comparison.compare import compare
from network.catalogue.declaration.entry_path import NumberPath
from network.cli import cli
from network.engine.response.parameters import at_values, centres, free_parameters, parameter, values_at
from network.platform.quantities.units import Number
from network.platform.refusal import Refused
from network.recordings.extrapolation import SLACK, list_extrapolated
from network.recordings.scenario import Scenario

THIRD = ((0.0, 7000), (1.2, 1000), (2.0, 6000), (3.4, 3000))
FOURTH = ((0.0, 5000), (0.4, 0), (1.0, 8000), (2.2, 4000))
DRAFT = {"kind": "forced_convection", "between": ["motor", "air"], "conductance": "1 W/K", "gain": "5",
         "reference_speed": "8000 rpm"}  # fmt: skip


def drawn(seed: int) -> Machine:
    """Two blocks with numbers drawn from their priors."""
    machine = two_blocks()
    parameters = free_parameters(machine)
    spread = np.array([p.spread for p in parameters])
    theta = centres(parameters) + spread * np.random.default_rng(seed).standard_normal(len(parameters))
    return at_values(machine, values_at(parameters, theta))


def run(machine: Machine, steps: tuple[tuple[float, float], ...], seed: int, name: str) -> Recording:
    return replace(recorded(machine, speeds(*steps, every=20.0), seed), name=name, file=f"{name}.csv")


def truth() -> Machine:
    """What the file does not say: air that is moved by the spindle cools the motor."""
    return two_blocks(links={"draft": DRAFT})


@pytest.fixture(scope="module")
def plain() -> Calibration:
    machine = drawn(0)
    return calibrate(two_blocks(), [run(machine, USUAL, 1, "one"), run(machine, ANOTHER, 2, "two")],
                     run(machine, THIRD, 3, "three"))  # fmt: skip


@pytest.fixture(scope="module")
def wrong() -> Calibration:
    runs = [run(truth(), steps, i, f"run{i}") for i, steps in enumerate((USUAL, ANOTHER, FOURTH))]
    return calibrate(two_blocks(), runs, run(truth(), THIRD, 9, "held out"))


@pytest.fixture
def saved(wrong: Calibration, tmp_path: Path) -> Path:
    path = tmp_path / "machine.calibrated.yaml"
    path.write_text(patch_text(wrong.machine, tmp_path, "by a test"), encoding="utf-8")
    return path


# -- what a calibrated machine says of itself -----------------------------------------------------------------------
def test_a_calibrated_machine_reads_back_as_it_was(wrong: Calibration, saved: Path) -> None:
    read = Machine.load(saved)
    assert read.validity is not None and read.validity == wrong.machine.validity
    assert read.to_plain() == wrong.machine.to_plain() and not read.warnings
    assert list(read.validity.root) == [p.path for p in wrong.parameters]
    speed = read.validity.ranges["speed"]
    assert speed.low == 0 and speed.high == pytest.approx(8000 * 2 * np.pi / 60)


def test_its_numbers_are_tied_as_the_calibration_found(wrong: Calibration) -> None:
    assert wrong.machine.validity is not None
    known = Posterior.of(wrong.machine, wrong.machine.validity.root)
    std = np.sqrt(np.diag(known.covariance))
    np.testing.assert_allclose(std, wrong.std, rtol=5e-3)  # three digits are written
    np.testing.assert_allclose(known.covariance / np.outer(std, std), wrong.correlation, atol=1e-3)


def test_it_keeps_what_it_says_as_long_as_its_numbers_stay(wrong: Calibration) -> None:
    machine = wrong.machine
    kept = machine.patched({"links": {"draft": {**DRAFT, "conductance": "1 W/K ± 20 %"}}})
    assert kept.validity == machine.validity
    assert len(Posterior.of(kept, kept.validity.root).theta) == len(wrong.theta) + 1  # type: ignore[union-attr]
    assert machine.patched({"calibrated": None}).validity is None
    fins = {"kind": "convection", "between": ["motor", "air"], "conductance": "5 W/K"}
    gone = machine.patched({"links": {"fins": fins}})
    assert gone.validity is None
    (warning,) = gone.warnings
    assert "calibrated speaks of links.fins.conductance, no uncertain number of this machine" in str(warning)


def test_what_cannot_be_read_of_it_is_refused(wrong: Calibration) -> None:
    given = {"ranges": {"speed": "0 rpm", "ambient": "2..1 degC"}, "left": {"q": "1 um", "z": "3 K"},
             "correlation_root": {"links.fins.conductance": ["0.1", "2"]}, "more": "1",
             "misfit": {"T_body": ["1.2", "1"]}}  # fmt: skip
    with pytest.raises(Refused) as refused:
        wrong.machine.patched({"calibrated": given})
    told = str(refused.value)
    for wanted in ("'0 rpm' is not a range", "ends the wrong way round", "calibrated.left.q is no axis",
                   "'3 K' is in K", "no row of a correlation's root", "calibrated.misfit.T_body is no misfit",
                   "unknown key 'more'"):  # fmt: skip
        assert wanted in told, wanted
    with pytest.raises(Refused, match=r"ranges\.speed is in degC, and the machine reads it in rpm"):
        wrong.machine.patched({"calibrated": {"ranges": {"speed": "0..30 degC"}}})


def test_a_range_of_what_only_says_when_readings_count_is_in_any_unit(wrong: Calibration) -> None:
    sensor = {"measures": "motor", "noise": "0.05 K", "while": "pump"}
    gated = wrong.machine.patched({"sensors": {"T_motor": sensor}})
    kept = gated.patched({"calibrated": {"ranges": {"pump": "0..2 kW"}}})
    assert kept.validity is not None and kept.validity.ranges["pump"].unit == "kW"


# -- bands ----------------------------------------------------------------------------------------------------------
SMALL = 0.1
"""Of the posterior's width: where the course is straight in the numbers."""


@pytest.mark.parametrize(("share", "within"), [(SMALL, 0.3), (1.0, 0.05)])
def test_the_band_is_what_drawn_numbers_and_what_is_left_amount_to(
    wrong: Calibration, share: float, within: float
) -> None:
    """1σ over machines drawn from the posterior, from what the file says alone: the numbers' part where it is narrow,
    the whole band also where it is wide and the course is bent in the numbers."""
    machine, schedule = wrong.machine, speeds(*THIRD, every=20.0)
    assert machine.validity is not None
    known = Posterior.of(machine, machine.validity.root)
    draw = np.random.default_rng(0).multivariate_normal(known.theta, known.covariance * share**2, 60)
    runs = [simulate(at_values(machine, values_at(known.parameters, x)), schedule).tcp["z"] for x in draw]
    (band,) = bands_of(machine, Scenario(schedule, 20.0))
    spread = np.std(runs, axis=0) / share
    k = int(np.argmax(spread))
    told = np.interp(schedule.t[k], band.t, band.std)
    left = 0.0 if share < 1 else machine.validity.left["z"]
    assert np.hypot(told, left) == pytest.approx(np.hypot(spread[k], left), rel=within)
    np.testing.assert_allclose(band.total, np.hypot(band.std, machine.validity.left["z"]))
    low, high = band.limits(band.t, band.centre)
    np.testing.assert_allclose((high - low) / 2, 1.959964 * band.total)


def test_what_is_left_is_what_a_complete_machine_lacks_not_and_an_incomplete_one_does(
    plain: Calibration, wrong: Calibration
) -> None:
    assert plain.machine.validity is not None and wrong.machine.validity is not None
    assert plain.machine.validity.left["z"] < 0.25e-6
    assert wrong.machine.validity.left["z"] > 4 * plain.machine.validity.left["z"]
    assert wrong.after_holdout is not None
    rms = np.sqrt(np.nanmean(wrong.after_holdout.recordings[0].channels["dz"].residual ** 2))
    (band,) = wrong.bands[-1]
    assert 0.4 * rms < np.sqrt(np.mean(band.total**2)) < 4 * rms


def test_left_of_runs_is_the_most_of_fits_without_each(wrong: Calibration) -> None:
    """Against calibrations that leave a run out: with it the readings of every one of them lie in their bands."""
    runs = [r.recording for r in wrong.after.recordings]
    beyond = []
    for i, held_out in enumerate(runs):
        found = calibrate(two_blocks(), [r for j, r in enumerate(runs) if j != i], held_out)
        assert found.after_holdout is not None
        e = found.after_holdout.recordings[0].channels["dz"].residual
        most = np.quantile(e[np.isfinite(e)] ** 2, 0.95) / 1.96**2
        beyond.append(most - np.mean(wrong.bands[i][0].std ** 2) - 0.25e-6**2)
    assert estimate_left(wrong.known)["z"] == pytest.approx(np.sqrt(max(*beyond, 0.0)), rel=0.4)


def test_a_run_left_out_is_one_that_was_never_there(wrong: Calibration) -> None:
    at = wrong.fit.at
    rows = np.ones(len(at.problem.whiteners[0].known), bool)[at.problem.data[0].known]
    theta = refit_without(at, 0, rows)
    others = calibrate(two_blocks(), [r.recording for r in wrong.after.recordings][1:])
    assert theta is not None
    assert np.abs((theta - others.theta) / others.std).max() < 1  # their noise is told anew


def test_half_a_run_left_out_counts_for_nothing(wrong: Calibration) -> None:
    """Whatever stands there."""
    at = wrong.fit.at
    data = at.problem.data[0]
    half = np.tile(data.centres > np.median(data.centres), len(data.run.channels))
    spoilt = replace(data, means=data.means + np.where(half, 5.0, 0.0))
    other = linearise(replace(at.problem, data=(spoilt, *at.problem.data[1:])), at.theta)
    one, two = (refit_without(each, 0, half[data.known]) for each in (at, other))
    assert one is not None and two is not None
    np.testing.assert_allclose(one, two, atol=1e-9)


def test_an_axis_that_nothing_measured_has_its_numbers_only() -> None:
    machine = two_blocks()
    blind = machine.patched({"sensors": {"dz": None}})
    found = calibrate(blind, run(machine, USUAL, 1, "one"))
    (band,) = bands_of(found.machine, run(machine, THIRD, 2, "two"))
    assert band.left is None and found.machine.validity is not None and not found.machine.validity.left
    assert "Along z that counts its numbers only" in str(found)


# -- whether they hold ----------------------------------------------------------------------------------------------
def test_bands_and_intervals_hold_what_they_promise() -> None:
    """Numbers drawn from their priors, a complete machine. Of 48 numbers less than 81 % inside happens once in 2000
    where 95 % are. Readings of a run lie off together, so that of eight runs most have to hold."""
    inside, z = [], []
    for seed in range(8):
        machine = drawn(100 + seed)
        found = calibrate(two_blocks(), run(machine, USUAL, seed, "one"), run(machine, THIRD, 50 + seed, "two"))
        true = np.log([machine.by_path[p.entry].__dict__[p.attribute] for p in found.parameters])
        z += ((found.theta - true) / found.std).tolist()
        inside.append(pool_coverage(found.coverage))
    assert np.sum(np.abs(z) < 1.96) >= 0.81 * len(z)
    assert np.mean(np.array(inside, float)) > 0.85 and np.median(np.array(inside, float)) > 0.9


def test_bands_of_an_incomplete_machine_hold(wrong: Calibration) -> None:
    share = pool_coverage(wrong.coverage)
    assert share is not None and share > 0.85
    without = replace(wrong.machine, calibrated=replace(wrong.machine.calibrated, left={}))  # type: ignore[type-var]
    assert wrong.after_holdout is not None
    blind = pool_coverage(measure_coverage(without, wrong.after_holdout))
    assert blind is not None and blind <= share


# -- beyond what it was calibrated in -------------------------------------------------------------------------------
def beyond(machine: Machine, top: float) -> list[str]:
    return [w for w in simulate(machine, speeds((0.0, top), (1.0, 0))).warnings if "extrapolated" in w]


def test_a_schedule_beyond_the_range_is_warned_of_once(wrong: Calibration) -> None:
    (told,) = beyond(wrong.machine, 12000)
    assert told.startswith("speed reaches 12\u00a0000 rpm, and the machine was calibrated from 0 to 8000 rpm: what it")
    assert not beyond(wrong.machine, 8000 * (1 + 0.9 * SLACK)) and beyond(wrong.machine, 8000 * (1 + 1.1 * SLACK))
    assert not beyond(two_blocks(), 12000)
    several = [speeds((0.0, 12000)), speeds((0.0, 15000))]
    (both,) = list_extrapolated(wrong.machine, several)
    assert "15\u00a0000 rpm" in both


# -- on the command line --------------------------------------------------------------------------------------------
SCENARIO = """scenario: hot
duration: 2 h
output: 60 s
start: 20 degC
inputs:
  ambient: 26 degC
  speed: [{for: 1 h, at: 9900 rpm}, {for: 1 h, at: 0 rpm}]
"""


def test_simulate_tells_bands_and_what_is_extrapolated(saved: Path, tmp_path: Path) -> None:
    (tmp_path / "hot.yaml").write_text(SCENARIO)
    out = tmp_path / "out"
    done = CliRunner().invoke(cli, ["simulate", str(saved), str(tmp_path / "hot.yaml"), "-o", str(out)])
    assert done.exit_code == 0, done.output
    assert "(95 %) at worst" in done.output and "bands.csv" in done.output and (out / "run.png").is_file()
    assert "ambient reaches 26 °C, and the machine was calibrated at 20 °C" in done.output
    table = np.genfromtxt(out / "bands.csv", delimiter=",", names=True)
    run_of_it = np.genfromtxt(out / "results.csv", delimiter=",", names=True)
    low, high = table["z_low_um"], table["z_high_um"]
    assert np.all(high > low) and np.all((run_of_it["tcpz_um"] > low) & (run_of_it["tcpz_um"] < high))


def test_simulate_and_compare_tell_it_as_json(saved: Path, tmp_path: Path) -> None:
    (tmp_path / "hot.yaml").write_text(SCENARIO)
    where = ["-o", str(tmp_path / "out"), "--no-plots", "--noise"]
    words = ["simulate", str(saved), str(tmp_path / "hot.yaml"), *where, "--json"]
    done = CliRunner().invoke(cli, words)
    (band,) = json.loads(done.stdout)["bands"]
    assert band["axis"] == "z" and band["unit"] == "um" and band["measured"] and band["widest95"] > 0
    recording = str(tmp_path / "out" / "results.csv")
    done = CliRunner().invoke(cli, ["compare", str(saved), recording, "--json", "-"])
    (told,) = json.loads(done.stdout)["coverage"]
    assert told["channel"] == "dz" and told["inside"] == 1.0
    done = CliRunner().invoke(cli, ["compare", str(saved), recording])
    assert "100 % of the readings of dz are inside their band" in done.stdout
    assert done.stderr.count("speed reaches 9900 rpm") == 1


def test_calibrate_tells_whether_bands_hold_on_held_out_runs(wrong: Calibration) -> None:
    assert "held out.csv:" in str(wrong) and "of the readings of dz are inside their band" in str(wrong)
    summary = wrong.summary()
    assert summary["coverage"]["inside"] == pool_coverage(wrong.coverage)
    assert summary["validity"]["ranges"]["speed"] == "0..8000 rpm"
    assert not measure_coverage(two_blocks(), compare(drawn(0), run(drawn(0), USUAL, 1, "one")))


def test_a_number_that_is_fitted_to_zero_stands_in_the_file_without_a_spread() -> None:
    """0 W that cannot be less: a prior of a file spreads no zero, and the machine could not be read again."""
    machine = two_blocks()
    path = NumberPath.parse("links.skin.conductance", machine.paths)
    assert path is not None
    p = parameter(machine, path, Number(0.0, "normal", 1.0))
    told = with_fitted_numbers(machine, [p], [0.0], [0.5])
    assert p.value(0.0) == 0.0 and told.by_path[p.entry].__dict__[p.attribute] == 0.0
