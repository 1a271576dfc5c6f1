"""Constants of a run: an uncertain room, offsets of sensors, starts; in fits, and held out from the run's beginning."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fits import ANOTHER, USUAL, problem_of, recorded, speeds, two_blocks

from network import Machine, Recording, Refused, Scenario, calibrate
from network.analysis.calibration.calibrate import Calibration
from network.analysis.calibration.estimated_constants import (
    Numbers,
    compare_estimated,
    compare_estimating,
    estimate_constants,
)
from network.analysis.calibration.gauss_newton import minimise
from network.analysis.calibration.linearised import linearise
from network.analysis.calibration.measured_means import weigh_recording
from network.analysis.calibration.misfit import channel_misfits
from network.analysis.comparison.compare import compare
from network.engine.response.input_slopes import acts_by_heat, input_slopes
from network.engine.response.model import Model
from network.engine.response.parameters import centres
from network.platform.yaml.document import dump
from network.recordings.inputs import constant

RADIATES = {"shine": {"kind": "radiation", "between": ["motor", "air"], "emissivity_area": "0.5 m^2"}}
ROOMS = (24.5, 19.0)


def run_in(
    room: float, steps: tuple[tuple[float, float], ...] = USUAL, seed: int = 0,
    more: Mapping[str, np.ndarray] | None = None, machine: Machine | None = None,
) -> Recording:  # fmt: skip
    """A run in a room that its recording does not tell; its parts begin at 20 °C."""
    schedule = speeds(*steps, ambient=constant("ambient", "degC", room))
    made = recorded(machine or two_blocks(), schedule, seed, more)
    columns = {n: c for n, c in made.columns.items() if n != "ambient"}
    stated = {"ambient": constant("ambient", "degC", 22.0, 2.0)}
    return replace(made, name=f"{room}", file=f"{room}", columns=columns, constants=stated, start=None)


@pytest.fixture(scope="module")
def fitted() -> Calibration:
    return calibrate(two_blocks(), [run_in(ROOMS[0], seed=1), run_in(ROOMS[1], ANOTHER, seed=2)], run_in(21.0, seed=3))


def test_the_rooms_of_the_runs_are_found(fitted: Calibration) -> None:
    found = [r.constants.inputs["ambient"] for r in fitted.after.recordings if r.constants]
    assert [c.value for c in found] == pytest.approx(ROOMS, abs=0.15)
    assert fitted.after.rmse_in_noise < 1.1 < 3 < fitted.stated.rmse_in_noise


def test_numbers_come_back_although_no_room_was_known(fitted: Calibration) -> None:
    known = {p.path: p.value(x) for p, x in zip(fitted.parameters, fitted.theta, strict=True)}
    for path, value in (("links.flange.conductance", 12.0), ("links.skin.conductance", 7.0)):
        assert known[path] == pytest.approx(value, rel=0.06)


def test_a_held_out_run_tells_its_constants_at_its_beginning(fitted: Calibration) -> None:
    assert fitted.after_holdout is not None
    (run,) = fitted.after_holdout.recordings
    assert run.constants is not None and run.constants.scored_from == pytest.approx(0.1 * 4 * 3600)
    for channel in run.channels.values():
        assert (
            np.isnan(channel.measured[channel.t < 1440]).all()
            and np.isfinite(channel.measured[channel.t >= 1440]).all()
        )
    assert run.rmse_in_noise < 2.5 < compare(fitted.machine, run_in(21.0, seed=3)).rmse_in_noise


def test_the_file_that_is_written_tells_a_held_out_run_as_was_claimed(fitted: Calibration, tmp_path: Path) -> None:
    """But for its digits: numbers rounded by 4e-6 move it by 2e-4, as numbers moved by 1e-6 at random do by 4e-5."""
    written = tmp_path / "machine.yaml"
    written.write_text(dump(fitted.machine.to_plain()), encoding="utf-8")
    told = compare_estimating(Machine.load(written), [run_in(21.0, seed=3)], held_out=True)
    assert fitted.after_holdout is not None
    assert told.rmse_in_noise == pytest.approx(fitted.after_holdout.rmse_in_noise, rel=5e-4)
    whole = compare_estimating(Machine.load(written), [run_in(21.0, seed=3)])
    assert whole.rmse_in_noise != pytest.approx(told.rmse_in_noise, rel=5e-4)


def test_what_constants_take_upon_themselves_is_told(fitted: Calibration) -> None:
    told = fitted.summary()["fit"]["train"]["runs"]
    assert told[0]["inputs"]["ambient"]["unit"] == "degC" and told[0]["share_absorbed"] > 0.5
    assert any("take" in s and "upon themselves" in s for s in fitted.sentences)


CHILLS = {
    "kind": "thermostat_cooling", "into": {"body": 1}, "watches": "body", "set": "26 degC ± 0.5 K",
    "hysteresis": "0.6 K ± 20 %", "power": "260 W ± 20 %",
}  # fmt: skip


@pytest.mark.parametrize(
    ("machine", "step", "off", "by_heat"),
    [
        (two_blocks(), 0.5, 1e-9, True), (two_blocks(links=RADIATES), 0.5, 0.01, True),
        (two_blocks(sources={"chiller": CHILLS}), 1e-5, 1e-3, True),
        (two_blocks(links=RADIATES, sources={"chiller": CHILLS}), 1e-5, 0.01, True),
        (two_blocks(sources={"chiller": {**CHILLS, "watches": "air"}}), 1e-3, 1e-3, False),
    ],
)  # fmt: skip
def test_the_slope_by_a_room_is_that_of_a_run_in_another(
    machine: Machine, step: float, off: float, by_heat: bool
) -> None:
    """Also where a relay switches by it, if only through parts."""
    problem = problem_of(machine, run_in(22.0, machine=machine))
    at = linearise(problem, centres(problem.parameters))
    moved = problem.data[0].with_inputs({"ambient": 22 + step})
    (again,) = Model(machine, problem.parameters, [moved.run]).predict(at.theta)
    change = again.cells - at.predictions[0].cells
    (slope,) = input_slopes(at.predictions, [{"ambient": 1.0}])
    assert acts_by_heat(at.predictions[0], "ambient", 0.05) is by_heat
    assert np.abs(change - step * slope[0]).max() < off * np.abs(change).max()


def test_offsets_are_free_unless_a_mapping_says_none() -> None:
    machine, bias = two_blocks(), {"T_body": np.full(1441, 0.12)}
    run = replace(run_in(22.0, more=bias), constants={"ambient": constant("ambient", "degC", 22.0)})
    free, none = (estimate_constants(Numbers.of(machine), replace(run, offsets=may)) for may in (True, False))
    assert free.offsets["T_body"] == pytest.approx(0.12, abs=0.03) and not none.offsets


def test_constants_do_not_take_a_drift() -> None:
    """A sensor that drifts by 2 K, thirty times its noise: offset and room take less than a third of its square."""
    drift = {"T_body": np.linspace(0.0, 2.0, 1441)}
    left = compare_estimated(Numbers.of(two_blocks()), run_in(22.0, more=drift))
    alone = compare_estimated(Numbers.of(two_blocks()), run_in(22.0))
    assert left.rmse_in_noise > 4 > 1.2 > alone.rmse_in_noise


AMISS = {"T_body": 3.0 * (1 - np.exp(-np.arange(1441) * 10.0 / 1500))}
"""A channel that goes off by 3 K, fifty times its noise, in what a machine knows nothing of."""


def test_a_channel_that_is_told_badly_does_not_bend_the_room_of_a_held_out_run() -> None:
    """Numbers that come from a run with the same error know how far to trust it; the other channels tell the room."""
    machine, run = two_blocks(), run_in(21.0, more=AMISS, seed=3)
    problem = problem_of(machine, in_known_rooms([run_in(ROOMS[0], seed=1, more=AMISS), run_in(ROOMS[1])])[0])
    misfit = channel_misfits(minimise(problem))
    trusted, known = (replace(Numbers.of(machine), misfit=m) for m in ({}, misfit))
    assert estimate_constants(trusted, run, held_out=True).inputs["ambient"].value > 22.0
    assert estimate_constants(known, run, held_out=True).inputs["ambient"].value == pytest.approx(21.0, abs=0.6)


def in_known_rooms(runs: Sequence[Recording]) -> list[Recording]:
    pairs = zip(runs, ROOMS, strict=True)
    return [replace(r, constants={"ambient": constant("ambient", "degC", x)}) for r, x in pairs]


@pytest.mark.parametrize("course", [lambda t: 0.6 * (t > 7200), lambda t: 0.3 * t / 3600], ids=["step", "drift"])
def test_unknown_rooms_hide_neither_a_step_nor_a_drift(course: Callable[[np.ndarray], np.ndarray]) -> None:
    """Of a sensor, in a fit of all numbers: with rooms to ± 2 K nine tenths of what is left in known ones."""
    amiss = {"T_body": course(np.arange(1441) * 10.0)}
    runs = [run_in(ROOMS[0], seed=1, more=amiss), run_in(ROOMS[1], ANOTHER, seed=2, more=amiss)]
    exact = in_known_rooms(runs)
    free, known = (calibrate(two_blocks(), each).after.rmse_in_noise for each in (runs, exact))
    assert free > 2 and free == pytest.approx(known, rel=0.1)


def test_a_weak_constant_source_in_every_run_moves_all_rooms_alike() -> None:
    """6 W that are always on cannot be told from rooms warmer by half a kelvin: known rooms show it, unknown ones say
    how far they went for it."""
    source = {"oil": {"kind": "heat_source", "into": {"body": 1}, "power": "6 W"}}
    truth = two_blocks().patched({"sources": source})
    runs = [run_in(ROOMS[0], seed=1, machine=truth), run_in(ROOMS[1], ANOTHER, seed=2, machine=truth)]
    exact = in_known_rooms(runs)
    assert calibrate(two_blocks(), exact).after.rmse_in_noise > 1.5
    free = calibrate(two_blocks(), runs)
    found = [r.constants.inputs["ambient"].value for r in free.after.recordings if r.constants]
    off = np.array(found) - ROOMS
    assert off == pytest.approx([0.55, 0.55], abs=0.1)
    assert any("ambient" in sentence for sentence in free.sentences)


def mapping(folder: Path, text: str) -> Path:
    (folder / "run.csv").write_text("time [s],T_motor [degC]\n0,20\n10,20.1\n20,20.2\n")
    path = folder / "run.yaml"
    columns = 'columns: {"time [s]": "time [s]", "T_motor [degC]": "T_motor [degC]"}'
    path.write_text(f"recording: r\nfile: run.csv\n{columns}\n{text}\n")
    return path


def test_a_mapping_says_how_well_a_constant_is_known(tmp_path: Path) -> None:
    run = Recording.load(mapping(tmp_path, "inputs: {ambient: 22 degC ± 2 K, flow: 3 l/min +- 10 %}\noffsets: none"))
    assert (run.constants["ambient"].value, run.constants["ambient"].std) == (22.0, 2.0)
    assert run.constants["flow"].std == pytest.approx(0.1 * run.constants["flow"].value)
    assert not run.offsets


def test_starts_are_free_unless_a_mapping_says_that_they_are_as_read(tmp_path: Path) -> None:
    run = run_in(22.0)
    free, read = (weigh_recording(two_blocks(), replace(run, starts=may)) for may in (True, False))
    assert free.starts and not read.starts and read.run.start == free.run.start
    said = [Recording.load(mapping(tmp_path, text)).starts for text in ("", "starts: free", "starts: read")]
    assert said == [True, True, False]


@pytest.mark.parametrize(
    ("text", "said"),
    [("inputs: {ambient: 22 degC ± 10 %}", "share of a temperature"),
     ("inputs: {ambient: 22 degC ± 0 K}", "not above zero"),
     ("inputs: {ambient: 22 degC ±}", "nothing behind the ±"), ("offsets: maybe", "free or none"),
     ("starts: maybe", "free or read")],
)  # fmt: skip
def test_spreads_that_mean_nothing_are_refused(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(Refused, match=said):
        Recording.load(mapping(tmp_path, text))


def test_a_scenario_is_driven_by_what_is_known() -> None:
    with pytest.raises(Refused, match="known, so drop the ±"):
        Scenario.of("s", "1 h", {"ambient": "22 degC ± 2 K"})
