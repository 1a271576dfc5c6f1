"""Noise beyond white: its covariances."""

from __future__ import annotations

import numpy as np
import pytest
from fits import USUAL, problem_of, recorded, speeds, two_blocks

from network.analysis.calibration.coloured_noise import LAGS, colour
from network.analysis.calibration.noise import Noise, whitener
from network.analysis.calibration.ornstein_uhlenbeck import correlate_cell_means


@pytest.mark.parametrize("tau", [3.0, 60.0, 5000.0])
def test_means_over_cells_of_coloured_noise_have_the_covariance_of_their_samples(tau):
    draw = np.random.default_rng(1)
    t = np.sort(draw.uniform(0, 1000, 80))
    cell = np.sort(draw.integers(0, 12, 80))
    cell[cell == 5] = 6
    average = np.array([(cell == c) / max((cell == c).sum(), 1) for c in range(12)])
    dense = average @ np.exp(-np.abs(t[:, None] - t[None, :]) / tau) @ average.T
    assert np.abs(correlate_cell_means(t, cell, 12, tau) - dense).max() < 1e-12


def test_channels_are_whitened_one_by_one_as_their_whole_covariance_says():
    data = problem_of(two_blocks(), recorded(two_blocks(), speeds(*USUAL), 0)).data[0]
    name, knots = data.run.channels[1], data.run.knots
    known, white = data.known, whitener(data, Noise({name: (0.03, 200.0)}))
    present, own = data.run.present[name], slice(knots.cells, 2 * knots.cells)
    covariance = np.diag(data.variance)
    shape = correlate_cell_means(knots.samples[present], knots.cell_of[present], knots.cells, 200.0)
    covariance[own, own] += 0.03**2 * shape
    covariance = covariance[np.ix_(known, known)]
    root = white.again(np.eye(known.sum())).T
    np.testing.assert_allclose(root @ covariance @ root.T, np.eye(known.sum()), atol=1e-9)
    np.testing.assert_allclose(white.colour(white.again(np.eye(known.sum()))), np.eye(known.sum()), atol=1e-9)
    assert white.log_determinant == pytest.approx(np.linalg.slogdet(covariance)[1], rel=1e-10)


@pytest.mark.parametrize("count", [1, 2, 3, LAGS[-1]])
def test_short_recordings_tell_no_colour(count):
    """However many there are: not one of them has two samples as far apart as the longest lag."""
    draw = np.random.default_rng(1)
    assert colour([draw.standard_normal(count) for _ in range(400)], 10.0) == (0.0, 0.0, 0.0)


def test_white_and_coloured_noise_are_told_apart():
    rng = np.random.default_rng(2)
    noise = ou_noise(rng, 1400, 6.0) + rng.standard_normal(1400)
    white, tinted, tau = colour([noise], 10.0)
    assert (white, tinted) == pytest.approx((1, 1), rel=0.15) and tau == pytest.approx(60, rel=0.4)


def ou_noise(rng: np.random.Generator, count: int, tau: float) -> np.ndarray:
    keep, e = np.exp(-1 / tau), np.zeros(count)
    for k in range(1, count):
        e[k] = keep * e[k - 1] + np.sqrt(1 - keep**2) * rng.standard_normal()
    return e
