"""The filter against dense covariances by matrix exponentials, and against the dense form that fits use."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fit_networks import machines
from fits import USUAL, recorded, speeds, two_blocks
from kalman import discretised, filter_run, state_space
from scipy.linalg import expm
from threadpoolctl import threadpool_limits

from network.analysis.calibration import measured_means
from network.analysis.calibration.coloured_noise import residuals
from network.analysis.calibration.measured_means import weigh_recording
from network.analysis.calibration.noise import Noise, whitener
from network.engine.response.knots import Knots, jumps_of
from network.engine.response.model import Model
from network.engine.response.parameters import centres, free_parameters

NOISE = Noise({"T_body": (0.08, 240.0), "dz": (0.3e-6, 900.0)})
OFFSETS = {"T_motor": 0.1, "T_body": 0.1}


@pytest.fixture(autouse=True)
def one_thread():
    with threadpool_limits(1):
        yield


def every_sample(schedule, *_, unread=()):
    """Each sample a knot and a cell of its own; the last one has none."""
    return Knots(schedule.t, jumps_of(schedule), np.arange(1, len(schedule.t)), schedule.t)


def sampled(monkeypatch, machine, hours=0.25, seed=1, beside=0.1):
    monkeypatch.setattr(measured_means, "make_knots", every_sample)
    steps = [(t * hours / 4, rpm) for t, rpm in USUAL]
    recording = recorded(machine, speeds(*steps, hours=hours), seed)
    for name in machine.sensors:
        recording.columns[name].values[-1] = np.nan
    recording.columns["T_body"].values[40:50] = np.nan
    data = weigh_recording(machine, recording)
    theta = centres(free_parameters(machine))
    return data, Model(machine, free_parameters(machine), [data.run]).predict(theta + beside)[0]


def dense(space, t, regime_of):
    """Covariance of what is seen at all samples, (samples, channels) both ways, straight from the equations."""
    P, S = [space.P0], space.P0
    steps, known = [], {}
    for k in range(1, len(t)):
        A, h = space.A[regime_of[k]], t[k] - t[k - 1]
        n, key = len(A), (regime_of[k], round(h, 9))
        if key not in known:
            known[key] = expm(np.block([[A, space.Q], [np.zeros((n, n)), -A.T]]) * h)
        G = known[key]
        phi = G[:n, :n]
        steps.append(phi)
        S = phi @ S @ phi.T + G[:n, n:] @ phi.T
        P.append(S)
    m = len(space.H[0])
    total = np.zeros((len(t) * m, len(t) * m))
    for i in range(len(t)):
        way = P[i]
        for j in range(i, len(t)):
            way = steps[j - 1] @ way if j > i else way
            block = space.H[regime_of[j]] @ way @ space.H[regime_of[i]].T
            total[j * m : (j + 1) * m, i * m : (i + 1) * m] = block
            total[i * m : (i + 1) * m, j * m : (j + 1) * m] = block.T
    return total


def log_density(r, covariance):
    _, volume = np.linalg.slogdet(2 * np.pi * covariance)
    return -0.5 * float(r @ np.linalg.solve(covariance, r) + volume)


@pytest.mark.parametrize("name", ["linear", "lag", "massless", "zeroed", "bar"])
def test_the_filter_gives_the_density_of_the_dense_covariance(name, monkeypatch):
    machine = machines()[name]
    data, prediction = sampled(monkeypatch, machine)
    residual = np.array([residuals(data, prediction)[n] for n in data.run.channels])[:, :-1]
    samples = data.run.knots.samples[:-1]
    data = replace(data, run=replace(data.run, knots=replace(data.run.knots, samples=samples)))
    space = state_space(prediction, data, NOISE, OFFSETS)
    covariance = dense(space, samples, np.zeros(len(samples), int))
    sigma = np.array([data.sigma[n] for n in data.run.channels])
    covariance += np.diag(np.tile(sigma**2, len(samples)))
    seen = np.isfinite(residual.T.ravel())
    expected = log_density(residual.T.ravel()[seen], covariance[np.ix_(seen, seen)])
    found = filter_run(prediction, data, residual, NOISE, OFFSETS)
    assert found.log_likelihood == pytest.approx(expected, abs=1e-6 * abs(expected))
    assert np.isfinite(found.innovations[seen.reshape(len(samples), -1).T]).all()


def test_fits_on_cells_of_one_sample_have_the_likelihood_of_the_filter(monkeypatch):
    machine = two_blocks()
    data, prediction = sampled(monkeypatch, machine, hours=1.0, beside=0.01)
    white = whitener(data, NOISE)
    offsets = np.array([np.repeat(data.run.channels, data.run.knots.cells) == n for n in OFFSETS], float)
    columns = np.concatenate([prediction.respond_to(data.pushes(prediction.course))[: len(data.starts)], offsets])
    spreads = np.array([*(s.spread for s in data.starts), *OFFSETS.values()])
    N, r = white(columns * spreads[:, None]), white(data.means - prediction.cells)
    inner = np.eye(len(N)) + N @ N.T
    least = r @ r - (N @ r) @ np.linalg.solve(inner, N @ r)
    volume = white.log_determinant + np.linalg.slogdet(inner)[1] + len(r) * np.log(2 * np.pi)
    residual = np.array([residuals(data, prediction)[n] for n in data.run.channels])
    found = filter_run(prediction, data, residual, NOISE, OFFSETS)
    assert found.log_likelihood == pytest.approx(-0.5 * (least + volume), abs=0.5)


def test_a_stiff_step_is_discretised_without_overflow():
    A, Q = np.array([[-2.0, 0.1], [0.0, -1e-4]]), np.diag([0.5, 1e-3])
    phi, noise = discretised(A, Q, 1000.0)
    assert np.isfinite(noise).all()
    fine = [discretised(A, Q, 1.0)] * 1000
    P = np.zeros((2, 2))
    for step, more in fine:
        P = step @ P @ step.T + more
    assert np.abs(noise - P).max() < 1e-9 * np.abs(P).max()
    assert np.abs(phi - expm(A * 1000.0)).max() < 1e-12
