"""A contact that is loose now and then: its jumps, its windows, and the diagnosis that sets its readings right."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from build import machine
from test_diagnosis import HELD_OUT, LADDERS, LINKS, NODES, SENSORS, SOURCES, plant, recorded

from network.analysis.diagnosis.diagnose import diagnose
from network.analysis.diagnosis.findings.result import Diagnosis
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.intermittent.change_points import COST, digit_of, find_loose_contact, find_steps
from network.analysis.diagnosis.intermittent.input_steps import InputStep, list_driven
from network.analysis.diagnosis.intermittent.intermittent_fault import find_intermittent_fault
from network.recordings.inputs import constant
from network.recordings.recording import Recording

SHARE = 0.3
WINDOWS = (((52, 70), (90, 104)), ((15, 30), (62, 80), (110, 130)))
HELD_WINDOWS = ((40, 60), (100, 120))


def loosened(recording: Recording, windows: tuple[tuple[float, float], ...]) -> Recording:
    """The recording with T_housing on the way to the air in some windows [min]."""
    t, column = recording.t / 60, recording.columns["T_housing"]
    loose = np.any([(t >= a) & (t < b) for a, b in windows], axis=0)
    values = column.values + SHARE * loose * (recording.columns["ambient"].values - column.values)
    return replace(recording, columns={**recording.columns, "T_housing": replace(column, values=values)})


@cache
def found(is_loose: bool = True) -> Diagnosis:
    runs = [recorded(plant(), ladder, i) for i, ladder in enumerate(LADDERS)]
    held = recorded(plant(), HELD_OUT, 7)
    if is_loose:
        runs = [loosened(r, w) for r, w in zip(runs, WINDOWS, strict=True)]
        held = loosened(held, HELD_WINDOWS)
    return diagnose(plant(), runs, [held])


def test_a_loose_contact_is_found_on_its_channel_with_its_share() -> None:
    d = found()
    finding = d.findings[0]
    assert d.verdict == "sensor_fault" and finding.kind == "sensor_fault" and finding.channels == ("T_housing",)
    assert finding.parameters["share"].value == pytest.approx(SHARE, abs=0.02) and not finding.patch


def test_its_windows_are_told_to_the_bin() -> None:
    told = np.array(found().findings[0].windows) / 60
    np.testing.assert_allclose(told, WINDOWS[0], atol=1.5)
    assert "in run 1 from" in found().findings[0].sentence


def test_held_out_readings_are_set_right_by_the_same_share() -> None:
    fits = found().fits.summary()["holdout"]
    assert fits["before"]["rmse_in_noise"] > 5 and fits["after"]["rmse_in_noise"] < 1.2


def test_the_machine_stays_as_it_was() -> None:
    assert {*found().after.to_plain()} - {"calibrated"} == {*found().machine.to_plain()}
    assert [*found().after.sensors] == [*found().machine.sensors]
    assert not any(s.effects for s in found().after.sensors.values())


def test_a_room_that_is_stated_wrongly_hides_no_loose_contact() -> None:
    """Shares are those of the way to the room as the fit finds it, and so are the readings that are set right."""
    sections = {"links": LINKS, "sources": SOURCES, "sensors": SENSORS}
    still = machine({**NODES, "air": {"temperature": "20 degC"}}, **sections)
    made = [recorded(still, ladder, i) for i, ladder in enumerate(LADDERS)]
    room = [replace(r.columns["speed"], name="ambient", unit="degC", values=np.full(len(r.t), 20.0)) for r in made]
    runs = [replace(r, columns={**r.columns, "ambient": air}) for r, air in zip(made, room, strict=True)]
    loose = [loosened(r, w) for r, w in zip(runs, WINDOWS, strict=True)]
    stated = {"ambient": constant("ambient", "degC", 22.0, 2.0)}
    stating = [
        replace(r, columns={n: c for n, c in r.columns.items() if n != "ambient"}, constants=stated) for r in loose
    ]
    h = fit_hypothesis(Case(plant(), tuple(stating)), plant())
    found = find_intermittent_fault(h)
    assert found is not None and found[0].channel == "T_housing"
    assert found[0].loose.share == pytest.approx(SHARE, abs=0.03)
    rooms = [float(found[0].surroundings[r.file]["ambient"].start[0]) for r in stating]
    assert all(abs(room - 20) < 1.2 < 22 - room for room in rooms)


def test_a_good_contact_is_not_accused() -> None:
    assert found(False).verdict in ("adequate", "parameters_only") and not found(False).findings


@pytest.mark.parametrize("is_shared", [False, True])
def test_one_time_that_it_was_loose_is_found_where_no_other_channel_jumps_then(is_shared: bool) -> None:
    runs = [recorded(plant(), ladder, i) for i, ladder in enumerate(LADDERS)]
    once = loosened(runs[0], WINDOWS[0][:1])
    if is_shared:
        inside = (once.t / 60 >= 52) & (once.t / 60 < 70)
        other = once.columns["T_column"]
        columns = {**once.columns, "T_column": replace(other, values=other.values + 1.5 * inside)}
        once = replace(once, columns=columns)
    case = Case(plant(), (once, runs[1]))
    told = find_intermittent_fault(fit_hypothesis(case, case.machine))
    assert (told is None) == is_shared
    if told is not None:
        assert told[0].channel == "T_housing" and told[0].loose.share == pytest.approx(SHARE, abs=0.02)
        assert [len(w) for w in told[0].windows] == [1, 0] and told[1].chi < 1.2


def test_a_pulse_of_heat_beside_a_thermometer_is_no_loose_contact_before_and_after_it() -> None:
    """Away from the air and back is what heat does; towards it and back a contact."""
    runs = [recorded(plant(), ladder, i) for i, ladder in enumerate(LADDERS)]
    column, t = runs[0].columns["T_housing"], runs[0].t / 60
    read = column.values + 3.0 * ((t >= 52) & (t < 70))
    case = Case(
        plant(), (replace(runs[0], columns={**runs[0].columns, "T_housing": replace(column, values=read)}), runs[1])
    )
    assert find_intermittent_fault(fit_hypothesis(case, case.machine)) is None


def test_a_drift_makes_no_jump_and_a_step_makes_one() -> None:
    t, rng = np.arange(0, 7200.0, 10), np.random.default_rng(1)
    drift = 2 * np.sin(t / 2000) + 0.05 * rng.standard_normal(len(t))
    steps = find_steps(t, drift + 0.8 * (t > 3600), np.full(len(t), 4.0))
    none = find_steps(t, drift, np.full(len(t), 4.0))
    assert steps is not None and none is not None and len(none.shares) == 0
    assert steps.shares == pytest.approx([0.2], abs=0.02)


def test_shares_are_told_by_what_is_read_however_far_off_a_fit_is() -> None:
    """T + s (T_air − T) while it is loose: a jump is s (T_air − T) of the T on its good side."""
    t, loose = np.arange(0, 14400.0, 10), 0.7
    part, air = 24 + 6 * np.sin(t / 5000), 17.0
    windows = [(3000.0, 5000.0), (8000.0, 11000.0)]
    inside = np.any([(t >= a) & (t < b) for a, b in windows], axis=0)
    read = part + loose * (air - part) * inside + 0.02 * np.random.default_rng(3).standard_normal(len(t))
    steps = find_steps(t, read - (part + 2.5), air - read)
    assert steps is not None and np.abs(steps.shares) == pytest.approx(np.full(4, loose), abs=0.03)
    assert np.array(steps.windows(loose)) == pytest.approx(np.array(windows), abs=120)
    bent = find_steps(t, read - (part + 2.5), air - (part + 2.5))
    assert bent is not None and np.abs(bent.shares).max() < 0.6


def test_jumps_with_which_an_input_steps_are_no_loose_contact() -> None:
    """A pipe whose heating goes on and off comes near the air, too, and back."""
    t = np.arange(0, 28800.0, 10)
    steps = find_steps(t, 3.0 * ((t // 3600) % 2 == 1) + 0.01 * np.sin(t), np.full(len(t), 10.0))
    assert steps is not None and find_loose_contact([steps]) is not None
    switched = replace(steps, driven=tuple(np.arange(3600.0, 28800, 3600)))
    assert len(switched.shares) == 0 and find_loose_contact([switched]) is None
    assert len(replace(steps, driven=(3600.0,)).shares) == len(steps.shares) - 1


WORK = [3600.0, 5400.0, 7200.0, 9000.0]
EDGES = [1800.0 * k for k in range(1, 8)]


@pytest.mark.parametrize(
    "moved, jumps, driven",
    [
        (np.arange(180.0, 14400, 180), WORK, 0), (np.arange(1800.0, 14400, 1800), EDGES, 7),
        (np.arange(1800.0, 14400, 1800), EDGES[:4], 4), ([7200.0], [7200.0], 1), (np.arange(180.0, 14400, 180), [], 0),
        (np.arange(3300.0, 9300, 150), WORK, 0), ([3600.0, 12000, 12600, 13200, 13800], WORK, 0),
    ],
)  # fmt: skip
def test_an_input_may_make_jumps_that_come_with_its_steps_as_often_as_not_or_beyond_chance(
    moved: list[float], jumps: list[float], driven: int
) -> None:
    """A relay that switches every few minutes, all day or at work alone, is near all jumps and makes none; one that
    hardly steps may."""
    t = np.arange(0, 14400.0, 10)
    read = sum((np.sign(t - at) * (-1) ** k for k, at in enumerate(jumps)), 0.01 * np.sin(t))
    steps = find_steps(t, read, np.full(len(t), 10.0))
    assert steps is not None and len(steps.clear) == len(jumps)
    told = list_driven([InputStep(1, at, {"relay": (1.0, 1.0)}) for at in moved], [None, steps])
    assert told[0] == () and len(told[1]) == driven and {*told[1]} <= {*steps.clear}
    load = [InputStep(1, at, {"load": (1.0, 1.0)}) for at in t[1:]]
    assert list_driven(load, [None, steps]) == [(), ()]


def test_a_run_that_tells_no_jumps_hides_a_loose_contact_in_no_other() -> None:
    """A short one, and one that does not read the channel."""
    runs = [
        loosened(recorded(plant(), ladder, i), w) for i, (ladder, w) in enumerate(zip(LADDERS, WINDOWS, strict=True))
    ]
    short, other = (recorded(plant(), HELD_OUT, seed) for seed in (7, 8))
    without = {name: column for name, column in other.columns.items() if name != "T_housing"}
    case = Case(plant(), (short.until(0.1), *runs, replace(other, columns=without)))
    told = find_intermittent_fault(fit_hypothesis(case, case.machine))
    assert told is not None and told[0].loose.share == pytest.approx(SHARE, abs=0.02)
    assert [len(w) for w in told[0].windows] == [0, 2, 3, 0] and told[1].chi < 1.2


def test_a_step_of_one_digit_is_no_jump() -> None:
    """A slow rise that is read in tenths with less noise than that goes up in steps, which nothing else scatters; what
    jumps by several digits among them shows."""
    t = np.arange(0.0, 28800.0, 10.0)
    rise = 22 + 0.4 * np.sin(t / 9000) + 0.9 * (t > 20000) + 0.01 * np.random.default_rng(2).standard_normal(len(t))
    read = np.round(rise, 1)
    smooth = 22 + 0.4 * np.sin(t / 9000)
    bare, told = (find_steps(t, read - smooth, np.ones(len(t)), digit) for digit in (0.0, digit_of(read)))
    assert digit_of(read) == pytest.approx(0.1) and bare is not None and told is not None
    assert len(bare.clear) > 3 and len(told.clear) == 1 and abs(told.clear[0] - 20000) < 120


def test_too_short_a_run_and_too_few_jumps_tell_nothing() -> None:
    t = np.arange(0, 600.0, 10)
    assert find_steps(t, np.zeros(len(t)), np.ones(len(t))) is None
    t = np.arange(0, 7200.0, 10)
    once = find_steps(t, 1.0 * (t > 3600) + 0.01 * np.sin(t), np.full(len(t), 4.0))
    assert once is not None and find_loose_contact([once]) is None and COST > 0


def test_the_scatter_of_steps_is_their_standard_deviation_where_nothing_jumps() -> None:
    """Robust: one jump, which makes their standard deviation larger, leaves it."""
    t = np.arange(0.0, 400_000.0, 60.0)
    noise = np.random.default_rng(0).normal(0, 0.3, len(t))
    calm, jumpy = (find_steps(t, r, np.ones(len(t))) for r in (noise, noise + 9.0 * (t > 200_000)))
    assert calm is not None and jumpy is not None
    assert calm.scatter == pytest.approx(calm.size.std(), rel=0.1)  # the drift takes some of it
    assert jumpy.scatter == pytest.approx(calm.scatter, rel=0.02)
    assert jumpy.size.std() > 1.2 * calm.size.std()
