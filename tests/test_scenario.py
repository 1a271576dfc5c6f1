"""Scenarios: instants, every form of an input against closed values, and what the user reads when one is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from network.platform.refusal import Refused
from network.recordings.inputs import Signal, Start
from network.recordings.scenario import Scenario

HEAD = "scenario: warm-up\nduration: 4 h\n"
RPM = 2 * math.pi / 60
FORMS = "write a value, a list of steps, `{ramp: …}`, `{sine: …}` or `{csv: file.csv, column: …}`"
STEPS = "write `{for: 2 h, at: 8000 rpm}` or `{for: 10 min, from: 0 rpm, to: 8000 rpm}`"
STARTS = "give a temperature like `22 degC`, `{housing: 24 degC, others: 22 degC}` or `steady`"


def load(folder: Path, text: str) -> Scenario:
    path = folder / "s.yaml"
    path.write_text(text, encoding="utf-8")
    return Scenario.load(path)


def signal(value: object, duration: str = "4 h") -> Signal:
    return Scenario.of("x", duration, {"it": value}).schedule.signals["it"]


def values(of: Signal, *hours: float) -> list[float]:
    return list(of.at(np.array(hours) * 3600.0))


def test_the_example_of_the_format(tmp_path: Path) -> None:
    steps = "  speed:\n    - {for: 2 h, at: 8000 rpm}\n    - {for: 2 h, at: 0 rpm}\n"
    scenario = load(tmp_path, f"{HEAD}output: 20 s\nstart: 22 degC\ninputs:\n{steps}  ambient: 21.6 degC\n")
    schedule = scenario.schedule
    assert (scenario.name, scenario.duration, scenario.output) == ("warm-up", 14400.0, 20.0)
    assert schedule.file == str(tmp_path / "s.yaml")
    assert schedule.start == Start(others=22.0)
    assert list(schedule.t[:3]) == [0.0, 20.0, 40.0] and schedule.t[-1] == 14400.0 and len(schedule.t) == 721
    speed = schedule.signals["speed"]
    assert speed.unit == "rpm" and speed.is_held
    assert values(speed, 0, 1.999, 2, 4, 9) == pytest.approx([8000 * RPM, 8000 * RPM, 0, 0, 0])
    assert values(schedule.signals["ambient"], 0, 3) == [21.6, 21.6]


def test_the_same_from_python(tmp_path: Path) -> None:
    inputs = {"speed": [{"for": "2 h", "at": "8000 rpm"}, {"at": "0 rpm"}], "door": 1}
    ours = Scenario.of(name="warm-up", duration="4 h", output="10 s", start=None, inputs=inputs).schedule
    text = "inputs:\n  speed:\n    - {for: 2 h, at: 8000 rpm}\n    - {at: 0 rpm}\n  door: 1\n"
    theirs = load(tmp_path, HEAD + text).schedule
    assert ours.start is theirs.start is None
    assert np.array_equal(ours.t, theirs.t)
    for name, one in ours.signals.items():
        assert np.array_equal(one.at(ours.t), theirs.signals[name].at(ours.t))


@pytest.mark.parametrize(
    ("duration", "output", "last"),
    [("1 h", "7 min", [3360.0, 3600.0]), ("1 h", "0.1 s", [3599.9, 3600.0]), ("10 s", "10 s", [0.0, 10.0])],
)
def test_the_end_is_an_instant(duration: str, output: str, last: list[float]) -> None:
    t = Scenario.of("x", duration, output=output).schedule.t
    assert t[0] == 0.0 and list(t[-2:]) == pytest.approx(last) and np.all(np.diff(t) > 1e-6)


@pytest.mark.parametrize(
    ("text", "start"),
    [
        ("295.15 K", Start(others=pytest.approx(22.0))),  # type: ignore[arg-type]
        ("steady", Start(steady=True)),
        ({"housing": "24 degC", "others": "22 degC"}, Start(others=22.0, nodes={"housing": 24.0})),
        ({"housing": "24 degC"}, Start(nodes={"housing": 24.0})),
    ],
)
def test_starts(text: str | dict[str, str], start: Start) -> None:
    assert Scenario.of("x", "1 h", start=text).schedule.start == start


def test_steps_may_rise_and_the_last_goes_to_the_end() -> None:
    up, hold = {"for": "1 h", "from": "0 rpm", "to": "6000 rpm"}, {"for": "1 h", "at": "50 Hz"}
    speed = signal([up, hold, {"from": "0 Hz", "to": "100 Hz"}])
    assert speed.unit == "rpm"
    assert values(speed, 0, 0.5, 1, 1.5, 2, 3, 4, 5) == pytest.approx(
        [0, 3000 * RPM, 3000 * RPM, 3000 * RPM, 0, 3000 * RPM, 6000 * RPM, 6000 * RPM]
    )
    left, right = speed.span(np.array([0.0, 3600.0]), np.array([3600.0, 7200.0]))
    assert list(left) == pytest.approx([0, 3000 * RPM]) and list(right) == pytest.approx([6000 * RPM, 3000 * RPM])


def test_a_ramp_holds_its_ends() -> None:
    ramp = {"from": "20 degC", "to": "24 degC", "for": "2 h"}
    assert values(signal({"ramp": {**ramp, "after": "1 h"}}), 0, 1, 1.5, 3, 4) == [20, 20, 21, 24, 24]
    assert values(signal({"ramp": ramp}), 0, 1, 2, 3) == [20, 22, 24, 24]


def test_a_sine_is_as_close_as_it_says() -> None:
    sine = signal({"sine": {"mean": "22 degC", "amplitude": "2 K", "period": "24 h", "phase": "6 h"}}, "50 h")
    t = np.linspace(0, 50 * 3600, 100_003)
    exact = 22 + 2 * np.cos(2 * np.pi * t / 86400)
    assert np.max(np.abs(sine.at(t) - exact)) < 1.3e-6 * 2
    assert sine.t[-1] >= 50 * 3600


def test_a_csv_column_is_linear_or_held_by_its_unit(tmp_path: Path) -> None:
    (tmp_path / "shop.csv").write_text("time [min],air [degF],n [rpm]\n0,50,0\n60,68,3000\n")
    text = "inputs:\n  ambient: {csv: shop.csv, column: air}\n  speed: {csv: shop.csv, column: n}\n"
    signals = load(tmp_path, HEAD + text).schedule.signals
    assert values(signals["ambient"], 0, 0.5, 1, 3) == pytest.approx([10, 15, 20, 20])
    assert values(signals["speed"], 0, 0.5, 1, 3) == pytest.approx([0, 0, 3000 * RPM, 3000 * RPM])
    assert signals["ambient"].name == "ambient"


ONE_FAULT = [
    (
        "name: x",
        "3: the scenario has an unknown key 'name'; known are: scenario, duration, output, start, inputs, phases",
    ),
    ("ouput: 5 s", "3: the scenario has an unknown key 'ouput'; did you mean 'output'?"),
    ("output: 0 s", "3: output: '0 s' is not above zero; give a time above zero"),
    ("output: 10", "3: output: '10' has no unit; give a time, like `10 min`"),
    ("output: 5 h", "3: output: 18000 s is longer than the duration, 14400 s; give 144 s, say"),
    ("output: 1 us", "3: output: 1e-06 s makes more than 20 million samples in 14400 s; give 0.00072 s or more"),
    ("start:", f"3: start: is empty; {STARTS}"),
    ("start: cold", f"3: start: 'cold' is not a number; {STARTS}"),
    ("start: {a: 2 m}", f"3: start.a: '2 m' is in m; {STARTS}"),
    ("start: -300 degC", "3: start: '-300 degC' is out of range; give a temperature from -80 to 400 degC"),
    ("inputs: 3", "3: inputs: is not a mapping; write `{speed: 8000 rpm, ambient: 22 degC}`"),
]
ONE_INPUT = [
    ("8000", "'8000' has no unit; write it like `8000 rpm`, only a switch (0 or 1) goes without"),
    ("20 degC ± 1 K", "'20 degC ± 1 K' has a spread; what drives a schedule is known, so drop the ±"),
    ("-1 K", "'-1 K' is out of range; give a finite value, a temperature above absolute zero"),
    ("[]", f"has no steps; {FORMS}"),
    ("{}", f"is a mapping of no known form; {FORMS}"),
    ("{rmp: {}}", "is a mapping of no known form; did you mean 'ramp'?"),
    ("{sine: 3}", "`sine` is not a mapping; write {sine: {mean: 22 degC, amplitude: 2 K, period: 24 h}}"),
    ("{csv: no.csv, column: a}", "there is no file 'no.csv'; give its path relative to the scenario file"),
    (
        f"{{csv: {'n' * 300}, column: a}}",
        f"there is no file '{'n' * 300}'; give its path relative to the scenario file",
    ),
]
PARTS = [
    ("[5]", f", step 1 is not a mapping; {STEPS}"),
    ("[{at: 1, from: 0, to: 1}]", f", step 1 has `at` beside `from` and `to`; {STEPS}"),
    ("[{at: 1}, {at: 0}]", ", step 1 has no `for`; add `for: 10 min`"),
    ("[{for: 1 h}]", ", step 1 has no `at`; add `at: 8000 rpm`"),
    (
        "[{for: 1 h, at: 5 rpm}, {at: 0}]",
        ", step 2, at: '0' is in another kind of unit than the first value; that one is in rpm, write all so",
    ),
    ("[{for: 0 s, at: 1}]", ", step 1, for: '0 s' is not above zero; give a time above zero"),
    ("[{for: 4 h, at: 1}, {from: 1, to: 0}]", ", step 2 begins at the end of the scenario; give `for: …`"),
    ("{ramp: {from: 0 K, to: 5 K}}", ", ramp has no `for`; add `for: 2 h`"),
    ("{ramp: {from: 0 K, to: 5 K, for: 1 h, after: -1 h}}", ", ramp, after: is before the start; give 0 s or more"),
    ("{ramp: {from: 0 K, to: 5 K, for: 1 h}, sine: {}}", " has an unknown key 'sine'; known are: ramp"),
    ("{sine: {mean: 0, amplitude: 1, period: 1 s}}", ": has more than 10000 periods; give a period of at least 1.44 s"),
    (
        "{csv: late.csv, column: a}",
        ": 'late.csv' runs from 90000 s to 93600 s, outside of the scenario; "
        "shift its time to lie between 0 s and 14400 s",
    ),
]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        *ONE_FAULT,
        *((f"inputs: {{it: {text}}}", f"3: inputs.it: {message}") for text, message in ONE_INPUT),
        *((f"inputs: {{it: {text}}}", f"3: inputs.it{message}") for text, message in PARTS),
    ],
)
def test_refusals_as_the_user_reads_them(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "late.csv").write_text("time [h],a [1]\n25,0\n26,1\n")
    with pytest.raises(Refused) as refused:
        load(tmp_path, HEAD + text)
    assert str(refused.value) == f"{tmp_path / 's.yaml'}:{message}"


def test_all_faults_of_a_file_are_told_with_their_lines(tmp_path: Path) -> None:
    steps = "  speed:\n    - for: 1 h\n      at: 5\n    - fro: 1 rpm\n"
    text = f"duration: 0 h\noutput: fast\ninputs:\n{steps}  ambient: warm\n"
    with pytest.raises(Refused) as refused:
        load(tmp_path, text)
    lines = [refusal.spot.line for refusal in refused.value.refusals]
    assert lines == [1, 1, 2, 6, 7, 7, 8]


def test_a_missing_column_is_refused_where_it_is_asked_for(tmp_path: Path) -> None:
    (tmp_path / "shop.csv").write_text("time [h],air [degC]\n0,20\n1,21\n")
    with pytest.raises(Refused, match=r"s.yaml:5: the recording 'shop' has no column 'ait'; did you mean 'air'\?"):
        load(tmp_path, HEAD + "inputs:\n  ambient:\n    column: ait\n    csv: shop.csv\n")


ROWS = "scenario: rows\nphases:\n  - {for: 30 min, speed: 6000 rpm, feed: 8 m/min, ambient: 22 degC}\n"
ROWS += "  - {for: 15 min, speed: 0 rpm}\n"
ROWS += "  - {for: 10 min, speed: {from: 0 rpm, to: 3000 rpm}}\n  - {for: 5 min, feed: 0 m/min}\n"


def test_phases_are_rows_and_what_a_row_does_not_name_holds(tmp_path: Path) -> None:
    scenario = load(tmp_path, ROWS)
    assert scenario.duration == 3600.0
    signals = scenario.schedule.signals
    minutes = np.array([0.0, 29, 30, 44, 45, 50, 55, 59])
    hours = minutes / 60
    assert values(signals["speed"], *hours) == pytest.approx(np.array([6000, 6000, 0, 0, 0, 1500, 3000, 3000]) * RPM)
    assert values(signals["feed"], *hours) == pytest.approx([8 / 60] * 6 + [0.0, 0.0])
    assert values(signals["ambient"], 0, 0.9) == [22.0, 22.0]
    assert (signals["speed"].unit, signals["feed"].unit) == ("rpm", "m/min")


def test_phases_say_what_the_same_steps_by_input_say(tmp_path: Path) -> None:
    rows = [{"for": "1 h", "speed": "3000 rpm"}, {"for": "30 min", "speed": "0 rpm"}, {"speed": "500 rpm"}]
    ours = Scenario.of("x", "4 h", {"ambient": "21 degC"}, phases=rows).schedule
    steps = [{"for": "1 h", "at": "3000 rpm"}, {"for": "30 min", "at": "0 rpm"}, {"at": "500 rpm"}]
    theirs = Scenario.of("x", "4 h", {"ambient": "21 degC", "speed": steps}).schedule
    assert np.array_equal(ours.t, theirs.t) and ours.signals.keys() == theirs.signals.keys()
    for name, one in theirs.signals.items():
        assert np.array_equal(one.at(ours.t), ours.signals[name].at(ours.t))


@pytest.mark.parametrize(
    ("text", "line", "wrong", "right"),
    [
        ("phases: []\n", 2, "phases: is no list of rows", "{for: 30 min"),
        ("phases:\n  - 3 h\n", 3, "phases, row 1 is not a mapping", "write it like"),
        ("phases:\n  - {speed: 2 rpm}\n", 3, "phases, row 1 has no `for`", "for: 30 min"),
        ("phases:\n  - {for: 1 h, speed: 200}\n", 3, "phases, row 1, speed: '200' has no unit", "200 rpm"),
        (
            "phases:\n  - {for: 1 h, speed: 1 rpm}\n  - {for: 1 h, sped: 0 rpm}\n",
            4,
            "sped: is named here first",
            "did you mean 'speed'? Else name it in row 1 as well, as in `sped: 0 rpm`",
        ),
        ("phases:\n  - {for: 1 h}\n  - {fro: 1 h}\n", 4, "row 2 has no `for`, but `fro`", "did you mean 'for'?"),
        ("phases:\n  - {for: 1 h, speed: 1 rmp}\n", 3, "speed: '1 rmp' has an unknown unit 'rmp'", "mean 'rpm'?"),
        (
            "phases:\n  - {for: 1 h, ambient: 20 degC}\n  - {for: 1 h, ambient: 30}\n",
            4,
            "ambient: '30' has no unit",
            "write `30 degC`",
        ),
        (
            "phases:\n  - {for: 1 h, speed: 1 rpm}\n  - {for: 1 h, speed: 10 degC}\n",
            4,
            "'10 degC' is in another kind of unit than above",
            "that was rpm, write all so",
        ),
        ("phases:\n  - {for: 1 h}\n  - {for: 1 h, feed: 2 m/min}\n", 4, "feed: is named here first", "`feed: 0 m/min`"),
        ("phases:\n  - {for: 1 h, n: 1 rpm}\n  - {for: 1 h, n: 2 W}\n", 4, "another kind of unit", "was rpm"),
        ("duration: 1 h\nphases:\n  - {for: 1 h, n: 1 rpm}\n  - {n: 2 rpm}\n", 5, "begins after 60 min", "drop it"),
        ("phases:\n  - {for: 1 h, n: 1 rpm}\ninputs:\n  n: 2 rpm\n", 5, "inputs.n is given in `phases`", "once"),
        ("phases:\n  - {for: 1 h, n: {from: 1 rpm}}\n", 3, "phases, row 1 has no `to`", "add `to:"),
        ("phases:\n  - {for: 1 h, air: 900 degC}\n", 2, "phases, air: reaches 900.0 degC", "to 400 degC"),
    ],
)
def test_rows_that_cannot_be_used(tmp_path: Path, text: str, line: int, wrong: str, right: str) -> None:
    with pytest.raises(Refused) as refused:
        load(tmp_path, f"scenario: x\n{text}")
    (one,) = refused.value.refusals
    assert one.spot.line == line and wrong in one.wrong and right in one.right
