"""Calibration: known numbers come back with honest uncertainty, and what cannot be known is said."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from measured import ROOT, blocks, changed, recorded, steps

from network import Machine, Recording, Scenario, calibrate
from network.analysis.calibration.calibrate import Calibration
from network.analysis.calibration.gauss_newton import residual_cost
from network.analysis.calibration.uncertainty import profile

CASES = ROOT.parent / "shared" / "cases"
HOT, COLD = ["hot", "room"], ["cold", "room"]


def joined(conductance: str, **skins: str) -> Mapping[str, Any]:
    """Links of the two blocks with other numbers."""
    found: dict[str, Any] = {"joint": {"kind": "conduction", "between": ["hot", "cold"], "conductance": conductance}}
    for name, value in skins.items():
        found[f"{name} skin"] = {"kind": "convection", "between": [name, "room"], "conductance": value}
    return found


def truth(joint: float = 2.4, hot: float = 0.6, cold: float = 0.4) -> Machine:
    return blocks(links=joined(f"{joint} W/K", hot=f"{hot} W/K", cold=f"{cold} W/K"))


@pytest.fixture(scope="module")
def plain() -> Calibration:
    return calibrate(blocks(), recorded(truth(), steps()), recorded(truth(), steps(), 9, "later"))


# -- numbers and their uncertainty ----------------------------------------------------------------------------------
def test_known_numbers_come_back(plain: Calibration) -> None:
    found = {p.path: p.value(x) for p, x in zip(plain.parameters, plain.theta, strict=True)}
    assert found["links.joint.conductance"] == pytest.approx(2.4, rel=0.01)
    assert found["links.hot skin.conductance"] == pytest.approx(0.6, rel=0.01)
    assert plain.after.rmse_in_noise < 1.03 < 1.8 < plain.before.rmse_in_noise
    assert plain.after_holdout is not None and plain.after_holdout.rmse_in_noise < 1.03


@pytest.mark.proof
def test_standard_errors_are_the_scatter_of_many_recordings() -> None:
    """Numbers drawn from the priors, offsets drawn from theirs: deviations in standard errors scatter by one."""
    rng, deviations = np.random.default_rng(5), []
    for seed in range(24):
        values = np.array([3, 0.5, 0.5]) * np.exp(0.3 * rng.standard_normal(3))
        off = {"T_hot": 0.1 * rng.standard_normal(), "T_cold": 0.1 * rng.standard_normal()}
        off["dz"] = 0.25e-6 * rng.standard_normal()
        shifted = {name: (lambda t, v, by=by: v + by) for name, by in off.items()}
        machine = truth(*values)
        found = calibrate(blocks(), changed(recorded(machine, steps(output="10 s"), seed), **shifted))
        deviations.append((found.theta - np.log(values)) / found.std)
    assert np.sqrt(np.mean(np.square(deviations))) == pytest.approx(1.0, abs=0.25)
    assert np.mean(np.abs(deviations) < 1.96) > 0.87


def test_the_profile_is_the_true_one(plain: Calibration) -> None:
    """J with one number moved and all others searched by brute force rises as the profile says."""
    at, j = plain.fit.at, 0
    move = 2 * plain.std[j]
    grid = np.linspace(-2, 2, 17)
    others = [np.array([move, a * plain.std[1], b * plain.std[2]]) for a in grid for b in grid]
    best = min(residual_cost(at, at.theta + moved) for moved in others)
    assert profile(plain.known, j, move) == pytest.approx(best - at.cost, abs=0.15)
    assert profile(plain.known, j, move) == pytest.approx(4.0, abs=0.5)


def test_the_same_seed_gives_the_same_result() -> None:
    machine = blocks(links=joined("unknown 0.1..50 W/K", hot="0.5 W/K ± 30 %", cold="0.5 W/K ± 100 %"))
    recording = recorded(truth(), steps())
    one, two = (calibrate(machine, recording, seed=3) for _ in range(2))
    np.testing.assert_array_equal(one.theta, two.theta)
    assert one.tried > 1 and one.sentences == two.sentences
    assert one.theta[0] == pytest.approx(np.log(2.4), abs=0.02)


def test_bands_of_the_tool_centre_point_are_what_the_numbers_leave(plain: Calibration) -> None:
    """1σ of dz over numbers drawn from the posterior."""
    rng = np.random.default_rng(0)
    from network import simulate
    from network.engine.response.parameters import at_values, values_at

    drawn = rng.multivariate_normal(plain.theta, plain.known.theta_covariance, 40)
    runs = [simulate(at_values(blocks(), values_at(plain.parameters, x)), steps()).tcp["z"] for x in drawn]
    (band,) = plain.bands[0]
    _, std = band.at(steps().schedule.t)
    spread = np.std(runs, axis=0)
    k = int(np.argmax(spread))
    assert std[k] == pytest.approx(spread[k], rel=0.35)


# -- what is said ---------------------------------------------------------------------------------------------------
def said(found: Calibration) -> str:
    return "\n".join(found.sentences)


def test_a_number_that_nothing_moves_is_known_by_its_prior_only() -> None:
    """A part of its own that begins at the temperature of the room."""
    skin = {"far skin": {"kind": "convection", "between": ["far", "room"], "conductance": "1 W/K"}}
    machine = blocks(nodes={"far": {"heat_capacity": "1 kJ/K ± 20 %"}}, links=skin)
    found = calibrate(machine, recorded(truth(), steps()))
    assert "Nothing in these recordings tells nodes.far.heat_capacity" in said(found)
    assert found.summary()["parameters"][0]["prior_only"] is True


def test_two_heats_into_one_place_are_known_as_a_sum() -> None:
    rubs = {"kind": "heat_source", "into": {"hot": 1}, "with": "level", "at": "1"}
    sources = {"heater": {**rubs, "power": "6 W ± 30 %"}, "other": {**rubs, "power": "7 W ± 30 %"}}
    links = joined("2.4 W/K", hot="0.6 W/K", cold="0.4 W/K")
    found = calibrate(blocks(sources=sources, links=links), recorded(truth(), steps()))
    assert "sources.heater.power and sources.other.power are known only as a sum" in said(found)


def test_heat_and_every_path_out_are_known_as_ratios() -> None:
    """Nothing fixes the size of the heat where capacities are free as well."""
    machine = blocks(
        nodes={"hot": {"heat_capacity": "400 J/K ± 30 %"}, "cold": {"heat_capacity": "400 J/K ± 30 %"}},
        sources={"heater": {"kind": "motor_loss", "into": {"hot": 1}, "copper": "12 W ± 30 %", "iron": "0 W",
                            "iron_exponent": 1, "reference_speed": "1 rpm"}},
    )  # fmt: skip
    inputs = {"ambient": "22 degC", "speed": [{"for": "40 min", "at": "1 rpm"}, {"for": "40 min", "at": "0 rpm"}]}
    found = calibrate(machine, recorded(machine.patched(fixed(machine)), steps(inputs=inputs)))
    assert "known only as a ratio" in said(found)


def fixed(machine: Machine) -> Mapping[str, Any]:
    """Its numbers without their spread."""
    plain = machine.to_plain()
    bare = {section: {} for section in ("nodes", "links", "sources")}  # type: dict[str, dict[str, Any]]
    for section, entries in bare.items():
        for name, entry in plain[section].items():
            entries[name] = {k: v.partition(" ±")[0] if isinstance(v, str) else v for k, v in entry.items()}
    return bare


def test_missing_physics_shows_as_far_moved_numbers_and_wide_errors() -> None:
    """A third path out that the file lacks."""
    leak = {"leak": {"kind": "radiation", "between": ["hot", "room"], "emissivity_area": "0.06 m^2"}}
    timed = {
        "pump": {"kind": "timed_source", "into": {"cold": 1}, "power": "4 W", "period": "9 min", "duration": "3 min"}
    }
    found = calibrate(blocks(), recorded(truth().patched({"links": leak, "sources": timed}), steps()))
    assert found.known.misfit > 2
    assert "some physics is missing" in said(found) and "twice their ± moved" in said(found)
    offsets = found.after.recordings[0].constants.offsets if found.after.recordings[0].constants else {}
    assert max(abs(offsets[n]) for n in ("T_hot", "T_cold")) <= 0.3


def test_a_number_at_its_bound_says_so() -> None:
    machine = blocks(links=joined("unknown 3..50 W/K", hot="0.6 W/K", cold="0.4 W/K ± 10 %"))
    found = calibrate(machine, recorded(truth(), steps()))
    assert "links.joint.conductance is at its bound, 3 W/K" in said(found)
    assert found.summary()["parameters"][0]["at_bound"] is True


# -- robust ---------------------------------------------------------------------------------------------------------
def test_readings_far_off_and_gaps_do_not_move_the_numbers() -> None:
    def spoiled(t: np.ndarray[Any, Any], values: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        values[40::97] += 30.0
        values[300:340] = np.nan
        return values

    found = calibrate(blocks(), changed(recorded(truth(), steps()), T_hot=spoiled))
    assert np.exp(found.theta[0]) == pytest.approx(2.4, rel=0.015)
    assert any("9 readings are left out" in warning and "T_hot" in warning for warning in found.warnings)


def test_coloured_noise_widens_the_standard_errors() -> None:
    def coloured(t: np.ndarray[Any, Any], values: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        rng, e = np.random.default_rng(1), 0.0
        for k in range(len(values)):
            e = 0.98 * e + 0.02 * rng.standard_normal()
            values[k] += e
        return values

    recording = recorded(truth(), steps())
    white, found = calibrate(blocks(), recording), calibrate(blocks(), changed(recording, T_hot=coloured))
    assert "T_hot" in found.noise.coloured and "T_cold" not in found.noise.coloured
    assert (found.std > white.std).all() and found.known.misfit < 1.1


def test_a_relay_is_found_from_a_wrong_set_point() -> None:
    """Set point, hysteresis and power of a thermostat, each a prior σ off: least squares alone slips a cycle."""
    slow = {name: {"heat_capacity": "4 kJ/K"} for name in ("hot", "cold")}
    inputs = {"ambient": "22 degC", "level": [{"for": "3 h", "at": "1"}, {"for": "1 h", "at": "0"}]}

    def cooled(set_point: str, power: str, hysteresis: str) -> Machine:
        relay = {"kind": "thermostat_cooling", "into": {"hot": 1}, "watches": "hot", "set": set_point,
                 "hysteresis": hysteresis, "power": power}  # fmt: skip
        links = joined("2.4 W/K", hot="0.6 W/K ± 10 %", cold="0.4 W/K")
        return blocks(links=links, sources={"chiller": relay}, nodes=slow)

    guess = cooled("26.5 degC ± 1 K", "10 W ± 30 %", "0.8 K ± 30 %")
    truly = cooled("27.4 degC", "13 W", "0.6 K")
    found = calibrate(guess, recorded(truly, steps("4 h", inputs, "10 s")))
    values = {p.path: p.value(x) for p, x in zip(found.parameters, found.theta, strict=True)}
    assert values["sources.chiller.set"] == pytest.approx(27.4, abs=0.05)
    assert values["sources.chiller.power"] == pytest.approx(13, rel=0.03)
    assert found.after.rmse_in_noise < 1.1


# -- concealed cases --------------------------------------------------------------------------------------------------
@pytest.mark.skipif(not CASES.is_dir(), reason="the concealed cases in ../shared/cases are not here")
@pytest.mark.parametrize(("case", "lumps", "least"), [("h-innocent", (), 1.05), ("i-innocent-fine", (20,), 1.1)])
def test_innocent_machines_reach_their_noise_on_what_was_held_out(
    case: str, lumps: tuple[int, ...], least: float
) -> None:
    machine = Machine.load(CASES / case / "machine.yaml", lumps=lumps)
    train, held_out = ([Recording.load(CASES / case / f"{n}.csv") for n in names]
                       for names in (("train1", "train2", "train3"), ("holdout",)))  # fmt: skip
    found = calibrate(machine, train, held_out)
    assert found.after_holdout is not None and found.after_holdout.rmse_in_noise < least


def test_a_start_that_first_readings_do_not_tell_is_found() -> None:
    """An inner part begins 4 K warmer than what is sensed would have it."""
    nodes = {"core": {"heat_capacity": "2 kJ/K"}}
    links = {"inside": {"kind": "conduction", "between": ["core", "hot"], "conductance": "1 W/K"}}
    machine = blocks(nodes=nodes, links=links)
    true = truth().patched({"nodes": nodes, "links": links})
    begin = {"core": "30 degC", "hot": "28 degC", "cold": "25 degC"}
    scenario = Scenario.of("begun", "80 min", {"ambient": "22 degC", "level": "0"}, output="5 s", start=begin)
    found = calibrate(machine, recorded(true, scenario))
    told = found.summary()["fit"]["train"]
    assert found.after.rmse_in_noise < 1.1 < 1.3 < told["after_as_stated"]["rmse_in_noise"]
    assert float(told["runs"][0]["start"]["core"].split()[0]) == pytest.approx(30, abs=0.7)
    assert "With the starts, inputs and offsets of each run" in said(found)
