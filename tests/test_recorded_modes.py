"""When a relay was on is read off what it watches, and a fit that follows it cannot fall out of step."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from network import Machine, Recording, Scenario, diagnose, simulate
from network.analysis.calibration import growing_horizon
from network.analysis.calibration.hysteresis_swing import Swing, _fit_bends, find_switchings
from network.analysis.calibration.measured_means import weigh_recording
from network.analysis.calibration.read_beginning import begin_beside_modes
from network.analysis.calibration.recorded_modes import forget_modes, read_modes
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.faced_relays import face_relays
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.engine.response.followed_relays import MODE, follow_relays
from network.engine.response.parameters import free_parameters, values_at
from network.engine.trajectory import Trajectory
from network.report.files.result_files import write_run

ROOT = Path(__file__).parents[1]
INPUTS = {
    "speed": [{"for": "1 h", "at": "8000 rpm"}, {"for": "1 h", "at": "2000 rpm"}, {"for": "2 h", "at": "10000 rpm"}],
    "ambient": "21.6 degC",
}  # fmt: skip


SPEEDS = ((8000, 2000, 10000), (3000, 9000, 0), (6000, 10000, 4000))


@pytest.fixture(scope="module")
def chilled() -> Machine:
    return Machine.load(ROOT / "machines" / "chilled_spindle.yaml")


def _chiller(machine: Machine) -> str:
    (name,) = [n for n, source in machine.sources.items() if source.kind == "thermostat_cooling"]
    return name


def _record(machine: Machine, folder: Path) -> tuple[Trajectory, Recording]:
    run = simulate(machine, Scenario.of("half a day", "4 h", INPUTS, output="10 s"), noise_seed=3)
    write_run(run, folder)
    return run, Recording.load(folder / "results.csv")


def test_instants_of_switchings_are_read(chilled: Machine, tmp_path: Path) -> None:
    run, recording = _record(chilled, tmp_path)
    (told,) = read_modes(chilled, [recording])
    (mode,) = told.modes.values()
    true = np.array([t for t, *_ in run.switches])
    assert len(mode.t) - 1 == len(true) > 20 and mode.first == 0
    off = mode.t[1:] - true
    assert np.abs(np.median(off)) < 3 and np.abs(off).max() < 20
    assert np.mean(np.abs(off) < 3 * mode.spread) > 0.9
    assert not forget_modes([told])[0].modes


def test_a_chiller_that_never_switches_in_one_run_is_read_in_the_others(chilled: Machine, tmp_path: Path) -> None:
    """An idle hour stays below the level at which it goes on: it was off. Alone, or read rarely, it says nothing."""
    _, work = _record(chilled, tmp_path)
    rest = simulate(chilled, Scenario.of("rest", "1 h", {**INPUTS, "speed": "0 rpm"}, output="10 s"), noise_seed=4)
    assert not rest.switches
    write_run(rest, tmp_path)
    idle = replace(Recording.load(tmp_path / "results.csv"), name="rest", file="rest.csv")
    (busy, off) = (next(iter(r.modes.values())) for r in read_modes(chilled, [work, idle]))
    assert len(busy.t) > 20 and len(off.t) == 1 and off.first == 0
    fit = fit_hypothesis(Case(chilled, read_modes(chilled, [work, idle])), chilled)
    assert fit.chi < 1.3
    assert not read_modes(chilled, [idle])[0].modes
    rare = replace(
        idle, t=idle.t[::30], columns={n: replace(c, values=c.values[::30]) for n, c in idle.columns.items()}
    )
    assert not any(r.modes for r in read_modes(chilled, [work, rare]))


def test_a_run_that_begins_near_a_level_may_be_long_there() -> None:
    """It comes near it within a minute and switches minutes later, which says nothing of how long it takes."""
    edges = np.array([0.0, 330.0, 500.0, 1300.0, 1470.0, 2270.0, 2440.0])
    t = np.arange(0.0, 2400.0, 10.0)
    x = np.interp(t, edges, [0.7, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0]) + np.random.default_rng(5).normal(0, 0.05, len(t))
    told = find_switchings(Swing(t, x, on=1.0, off=-1.0))
    assert told is not None and [bend.t for bend in told] == pytest.approx(edges[1:-1], abs=20)


@pytest.mark.parametrize("begin", [0.97, 1.05, 0.2])
def test_whether_it_is_on_when_a_run_begins_shows_where_it_goes_off(begin: float) -> None:
    """It begins near the level at which it goes on, or on its way to the other one, in noise of a tenth of its width:
    off, its first bend is none."""
    edges = np.array([0.0, 170.0 * (begin + 1) / 2, 970.0, 1140.0, 1940.0, 2110.0, 2910.0])
    t = np.arange(0.0, 2600.0, 10.0)
    x = np.interp(t, edges, [begin, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0]) + np.random.default_rng(3).normal(0, 0.1, len(t))
    told = find_switchings(Swing(t, x, on=1.0, off=-1.0))
    assert told is not None and [bend.goes_on for bend in told[-4:]] == [True, False, True, False]
    assert [bend.t for bend in told[-5:]] == pytest.approx(edges[1:6], abs=25)
    assert len(told) == 5 or told[0].t < 10  # on from the first sample


@pytest.mark.parametrize("low, bends", [(0.3, 9), (0.9, 7)])
def test_a_turn_that_stays_short_of_a_level_switches_where_it_bends_as_others_do(low: float, bends: int) -> None:
    """A saw tooth from 0 to 1 of which one tooth is cut short or, hardly turning, goes on."""
    edges = [0.0, 1.0, 0.0, 1.0, low, 1.0, 0.0, 1.0, 0.0, 1.0, 0.5]
    lengths = np.abs(np.diff(edges)) * 600.0
    t = np.arange(0, lengths.sum(), 10.0)
    x = np.interp(t, np.append(0.0, np.cumsum(lengths)), edges)
    noise = 0.01 * np.random.default_rng(5).standard_normal(len(t))
    told = find_switchings(Swing(t, x + noise, on=1.0, off=0.0))
    assert told is not None and len(told) == bends
    near = [np.abs(bend.t - np.cumsum(lengths)).min() for bend in told]
    assert max(near) < 40


def test_turns_beyond_a_level_are_no_switchings() -> None:
    """What goes up and down below the level at which it goes off comes near that level alone."""
    t = np.arange(0.0, 5700.0, 10.0)
    swing = Swing(t, -3.0 + np.sin(t / 300), on=1.0, off=-1.0)
    high, low = swing.close
    assert not high.any() and low.all() and find_switchings(swing) == []
    busy = Swing(t, 1.3 * np.sin(t / 300), on=1.0, off=-1.0)
    assert not (busy.close[0] & busy.close[1]).any() and len(find_switchings(busy) or ()) == 6


def test_a_fit_that_follows_them_keeps_step_from_anywhere(chilled: Machine, tmp_path: Path) -> None:
    """The jacket lets a quarter less through than stated: simulated, the relay is out of step at the file's numbers."""
    weaker = chilled.patched({"links.coolant jacket.conductance": "22 W/K"})
    _, recording = _record(weaker, tmp_path)
    alone = fit_hypothesis(Case(chilled, (recording,)), chilled)
    followed = fit_hypothesis(Case(chilled, read_modes(chilled, [recording])), chilled)
    assert followed.chi < 1.1 < alone.chi
    assert followed.values["links.coolant jacket.conductance"] == pytest.approx(22, rel=0.05)
    faced = face_relays(followed)
    assert not faced.case.recordings[0].modes and faced.chi < 1.2


def test_numbers_beside_the_modes_that_were_read_are_a_beginning_that_keeps_step(
    chilled: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The whole recording is fitted at once, not ever more of it."""
    weaker = chilled.patched({"links.coolant jacket.conductance": "22 W/K"})
    _, recording = _record(weaker, tmp_path)
    parameters, data = free_parameters(chilled), [weigh_recording(chilled, recording)]
    read = begin_beside_modes(chilled, parameters, data, None)
    assert read is not None and read.left_over is not None and read.left_over(1.0) < 1.1 and read.left_over(0.25) < 1.1
    assert values_at(parameters, read.theta)["links.coolant jacket.conductance"] == pytest.approx(22, rel=0.05)
    shares: list[float] = []
    fit = growing_horizon._fit_share

    def watch(*of: Any) -> Any:
        shares.append(of[4])
        return fit(*of)

    monkeypatch.setattr(growing_horizon, "_fit_share", watch)
    found = growing_horizon.begin_in_step(chilled, parameters, data, None, lambda: False, about=read)
    assert shares == [1.0] and found is not None
    assert values_at(parameters, found.theta)["links.coolant jacket.conductance"] == pytest.approx(22, rel=0.05)
    monkeypatch.undo()
    grown = growing_horizon.begin_in_step(chilled, parameters, data, None, lambda: False)
    assert grown is not None
    assert values_at(parameters, grown.theta)["links.coolant jacket.conductance"] == pytest.approx(22, rel=0.05)


def test_where_relays_slip_over_the_whole_it_begins_with_the_most_over_which_they_do_not(
    chilled: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In step is what leaves hardly more than what is known of that share; then on, but what slips then is not waited
    for long. What is not known of a share does not count."""
    _, recording = _record(chilled, tmp_path)
    parameters, data = free_parameters(chilled), [weigh_recording(chilled, recording)]
    read = begin_beside_modes(chilled, parameters, data, None)
    assert read is not None
    fit, tried = growing_horizon._fit_share, list[tuple[float, float]]()

    def watch(*of: Any) -> Any:
        tried.append((of[4], of[6]))
        return fit(*of)

    monkeypatch.setattr(growing_horizon, "_fit_share", watch)
    left, late = {1.0: np.inf, 0.5: -1.0}, iter([False] * 6)
    about = replace(read, left_over=lambda share: left.get(share, 1.0))
    monkeypatch.setattr(growing_horizon, "LEAP", 0.1)
    monkeypatch.setattr(growing_horizon, "FIRST", 0.2)
    assert growing_horizon.begin_in_step(chilled, parameters, data, None, lambda: True, about=about) is None
    growing_horizon.begin_in_step(chilled, parameters, data, None, lambda: next(late, True), about=about)
    assert tried == [(0.5, 0.1), (0.25, 0.1), (0.2, np.inf), (0.4, 0.1), (pytest.approx(0.2 * np.sqrt(2)), np.inf)]


def test_without_relays_or_modes_there_is_no_such_beginning(chilled: Machine, tmp_path: Path) -> None:
    _, recording = _record(chilled, tmp_path)
    blind = replace(recording, columns={n: c for n, c in recording.columns.items() if n != "T_tank"})
    parameters = free_parameters(chilled)
    assert begin_beside_modes(chilled, parameters, [weigh_recording(chilled, blind)], None) is None
    still = chilled.patched({"sources": {_chiller(chilled): None}})
    assert begin_beside_modes(still, free_parameters(still), [weigh_recording(still, recording)], None) is None


def test_what_nothing_reads_is_simulated(chilled: Machine, tmp_path: Path) -> None:
    _, recording = _record(chilled, tmp_path)
    deaf = chilled.patched({"sensors": {"T_tank": None}})
    assert not read_modes(deaf, [recording])[0].modes
    slow = {**chilled.sensors["T_tank"].to_plain(), "effects": [{"kind": "sensor_lag", "lag": "60 s"}]}
    assert not read_modes(chilled.patched({"sensors": {"T_tank": slow}}), [recording])[0].modes
    warmer = {**chilled.sources[_chiller(chilled)].to_plain(), "set": "27 degC"}
    assert not read_modes(chilled.patched({"sources": {_chiller(chilled): warmer}}), [recording])[0].modes
    shown = recording.columns["T_tank"]
    for values in (np.full(len(shown.values), np.nan), np.full(len(shown.values), 20.0)):
        silent = replace(recording, columns={**recording.columns, "T_tank": replace(shown, values=values)})
        assert not read_modes(chilled, [silent])[0].modes
    unsure = {**chilled.sources[_chiller(chilled)].to_plain(), "set": "22 degC ± 1 K"}
    assert not read_modes(chilled.patched({"sources": {_chiller(chilled): unsure}}), [recording])[0].modes
    rough = chilled.patched({"sensors": {"T_tank": {**chilled.sensors["T_tank"].to_plain(), "noise": "0.5 K"}}})
    assert not read_modes(rough, [recording])[0].modes


def test_a_followed_relay_is_a_source_that_an_input_switches(chilled: Machine) -> None:
    name = _chiller(chilled)
    followed = follow_relays(chilled, {MODE + name})
    assert followed.sources[name].kind == "heat_source" and MODE + name in followed.inputs
    assert follow_relays(chilled, set()) is chilled
    late = {**chilled.sensors["T_tank"].to_plain(), "effects": [{"kind": "clock_shift", "late": "60 s"}]}
    behind = chilled.patched({"sensors": {"T_tank": late}})
    assert follow_relays(behind, {MODE + name}) is behind


@pytest.mark.proof
def test_a_chilled_machine_with_a_source_that_the_file_lacks_is_diagnosed_beside_its_switchings(
    chilled: Machine, tmp_path: Path
) -> None:
    """Heat in the housing loads the chiller: its relay is out of step at any numbers of the file."""
    part = "housing" if "housing" in chilled.nodes else next(n for n, node in chilled.nodes.items() if node.is_part)
    source = {"kind": "heat_source", "into": {part: 1}, "power": "150 W", "with": "running"}
    truth = chilled.patched({"sources": {"cabinet": source}})
    runs = []
    for k, speeds in enumerate(SPEEDS):
        inputs = {**INPUTS, "speed": [{"for": "1 h", "at": f"{n} rpm"} for n in speeds]}
        (tmp_path / str(k)).mkdir()
        day = Scenario.of(f"day {k}", "3 h", inputs, output="20 s")
        write_run(simulate(truth, day, noise_seed=k), tmp_path / str(k))
        runs.append(Recording.load(tmp_path / str(k) / "results.csv"))
    told = diagnose(chilled, runs[:2], runs[2])
    first = told.findings[0]
    assert (first.kind, first.places) == ("heat_source", (part,))
    power = first.parameters["power"].value
    assert power == pytest.approx(150, rel=0.02)
    (written,) = (e for n, e in told.after.sources.items() if n not in chilled.sources)
    size = float(str(written.to_plain()["power"]).split()[0])
    assert size == pytest.approx(power, rel=1e-3)  # one size in what is told and written
    assert told.fits.holdout_after is not None and told.fits.holdout_after.rmse_in_noise < 1.1
    assert any("switched" in note and "followed" in note for note in told.notes)


@pytest.mark.parametrize("level", [None, 21.9])
def test_bends_fitted_at_once_are_those_of_least_squares(level: float | None) -> None:
    """Also where nothing lies before one: then both rates are half of it."""
    t = 300.0 + 10.0 * np.arange(40)
    x = np.interp(t, [300, 500, 700], [21.0, 22.0, 21.5]) + np.random.default_rng(2).normal(0, 0.05, len(t))
    tried = np.array([300.0, 420.0, 505.0, 680.0])
    for at, *told in zip(tried, *_fit_bends(t, x, tried, level), strict=True):
        A = np.stack([np.ones_like(t), t - at, np.maximum(t - at, 0.0)], axis=1)[:, 0 if level is None else 1 :]
        c, *_ = np.linalg.lstsq(A, x - (level or 0.0), rcond=None)
        left = x - (level or 0.0) - A @ c
        assert told == pytest.approx([left @ left, c[0] if level is None else level, c[-1]], rel=1e-6)
