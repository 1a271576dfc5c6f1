"""A machine whose cooler switches is calibrated in step with its recording, from one beginning."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from network import Machine, Recording, Scenario, calibrate, simulate
from network.analysis.calibration.growing_horizon import begin_in_step
from network.analysis.calibration.measured_means import weigh_recording
from network.analysis.diagnosis.intermittent.channel_samples import truth_at_samples
from network.engine.response.model import Model
from network.engine.response.parameters import at_prior_centres, free_parameters
from network.report.files.result_files import write_run

ROOT = Path(__file__).parents[1]
INPUTS = {
    "speed": [{"for": "2 h", "at": "8000 rpm"}, {"for": "1 h", "at": "3000 rpm"}, {"for": "3 h", "at": "10000 rpm"},
              {"for": "1 h", "at": "0 rpm"}, {"for": "3 h", "at": "9000 rpm"}, {"for": "2 h", "at": "6000 rpm"}],
    "ambient": "21.6 degC",
}  # fmt: skip


@pytest.fixture(scope="module")
def chilled() -> Machine:
    return Machine.load(ROOT / "machines" / "chilled_spindle.yaml")


def test_switchings_fall_into_step(chilled: Machine, tmp_path: Path) -> None:
    """112 switchings, the jacket a quarter off: from the priors' centres alone the tank stays 10 σ off."""
    weaker = chilled.patched({"links.coolant jacket.conductance": "22 W/K"})
    run = simulate(weaker, Scenario.of("a day of shifts", "12 h", INPUTS, output="20 s"), noise_seed=3)
    assert len(run.switches) > 100
    write_run(run, tmp_path)
    found = calibrate(chilled, Recording.load(tmp_path / "results.csv"))
    tank = found.after.recordings[0].channels["T_tank"]
    assert tank.rmse_in_noise < 1.1 and found.after.rmse_in_noise < 1.1 and found.before.rmse_in_noise > 10
    jacket = next(k for k, p in enumerate(found.parameters) if p.path == "links.coolant jacket.conductance")
    assert abs(found.theta[jacket] - np.log(22)) < 3 * found.std[jacket]
    assert found.tried == 1


@pytest.mark.proof
def test_what_switches_stays_in_step_in_a_room_that_is_only_stated(chilled: Machine, tmp_path: Path) -> None:
    """The room is 2.4 K warmer than stated: how often the chiller switches hangs on that, and not along a line."""
    warm = {**INPUTS, "ambient": "24 degC"}
    write_run(simulate(chilled, Scenario.of("a warm day", "12 h", warm, output="20 s"), noise_seed=3), tmp_path)
    mapping = tmp_path / "warm.yaml"
    names = {"time": "s", "speed": "rpm", **{name: sensor.unit for name, sensor in chilled.sensors.items()}}
    columns = [f"{name} [{text}]" for name, text in names.items()]
    told = {"recording": "a warm day", "file": "results.csv", "inputs": {"ambient": "21.6 degC ± 2 K"}}
    mapping.write_text(yaml.safe_dump({**told, "columns": {name: name for name in columns}}))
    found = calibrate(chilled, Recording.load(mapping))
    (run,) = found.after.recordings
    assert run.rmse_in_noise < 1.1 and run.constants is not None
    assert run.constants.inputs["ambient"].value == pytest.approx(24, abs=0.5)


def test_without_relays_there_is_nothing_to_fall_into() -> None:
    gantry = Machine.load(ROOT / "machines" / "gantry_spindle.yaml")
    assert begin_in_step(gantry, free_parameters(gantry), [], None, lambda: False) is None


def test_it_says_what_it_does_and_what_it_has(chilled: Machine, tmp_path: Path) -> None:
    """A listener with `now` hears stages and the misfit that is left; one without hears shares alone."""

    class Listener:
        def __init__(self) -> None:
            self.said: list[str] = []
            self.shares: list[float] = []

        def __call__(self, share: float) -> None:
            self.shares.append(share)

        def now(self, what: str) -> None:
            self.said.append(what)

    write_run(simulate(chilled, Scenario.of("a morning", "3 h", INPUTS, output="20 s"), noise_seed=3), tmp_path)
    heard, plain = Listener(), list[float]()
    calibrate(chilled, Recording.load(tmp_path / "results.csv"), progress=heard)
    assert heard.said[0] == "looking at the recordings" and "fitting 23 numbers" in heard.said
    assert "what switches falls into step: all of the recordings" in heard.said
    assert heard.said[-1].endswith(" σ left; bands, and every recording beside it")
    assert heard.shares == sorted(heard.shares)
    calibrate(chilled, Recording.load(tmp_path / "results.csv"), progress=plain.append)
    assert plain == heard.shares


def test_laws_that_bend_beside_a_relay_are_those_of_the_run_itself(chilled: Machine, tmp_path: Path) -> None:
    """Buoyancy and radiation by their tangents about the means of the run, against stiff steps; about the reference
    the skin would carry nothing by buoyancy, and parts would be a kelvin too warm."""
    skins = {
        "still air": {"kind": "natural_convection", "between": ["housing", "ambient"], "area": "0.8 m^2",
                      "coefficient": "3 W/(m^2 K^1.25)", "exponent": "0.25"},
        "to the walls": {"kind": "radiation", "between": ["housing", "ambient"], "emissivity_area": "0.5 m^2"},
    }  # fmt: skip
    bent = chilled.patched({"links": skins})
    run = simulate(bent, Scenario.of("a day of shifts", "6 h", INPUTS, output="20 s"), method="solve_ivp:LSODA")
    write_run(run, tmp_path)
    recording = Recording.load(tmp_path / "results.csv")
    known = at_prior_centres(bent, free_parameters(bent))
    (told,) = Model(known, (), [weigh_recording(known, recording, None).run]).predict(np.empty(0))
    off = {name: truth_at_samples(told, recording, name) - run.sensors[name] for name in ("T_tank", "T_housing")}
    assert {name: float(np.sqrt(np.mean(x**2))) < 0.1 for name, x in off.items()} == dict.fromkeys(off, True)
