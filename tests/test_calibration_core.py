"""Runs on knots against exact ones, their recursions against loops, and the noise-free agreement of every path."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from fit_networks import machines, ramped
from fits import USUAL, problem_of, recorded, speeds, two_blocks
from scipy.optimize import minimize

from network.analysis.calibration import gauss_newton
from network.analysis.calibration.measured_means import weigh_recording
from network.analysis.calibration.trust_region import bounded_step, length_of
from network.analysis.diagnosis.hypotheses.case import Case
from network.engine.channels import readouts
from network.engine.response import knots as knots_module
from network.engine.response import recursion, series
from network.engine.response.cells import FEW, averages, cell_matrix, sum_rows
from network.engine.response.intervals import first_from, interval_of, locate_instants
from network.engine.response.knots import make_knots, on_knots
from network.engine.response.model import Model, Run
from network.engine.response.parameters import centres
from network.engine.response.waveform import course_of
from network.engine.simulation import simulate
from network.recordings.columns import Column
from network.recordings.inputs import hold, linear

NAMES = list(machines())
PART_OF_NOISE = {"stream": 0.01}
"""Largest error of a cell's mean over its own noise; equal cells of a stream are computed as if a little unequal."""


@pytest.fixture(scope="module")
def every():
    return machines()


@pytest.mark.parametrize("name", NAMES)
def test_means_over_cells_are_those_of_the_exact_run_at_all_samples(name, every):
    machine = every[name]
    for schedule, part in ((speeds(*USUAL), 1e-3), (ramped(), 5e-3)):
        problem = problem_of(machine, recorded(machine, schedule, None))
        data, run = problem.data[0], problem.model.predict(centres(problem.parameters))[0]
        off = np.abs(data.means - run.cells)[data.known] / np.sqrt(data.variance[data.known])
        assert off.max() < max(part, PART_OF_NOISE.get(name, 0.0))


@pytest.mark.parametrize(("noise", "is_followed"), [(0.002, False), (0.009, False), (0.5, True)])
def test_a_speed_that_is_read_with_noise_counts_by_its_means_between_knots(noise, is_followed, every):
    """At every sample another value is no jump: the knots stay those of the steps that it was set in. What varies by as
    much as it is large is followed all the same."""
    schedule = speeds(*USUAL)
    set_to = schedule.signals["speed"].at(schedule.t)
    drawn = noise * set_to.mean() * np.random.default_rng(2).standard_normal(len(set_to))
    read = hold("speed", "rpm", schedule.t, np.where(set_to > 0, set_to + drawn, 0.0))
    noisy, steps = replace(schedule, signals={**schedule.signals, "speed": read}), make_knots(schedule)
    knots = make_knots(noisy)
    assert (len(knots.jumps) > 700) == is_followed
    if not is_followed:
        np.testing.assert_allclose(knots.jumps, steps.jumps)
        driven = on_knots(noisy, knots).signals["speed"]
        whole = sum(h * x for h, x in zip(np.diff(knots.t), driven.at(knots.t[:-1]), strict=True))
        assert whole == pytest.approx(10.0 * read.start[:-1].sum(), rel=1e-9)
    machine = every["linear"]
    problem = problem_of(machine, recorded(machine, noisy, None))
    data, run = problem.data[0], problem.model.predict(centres(problem.parameters))[0]
    assert (np.abs(data.means - run.cells)[data.known] / np.sqrt(data.variance[data.known])).max() < 0.5


def test_columns_that_nobody_reads_lay_no_knots_where_they_change_all_the_time(every):
    """A load in % with its noise, whoever reads it later; a displacement beside the channels is no input at all."""
    run, draw = recorded(every["linear"], speeds(*USUAL), 1), np.random.default_rng(3)
    load = Column("load", "%", 0.4 + 0.03 * draw.standard_normal(len(run.t)))
    grown = Column("second_probe", "um", np.cumsum(1e-8 * draw.standard_normal(len(run.t))))
    seen = replace(run, columns={**run.columns, "load": load, "second_probe": grown})
    case = Case(every["linear"], (seen,))
    assert case.drivers == ("ambient", "load", "speed")
    reads = two_blocks(
        sources={"more": {"kind": "heat_source", "into": {"motor": 1}, "power": "50 W", "with": "load", "at": "1"}}
    )
    (plain,), (laid,), (rival,) = (
        Case(every["linear"], (run,)).lay_out(every["linear"]),
        *map(case.lay_out, (every["linear"], reads)),
    )
    for other in (laid, rival):
        np.testing.assert_array_equal(other.run.knots.t, plain.run.knots.t)
    assert np.median(np.abs(rival.run.schedule.signals["load"].start - 0.4)) < 0.05


@pytest.mark.parametrize("columns", [3, FEW])
def test_sums_of_few_rows_and_of_many_are_the_same_sums(columns):
    values, starts = np.random.default_rng(1).standard_normal((12, columns)), np.array([0, 1, 5, 11])
    told = [values[a:b].sum(axis=0) for a, b in pairwise([*starts, 12])]
    np.testing.assert_allclose(sum_rows(values, starts), told, atol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_a_step_within_bounds_is_the_best_there_is(seed):
    draw = np.random.default_rng(seed)
    root, gradient = draw.standard_normal((6, 9)), 5 * draw.standard_normal(6)
    low, high = -draw.uniform(0, 0.3, 6), draw.uniform(0.01, 0.3, 6)
    bounds = list(zip(low, high, strict=True))
    best = minimize(lambda s: s @ root @ root.T @ s / 2 - gradient @ s, np.zeros(6), bounds=bounds)
    step = bounded_step(root @ root.T, gradient, np.ones(6), np.inf, (low, high))
    np.testing.assert_allclose(step, best.x, atol=1e-4)
    assert ((step >= low) & (step <= high)).all()


@pytest.mark.parametrize("radius", [1e-6, 0.01, 0.3])
def test_a_step_within_a_radius_is_the_best_there_is(radius):
    draw = np.random.default_rng(3)
    root, gradient, units = draw.standard_normal((4, 9)), 5 * draw.standard_normal(4), draw.uniform(0.2, 5, 4)
    P, free = root @ root.T, (np.full(4, -np.inf), np.full(4, np.inf))
    step = bounded_step(P, gradient, units, radius, free)
    assert length_of(step, units) == pytest.approx(radius, rel=0.02)
    worth = 2 * step @ gradient - step @ P @ step
    others = draw.standard_normal((2000, 4)) * units
    others *= (radius * 0.98 / np.linalg.norm(others / units, axis=1))[:, None]
    assert worth >= (2 * others @ gradient - np.einsum("ni,ij,nj->n", others, P, others)).max()


@pytest.mark.parametrize("radius", [0.01, 0.1])
def test_what_pulls_at_a_number_that_stands_at_its_bound_shortens_no_step_of_the_others(radius):
    draw = np.random.default_rng(3)
    root, gradient, units = draw.standard_normal((4, 9)), 5 * draw.standard_normal(4), draw.uniform(0.2, 5, 4)
    gradient[1] = 1e4
    low, high = np.full(4, -np.inf), np.array([np.inf, 0.0, np.inf, np.inf])
    step = bounded_step(root @ root.T, gradient, units, radius, (low, high))
    assert step[1] == 0.0 and length_of(step, units) == pytest.approx(radius, rel=0.1)
    free = [0, 2, 3]
    P = (root @ root.T)[np.ix_(free, free)]
    alone = bounded_step(P, gradient[free], units[free], radius, (low[free], high[free]))
    np.testing.assert_allclose(step[free] / units[free], alone / units[free], atol=0.1 * radius)


def test_where_runs_are_laid_out_anew_every_step_is_judged_by_its_own(monkeypatch):
    """J with slopes by η from elsewhere is too low beside one that has its own, however near it lies."""
    anew = SimpleNamespace()
    monkeypatch.setattr(gauss_newton, "expand_anew", lambda at: anew)
    near = SimpleNamespace(problem=SimpleNamespace(moves=True), theta=np.zeros(1), made_at=np.zeros(1))
    assert gauss_newton._renew_slopes(near, SimpleNamespace()) is anew


def test_beside_bounds_a_step_is_no_longer_than_its_radius_either():
    """What one bound holds back others may make up for: at the damping of the free step it would be the longer."""
    root = np.array([[2.7, 0.1, -1.4], [-0.6, -1.2, -0.6], [0.2, 0.7, 0.6]])
    gradient, room = np.array([-4.3, -1.8, 1.5]), np.array([0.06, 1.38, 12.41])
    for radius in (1.22, 0.3, 1e-3):
        step = bounded_step(root @ root.T, gradient, np.ones(3), radius, (-room, room))
        assert length_of(step, np.ones(3)) == pytest.approx(radius, rel=0.1) and (np.abs(step) <= room).all()


def test_where_every_number_stands_at_its_bound_there_is_no_step():
    room = (np.zeros(3), np.full(3, np.inf))
    assert not bounded_step(np.eye(3), -np.ones(3), np.ones(3), 0.1, room).any()


def test_a_step_is_lengthened_where_j_is_flatter_than_slopes_tell(monkeypatch):
    """J = 10 − 2 t + 0.1 t² along the step: the least is at ten of them; what breaks down or is no better is left."""
    tried = []

    def beside(at, theta):
        tried.append(float(theta[0]))
        t = theta[0] / 0.1
        return None if broken else SimpleNamespace(cost=10 - 2 * t + 0.1 * t**2)

    monkeypatch.setattr(gauss_newton, "move_beside", beside)
    at = SimpleNamespace(cost=10.0, theta=np.zeros(1), problem=SimpleNamespace(model=SimpleNamespace(switches=False)))
    new, broken = SimpleNamespace(cost=10 - 2 + 0.1), False
    step, wide, near = np.array([0.1]), (np.array([-9.0]), np.array([9.0])), (np.array([-9.0]), np.array([0.3]))
    assert gauss_newton._lengthen(at, new, step, wide, 1.0).cost == pytest.approx(0) and tried == [pytest.approx(1.0)]
    assert gauss_newton._lengthen(at, new, step, near, 1.0).cost == pytest.approx(10 - 6 + 0.9)
    broken = True
    assert gauss_newton._lengthen(at, new, step, wide, 1.0) is new
    broken, better = False, SimpleNamespace(cost=-1.0)
    assert gauss_newton._lengthen(at, better, step, wide, 5.5).cost == -1.0  # the parabola promises more than is there
    count, straight = len(tried), SimpleNamespace(cost=9.0)
    assert gauss_newton._lengthen(at, straight, step, wide, 1.0) is straight and len(tried) == count
    at.problem.model.switches = True
    assert gauss_newton._lengthen(at, new, step, wide, 1.0) is new and len(tried) == count


@pytest.mark.parametrize("name", ["linear", "bent", "relay"])
def test_gaps_and_samples_left_out_stay_out_of_the_means(name, every):
    machine, schedule = every[name], speeds(*USUAL)
    recording = recorded(machine, schedule, None)
    recording.columns["T_body"].values[100:160] = np.nan
    recording.columns["dz"].values[[300, 302, 700]] = np.nan
    problem = problem_of(machine, recording)
    data, run = problem.data[0], problem.model.predict(centres(problem.parameters))[0]
    assert (np.abs(data.means - run.cells) / np.sqrt(data.variance))[data.known].max() < 1e-3


def test_bent_networks_agree_with_the_rosenbrock_method_at_the_knots(every):
    machine, schedule = every["bent"], speeds(*USUAL)
    problem = problem_of(machine, recorded(machine, schedule, None))
    course, run = problem.model.predict(centres(problem.parameters))[0].course, problem.data[0].run
    exact = simulate(machine, replace(schedule, t=run.knots.t), method="rosenbrock", rtol=1e-9, parts=False)
    motor = course.T[0][:, course.problem.plan.network.parts["motor"].start]
    assert np.abs(motor - exact.sensors["T_motor"][:-1]).max() < 2e-5


def test_a_runaway_is_told_as_such(every):
    from network.platform.refusal import Failed

    grows = {"kind": "preload_friction", "into": {"motor": 1}, "torque": "900 N mm", "growth": "0.5 1/K",
             "inner": "motor", "outer": "body"}  # fmt: skip
    machine = two_blocks(sources={"rub": grows})
    problem = problem_of(machine, recorded(two_blocks(), speeds(*USUAL), None))
    network = Model(machine, (), [problem.data[0].run])
    with pytest.raises(Failed):
        network.predict(np.empty(0))


def test_what_straight_heats_cost_falls_with_the_square_of_the_distance_of_knots(every):
    schedule, machine, slopes = speeds(*USUAL), every["linear"], []
    problem = problem_of(machine, recorded(machine, schedule, None))
    data, theta = problem.data[0], centres(problem.parameters)
    for growth, longest in ((0.01, 10.0), (0.05, 60.0), (0.1, 120.0), (0.2, 240.0), (0.4, 480.0)):
        knots = make_knots(schedule, growth, longest)
        run = Run("run", on_knots(schedule, knots), knots, data.run.start, data.run.present)
        model = Model(machine, problem.parameters, [run])
        at = model.predict(theta)
        jumps = np.searchsorted(at[0].course.problem.plan.edges, knots.jumps - 1e-6)
        slopes.append(model.slopes(theta, at)[0][:, :, jumps])
    errors = np.array([np.abs(s - slopes[0])[:4].max() for s in slopes[1:]])
    assert (errors[1:] / errors[:-1] > 3.5).all()


def test_an_instant_at_an_edge_belongs_to_the_interval_after_it():
    edges = np.array([0.0, 10.0, 25.0, 30.0])
    at = np.array([0.0, 9.99, 10.0 - 1e-7, 10.0, 24.0, 25.0, 30.0])
    assert interval_of(edges, at).tolist() == [0, 0, 1, 1, 1, 2, 2]
    assert first_from(edges, at).tolist() == [0, 1, 1, 1, 2, 2, 3]
    k, share = locate_instants(edges, at)
    np.testing.assert_allclose(edges[k] + share * np.diff(edges)[k], at, atol=2e-7)


def test_a_run_is_laid_out_once_for_all_starts_and_anew_for_other_channels(every):
    problem = problem_of(every["linear"], recorded(every["linear"], speeds(*USUAL), None))
    (data,), theta = problem.data, centres(problem.parameters)
    before = problem.model.predict(theta)[0]
    moved = data.with_start({"motor": 30.0}).run
    assert moved.start["motor"] == 30.0 and moved.layout is data.run.layout
    (after,) = Model(problem.model.machine, problem.parameters, [moved]).predict(theta)
    assert after.resampled is before.resampled and np.abs(after.cells - before.cells).max() > 1
    names = list(data.run.present)[:1]
    fewer = replace(data.run, present={name: data.run.present[name] for name in names})
    (seen,) = Model(problem.model.machine, problem.parameters, [fewer]).predict(theta)
    np.testing.assert_allclose(seen.cells, before.cells[: len(seen.cells)])


def test_sums_over_samples_are_those_of_the_matrix(every):
    schedule = speeds(*USUAL)
    knots = make_knots(schedule)
    present = np.random.default_rng(0).random(len(schedule.t)) > 0.3
    matrix = cell_matrix(knots, knots.t, present)
    values = np.random.default_rng(1).standard_normal((3, 2 * (len(knots.t) - 1)))
    over = averages(knots, knots.t, [present, np.ones_like(present), present])
    assert np.abs(over.of(values)[0] - matrix @ values[0]).max() < 1e-12
    assert np.abs(over.of(values)[2] - matrix @ values[2]).max() < 1e-12


@pytest.mark.parametrize("follow", [recursion.by_blocks, recursion.as_banded])
@pytest.mark.parametrize("count", [1, 2, 7, 100])
def test_recursions_at_once_are_those_of_a_loop(count, follow):
    draw = np.random.default_rng(count)
    for kind in (float, complex):
        gain = draw.random((count, 5)).astype(kind) * (np.exp(0.3j) if kind is complex else 1)
        push, x = draw.standard_normal((count, 3, 5)).astype(kind), draw.standard_normal((3, 5)).astype(kind)
        states, end = follow(gain, push.copy(), x)
        for k in range(count):
            assert np.abs(states[k] - x).max() < 1e-12
            x = gain[k] * x + push[k]
        assert np.abs(end - x).max() < 1e-12


def test_machine_code_gives_what_arrays_give(every, monkeypatch):
    pytest.importorskip("numba")
    problem = problem_of(every["bar"], recorded(every["bar"], speeds(*USUAL), 1))
    theta, found = centres(problem.parameters), []
    for without in (False, True):
        if without:
            monkeypatch.setattr(recursion, "compile_recursion", lambda: None)
            monkeypatch.setattr("network.engine.response.cell_means.compile_means", lambda: None)
        predictions = problem.model.predict(theta)
        pushes = [problem.data[0].pushes(predictions[0].course)]
        found.append((predictions[0].cells, problem.model.mean_slopes(theta, predictions, pushes)[0]))
    assert series.compile_means() is not None
    for a, b in zip(*found, strict=True):
        assert np.abs(a - b).max() < 1e-9 * np.abs(a).max()


def test_held_inputs_are_left_with_their_jumps_and_noisy_ones_are_smoothed():
    t = np.arange(0.0, 14401.0, 10.0)
    noisy = linear("ambient", "degC", t, 20 + 0.1 * np.random.default_rng(0).standard_normal(len(t)))
    schedule = speeds(*USUAL, ambient=noisy)
    machine = two_blocks()
    recording = recorded(machine, schedule, None)
    run = weigh_recording(machine, recording).run
    assert len(run.schedule.signals["speed"].t) == len(USUAL)
    assert np.abs(run.schedule.signals["ambient"].at(t) - 20).std() < 0.06
    assert knots_module.LONGEST >= 60
    plan = Model(machine, (), [run]).predict(np.empty(0))[0].course.problem.plan
    assert len(plan.steps) == len(run.knots.t) - 1
    assert course_of(plan, readouts(plan.network, parts=False)).x0.shape[1] == 2
