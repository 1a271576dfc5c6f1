"""The null: one estimate for calibrate and diagnose, noise bounded by sensors of a kind, a misfit that lasts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fits import ANOTHER, USUAL, ou_series, problem_of, recorded, speeds, two_blocks

from network import calibrate, diagnose
from network.analysis.calibration.coloured_noise import bound_by_peers
from network.analysis.calibration.gauss_newton import minimise
from network.analysis.calibration.misfit import lasting_misfit, persistence
from network.catalogue.declaration.sections import CALIBRATED

LEAK = {"leak": {"kind": "radiation", "between": ["body", "air"], "emissivity_area": "0.5 m^2"}}


def test_calibrate_and_diagnose_mean_the_same_by_calibrated() -> None:
    machine = two_blocks()
    runs = [recorded(two_blocks(links=LEAK), speeds(*steps), seed) for seed, steps in enumerate((USUAL, ANOTHER))]
    calibrated = calibrate(machine, runs).machine.to_plain()
    assert diagnose(machine, runs).before.to_plain() == {k: v for k, v in calibrated.items() if k != CALIBRATED}


def test_a_machine_that_lacks_nothing_is_the_calibrated_one() -> None:
    machine, run = two_blocks(), recorded(two_blocks(), speeds(*USUAL), 3)
    told = diagnose(machine, [run])
    assert told.verdict == "adequate" and told.after.to_plain() == calibrate(machine, [run]).machine.to_plain()


def test_readings_of_white_noise_count_as_they_are() -> None:
    problem = problem_of(two_blocks(), recorded(two_blocks(), speeds(*USUAL), 1))
    at = minimise(problem)
    assert persistence(at) < 0.05 and lasting_misfit(at) == pytest.approx(1.0, abs=0.1)


def test_a_misfit_that_lasts_counts_as_bayley_and_hammersley_have_it() -> None:
    """First-order noise of a known correlation from cell to cell, laid over a fit that is right."""
    problem = problem_of(two_blocks(), recorded(two_blocks(), speeds(*USUAL), 1))
    at = minimise(problem)
    rho, rng = 0.9, np.random.default_rng(2)
    factors = []
    for _ in range(20):
        lasting = np.concatenate(
            [_first_order(rho, rows.stop - rows.start, rng) for rows, _ in problem.whiteners[0].blocks]
        )
        of = replace(at, rows=replace(at.rows, residual=at.residual - at.left + 3 * lasting))
        factors.append(lasting_misfit(replace(of, problem=replace(of.problem, firm_eta=1e3))))
    assert np.median(factors) == pytest.approx(3 * np.sqrt(1.9 / 0.1), rel=0.35)


def _first_order(rho: float, count: int, rng: np.random.Generator) -> np.ndarray:
    x = np.empty(count)
    x[0] = rng.standard_normal()
    for k in range(1, count):
        x[k] = rho * x[k - 1] + np.sqrt(1 - rho**2) * rng.standard_normal()
    return x


def test_what_no_other_sensor_of_its_kind_has_is_no_colour_of_one() -> None:
    told = {"a": (0.05, 0.5, 300.0), "b": (0.05, 0.0, 0.0), "c": (0.05, 0.0, 0.0), "dz": (1e-6, 2e-6, 60.0)}
    units = {"a": "degC", "b": "degC", "c": "degC", "dz": "um"}
    bound = bound_by_peers(told, units, {"dz": 1.5e-6})
    assert bound["a"][1] == 0.0 and bound["dz"] == told["dz"]


def test_colour_that_sensors_of_a_kind_share_stays() -> None:
    told = {n: (0.05, s, 300.0) for n, s in (("a", 0.06), ("b", 0.05), ("c", 0.045), ("d", 0.4))}
    bound = bound_by_peers(told, dict.fromkeys(told, "degC"), dict.fromkeys(told, 0.01))
    assert [bound[n] for n in "abc"] == [told[n] for n in "abc"]
    assert bound["d"][1] == pytest.approx(0.05 * np.exp(0.6), rel=1e-6)


def test_colour_of_the_only_sensor_of_a_kind_is_what_its_file_says() -> None:
    told = {"T": (0.05, 0.5, 300.0)}
    assert bound_by_peers(told, {"T": "degC"}, {"T": 0.1})["T"][1] == pytest.approx(0.1 * np.exp(0.6), rel=1e-6)
    assert bound_by_peers(told, {"T": "degC"}, {"T": 0.01})["T"][1] == pytest.approx(0.05 * np.exp(0.6), rel=1e-6)


def test_a_sensor_is_no_more_coloured_than_at_standstill() -> None:
    """Colour that only comes while the spindle turns is heat or vibration, and no noise."""
    from network.analysis.calibration.coloured_noise import estimate_colours

    schedule = speeds((0.0, 6000), (4.0, 0), hours=8)
    sway = ou_series(schedule.t, 0.3, 120.0, 5) * (schedule.t < 4 * 3600)
    problem = problem_of(two_blocks(), recorded(two_blocks(), schedule, 1, {"T_body": sway}))
    at = minimise(problem)
    told = estimate_colours(problem.data, at.predictions)
    assert told["T_body"][1] < 0.05


def test_runs_of_two_machines_want_different_numbers() -> None:
    other = two_blocks().patched({"nodes": {"motor": {"heat_capacity": "8 kJ/K"}}})
    of = enumerate(((two_blocks(), USUAL), (other, ANOTHER), (two_blocks(), ANOTHER)))
    runs = [replace(recorded(machine, speeds(*steps), i), file=f"run {i}") for i, (machine, steps) in of]
    found = calibrate(two_blocks(), runs)
    first = found.disagreements[0]
    assert first.parameter.path == "nodes.motor.heat_capacity" and first.sigma > 5
    told = found.summary()["one_machine"]
    assert told["agree"] is False and told["numbers"][0]["values"][1]["file"] == "run 1"
    assert told["numbers"][0]["values"][1]["value"] == pytest.approx(8000, rel=0.1)
    assert told["numbers"][0]["unit"] == "J/K"
    assert any("is it one machine? nodes.motor.heat_capacity" in s for s in found.sentences)


@pytest.mark.parametrize("seed", range(4))
def test_runs_of_one_machine_agree(seed: int) -> None:
    several = enumerate((USUAL, ANOTHER, USUAL[:2]))
    runs = [recorded(two_blocks(), speeds(*steps), seed + 10 * i) for i, steps in several]
    assert not calibrate(two_blocks(), [replace(r, file=str(i)) for i, r in enumerate(runs)]).disagreements
