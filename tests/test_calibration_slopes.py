"""Slopes by every parameter against differences of runs, and what a fit makes of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fit_networks import RADIATES, STEEL, cooler, machines
from fits import ANOTHER, USUAL, problem_of, recorded, speeds, two_blocks
from scipy.linalg import block_diag

from network.analysis.calibration.gauss_newton import linearise, make_problem, minimise
from network.analysis.calibration.linearised import weigh_anew
from network.analysis.calibration.noise import Noise
from network.analysis.calibration.projector import Projector
from network.engine.assembly import build
from network.engine.balance import affine_matrix
from network.engine.response import cell_means, series
from network.engine.response import model as response_model
from network.engine.response.model import Model
from network.engine.response.nuisance_pushes import edge_pushes, start_pushes
from network.engine.response.parameters import centres
from network.engine.response.segments import Push

EPS = float(np.finfo(float).eps)
SHARE = 5e-3
"""How far slopes may lie from differences: heats run straight between knots."""


def more_machines():
    grows = {"kind": "stretching", "of": "body@0..0.5", "length": "200 mm ± 10 %", "direction": 1}
    geometry = two_blocks(nodes={"body": {**STEEL, "length": "400 mm ± 5 %"}}, tcp={"z": {"grows": grows}})
    material = {"material": "stock", "length": "400 mm", "area": "60 cm^2", "lumps": 3}
    stock = {"density": "7800 kg/m^3", "specific_heat": "460 J/(kg K) ± 10 %",
             "conductivity": "45 W/(m K) ± 20 %", "expansion": "1.1e-5 1/K"}  # fmt: skip
    made = two_blocks(nodes={"body": material}, materials={"stock": stock})
    chiller = {"kind": "pi_cooling", "into": {"motor": 1}, "watches": "motor", "set": "24 degC ± 1 K",
               "gain": "10 W/K ± 30 %", "reset_time": "900 s ± 30 %"}  # fmt: skip
    chilled = two_blocks(sources={"chiller": chiller})
    coil = {"kind": "heat_source", "into": {"body": 1}, "power": "80 W ± 20 %", "with": "speed", "at": "8000 rpm",
            "exponent": "2 ± 20 %", "while": "speed"}  # fmt: skip
    spray = {"kind": "convection", "between": ["motor", "air"], "conductance": "9 W/K ± 20 %", "while": "speed"}
    gated = two_blocks(sources={"coil": coil}, links={"spray": spray})
    lean = {"kind": "stretching", "of": "motor", "length": "90 mm ± 30 %", "expansion": "1.1e-5 1/K ± 20 %",
            "direction": -1}  # fmt: skip
    seen = {"measures": "motor", "noise": "0.05 K", "effects": [{"kind": "sensor_offset", "offset": "0.4 K ± 1 K"}]}
    late = {"kind": "sensor_lag", "lag": "200 s ± 50 %"}
    sensed = two_blocks(
        tcp={"x": {"leans": lean}, "z": {"leans": lean}},
        sensors={"T_motor": seen, "T_late": {**seen, "effects": [*seen["effects"], late]},
                 "dx": {"measures": "tcp.x", "noise": "0.25 um", "zero": "start"}},
    )  # fmt: skip
    late_at_seat = two_blocks(
        nodes={"seat": {}},
        links={
            "flange": {"kind": "conduction", "between": ["motor", "seat"], "conductance": "20 W/K ± 30 %"},
            "seat": {"kind": "conduction", "between": ["seat", "body"], "conductance": "30 W/K ± 30 %"},
        },
        sensors={"T_seat": {"measures": "seat", "noise": "0.05 K", "effects": [late]}},
    )
    bent_and_late = two_blocks(links={"glow": RADIATES}, sensors={"T_late": {**seen, "effects": [late]}})
    hose = {"kind": "advection", "through": ["supply", "body"], "capacity_flow": "15 W/K ± 20 %"}
    cooled = two_blocks(
        nodes={"supply": {"temperature": "18 degC"}, "body": {**STEEL, "length": "400 mm ± 5 %"}},
        tcp={"z": {"grows": grows}},
        links={"hose": hose}, sources={"cooler": cooler("25 s ± 20 %")},
    )  # fmt: skip
    return machines() | {
        "cooled": cooled,
        "sensed": sensed,
        "bent and late": bent_and_late,
        "late at a seat": late_at_seat,
        "gated": gated,
        "geometry": geometry,
        "material": made,
        "chilled": chilled,
    }


MACHINES = more_machines()


def test_tangents_of_bent_laws_stay_while_a_difference_is_made(monkeypatch):
    """However far the means of the run have moved from those that they are laid about: of a number that moves the edges
    of a law, and with them the whole run."""
    drifts = {"swing": "4 K", "peak": "1 h ± 0.5 h"}
    machine = two_blocks(
        nodes={"air": {"temperature": "20 degC", "drifts": drifts}}, links={"glow": RADIATES},
        sources={"cooler": cooler("25 s ± 20 %")},
    )  # fmt: skip
    model = problem_of(machine, recorded(machine, speeds(*USUAL), None)).model
    theta, j = centres(model.parameters), next(i for i, p in enumerate(model.parameters) if p.path.endswith("peak"))
    at = model.predict(theta)
    slopes = model.mean_slopes(theta, at)[0][j]
    model.warm.middle[0] = at[0].course.problem.plan.about + 5.0
    laid = []
    monkeypatch.setattr(response_model, "build_course_about", lambda *of: laid.append(of))
    np.testing.assert_allclose(model.mean_slopes(theta, at)[0][j], slopes, rtol=1e-9)
    assert not laid and np.abs(slopes).max() > 0


@pytest.mark.parametrize("name", list(MACHINES))
def test_slopes_by_every_parameter_are_those_of_differences(name):
    machine = MACHINES[name]
    problem = problem_of(machine, recorded(machine, speeds(*USUAL), None))
    data, theta = problem.data[0], centres(problem.parameters)
    predictions = problem.model.predict(theta)
    slopes = problem.model.mean_slopes(theta, predictions)[0]
    whole = predictions[0].means(problem.model.slopes(theta, predictions)[0])
    weight = np.where(data.known, data.variance**-0.5, 0.0)
    for j, p in enumerate(problem.parameters):
        step = 1e-5 * (1 if p.is_log else p.spread)
        ends = []
        for sign in (1, -1):
            there = theta.copy()
            there[j] += sign * step
            ends.append(problem.model.predict(there)[0].cells)
        difference = (ends[0] - ends[1]) / (2 * step) * weight
        size = max(np.linalg.norm(difference), 1.0)
        assert np.linalg.norm(slopes[j] * weight - difference) < SHARE * size, p.path
        assert np.linalg.norm(whole[j] * weight - difference) < 0.02 * size, p.path


@pytest.mark.parametrize("most", [1, 2, 8])
@pytest.mark.parametrize("name", ["linear", "gated", "cooled", "chilled"])
def test_pieces_of_cells_bring_what_their_intervals_bring(name, most, monkeypatch):
    monkeypatch.setattr(series, "MOST_INTERVALS", most)
    monkeypatch.setattr(cell_means, "compile_means", lambda: None)
    often = [(k / 100, 8000 * (k % 3)) for k in range(200)]
    problem = problem_of(MACHINES[name], recorded(MACHINES[name], speeds(*often), None))
    at = problem.model.predict(centres(problem.parameters))[0]
    course, means, draw = at.course, at._means, np.random.default_rng(1)
    assert np.diff(means.over.starts).max() > 2
    lumps = np.flatnonzero(np.isfinite(course.problem.plan.network.capacity))[:4]
    pushes = [Push(lumps[[i]], *draw.normal(size=(2, len(course.x0), 1))) for i in range(len(lumps))]
    told = means.respond_to(pushes, course.output_map)
    monkeypatch.setattr(cell_means.Means, "_follow_series", cell_means.Means._follow_pushes)
    np.testing.assert_allclose(told, means.respond_to(pushes, course.output_map), atol=1e-11 * np.abs(told).max())


def test_radiation_beside_a_relay_is_as_strong_as_at_the_reference():
    """A fit takes it for linear there: 4 ε A σ T³."""
    own, without = (
        build(two_blocks(sources={"cooler": cooler("0 s")}, links=links)) for links in ({"glow": RADIATES}, {})
    )
    u = {"speed": np.zeros(1), "ambient": np.full(1, 20.0), "time": np.zeros(1)}
    more = affine_matrix(own, u, np.zeros(1)) - affine_matrix(without, u, np.zeros(1))
    motor, kelvin = own.parts["motor"].start, own.machine.reference + 273.15
    assert more[motor, motor] == pytest.approx(-4 * 0.5 * 5.670374419e-8 * kelvin**3, rel=1e-9)


@pytest.mark.parametrize("name", list(MACHINES))
def test_runs_found_as_one_are_those_found_alone(name):
    machine = MACHINES[name]
    problem = problem_of(machine, *(recorded(machine, speeds(*steps), None) for steps in (USUAL, ANOTHER, USUAL[:2])))
    model, centre = problem.model, centres(problem.parameters)
    network = build(machine)
    joins, bent = not (network.relays or network.melting), not network.is_affine()
    for theta in (centre, centre + 0.01):  # what is known from the first point on is used at the second
        together = model.predict(theta)
        assert all((p.joint is not None) == joins for p in together)
        slopes = model.mean_slopes(
            theta, together, [d.pushes(p.course) for d, p in zip(problem.data, together, strict=True)]
        )
        for i, run in enumerate(model.runs if joins else ()):
            alone = Model(machine, model.parameters, [run])
            (own,) = alone.predict(theta)
            close = max(1e-10, 100 * EPS * max(m.condition for m in own.course.modes))  # 25 degC, some ways to add up
            close = 1e-5 if bent else close  # rounds end at 2e-6 K
            assert np.abs(own.cells - together[i].cells).max() < close
            (answers,) = alone.mean_slopes(theta, [own], [problem.data[i].pushes(own.course)])
            assert np.abs(answers - slopes[i]).max() < (1e-4 if bent else 1e-6) * np.abs(answers).max()
            assert len(answers) > len(theta)
            assert np.abs(own.course.x1 - together[i].course.x1).max() < close


@pytest.mark.parametrize(("name", "part"), [*((n, "body") for n in ("linear", "massless", "bent", "relay", "zeroed")),
                                            ("lag", "motor"), ("bent and late", "motor"), ("late at a seat", "body"),
                                            ("late at a seat", "motor")])  # fmt: skip
def test_answers_to_another_start_are_those_of_runs_that_start_so(name, part):
    """Sensors that are slow have settled at it."""
    machine = MACHINES[name]
    problem = problem_of(machine, recorded(machine, speeds(*USUAL), None))
    theta, run = centres(problem.parameters), problem.data[0].run
    at = problem.model.predict(theta)[0]
    column = at.respond_to(start_pushes(at.course, [part]))[0]
    step = 1e-4
    there, back = (problem.model.predict(theta, [{**run.start, part: run.start[part] + s}])[0].cells
                   for s in (step, -step))  # fmt: skip
    assert np.abs((there - back) / (2 * step) - column).max() < 2e-3 * np.abs(column).max()


def test_answers_to_a_later_jump_are_those_of_runs_that_jump_later():
    machine, late = two_blocks(), 1.0
    steps = [(t + (late / 3600 if 0 < t < 1 else 0.0), rpm) for t, rpm in USUAL]
    problem = problem_of(machine, recorded(machine, speeds(*USUAL), None))
    at, data = problem.model.predict(centres(problem.parameters))[0], problem.data[0]
    column = at.respond_to(edge_pushes(at.course, data.run.knots.jumps))[0]
    there = recorded(machine, speeds(*steps), None)
    here = recorded(machine, speeds(*USUAL), None)
    cells, counts = data.run.knots.cell_of, np.bincount(data.run.knots.cell_of)
    moved = there.columns["T_motor"].values - here.columns["T_motor"].values
    means = np.bincount(cells, moved) / counts
    own = column[: len(means)]
    after = int(np.argmax(own != 0))  # the sample at the jump itself comes before the later one
    assert after > 0
    assert np.abs(means - own)[:after].max() < 1e-9  # two runs alike so far, but for rounding
    assert np.abs(means - own)[after + 1 :].max() < 0.02 * np.abs(own).max()


@pytest.mark.parametrize("name", ["linear", "bar", "lag", "fan", "bent", "delayed relay", "geometry"])
def test_a_fit_finds_what_the_recordings_were_made_with(name):
    machine = MACHINES[name]
    problem = problem_of(machine, *(recorded(machine, speeds(*s), None) for s in (USUAL, ANOTHER)))
    problem = replace(problem, data=tuple(replace(d, edges=()) for d in problem.data))
    draw, far = np.random.default_rng(3), 0.02 if "relay" in name else 0.5
    spreads = np.array([p.spread for p in problem.parameters])
    at = minimise(problem, centres(problem.parameters) + far * spreads * draw.standard_normal(len(spreads)))
    error = (at.theta - centres(problem.parameters)) / np.sqrt(np.diag(at.covariance)[: at.free])
    assert np.abs(error).max() < 0.3


def test_repeats_scatter_as_the_covariance_says():
    machine, scaled = two_blocks(), []
    for seed in range(60):
        problem = problem_of(machine, recorded(machine, speeds(*USUAL), seed))
        problem = replace(problem, offsets=(), data=tuple(replace(d, edges=()) for d in problem.data))
        at = minimise(problem)
        scaled.append((at.theta - centres(problem.parameters)) / np.sqrt(np.diag(at.covariance)[: at.free]))
    spread = np.std(scaled, axis=0)
    # about the priors' centres the posterior scatters less than its width where a prior counts
    assert (spread < 1.3).all()
    well_told = np.sqrt(np.diag(at.covariance)[: at.free]) < 0.1 * np.array([p.spread for p in problem.parameters])
    assert well_told.sum() >= 4
    assert (spread[well_told] > 0.7).all()


def test_the_linearised_gradient_is_that_of_the_cost():
    machine = two_blocks()
    problem = problem_of(machine, recorded(machine, speeds(*USUAL), 5))
    theta = centres(problem.parameters) + 0.02
    at = linearise(problem, theta)
    _, gradient = at.reduced
    for j in range(len(theta)):
        costs = []
        for step in (1e-4, -1e-4):
            there = theta.copy()
            there[j] += step
            costs.append(linearise(problem, there).cost)
        by_difference = -0.5 * (costs[0] - costs[1]) / 2e-4
        assert by_difference == pytest.approx(gradient[j], rel=0.02, abs=0.02 * np.abs(gradient).max())


def test_under_another_noise_a_fit_is_what_it_is_found_anew():
    machine = two_blocks()
    problem = problem_of(machine, *(recorded(machine, speeds(*s), 1) for s in (USUAL, ANOTHER)))
    noise = Noise({"T_motor": (0.03, 900.0)})
    other = make_problem(machine, problem.parameters, [replace(d, sigma={**d.sigma, "dz": 1e-6}) for d in problem.data],
                         noise)  # fmt: skip
    assert other.follows(problem) and not other.follows(replace(problem, data=problem.data[:1]))
    at, theta = linearise(problem, centres(problem.parameters) + 0.03), centres(problem.parameters) + 0.03
    told, anew = weigh_anew(at, other), linearise(other, theta)
    assert np.allclose(told.slopes, anew.slopes, rtol=1e-9, atol=1e-9) and np.allclose(told.residual, anew.residual)
    assert told.log_evidence == pytest.approx(anew.log_evidence, rel=1e-9)
    bare = weigh_anew(linearise(replace(problem, offsets=()), theta), other)
    assert np.allclose(bare.slopes, anew.slopes, rtol=1e-9, atol=1e-9)


def test_folding_the_runs_gives_what_the_whole_matrix_gives():
    machine = two_blocks()
    problem = problem_of(machine, *(recorded(machine, speeds(*s), 1) for s in (USUAL, ANOTHER)))
    at = linearise(problem, centres(problem.parameters) + 0.03)
    n, (mean, spread) = at.free, problem.prior
    assert np.abs(at.normal - at.slopes @ at.slopes.T).max() < 1e-9 * np.abs(at.normal).max()
    own = np.linalg.solve(at.precision[n:, n:], np.column_stack([at.precision[n:, :n], at.gradient[n:]]))
    precision, gradient = at.reduced
    assert np.allclose(precision, at.precision[:n, :n] - at.precision[:n, n:] @ own[:, :n])
    assert np.allclose(gradient, at.gradient[:n] - at.precision[:n, n:] @ own[:, n])
    assert np.allclose(at.eta, mean[n:] + own[:, n])
    deviation = (np.concatenate([at.theta, at.eta]) - mean) / spread
    assert at.cost == pytest.approx(at.left @ at.left + deviation @ deviation)
    assert at.misfit == pytest.approx(at.left @ at.left)
    _, volume = np.linalg.slogdet(at.precision * np.outer(spread, spread))
    assert at.log_evidence == pytest.approx(-0.5 * (at.cost + problem.log_determinant + volume))
    rows = np.random.default_rng(0).standard_normal(len(at.residual))
    whole = np.eye(len(rows)) + (at.slopes.T * spread**2) @ at.slopes
    assert np.allclose(whole @ at.project(rows), rows, atol=1e-5)
    projector = Projector(at.slopes, at.precision)
    moved, fall = projector.adjust(rows, np.zeros(len(spread)))
    assert np.allclose(rows - moved @ at.slopes, at.project(rows), atol=1e-8)
    assert projector.misfit(rows) == pytest.approx(rows @ at.project(rows)) == pytest.approx(rows @ rows - fall)
    apart = [np.random.default_rng(1).standard_normal((2, own.stop - own.start)) for own, _ in at.rows.slopes.blocks]
    among, toward = at.weigh_runs(apart)
    assert np.allclose(among, block_diag(*apart) @ at.project(block_diag(*apart)).T, atol=1e-8)
    from_mean = at.left + (np.concatenate([at.theta, at.eta]) - mean) @ at.slopes
    assert np.allclose(at.unexplained, at.project(from_mean), atol=1e-6)
    assert np.allclose(toward, block_diag(*apart) @ at.unexplained, atol=1e-8)


def bent_problem():
    """Of a motor that radiates and a viscous friction."""
    machine = MACHINES["bent"]
    return problem_of(machine, *(recorded(machine, speeds(*steps), None) for steps in (USUAL, ANOTHER)))


def test_what_bent_laws_add_is_told_apart():
    problem = bent_problem()
    model, theta = problem.model, centres(problem.parameters)
    at = model.predict(theta)
    pushes = [d.pushes(p.course) for d, p in zip(problem.data, at, strict=True)]
    whole, apart = model.mean_slopes(theta, at, pushes), model.divide_slopes(theta, at, pushes)
    rough = model.divide_slopes(theta, at, pushes, is_rough=True)
    for slopes, both, straight in zip(whole, apart, rough, strict=True):
        np.testing.assert_allclose(slopes, both.straight + both.bent, atol=1e-12 * np.abs(slopes).max())
        assert straight.bent is None and np.abs(both.bent).max() > 1e-3 * np.abs(slopes).max()
        np.testing.assert_allclose(straight.straight, both.straight, atol=1e-12 * np.abs(slopes).max())


def test_what_bent_laws_add_is_nearly_the_same_nearby():
    """Half a standard error of every number away slopes with it are nearer by far than those without."""
    problem = bent_problem()
    theta = centres(problem.parameters)
    first = linearise(problem, theta)
    there = theta + 0.5 * np.array([p.spread for p in problem.parameters])
    exact, rough = linearise(problem, there), linearise(problem, there, first.bent)
    without = linearise(problem, there, [np.zeros_like(rows) for rows in first.bent])
    off, far = (np.linalg.norm(at.slopes - exact.slopes) for at in (rough, without))
    assert rough.is_rough and not exact.is_rough
    assert 0 < off < 0.4 * far and off < 0.01 * np.linalg.norm(exact.slopes)


def test_a_fit_ends_with_slopes_of_its_own():
    """Whatever those of its steps were."""
    problem = bent_problem()
    fit = minimise(problem, centres(problem.parameters) + 0.3)
    exact = linearise(problem, fit.theta)
    assert not fit.is_rough and fit.bent is not None
    np.testing.assert_allclose(fit.slopes, exact.slopes, rtol=0, atol=0.02 * np.abs(exact.slopes).max())
