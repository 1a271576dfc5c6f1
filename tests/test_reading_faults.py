"""Sensors that fail from an instant of one run on: found with channel, run, instant and size; heat is no such fault."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from build import machine
from test_diagnosis import CONCEALED, HELD_OUT, LADDERS, plant, recorded
from test_small_decisions import bare

from network.analysis.calibration.estimated_constants import compare_estimating
from network.analysis.comparison.channel_residual import rms
from network.analysis.diagnosis import resized_fault
from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.diagnose import diagnose
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.intermittent import onset_jump
from network.analysis.diagnosis.intermittent.fault_shapes import list_shapes
from network.analysis.diagnosis.intermittent.find_fault import find_reading_fault
from network.analysis.diagnosis.intermittent.input_steps import InputStep, exceeds_inputs, list_input_steps
from network.analysis.diagnosis.intermittent.onset_fault import OnsetFault
from network.analysis.diagnosis.intermittent.onset_jump import ResidualSteps
from network.analysis.diagnosis.intermittent.onset_scan import Onset, OnsetScan
from network.analysis.diagnosis.readings_set_right import set_right
from network.analysis.diagnosis.screening.screen import screen
from network.catalogue.declaration.declare import Array
from network.engine.simulation import simulate
from network.recordings.columns import Column
from network.recordings.inputs import Schedule, Start, constant, hold
from network.recordings.recording import Recording
from network.report.words.finding_words import windows_words

BEGINS = 70 * 60.0
Wrong = Callable[[Array, Array, Array], Array]
FAULTS: dict[str, Wrong] = {
    "offset": lambda since, x, air: x + 0.9 * (since >= 0),
    "drift": lambda since, x, air: x + 1.2 / 3600 * np.maximum(since, 0),
    "loose": lambda since, x, air: x + 0.4 * (air - x) * (since >= 0),
}


def fail(run: Recording, wrong: Wrong, channel: str = "T_housing", begins: float = BEGINS) -> Recording:
    """The run with a channel that is read wrong from an instant on."""
    column = run.columns[channel]
    values = wrong(run.t - begins, column.values, run.columns["ambient"].values)
    return replace(run, columns={**run.columns, channel: replace(column, values=values)})


def runs_with(shape: str, stays: bool = False) -> list[Recording]:
    first, second = (recorded(plant(), x, i) for i, x in enumerate(LADDERS))
    last = fail(second, FAULTS[shape], begins=-1.0) if stays else second
    return [fail(first, FAULTS[shape]), last]


def case_of(runs: list[Recording]) -> Case:
    return Case(plant(), tuple(runs))


SIZES = [("offset", "size", 0.9), ("drift", "size", 1.2 / 3600), ("loose", "share", 0.4)]


@pytest.mark.parametrize(("shape", "key", "size"), SIZES)
def test_a_fault_is_found_with_channel_run_instant_and_size(shape: str, key: str, size: float) -> None:
    h = fit_hypothesis(case_of(runs_with(shape)), plant())
    found = find_reading_fault(h, lambda: 0.0)
    assert found is not None and found[0].channel == "T_housing" and found[0].kind == "sensor_fault"
    told = found[0].quantities
    assert told[key].value == pytest.approx(size, rel=0.15)
    reach = 1500 if shape == "drift" else 200
    assert told["begins"].value == pytest.approx(BEGINS, abs=reach)
    assert found[0].windows[1] == () and found[0].windows[0][0][1] == runs_with(shape)[0].t[-1]
    assert found[1].chi < 1.1 < h.chi


def test_processes_find_the_same_fault_as_one() -> None:
    h = fit_hypothesis(case_of(runs_with("offset")), plant())
    alone, together = (set_right(h, jobs) for jobs in (1, 2))
    assert alone[0] is not None and together[0] is not None
    assert together[0].channels == alone[0].channels == ("T_housing",) and together[0].windows == alone[0].windows
    assert together[0].gain == pytest.approx(alone[0].gain) and together[1].values == pytest.approx(alone[1].values)


@pytest.mark.parametrize("shape", [*FAULTS])
def test_a_fault_that_stays_is_told_so_and_is_in_the_file_that_tells_what_comes_next(shape: str) -> None:
    held = fail(recorded(plant(), HELD_OUT, 9), FAULTS[shape], begins=-1.0)
    d = diagnose(plant(), runs_with(shape, stays=True), [held], seed=1)
    assert d.verdict == "sensor_fault" and d.findings[0].channels == ("T_housing",)
    assert re.search(r"in run 0 from \d+ min on, and in the later recordings", d.findings[0].sentence)
    after = d.fits.holdout_after
    assert after is not None and after.rmse_in_noise < 1.2
    (effect,) = d.after.sensors["T_housing"].effects
    assert effect.shape == shape
    assert compare_estimating(d.after, [held], True).rmse_in_noise < 1.2


def test_a_fault_that_a_run_left_out_has_no_more_is_not_in_the_file() -> None:
    d = diagnose(plant(), runs_with("offset", stays=True), [recorded(plant(), HELD_OUT, 9)], seed=1)
    assert d.findings[0].channels == ("T_housing",) and not d.after.sensors["T_housing"].effects


def test_readings_that_hardly_see_their_part_are_told_with_the_noise_that_setting_them_right_leaves() -> None:
    """What is a tenth of the truth has ten times the noise once it is set right: that is no sign of what is left."""
    rng, noise = np.random.default_rng(5), plant().sensors["T_housing"].sigma

    def hang(since: Array, x: Array, air: Array) -> Array:
        seen = x + 0.9 * (air - x) + rng.normal(0.0, noise, len(x))
        return np.where(since >= 0, seen, x)

    runs = [recorded(plant(), x, i) for i, x in enumerate((*LADDERS, HELD_OUT))]
    first, second, held = (fail(r, hang, begins=at) for r, at in zip(runs, (BEGINS, -1.0, -1.0), strict=True))
    d = diagnose(plant(), [first, second], [held], seed=1)
    assert d.findings[0].parameters["share"].value == pytest.approx(0.9, abs=0.01)
    for told in (d.fits.train_after, d.fits.holdout_after):
        assert told is not None and 0.9 < told.rmse_in_noise < 1.1
    channel = d.fits.train_after.recordings[0].channels["T_housing"]
    since = channel.t > BEGINS + 300
    assert channel.spread is not None
    assert channel.spread[~(channel.t > BEGINS - 300)] == pytest.approx(1.0)
    assert channel.spread[since] == pytest.approx(10.0, rel=0.1)
    assert rms(channel.residual[since]) == pytest.approx(10 * noise, rel=0.2)


def test_what_the_scan_gains_is_what_a_fit_with_it_gains() -> None:
    """Near the truth all is linear: the score is the fall of J over two, numbers refitted."""
    slight = fail(recorded(plant(), LADDERS[0], 0), lambda since, x, air: x + 0.05 * (since >= 0))
    wrong = [slight, recorded(plant(), LADDERS[1], 1)]
    h = fit_hypothesis(case_of(wrong), plant())
    shapes = [s for s in list_shapes(h) if s.channel == "T_housing" and type(s).__name__ == "Offset"]
    onset = max(OnsetScan(h.linearised, shapes, wrong).best(), key=lambda o: o.gain)
    right = [fail(slight, lambda since, x, air: x - onset.size * (since >= onset.t0 - BEGINS)), wrong[1]]
    after = fit_hypothesis(case_of(right), plant(), start=h.values)
    fall = (h.fit.cost - after.fit.cost) / 2
    assert onset.run == 0 and onset.gain * max(1.0, h.chi) ** 2 == pytest.approx(fall, rel=0.1)


@pytest.mark.parametrize(("shape", "key", "size"), SIZES)
def test_a_size_that_is_off_is_found_again_beside_the_numbers_of_each(shape: str, key: str, size: float) -> None:
    """And one that is right stays as it is."""
    case = case_of(runs_with(shape, stays=True))
    found = find_reading_fault(fit_hypothesis(case, plant()), lambda: 0.0)
    assert found is not None and isinstance(found[0], OnsetFault)
    fault = found[0]
    begun, fault = fault.onset.t0, replace(fault, onset=replace(fault.onset, size=1.2 * fault.onset.size))
    for _ in range(4):
        again = fault.resize(fit_hypothesis(fault.set_right(case), plant()))
        if again is None:
            break
        fault = again
    told = fault.quantities[key]
    assert again is None and fault.onset.t0 == begun and abs(told.value - size) < 4 * told.std < 0.1 * size


@pytest.mark.parametrize(("shape", "key", "size"), [row for row in SIZES if row[0] != "drift"])
def test_beside_missing_heat_both_are_told_with_their_true_sizes(shape: str, key: str, size: float) -> None:
    """The size of the fault is first told beside numbers that are bent to the heat."""
    lamp = {"kind": "heat_source", "into": {"housing": 1}, "power": "60 W", "with": "running"}
    runs = [recorded(plant(sources={"lamp": lamp}), x, i) for i, x in enumerate(LADDERS)]
    d = diagnose(
        plant(), [fail(r, FAULTS[shape], begins=at) for r, at in zip(runs, (BEGINS, -1.0), strict=True)], seed=1
    )
    fault, heat = d.findings
    assert (fault.channels, heat.kind, heat.places) == (("T_housing",), "heat_source", ("housing",))
    for told, true in ((fault.parameters[key], size), (heat.parameters["power"], 60.0)):
        assert abs(told.value - true) < 4 * told.std < 0.05 * true


@pytest.mark.parametrize(
    ("sizes", "counts", "chi", "told"),
    [
        ((0.3, 0.31, None, None), (1,), 1.0, [(0.31, 1)]),
        ((0.3, None, 0.32, None), (1, 1), 1.0, [(0.3, 1), (0.32, 1)]),
        ((None,), (), 1.0, []),
        ((0.3,), (), 9.0, []),
        ((0.3,) * 9, (2,), 1.0, [(0.3, 2)]),
    ],
)
def test_a_fault_is_resized_until_it_is_no_other_and_again_beside_less(
    sizes: tuple[float | None, ...], counts: tuple[int, ...], chi: float, told: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What was found is tested again with each; nothing is resized where much is left."""
    left, kept = iter(sizes), iter(counts)

    def resize(h: Any) -> Any:
        size = next(left)
        return None if size is None else bare(size=size, resize=resize, set_right=lambda case: case)

    def found(count: int) -> Any:
        return bare(chi=chi, found=("finding",) * count, case=bare(noise="left", sigma={}))

    search = {"fault": bare(resize=resize), "case": None, "written": None, "null": None}
    monkeypatch.setattr(resized_fault, "replace", lambda of, **new: state(**{**vars(of), **new}))
    monkeypatch.setattr(resized_fault, "_refit", lambda case, h: h)
    monkeypatch.setattr(resized_fault, "check_selection", lambda null, now, jobs: bare(best=found(next(kept))))

    def state(**values: Any) -> Any:
        return bare(**{**values, **({"best": values["selection"].best} if "selection" in values else {})})

    states = [*resized_fault.resize_fault(state(**search, selection=bare(best=found(2))), bare(), 1)]
    assert [(s.fault.size, len(s.best.found)) for s in states] == told


@pytest.mark.parametrize(
    ("chi", "leaves", "count", "told"),
    [(9.0, 1.0, 1, 0.31), (9.0, 2.0, 1, None), (9.0, 1.0, 0, None), (1.0, 0.9, 1, None)],
)
def test_a_fault_is_resized_beside_what_leaves_much_where_that_hardly_leaves_anything(
    chi: float, leaves: float, count: int, told: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And what was found goes on from there untested; what hardly leaves anything is resized in the end."""
    best = bare(chi=chi, found=("finding",) * count, case=bare(noise="left", sigma={}))
    again = bare(size=0.31, resize=lambda h: None, set_right=lambda case: case)
    fault = bare(size=0.3, resize=lambda h: again)

    def state(**values: Any) -> Any:
        return bare(**{**values, **({"best": values["selection"].best} if "selection" in values else {})})

    monkeypatch.setattr(resized_fault, "replace", lambda of, **new: state(**{**vars(of), **new}))
    monkeypatch.setattr(resized_fault, "_refit", lambda case, h: h and bare(**{**vars(h), "chi": leaves}))
    now: Any = bare(fault=fault, case=None, written=None, null=None, best=best, selection=bare(best=best))
    told_of: Any = resized_fault.resize_beside(now, bare())  # type: ignore[arg-type]
    assert (told_of and (told_of.fault.size, told_of.best.chi)) == (told and (told, leaves))


def find_beside_catalogue(runs: list[Recording]) -> object:
    """What is found of a fault where the catalogue may score more."""
    h = fit_hypothesis(case_of(runs), plant())
    assert h.chi > 1.5
    scores = screen(h.linearised, candidates(h.machine, h.case.drivers), h.values)
    return find_reading_fault(h, lambda: max(s.gain for s in scores))


def test_a_jump_is_seen_beside_what_is_missing_and_at_a_step_of_an_input_that_makes_none_elsewhere() -> None:
    pump = plant(sources={"pump": {"kind": "heat_source", "into": {"housing": 1}, "power": "80 W"}})
    first, second = (recorded(pump, x, i) for i, x in enumerate(LADDERS))
    moves = [t for t in fit_hypothesis(case_of([first, second]), plant()).predictions[0].run.knots.jumps if t > 1800]
    for begins, few in ((BEGINS, False), (moves[0], False), (moves[0], True)):
        runs = [fail(first, FAULTS["offset"], begins=begins), second]
        h = fit_hypothesis(case_of(runs), plant())
        steps = ResidualSteps(h, runs)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(onset_jump, "MANY", 99 if few else onset_jump.MANY)
            seen = [(run, name, at) for run, name, at, _ in onset_jump.list_lone_jumps(steps)]
        assert (seen == []) is few
        assert few or (seen[0][:2] == (0, "T_housing") and seen[0][2] == pytest.approx(begins, abs=150))


@pytest.mark.parametrize("share", [0.7, 0.9])
def test_a_jump_is_what_a_fit_of_each_fault_says_whatever_else_is_missing(share: float) -> None:
    """Numbers are bent by a pump that nobody told, so that the linear score of a contact that came loose is poor."""
    pump = plant(sources={"pump": {"kind": "heat_source", "into": {"housing": 1}, "power": "300 W"}})
    first, second = (recorded(pump, x, i) for i, x in enumerate(LADDERS))
    runs = [
        fail(r, lambda since, x, air: x + share * (air - x) * (since >= 0), begins=begins)
        for r, begins in ((first, BEGINS), (second, -1.0))
    ]
    found = find_reading_fault(fit_hypothesis(case_of(runs), plant()), lambda: 0.0)
    assert found is not None and type(found[0].onset.shape).__name__ == "Loose" and found[0].onset.stays
    assert found[0].quantities["share"].value == pytest.approx(share, abs=0.03)


def test_a_jump_at_which_a_fault_would_change_nothing_is_not_that_fault() -> None:
    """A thermometer that reads what the room has cannot come loose there."""
    run = recorded(plant(), LADDERS[0], 0)
    still = replace(run, columns={**run.columns, "T_housing": run.columns["ambient"]})
    steps = bare(recordings=(still,), of=lambda run, name: bare(t=run_times, size=np.ones(9), scatter=0.1))
    run_times = np.arange(9) * 60.0
    shapes = {
        type(s).__name__: s for s in list_shapes(fit_hypothesis(case_of([run]), plant())) if s.channel == "T_housing"
    }
    for name, allowed in (("Loose", False), ("Offset", True)):
        o = onset_jump.begin_with_jump(steps, Onset(shapes[name], 0, 0.0, False, 0.1, 0.1, 99.0, 60.0, 99.0), 300.0)
        assert o.t0 == 300.0 and shapes[name].allows(o.size) is allowed


def test_a_jump_far_above_one_that_another_step_makes_is_the_channels_own_and_that_is_not() -> None:
    first, second = (recorded(plant(), x, i) for i, x in enumerate(LADDERS))
    known = fit_hypothesis(case_of([first, second]), plant()).predictions
    at, there = (next(t for t in p.run.knots.jumps if t > 1800) for p in known)
    shaken = fail(second, lambda since, x, air: x + 0.3 * (since >= 0), begins=there)
    for size, told in ((1.5, [0]), (0.45, [])):
        runs = [fail(first, lambda since, x, air, by=size: x + by * (since >= 0), begins=at), shaken]
        steps = ResidualSteps(fit_hypothesis(case_of(runs), plant()), runs)
        assert all(
            any(abs(t - begun) < 150 for t in steps.of(i, "T_housing").clear) for i, begun in ((0, at), (1, there))
        )
        assert [run for run, *_ in onset_jump.list_lone_jumps(steps)] == told


def step_of(speed: tuple[float, float], feed: float = 0.0) -> InputStep:
    """Of a speed from one to another, and of a feed."""
    moved = {"speed": (abs(speed[1] - speed[0]), abs(speed[1] ** 2 - speed[0] ** 2))}
    return InputStep(0, 0.0, {**moved, "feed": (feed, feed**2)} if feed else moved)


SPEEDS = [(0, 2), (2, 3), (3, 1), (1, 4), (4, 2), (2, 0), (0, 3), (3, 2), (2, 4), (4, 1)]
OFF = np.random.default_rng(2).normal(0, 0.1, len(SPEEDS))


@pytest.mark.parametrize(
    ("own", "jump", "exceeds"),
    [
        (step_of((1, 2)), 3.0, False),  # as |Δu²| says
        (step_of((1, 2)), 3.3, False),
        (step_of((1, 2)), 5.0, True),
        (step_of((0, 4)), 16.0, False),
        (step_of((0, 4)), 18.0, True),
        (step_of((0, 9)), 99.0, False),  # a step as there is no other
        (step_of((1, 2), feed=1.0), 5.0, False),  # an input that steps nowhere else
    ],
)
def test_a_jump_is_the_channels_own_where_inputs_make_it_by_far_less(
    own: InputStep, jump: float, exceeds: bool
) -> None:
    """A shaft that grows with the square of its speed, read to a tenth."""
    others = [step_of(speed) for speed in SPEEDS]
    jumps = [of.moved["speed"][1] + off for of, off in zip(others, OFF, strict=True)]
    assert exceeds_inputs(own, jump, others, jumps) is exceeds
    assert not exceeds_inputs(own, jump, others[:3], jumps[:3])


def test_a_clear_jump_stands_alone_and_is_told_of_its_run() -> None:
    first, second = (recorded(plant(), x, i) for i, x in enumerate(LADDERS))
    d = diagnose(plant(), [first, fail(second, FAULTS["offset"])], seed=1)
    (finding,) = d.findings
    h = fit_hypothesis(case_of([first, fail(second, FAULTS["offset"])]), plant())
    found = find_reading_fault(h, lambda: 0.0)
    assert found is not None and found[0].stands_alone
    assert finding.run == finding.summary()["run"] == 1 and finding.windows[0][0] == pytest.approx(BEGINS, abs=200)
    assert "of run1.csv" in windows_words(d, finding)


def test_heat_in_one_run_is_no_fault_of_a_sensor() -> None:
    pump = {"kind": "heat_source", "into": {"housing": 1}, "power": "80 W"}
    heated = recorded(plant(sources={"pump": pump}), LADDERS[0], 0)
    assert find_beside_catalogue([heated, recorded(plant(), LADDERS[1], 1)]) is None


@pytest.mark.parametrize("name", ["source", "fan", "slow"])
def test_missing_physics_is_no_fault_from_an_instant_on(name: str) -> None:
    truth = plant(**CONCEALED[name])
    assert find_beside_catalogue([recorded(truth, x, i) for i, x in enumerate(LADDERS)]) is None


@pytest.mark.parametrize("noise", [0.0, 0.5])
def test_what_a_measured_power_does_to_a_thermometer_beside_its_heater_is_no_fault(noise: float) -> None:
    """The file lacks that the heater warms the spot where T_block sits 4 K above the block within a minute."""
    nodes = {
        "block": {"heat_capacity": "20 kJ/K"},
        "base": {"heat_capacity": "60 kJ/K"},
        "air": {"temperature": "ambient"},
    }
    links = {
        "joint": {"kind": "conduction", "between": ["block", "base"], "conductance": "20 W/K ± 30 %"},
        "skin": {"kind": "convection", "between": ["block", "air"], "conductance": "3 W/K ± 30 %"},
        "base skin": {"kind": "convection", "between": ["base", "air"], "conductance": "8 W/K ± 30 %"},
    }
    heat = {"kind": "heat_source", "into": {"block": 1}, "power": "120 W", "with": "power", "at": "120 W"}
    sensors = {name: {"measures": name[2:], "noise": "0.05 K"} for name in ("T_block", "T_base")}
    plain = machine(nodes, links=links, sources={"heater": heat}, sensors=sensors)
    spot = {"kind": "conduction", "between": ["spot", "block"], "conductance": "30 W/K"}
    truth = machine(
        {**nodes, "spot": {"heat_capacity": "0.6 kJ/K"}}, links={**links, "near": spot},
        sources={"heater": {**heat, "into": {"spot": 1}}},
        sensors={**sensors, "T_block": {"measures": "spot", "noise": "0.05 K"}},
    )  # fmt: skip
    t = np.arange(0.0, 6 * 3600.0 + 1, 10.0)
    inputs = [hold("power", "W", np.array([0.0, 3600.0]), np.array([0.0, 120.0])), constant("ambient", "degC", 20.0)]
    schedule = Schedule("made", "made", t, {s.name: s for s in inputs}, Start(others=20.0))
    run = simulate(truth, schedule, noise_seed=1)
    columns = {n: Column(n, "degC", v) for n, v in run.sensors.items()}
    columns |= {n: Column(n, schedule.signals[n].unit, v) for n, v in run.inputs.items()}
    read = columns["power"].values + noise * np.random.default_rng(1).standard_normal(len(t))
    case = Case(plain, (Recording("run", "run.csv", t, {**columns, "power": Column("power", "W", read)}),))
    h = fit_hypothesis(case, plain)
    steps = list_input_steps(p.run for p in h.predictions)
    assert [list(s.moved) for s in steps] == [["power"]] and steps[0].t == pytest.approx(3600, abs=120)
    assert h.chi > 20 and set_right(h, 1)[0] is None
