"""Stops that recordings do not tell: found with what stood, the run and both instants; physics is no stop."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from build import RPM, machine
from test_diagnosis import CONCEALED, LINKS, MINUTES, NODES, SENSORS
from test_diagnosis import SOURCES as FRICTION

from network.analysis.calibration.gauss_newton import linearise
from network.analysis.calibration.misfit import ChannelMisfit
from network.analysis.diagnosis.diagnose import diagnose
from network.analysis.diagnosis.findings.result import Diagnosis
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.standstill.driver import Driver, list_drivers
from network.analysis.diagnosis.standstill.find_standstill import _is_vain, find_standstill
from network.analysis.diagnosis.standstill.laid_instants import lay_instants
from network.analysis.diagnosis.standstill.lasting_fit import LastingFit
from network.analysis.diagnosis.standstill.standstill_edges import list_reaches
from network.analysis.diagnosis.standstill.standstill_fault import StandstillFault
from network.analysis.diagnosis.standstill.standstill_scan import scan_stretches
from network.analysis.diagnosis.standstill.stopped_fits import fit_stopped
from network.engine.simulation import simulate
from network.machine.machine import Machine
from network.platform.threads import on_one_thread
from network.recordings.columns import Column
from network.recordings.inputs import Schedule, Start, hold, linear
from network.recordings.recording import Recording
from network.report.words.catalogue_page import catalogue_page
from network.report.words.verdict_words import next_words, verdict_words

STOOD = (3130.0, 4990.0)
"""s: when it stood, at no jump of an input and between samples."""
NEAR = 90.0
SPEEDS = ((4000, 6000, 2000), (5000, 3000, 8000), (3000, 7000, 5000))
SOURCES = {
    "slides": {"kind": "guide_friction", "into": {"column": 1}, "power_per_feed": "12 W/(m/min) ± 30 %"},
    "pump": {"kind": "heat_source", "into": {"housing": 1}, "power": "150 W ± 60 W"},
}
GROWS = {"z": {"grows": {"kind": "stretching", "of": "housing", "length": "400 mm", "expansion": "1.1e-5 1/K",
                         "direction": 1}}}  # fmt: skip
PROBE = {"dz": {"measures": "tcp.z", "noise": "0.3 um", "while": "speed"}}
BOTH = ("speed", "feed")


def mill(tcp: Any = None, **more: Any) -> Machine:
    sections = {"links": LINKS, "sources": {**FRICTION, **SOURCES}, "sensors": SENSORS}
    whole = {name: {**section, **more.get(name, {})} for name, section in sections.items()}
    return machine(NODES, **whole, **({"tcp": tcp} if tcp else {}))


def recorded(truth: Machine, number: int, stopped: tuple[str, ...] = (), seed: int = 0) -> Recording:
    """A run in which some inputs stood, told as if they had not; `pump`: a source that did."""
    t = np.arange(0, MINUTES * 60.0 + 1, 20.0)
    steps = np.linspace(0, t[-1], 4)[:-1] // 20 * 20
    given = {"speed": np.array(SPEEDS[number]) * RPM, "feed": np.array([8, 5, 10]) / 60, "pump on": np.ones(3)}
    units, signals = {"speed": "rpm", "feed": "m/min", "pump on": "1"}, []
    for name, values in given.items():
        at = np.unique([*steps, *(STOOD if name in stopped else ())])
        true = values[np.searchsorted(steps, at, side="right") - 1]
        signals.append(
            hold(name, units[name], at, np.where((at >= STOOD[0]) & (at < STOOD[1]) & (name in stopped), 0, true))
        )
    signals.append(linear("ambient", "degC", t, 20 + np.sin(2 * np.pi * t / 9000)))
    schedule = Schedule("made", "made", t, {s.name: s for s in signals}, Start(others=20.0))
    real = truth.patched({"sources": {"pump": {"while": "pump on"}}}) if "pump on" in stopped else truth
    run = simulate(real, schedule, noise_seed=10 * seed + number)
    columns = {n: Column(n, truth.sensors[n].unit, v) for n, v in run.sensors.items()}
    for name in ("speed", "feed"):
        told = given[name][np.searchsorted(steps, t, side="right") - 1]
        columns[name] = Column(name, units[name], told)
    columns["ambient"] = Column("ambient", "degC", run.inputs["ambient"])
    return Recording(f"run {number}", f"run{number}.csv", t, columns)


def runs_of(truth: Machine, stops: dict[int, tuple[str, ...]], seed: int = 0, count: int = 2) -> list[Recording]:
    return [recorded(truth, i, stops.get(i, ()), seed) for i in range(count)]


@on_one_thread
def fitted(runs: list[Recording], given: Machine | None = None) -> Hypothesis:
    machine = given or mill()
    return fit_hypothesis(Case(machine, tuple(runs)), machine)


@on_one_thread
def find(h: Hypothesis, rival_gain: float = 0.0) -> tuple[StandstillFault, Hypothesis] | None:
    return find_standstill(h, lambda: rival_gain)


def told(h: Hypothesis) -> StandstillFault | None:
    found = find(h)
    return found and found[0]


def is_near(window: tuple[float, float]) -> bool:
    return all(abs(a - b) < NEAR for a, b in zip(window, STOOD, strict=True))


@cache
def diagnosed() -> Diagnosis:
    return diagnose(mill(), runs_of(mill(), {1: BOTH}), [recorded(mill(), 2)], seed=1)


def test_a_machine_that_stood_is_found_with_run_and_instants_and_nothing_else_is_named() -> None:
    d = diagnosed()
    assert d.verdict == "sensor_fault" and [f.kind for f in d.findings] == ["input_fault"]
    (f,) = d.findings
    assert f.channels == BOTH and not f.patch and f.confidence > 0.9 and f.part == "whole"
    assert len(f.windows) == 1 and is_near(f.windows[0])
    assert f.sentence == (
        "Speed and feed stood still in run 1 from 52 to 83 min, though speed and feed say that they ran: this "
        "recording was set right there; the machine is unchanged."
    )
    assert d.fits.train_after.rmse_in_noise < 1.1 < d.fits.train_before.rmse_in_noise
    assert d.fits.holdout_after is not None and d.fits.holdout_after.rmse_in_noise < 1.1
    assert [*d.after.sources] == [*d.before.sources] and d.after.inputs == d.before.inputs


def test_its_numbers_and_words_say_what_to_do() -> None:
    d = diagnosed()
    told = d.summary()["findings"][0]
    assert told["parameters"]["begins"]["value"] == pytest.approx(STOOD[0] / 60, abs=1)
    assert told["parameters"]["lasts"]["value"] == pytest.approx((STOOD[1] - STOOD[0]) / 60, abs=1.5)
    assert 0 < told["parameters"]["begins"]["std"] < 1
    assert "when speed and feed stood still is not in their recordings" in verdict_words(d)
    assert "sensor" not in next_words(d)


@pytest.mark.parametrize("stopped", [("speed",), ("feed",)])
def test_one_input_that_stood_is_no_other(stopped: tuple[str, ...]) -> None:
    fault = told(fitted(runs_of(mill(), {0: stopped})))
    assert fault is not None and fault.channels == stopped
    assert is_near(fault.windows[0][0]) and not fault.windows[1]


def test_a_source_that_paused_in_several_runs_is_found_in_each_and_pauses_in_no_other_file() -> None:
    given = mill()
    h = fitted(runs_of(mill(), {0: ("pump on",), 1: ("pump on",)}))
    fault = told(h)
    assert fault is not None and fault.channels == ("pump",)
    assert all(len(windows) == 1 and is_near(windows[0]) for windows in fault.windows)
    right = fault.set_right(h.case)
    assert "pump on" in right.machine.inputs and fault.leave_in(right.machine).to_plain() == given.to_plain()
    assert "which nothing that is recorded tells: these recordings were" in fault.told


def test_stops_of_a_source_that_explain_less_than_half_are_given_up_where_no_further_ones_show() -> None:
    """An input that stood may leave what else is missing, but explains no less than a quarter of what the catalogue
    does; of a source hardly anything may be left."""
    source, before = SimpleNamespace(source="pump"), SimpleNamespace(chi=3.0)
    one, two = ((0.0, 60.0),), ((0.0, 60.0), (120.0, 180.0))

    def is_vain(after: float, driver: Any, *stops: Any, gain: float = 90.0) -> bool:
        now = SimpleNamespace(driver=driver, stops=(one, ()), after=SimpleNamespace(chi=after), gain=gain)
        return _is_vain(cast(Any, before), cast(Any, now), stops, lambda: 20.0)

    assert is_vain(2.3, source, one, ()) and not is_vain(2.2, source, one, ())  # of an excess of 8
    assert not is_vain(2.3, source, two, ()) and not is_vain(2.3, source, one, one)
    stood = SimpleNamespace(source="")
    assert not is_vain(2.3, stood, one, ()) and not is_vain(2.3, stood, one, (), gain=46.0)
    assert is_vain(2.3, stood, one, (), gain=44.0) and not is_vain(2.3, stood, two, (), gain=44.0)


def test_a_pause_of_a_run_held_out_is_set_right_by_its_own_readings() -> None:
    d = diagnose(mill(), runs_of(mill(), {0: ("pump on",)}), [recorded(mill(), 2, ("pump on",))], seed=1)
    assert [f.kind for f in d.findings] == ["input_fault"] and d.after.inputs == d.before.inputs
    assert d.fits.holdout_after is not None and d.fits.holdout_after.rmse_in_noise < 1.3
    assert any(note.startswith("By its own readings pump stood still in run 2, too, from 5") for note in d.notes)


def test_readings_that_do_not_count_at_standstill_are_left_out_there() -> None:
    given = mill(tcp=GROWS, sensors=PROBE)
    runs = runs_of(given, {1: BOTH})
    dz = runs[1].columns["dz"]
    before = dz.values[runs[1].t < STOOD[0]][-1]
    stands = (runs[1].t >= STOOD[0]) & (runs[1].t < STOOD[1])
    frozen = replace(dz, values=np.where(stands, before, dz.values))
    runs[1] = replace(runs[1], columns={**runs[1].columns, "dz": frozen})
    found = find(fitted(runs, given))
    assert found is not None and found[0].channels == BOTH and is_near(found[0].windows[1][0])
    assert found[1].chi < 1.1


@pytest.mark.parametrize("seed", range(3))
def test_innocent_recordings_tell_no_stop(seed: int) -> None:
    truth = mill(links={"flange": {**LINKS["flange"], "conductance": "52 W/K"}})
    assert told(fitted(runs_of(truth, {}, seed))) is None


@pytest.mark.parametrize("name", ["source", "fan", "slow"])
def test_missing_physics_is_no_stop(name: str) -> None:
    h = fitted(runs_of(mill(**CONCEALED[name]), {}))
    assert h.chi > 1.1 and told(h) is None


def test_what_the_catalogue_explains_as_well_is_not_told() -> None:
    h = fitted(runs_of(mill(), {1: BOTH}))
    assert find(h, 1e9) is None


def test_what_the_scan_gains_is_what_a_fit_gains() -> None:
    """A little heat, so that numbers hardly bend: in white noise g − κ/2 is the fall of J/2 by the window."""
    little = mill(sources={"slides": {**SOURCES["slides"], "power_per_feed": "2 W/(m/min) ± 30 %"}})
    h = fitted(runs_of(little, {0: ("feed",)}), little)
    driver = next(d for d in list_drivers(h) if d.inputs == ("feed",))
    at = linearise(h.fit.problem, fitted(runs_of(little, {}), little).fit.theta)
    white = {name: ChannelMisfit(1.0, 0.0) for name in SENSORS}
    best = scan_stretches(at, [driver], [0], white)[0]
    fits = fit_stopped(h, driver, (((best.begin, best.end),), ()), best.tried)
    assert fits is not None
    assert best.gain * LastingFit(at, white).chi ** 2 == pytest.approx(fits.gain, rel=0.1)
    assert best.strength == pytest.approx(1, abs=0.25) and best.is_full


def test_instants_are_laid_between_samples_and_inputs_held() -> None:
    run = recorded(mill(), 0)
    laid = lay_instants(mill(), run, (3130.0, 4000.0))
    assert len(laid.t) == len(run.t) + 2 and {3129.0, 3130.0} <= {*laid.t}
    assert np.isnan(laid.columns["T_column"].values[laid.t == 3130.0]).all()
    assert laid.columns["speed"].values[laid.t == 3130.0] == run.columns["speed"].values[run.t == 3120.0]
    assert lay_instants(mill(), run, (4000.0,)) is run


def test_edges_move_as_far_as_a_step_of_the_scan_is_long() -> None:
    """Of a run of a week that is half an hour, of one of a morning two minutes."""
    runs: Any = [
        SimpleNamespace(run=SimpleNamespace(knots=SimpleNamespace(t=np.array([0.0, T])))) for T in (604800, 9000)
    ]
    assert list_reaches(runs, (((1.0, 2.0),), ((3.0, 4.0), (5.0, 6.0)))).tolist() == [2016.0] * 2 + [120.0] * 4
    assert list_reaches(runs, ((), ((3.0, 4.0),))).tolist() == [120.0] * 2


def test_a_driver_that_is_left_as_it_is_changes_nothing() -> None:
    run, driver = recorded(mill(), 0), Driver(("speed",))
    same = driver.stop(mill(), run, (STOOD,), sets_right=False)
    assert np.allclose(same.columns["speed"].values[np.isin(same.t, run.t)], run.columns["speed"].values, rtol=2e-6)
    stopped = driver.stop(mill(), run, (STOOD,))
    inside = (stopped.t >= STOOD[0]) & (stopped.t < STOOD[1])
    assert (stopped.columns["speed"].values[inside] == 0).all() and len(stopped.t) == len(same.t)


def test_the_catalogue_tells_of_it() -> None:
    assert "stands for a time" in catalogue_page("input_fault")
    assert "A diagnosis does not look for it." not in catalogue_page("input_fault")
