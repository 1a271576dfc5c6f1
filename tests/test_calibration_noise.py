"""Noise beyond white: its covariances, and how much of it is found in residuals."""

from __future__ import annotations

import numpy as np
import pytest
from fits import ANOTHER, USUAL, ou_series, problem_of, recorded, speeds, two_blocks

from network.calibration.fitting import minimise
from network.calibration.noise import Noise, coloured, whitener
from network.calibration.noise_fit import estimate_noise, rewhitened
from network.calibration.ou import sampled_ou
from network.inputs import linear


@pytest.mark.parametrize("tau", [3.0, 60.0, 5000.0])
def test_means_over_cells_of_coloured_noise_have_the_covariance_of_their_samples(tau):
    draw = np.random.default_rng(1)
    t = np.sort(draw.uniform(0, 1000, 80))
    cell = np.sort(draw.integers(0, 12, 80))
    cell[cell == 5] = 6
    average = np.array([(cell == c) / max((cell == c).sum(), 1) for c in range(12)])
    dense = average @ np.exp(-np.abs(t[:, None] - t[None, :]) / tau) @ average.T
    assert np.abs(sampled_ou(t, cell, 12, tau) - dense).max() < 1e-12


def test_channels_are_whitened_one_by_one_as_their_whole_covariance_says():
    data = problem_of(two_blocks(), recorded(two_blocks(), speeds(*USUAL), 0)).data[0]
    noise = Noise({data.run.channels[1]: (0.03, 200.0)})
    known, white = data.known, whitener(data, noise)
    covariance = (np.diag(data.variance) + coloured(data, noise))[np.ix_(known, known)]
    root = white.again(np.eye(known.sum())).T
    np.testing.assert_allclose(root @ covariance @ root.T, np.eye(known.sum()), atol=1e-9)
    np.testing.assert_allclose(white.undone(white.again(np.eye(known.sum()))), np.eye(known.sum()), atol=1e-9)
    assert white.log_determinant == pytest.approx(np.linalg.slogdet(covariance)[1], rel=1e-10)


def test_an_innocent_machine_has_neither_colour_nor_slack():
    machine = two_blocks()
    for seed in range(4):
        runs = [recorded(machine, speeds(*steps), 2 * seed + i) for i, steps in enumerate((USUAL, ANOTHER))]
        noise = estimate_noise(minimise(problem_of(machine, *runs)))
        assert not any(s for s, _ in noise.coloured.values()) and not any(noise.slack.values())


@pytest.mark.parametrize(("ratio", "tau"), [(1.0, 120.0), (2.5, 400.0)])
def test_coloured_noise_of_one_sensor_is_found_at_its_size_and_there_only(ratio, tau):
    machine, runs = two_blocks(), []
    for i, steps in enumerate((USUAL, ANOTHER)):
        schedule = speeds(*steps)
        runs.append(recorded(machine, schedule, i, {"T_body": ou_series(schedule.t, 0.05 * ratio, tau, 10 + i)}))
    noise = estimate_noise(minimise(problem_of(machine, *runs)))
    assert list(noise.coloured) == ["T_body"]
    size, time = noise.coloured["T_body"]
    assert 1 / 1.5 < size / (0.05 * ratio) < 1.5
    assert 1 / 2 < time / tau < 2
    assert not any(noise.slack.values())


def test_misplaced_heat_is_found_at_its_size():
    machine, q, ell, total = two_blocks(), 0.05, 4000.0, 19000.0
    shaken = two_blocks(sources={
        name: {"kind": "heat_source", "into": {name: 1}, "power": "1 W", "with": name, "at": "1 degC"}
        for name in ("motor", "body")
    })  # fmt: skip
    ratios = []
    for seed in range(2):
        runs = []
        for i, steps in enumerate((USUAL, ANOTHER)):
            schedule = speeds(*steps)
            power, t = 260.0, schedule.t
            heats = {n: linear(n, "degC", t, ou_series(t, q * power * c / total, ell, 100 + 10 * seed + 2 * i + k))
                     for k, (n, c) in enumerate((("motor", 4000.0), ("body", 15000.0)))}  # fmt: skip
            runs.append(recorded(shaken, speeds(*steps, **heats), seed * 2 + i))
        at = minimise(problem_of(machine, *runs))
        noise = estimate_noise(at)
        ratios.append(noise.slack["body"] / (q * power * 15 / 19))
        assert rewhitened(at, noise).log_evidence > at.log_evidence + 10
        # what the heat does between its knots, 600 s apart, may pass for colour below the white noise
        assert all(size < machine.sensors[name].sigma for name, (size, _) in noise.coloured.items())
    assert 1 / 1.5 < np.exp(np.mean(np.log(ratios))) < 1.5


def test_another_noise_needs_no_other_run():
    machine = two_blocks()
    at = minimise(problem_of(machine, recorded(machine, speeds(*USUAL), 3)))
    assert rewhitened(at, Noise()).log_evidence == pytest.approx(at.log_evidence, abs=1e-6)
    coloured = Noise({"T_body": (0.1, 300.0)}, {"body": 5.0})
    there = rewhitened(at, coloured)
    back = rewhitened(there, Noise())
    assert np.abs(back.slopes - at.slopes).max() < 1e-6 * np.abs(at.slopes).max()
