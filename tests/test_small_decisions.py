"""Single decisions of a fit and a search, on bare numbers: what mutation testing found no quick test to look at."""

from __future__ import annotations

from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from build import RPM, machine
from scipy.special import ndtri

from network.analysis.calibration import gauss_newton, limit_cycle_matching, one_machine, uncertainty, unit_mistakes
from network.analysis.calibration.coloured_noise import LOUDEST, bound_by_peers
from network.analysis.calibration.gauss_newton import FAR
from network.analysis.calibration.limit_cycle_matching import along
from network.analysis.calibration.misfit import correlate_neighbours
from network.analysis.calibration.recording_admission import _check_length
from network.analysis.calibration.trust_region import bounded_step
from network.analysis.calibration.uncertainty import Uncertainty
from network.analysis.diagnosis.experiments.programs import Program
from network.analysis.diagnosis.findings.findings import list_rivals, windows_of
from network.analysis.diagnosis.latent_heat.heat_evidence import explain_best
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.switching.prior_samples import Judge
from network.platform.refusal import Complaints
from network.recordings.inputs import constant, hold


def bare(**values: Any) -> Any:
    return SimpleNamespace(**values)


# -- a fit ----------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_step_ends_at_the_bound_that_it_would_pass(sign: float) -> None:
    """The other number, which hangs together with it, then goes to where it is best beside that bound."""
    precision, gradient = np.array([[2.0, 1.0], [1.0, 3.0]]), sign * np.array([4.0, 1.0])
    bound, wide = np.array([0.5, 9.0]), (-9 * np.ones(2), 9 * np.ones(2))
    step = partial(bounded_step, precision, gradient, np.ones(2), np.inf)
    np.testing.assert_allclose(step(wide), np.linalg.solve(precision, gradient), rtol=1e-6)
    beside = (gradient[1] - precision[1, 0] * sign * 0.5) / precision[1, 1]
    low, high = (-9 * np.ones(2), bound) if sign > 0 else (-bound, 9 * np.ones(2))
    np.testing.assert_allclose(step((low, high)), [sign * 0.5, beside], atol=1e-6)


def test_neighbours_are_correlated_by_their_products_less_what_chance_brings() -> None:
    x = np.repeat([1.0, -1.0, 1.0, -1.0], 100)
    products = 399 - 2 * 3  # 3 of 399 pairs are opposite
    assert correlate_neighbours([x]) == pytest.approx(products / 399 - 2 / np.sqrt(399))
    assert correlate_neighbours([x, x]) == pytest.approx(products / 399 - 2 / np.sqrt(2 * 399))
    assert correlate_neighbours([np.tile([1.0, -1.0], 50)]) == 0.0
    assert correlate_neighbours([np.ones(3)]) == 0.0 and correlate_neighbours([np.ones(1)]) == 0.0


def test_numbers_are_tried_evenly_on_both_sides_of_what_is_stated() -> None:
    known = bare(centre=2.0, spread=0.1, is_unknown=False, low=1.9, high=9.0)
    tried = along(known, 1)
    assert len(tried) == 7 and tried.min() == 1.9 and tried.max() == pytest.approx(2 + 1.5 * 0.1 * 6 / 7)
    unknown = along(bare(centre=2.0, spread=7.0, is_unknown=True, low=-99.0, high=99.0), 1)
    np.testing.assert_allclose(unknown - 2, [-6, -4, -2, 0, 2, 4, 6])
    assert [len(along(known, together)) for together in (2, 3, 9)] == [7, 4, 2]


def test_a_wrong_unit_is_looked_for_where_a_fit_leaves_much(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = list[float]()
    monkeypatch.setattr(unit_mistakes, "_channels", lambda written: asked.append(written) or ["a channel"])
    monkeypatch.setattr(unit_mistakes, "move_beside", lambda at, theta: at.left[0])
    monkeypatch.setattr(unit_mistakes, "centres", lambda parameters: None)
    for left in (19.9, 20.1, 500.0):
        list(unit_mistakes.misread(bare(left=np.full(9, left), cost=1.0, problem=bare(parameters=()))))
    assert asked == [20.1, 500.0]


@pytest.mark.parametrize("measured, told", [
    (lambda T, dz: (T + 273.15, dz), ["T reads +273 K beside the simulation, as kelvin and degrees Celsius do"]),
    (lambda T, dz: (20 + 40 * (T - 20), dz), []),
    (lambda T, dz: (T, 1e3 * dz), ["dz reads 1e3 times what is simulated, in the same shape"]),
    (lambda T, dz: (T, np.where(np.arange(9) < 2, 1e3 * dz, np.nan)), []),
])  # fmt: skip
def test_a_channel_in_a_wrong_unit_is_told_by_its_sensor_whatever_its_header_says(
    measured: Any, told: list[str]
) -> None:
    """A temperature that moves forty times as far may lack a path; two means always lie along each other."""
    T, dz = 20 + np.linspace(0.0, 5.0, 9), 1e-6 * np.linspace(0.0, 40.0, 9)
    means = np.concatenate(measured(T, dz))
    data = bare(
        run=bare(knots=bare(cells=9), channels=("T", "dz")), known=np.isfinite(means), means=np.nan_to_num(means),
        centres=np.arange(9.0), sigma={"T": 0.1, "dz": 1e-7}, recording=bare(file="day.csv"),
    )  # fmt: skip
    machine = bare(sensors={"T": bare(unit="degC"), "dz": bare(unit="um")})
    written = bare(problem=bare(model=bare(machine=machine), data=(data,)), predictions=(
        bare(cells=np.concatenate([T, dz])),))  # fmt: skip
    assert [refusal.wrong for refusal in unit_mistakes._channels(written)] == told


@pytest.mark.parametrize("power, told", [(3, True), (1, False), (5, False)])
def test_a_number_is_asked_for_its_unit_where_a_power_of_ten_explains_most(
    power: int, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """16 times less cost, a quarter of what is left, is what it takes; five powers of ten are not looked for."""
    cost = {10.0**3: 9 * 25.0**2 / 17, 10.0**1: 9 * 25.0**2 / 15, 10.0**5: 0.0}
    monkeypatch.setattr(
        unit_mistakes, "residual_of", lambda at, j, factor: cost[factor] if factor == 10.0**power else 1e9
    )
    p = bare(path="links.fins.conductance", centre=1.0, is_unknown=False, value=lambda x: 2.0 * x,
             field=bare(unit="W/K"), format_value=lambda x: "2 W/K")  # fmt: skip
    problem = bare(parameters=(p,), model=bare(machine=bare(file="m.yaml")), data=(None,))
    found = list(unit_mistakes._numbers(bare(problem=problem, cost=9 * 25.0**2, left=np.full(9, 25.0))))
    assert len(found) == told
    if told:
        assert "is 2 W/K, and with 2000 W/K" in found[0].wrong and "met to 6.06 σ instead of 25 σ" in found[0].wrong


def test_a_model_is_read_in_the_middle_of_bins_straight_between_knots() -> None:
    edges, T = np.array([0.0, 100.0, 400.0, 1000.0]), np.array([20.0, 30.0, 24.0, 60.0])
    course = bare(problem=bare(plan=bare(edges=edges)))
    data, values = bare(run=bare(knots=bare(t=edges))), np.concatenate([T[:-1], T[1:]])[None]
    (read,) = limit_cycle_matching.model_cycle(data, bare(course=course, values=values))
    middle = np.linspace(0.0, 1000.0, 301)[:-1] + 1000 / 600
    np.testing.assert_allclose(read, np.interp(middle, edges, T))


def test_a_recording_lasts_from_its_first_sample_to_its_last() -> None:
    """Of a part with τ = 100 s; what is before the first sample does not count."""
    skin = {"kind": "convection", "between": ["a", "air"], "conductance": "10 W/K"}
    nodes = {"a": {"heat_capacity": "1 kJ/K"}, "air": {"temperature": "20 degC"}}
    of = machine(nodes, links={"skin": skin}, sensors={"T": {"measures": "a", "noise": "0.1 K"}})
    for first, last, told in ((0.0, 101.0, 0), (0.0, 99.0, 1), (1000.0, 1099.0, 1), (1000.0, 1101.0, 0)):
        complaints = Complaints()
        _check_length(of, [bare(recording=bare(t=np.array([first, last]), file="r"))], complaints)
        assert len(complaints.refusals) == told


def linear_fit(theta: Any) -> Any:
    """y = Sᵀθ, 1σ of noise 1, θ ~ N(0, 2²), as `profile` sees it."""
    slopes, read = np.array([[1.0, 2.0, 0.5, 1.0], [1.0, -1.0, 2.0, 0.3]]), np.array([3.0, 1.0, 2.0, 0.5])
    one = bare(low=-9.0, high=9.0)
    left, prior = read - slopes.T @ theta, (np.zeros(2), np.full(2, 2.0))
    return bare(theta=np.asarray(theta), eta=np.zeros(0), free=2, slopes=slopes, normal=slopes @ slopes.T, left=left,
                stated_prior=prior, problem=bare(parameters=(one, one)))  # fmt: skip


@pytest.mark.parametrize("misfit", [1.0, 1.7])
@pytest.mark.parametrize("along", [[1.0, 0.0], [1.0, -0.8]])
def test_a_profile_rises_by_the_square_of_the_standard_errors_moved(
    along: list[float], misfit: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of what is linear, exactly, and whatever the way on which the others were taken along."""
    monkeypatch.setattr(uncertainty, "linearise", lambda problem, theta: linear_fit(theta))
    S = linear_fit(np.zeros(2)).slopes
    precision = S @ S.T / misfit**2 + np.eye(2) / 4
    best = np.linalg.solve(precision, S @ linear_fit(np.zeros(2)).left / misfit**2)
    known = bare(at=linear_fit(best), misfit=misfit, covariance=np.array([along, along]).T)
    moved = 0.7 * np.linalg.inv(precision)[0, 0] ** 0.5
    assert uncertainty.profile(known, 0, moved) == pytest.approx(0.7**2)


@pytest.mark.parametrize(
    "rise, sigma",
    [(4.0, 1.0), (16.0, 0.5), (1.0, 2.0), (400.0, 1 / 3), (0.26, 3.0), (0.25, 1.0), (-1.0, 1.0), (np.inf, 1.0)],
)
def test_a_side_is_where_a_parabola_rises_by_one(rise: float, sigma: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A third to three times what slopes say, and that alone where nothing rises or it breaks down."""
    monkeypatch.setattr(uncertainty, "profile", lambda known, j, move: rise)
    assert uncertainty._sides(bare(std=np.array([9.0, 0.1])), 1) == pytest.approx((0.1 * sigma, 0.1 * sigma))


def test_a_sensor_is_no_louder_than_what_is_built_alike() -> None:
    """LOUDEST times the median of its kind; one that is alone, times what its file says or its white noise shows."""
    units, most = dict.fromkeys("abcdef", "degC") | {"z": "um"}, LOUDEST
    peers = dict.fromkeys("abcde", (0.1, 0.02, 60.0))
    told = bound_by_peers({**peers, "f": (0.1, 5.0, 60.0), "z": (0.3, 9.0, 60.0)}, units, {"z": 0.5})
    assert told["f"] == pytest.approx((0.1, most * 0.02, 60.0)) and told["z"] == pytest.approx((0.3, most * 0.5, 60.0))
    assert all(told[name] == peers[name] for name in peers)
    silent = dict.fromkeys("abcde", (0.1, 0.0, 60.0))
    assert bound_by_peers({**silent, "f": (0.1, 5.0, 60.0)}, units, {})["f"] == (0.1, 0.0, 0.0)
    unknown = bound_by_peers({"z": (0.3, 9.0, 60.0)}, units, {})
    assert unknown["z"] == (0.3, 9.0, 60.0)


def test_numbers_that_only_their_prior_knows_and_those_at_a_bound() -> None:
    """Known to less than a tenth better than stated, within 1σ of it; a bound, within a thousandth of σ."""
    theta, spread = np.array([0.0, 0.0, 0.3, 0.19, -4.9999, -4.999]), np.array([0.3, 0.3, 0.2, 0.2, 0.3, 0.3])
    numbers = [bare(centre=0.0, spread=s, low=-5.0, high=5.0) for s in spread]
    at = bare(theta=theta, problem=bare(parameters=numbers))
    known = bare(at=at, std=spread * [0.91, 0.89, 1.0, 1.0, 0.1, 0.1])
    assert Uncertainty.prior_only.fget(known) == (0, 3)  # type: ignore[attr-defined]
    assert Uncertainty.at_bound.fget(known) == (4,)  # type: ignore[attr-defined]


@pytest.mark.parametrize("chi, by", [(0.5, (1.0, 1.0)), (3.0, (1.0, 3.0)), (2 * FAR, (2 * FAR, 2 * FAR))])
def test_priors_are_narrowed_by_the_misfit_that_is_left(
    chi: float, by: tuple[float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gauss_newton, "chi_of", lambda at: chi)
    at = bare(temper=lambda firm, loose: (firm, loose))
    assert gauss_newton._temper_priors(at) == by  # type: ignore[comparison-overlap]
    assert gauss_newton._temper_priors(at, free=True) == (1.0, by[1])  # type: ignore[comparison-overlap]


@pytest.mark.parametrize("factor, names", [(0.999, []), (1.001, ["b"])])
def test_runs_disagree_beyond_what_one_in_a_hundred_searches_brings(
    factor: float, names: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of two numbers in three runs: 6 comparisons, 0.01 of all of them by chance is 3.14 σ."""
    most = float(-ndtri(0.01 / 2 / 6))
    off = factor * most * (1 + 1 / 2) ** 0.5  # from the mean of two others, known to 1/√2
    alone = {"1": [0.0, off], "2": [0.5, 0.0], "3": [-0.5, 0.0]}
    monkeypatch.setattr(one_machine, "_fit_alone", lambda null, d: (np.array(alone[d.recording.file]), np.ones(2)))
    monkeypatch.setattr(one_machine, "has_relays", lambda machine: False)

    def null_of(*files: str) -> Any:
        runs = tuple(bare(recording=bare(file=file)) for file in files)
        return bare(parameters=("a", "b"), original=None, fit=bare(at=bare(problem=bare(data=runs))))

    null = null_of(*alone)
    found = one_machine.find_disagreements(null)
    assert [d.parameter for d in found] == names
    if names:
        assert found[0].sigma == pytest.approx(factor * most) and found[0].theta == {"1": off, "2": 0.0, "3": 0.0}
    assert one_machine.find_disagreements(null_of("1")) == ()
    alone = {"1": [9.0, 99.0], "2": [0.0, 0.0], "3": [0.0, 0.0]}
    gravest = one_machine.find_disagreements(null)
    assert [d.parameter for d in gravest] == ["b", "a"]


# -- a search -------------------------------------------------------------------------------------------------------
def hypothesis(kind: str, evidence: float) -> Any:
    found = bare(key=(kind,), kind=bare(kind=kind), places=("bed",), channels=())
    return bare(found=(found,), evidence=evidence, weighed=evidence, chi=1.0, shift=np.zeros(1))


def test_rivals_are_told_that_stand_less_than_what_cannot_be_told_apart_behind_nothing() -> None:
    alike = SETTINGS.alike
    null = bare(evidence=-50.0, weighed=-50.0)
    ranked = [hypothesis("a", -20.0), hypothesis("b", -50.0 - 0.9 * alike), hypothesis("c", -50.0 - 1.1 * alike)]
    assert [rival.kind for rival in list_rivals(ranked, null)] == ["a", "b"]
    assert [rival.kind for rival in list_rivals(ranked, null, ("a",))] == ["b"]
    assert [rival.gain for rival in list_rivals(ranked, null)] == pytest.approx([30.0, -0.9 * alike])


def test_unknown_heat_is_told_from_its_first_knot_to_its_last() -> None:
    t, heat = np.arange(9.0) * 60, np.array([0, 5, 5, -5, 0, 9, 0, 5, 5.0])
    unknown = bare(t=[t], heat=[heat], std=[np.full(9, 2.0)])
    assert windows_of([unknown]) == ((60.0, 180.0), (420.0, 480.0))
    assert windows_of([]) == ()


def test_evidence_of_an_unknown_heat_is_that_of_gaussians() -> None:
    """Readings y ~ N(0, 1 + 4) beside y ~ N(0, 1), for y = 3: ½ · 9 (1 − 1/5) − ½ log 5; two of them add up."""
    one = 0.5 * 9 * (1 - 1 / 5) - 0.5 * np.log(5)
    knot, alone = np.zeros(1), [2.0]
    told = explain_best(np.eye(1), np.array([3.0]), [knot], alone)
    assert told.gain == pytest.approx(one) and told.course == pytest.approx([3 * 4 / 5])
    assert told.std == pytest.approx([0.8**0.5]) and told.size == 2.0
    assert explain_best(np.eye(2), np.array([3.0, 3.0]), [knot, knot], alone).gain == pytest.approx(2 * one)


def test_a_program_is_told_step_by_step_to_its_end() -> None:
    speed = hold("speed", "rpm", np.array([0.0, 600.0, 3600.0]), np.array([0.0, 8000.0, 0.0]) * RPM)
    told = Program("a day", 2.0, {"speed": speed, "air": constant("air", "degC", 21.0)}, 20.0, 10.0).scenario()
    assert [row["for"] for row in told["phases"]] == ["10 min", "50 min", "60 min"]
    assert [row["speed"] for row in told["phases"]] == ["0 rpm", "8000 rpm", "0 rpm"] and told["inputs"] == {
        "air": "21 degC"
    }


def test_draws_far_from_the_prior_count_as_much_worse_as_they_are_unlikely() -> None:
    judge = bare(space=bare(prior=(np.array([1.0, 2.0]), np.array([0.5, 4.0]), None, None)))
    view, residual = bare(take_up=lambda residual: (None, np.array([1.0, 0.0]))), np.array([[3.0, 0.0], [1.0, 1.0]])
    theta = np.array([[1.0, 2.0], [2.0, 10.0]])
    assert Judge.misfits(judge, view, theta, residual) == pytest.approx([9 - 1, 2 + 4 + 4])
    assert Judge.misfits(judge, view, theta, residual * np.nan).tolist() == [np.inf, np.inf]
