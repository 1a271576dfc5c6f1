"""Words: what a machine, a run and a comparison say of themselves in the terminal."""

from __future__ import annotations

import re
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from network.analysis.comparison.compare import Comparison, RecordingResidual, compare
from network.analysis.comparison.window import worst_window
from network.engine.assembly import build
from network.engine.simulation import simulate
from network.engine.time_constants import time_constants
from network.engine.trajectory import Trajectory
from network.machine.machine import Machine
from network.platform.quantities.number_format import write_minus
from network.platform.quantities.text_table import MOST_ROWS, digits, format_shift, span, table
from network.platform.refusal import Spot
from network.platform.yaml.document import tree_of
from network.recordings.columns import Column
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario
from network.report.words.describe import describe
from network.report.words.run_words import tell_run
from network.report.words.words import tell_comparison, tell_worst

SHARED = Path(__file__).parents[2] / "shared" / "cases"


def machine_of(**sections: Any) -> Machine:
    tree = {
        "machine": "Test mill",
        "reference": "22 degC",
        "materials": {"iron": {"density": "8000 kg/m^3", "specific_heat": "500 J/(kg K)", "conductivity": "50 W/(m K)",
                               "expansion": "1.1e-5 1/K"}},
        "nodes": {
            "shaft": {"heat_capacity": "4 kJ/K ± 20 %", "rotates": "true"},
            "bed": {"material": "iron", "length": "500 mm", "area": "150 cm^2", "lumps": 2},
            "seat": {},
            "ambient": {"temperature": "ambient"},
            "water": {"temperature": "20 degC"},
        },
        "links": {
            "bearing": {"kind": "conduction", "between": ["shaft", "bed@0..0.5"], "conductance": "20 W/K ± 30 %"},
            "to seat": {"kind": "conduction", "between": ["bed", "seat"], "conductance": "30 W/K"},
            "skin": {"kind": "convection", "between": ["seat", "ambient"], "conductance": "unknown 1..50 W/K"},
            "jacket": {"kind": "advection", "through": ["water", "bed"], "capacity_flow": "12 W/K"},
        },
        "sources": {
            "friction": {"kind": "bearing_friction", "into": {"shaft": 0.25, "bed": 0.75}, "torque": "400 N mm"},
        },
        "tcp": {"z": {"bed grows": {"kind": "stretching", "of": "bed", "length": "300 mm", "direction": -1}}},
        "sensors": {
            "T_shaft": {"measures": "shaft", "noise": "0.05 K", "effects": [{"kind": "sensor_lag", "lag": "20 s"}]},
            "T_bed": {"measures": "bed@0.2..0.8", "noise": "0.1 K"},
            "dz": {"measures": "tcp.z", "noise": "0.25 um", "zero": "start"},
        },
    }  # fmt: skip
    merged = {key: value for key, value in {**tree, **sections}.items() if value is not None}
    return Machine.read(tree_of(merged, Spot("test")), "test")  # type: ignore[arg-type]


KNOWN_SKIN = {"links": {"skin": {"kind": "convection", "between": ["seat", "ambient"], "conductance": "6 W/K"}}}


@pytest.fixture(scope="module")
def mill() -> Machine:
    return machine_of().patched(KNOWN_SKIN)


@pytest.fixture(scope="module")
def run(mill: Machine) -> Trajectory:
    inputs = {"speed": [{"for": "1 h", "at": "6000 rpm"}, {"for": "1 h", "at": "0 rpm"}], "ambient": "21 degC"}
    return simulate(mill, Scenario.of("warm up", "2 h", inputs, output="10 s", start="22 degC"))


def recording_of(run: Trajectory, shifts: dict[str, Any] | None = None, **more: Column) -> Recording:
    """What a run would measure, with noise, shifted by so many K or m."""
    draw = np.random.default_rng(7)
    columns = {name: Column(name, run.schedule.signals[name].unit, values) for name, values in run.inputs.items()}
    for name, values in run.sensors.items():
        sensor = run.machine.sensors[name]
        noisy = values + sensor.sigma * draw.standard_normal(len(values)) + (shifts or {}).get(name, 0.0)
        columns[name] = Column(name, sensor.unit, noisy)
    return Recording("morning", "morning.csv", run.t, {**columns, **more})


def compared(run: Trajectory, *shifts: dict[str, Any], **more: Column) -> Comparison:
    return compare(run.machine, [recording_of(run, shift, **more) for shift in shifts], start=Start(others=22.0))


def only(comparison: Comparison) -> RecordingResidual:
    (residual,) = comparison.recordings
    return residual


def line_of(text: str, start: str) -> str:
    return next(line for line in text.splitlines() if line.strip().startswith(start))


# -- tables ---------------------------------------------------------------------------------------------------------
def test_numbers_stand_to_the_right_and_words_to_the_left() -> None:
    lines = table(["name", "value [K]"], [["a", "1"], ["longer", "10.5"]], ["value [K]"])
    assert lines == ["  name    value [K]", "  a               1", "  longer       10.5"]


def test_long_tables_are_cut() -> None:
    lines = table(["name"], [[str(i)] for i in range(MOST_ROWS + 5)])
    assert len(lines) == MOST_ROWS + 2 and lines[-1] == "  … and 5 more"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.05, "0.05000"),
        (39.24, "39.24"),
        (1234.5, "1234"),
        (-2.5, "-2.500"),
        (0, "0"),
        (4e7, "4e+07"),
        (np.nan, "–"),
        (99.996, "100.0"),
    ],
)
def test_digits(value: float, text: str) -> None:
    assert digits(value) == text


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("closure -5e-13, z -12.87 to +3 (-3.1 σ)", "closure −5e-13, z −12.87 to +3 (−3.1 σ)"),
        ("-0.5 [-1; -2] ±-3 and -.5", "−0.5 [−1; −2] ±−3 and −.5"),
        ("run-2.csv of 2026-11-20, solve_ivp:a-b, ISO 230-3, 1e-5 --lumps", None),
    ],
)
def test_there_is_one_minus(text: str, told: str | None) -> None:
    assert write_minus(text) == (told or text)


@pytest.mark.parametrize(
    ("seconds", "text"), [(0.01, "0.01 s"), (100, "100 s"), (7200, "2 h"), (600, "10 min"), (864e3, "10 d")]
)
def test_spans_of_time(seconds: float, text: str) -> None:
    assert span(seconds) == text


# -- a machine ------------------------------------------------------------------------------------------------------
def test_a_machine_is_described_in_tables() -> None:
    text = describe(machine_of())
    assert text.startswith("Test mill: 5 nodes, 4 links, 1 source, 3 sensors; displacements are zero at 22 °C")
    assert re.split(r"\s{2,}", line_of(text, "shaft").strip()) == ["shaft", "mass, rotates", "4.000", "1"]
    assert re.split(r"\s{2,}", line_of(text, "bed").strip()) == ["bed", "bar of iron", "30.00", "2"]
    assert line_of(text, "seat").split("  ")[1].strip() == "seat" and "massless junction" in line_of(text, "seat")
    assert "held at 20 °C" in line_of(text, "water") and "held at ambient" in line_of(text, "ambient")
    assert "conductance or capacity flow [W/K]" in line_of(text, "link")
    assert line_of(text, "bearing").split()[1:] == ["conduction", "shaft", "–", "bed@0..0.5", "20.0"]
    assert line_of(text, "jacket").split()[1:] == ["advection", "water", "→", "bed", "12.0"]
    assert line_of(text, "friction").endswith("bearing_friction  shaft 25%, bed 75%  torque 0.4 N m")
    told = "stretching  bed  direction −1, length 0.3 m"
    assert line_of(text, "z: bed grows").endswith(told)
    assert "shaft, with sensor_lag" in line_of(text, "T_shaft") and line_of(text, "T_bed").split()[-2:] == ["0.10", "K"]
    assert "tcp.z, zeroed at the start" in line_of(text, "dz") and line_of(text, "dz").split()[-2:] == ["0.25", "µm"]
    assert "reads the inputs: ambient [degC], speed [rpm]" in text


def test_what_an_entry_reads_and_how_it_is_driven_is_told() -> None:
    axis = {"kind": "stretching", "of": "bed", "fixed": "30 mm", "at": "50 mm + position", "direction": 1}
    fan = {"kind": "forced_convection", "between": ["shaft", "ambient"], "conductance": "4 W/K", "gain": 3,
           "reference_speed": "9000 rpm", "input": "n2", "while": "door"}  # fmt: skip
    cooler = {"kind": "thermostat_cooling", "into": {"bed": 1}, "watches": "shaft", "set": "22 degC",
              "hysteresis": "0.5 K", "power": "800 W"}  # fmt: skip
    coil = {"kind": "heat_source", "into": {"shaft": 1}, "power": "30 W", "with": "feed_x", "at": "40 m/min"}
    machine = machine_of(tcp={"z": {"bed grows": axis}}, sources={"cooler": cooler, "coil": coil})
    text = describe(machine.patched({"links": {"fan": fan}}))
    assert "further" in line_of(text, "link")
    assert line_of(text, "fan").endswith("while door, gain 3, reference_speed 9000 rpm, input n2")
    assert line_of(text, "cooler").endswith("watches shaft, set 22 °C, hysteresis 0.5 K, power 800 W")
    assert line_of(text, "coil").endswith("power 30 W, with feed_x, at 40 m/min")
    assert line_of(text, "z: bed grows").endswith("direction 1, fixed 30 mm, at 50 mm + position")


def test_uncertain_numbers_stand_with_their_spread() -> None:
    text = describe(machine_of())
    assert line_of(text, "nodes.shaft.heat_capacity").split()[1:] == ["4000", "20", "%", "J/K"]
    assert line_of(text, "links.bearing.conductance").split()[1:] == ["20.00", "30", "%", "W/K"]
    assert line_of(text, "links.skin.conductance").split()[1:] == ["unknown", "1.00..50.0", "W/K"]
    nodes = {"a": {"heat_capacity": "1 J/K"}, "room": {"temperature": "20 degC"}}
    links = {"l": {"kind": "conduction", "between": ["a", "room"], "conductance": "1 W/K"}}
    known = machine_of(nodes=nodes, links=links, sources=None, tcp=None, sensors=None)
    assert "No number is uncertain: nothing to calibrate." in describe(known)
    assert "sensor  " not in describe(known)


def two_masses(**ambient: Any) -> Machine:
    nodes = {
        "a": {"heat_capacity": "1000 J/K"},
        "b": {"heat_capacity": "1000 J/K"},
        "j": {},
        "room": {"temperature": "20 degC"},
    }
    links = {
        "a j": {"kind": "conduction", "between": ["a", "j"], "conductance": "4 W/K"},
        "j b": {"kind": "conduction", "between": ["j", "b"], "conductance": "4 W/K"},
        **ambient,
    }
    return machine_of(nodes=nodes, links=links, sources=None, tcp=None, sensors=None)


def test_time_constants_are_those_of_two_masses() -> None:
    """Symmetric and antisymmetric mode: C/G₀ and C/(G₀ + 2 G), G through the junction 2 W/K."""
    skins = {f"{n} skin": {"kind": "convection", "between": [n, "room"], "conductance": "1 W/K"} for n in "ab"}
    machine = two_masses(**skins)
    np.testing.assert_allclose(time_constants(build(machine)), [1000 / 5, 1000 / 1])
    assert describe(machine).endswith("time constants: fastest 3.33 min, slowest 16.7 min")


def test_a_machine_that_never_settles_says_so() -> None:
    lost = {"x": {"kind": "conduction", "between": ["a", "b"], "conductance": "1 W/K"}}
    assert "fastest 2.78 min, it never settles: no path to a held node" in describe(two_masses(**lost))
    radiating = {"r": {"kind": "radiation", "between": ["a", "room"], "emissivity_area": "1 m^2"}}
    assert describe(two_masses(**radiating)).endswith("time constants: none, the network is not linear")


@pytest.mark.speed
def test_describing_is_quick(mill: Machine) -> None:
    began = time.process_time()
    describe(mill)
    assert time.process_time() - began < 0.2


# -- a run ----------------------------------------------------------------------------------------------------------
def test_a_run_tells_method_temperatures_and_movement(run: Trajectory) -> None:
    text = tell_run(run)
    first, second, *_ = text.splitlines()
    assert first.startswith("Test mill: warm up, 2 h simulated in ") and second.startswith(
        f"method {run.method}: {run.why}"
    )
    values = run.sensors["T_bed"]
    told = [float(word) for word in line_of(text, "T_bed").split()[1:]]
    np.testing.assert_allclose(told, [values[0], values.min(), values.max(), values[-1]], atol=0.006)
    assert "temperature [°C]" in text and "dz" not in text
    z = run.tcp["z"] * 1e6
    cells = line_of(text, "z [µm]").split()
    ends = [float(cell.replace("−", "-")) for cell in cells[2:5]]
    np.testing.assert_allclose(ends, [z.max(), z.min(), z[-1]], atol=0.006)
    peak = int(np.abs(z).argmax())
    shift = format_shift(float(z[peak]), 2)
    assert line_of(text, "z [µm]").endswith(f"bed grows ({shift} at {run.t[peak] / 60:.0f} min)")


def test_a_run_tells_its_energy(run: Trajectory) -> None:
    text = tell_run(run)
    told = re.search(r"energy \[kJ\]: in ([\d.]+), out ([\d.]+), stored (-?[\d.]+); closure", text)
    assert told is not None
    account = run.energy
    expected = [account.in_ / 1e3, account.out / 1e3, account.total_stored / 1e3]
    np.testing.assert_allclose([float(number) for number in told.groups()], expected, rtol=1e-3)
    assert "brought in by friction" in text and "taken out by" in text


def test_a_run_without_sensors_or_movement_tells_of_its_parts(run: Trajectory) -> None:
    bare = replace(run, sensors={}, tcp={}, contributions={})
    assert "shaft" in tell_run(bare) and "moves no tool centre point" in tell_run(bare)


def test_switches_and_warnings_are_told(run: Trajectory) -> None:
    events = replace(
        run, switches=((600.0, "cooler", True), (900.0, "cooler", False), (50.0, "fan", True)), warnings=("hot",)
    )
    text = tell_run(events)
    assert "cooler switches 2 times, first after 10 min" in text and "fan switches once, first after 50 s" in text
    assert text.endswith("warning: hot")


# -- a comparison ---------------------------------------------------------------------------------------------------
def test_a_comparison_tells_the_residual_of_every_channel(run: Trajectory) -> None:
    comparison = compared(run, {})
    text = tell_comparison(comparison)
    assert text.splitlines()[0] == "Test mill: morning.csv"
    assert line_of(text, "channel").split("  ")[1] == "channel"
    channel = only(comparison).channels["dz"]
    told = channel.summary()
    assert line_of(text, "dz").split()[4:] == ["µm", "721"]
    np.testing.assert_allclose([float(word) for word in line_of(text, "dz").split()[1:4]],
                               [channel.rmse_in_noise, told["rmse"], told["max"]], rtol=6e-3)  # fmt: skip
    assert line_of(text, "T_bed").split()[4] == "K"
    assert f"all channels: rmse {digits(comparison.rmse_in_noise, 3)} σ" in text
    assert "Every channel agrees within its noise" in text and "Columns" not in text


@pytest.mark.parametrize(
    ("name", "shift", "sentence"),
    [
        ("T_shaft", -3.0, "Worst is T_shaft: simulated 3.00 K too warm between 40 and 110 min."),
        ("T_bed", 3.0, "Worst is T_bed: simulated 3.00 K too cold between 40 and 110 min."),
        ("dz", 20e-6, "Worst is dz: simulated 20.0 µm too low between 40 and 110 min."),
        ("dz", -20e-6, "Worst is dz: simulated 20.0 µm too high between 40 and 110 min."),
    ],
)
def test_the_worst_channel_is_told_with_its_window(run: Trajectory, name: str, shift: float, sentence: str) -> None:
    window = (run.t >= 2400) & (run.t <= 6600)
    told = tell_worst(only(compared(run, {name: np.where(window, shift, 0.0)})))
    rough = re.sub(r"\d[\d.]*", lambda number: f"{float(number[0]):.1g}", told)
    assert rough == re.sub(r"\d[\d.]*", lambda number: f"{float(number[0]):.1g}", sentence)


def test_the_worst_window_keeps_to_the_readings(run: Trajectory) -> None:
    window = (run.t >= 2400) & (run.t <= 6600)
    channel = only(compared(run, {"T_bed": np.where(window, 3.0, np.where(run.t < 1000, np.nan, 0.0))})).channels[
        "T_bed"
    ]
    first, last, mean = worst_window(channel)
    assert abs(first - 2400) < 100 and abs(last - 6600) < 100 and mean == pytest.approx(3, abs=0.05)
    short = replace(
        channel, t=channel.t[300:302], measured=channel.measured[300:302], simulated=channel.simulated[300:302]
    )
    assert worst_window(short)[:2] == (3000, 3010)


def test_a_shift_all_along_is_told_as_such(run: Trajectory) -> None:
    assert tell_worst(only(compared(run, {"T_bed": 2.0}))).endswith("too cold throughout.")


def test_unused_columns_and_empty_channels(run: Trajectory) -> None:
    empty = np.full(len(run.t), np.nan)
    feed = Column("feed", "m/min", np.zeros(len(run.t)))
    text = tell_comparison(compared(run, {"T_shaft": empty}, feed=feed))
    assert line_of(text, "T_shaft").split() == ["T_shaft", "–", "–", "–", "K", "0"]
    assert text.endswith("Columns the machine does not use, candidate drivers of missing physics: feed.")


def test_several_recordings_end_with_a_pooled_line(run: Trajectory) -> None:
    comparison = compared(run, {}, {"T_bed": 2.0})
    text = tell_comparison(comparison)
    assert text.count("Test mill: morning.csv") == 2
    assert text.endswith(f"all recordings: rmse {digits(comparison.rmse_in_noise, 3)} σ")


@pytest.mark.skipif(not SHARED.is_dir(), reason="the folder shared/ is not beside this repository")
@pytest.mark.parametrize("case", ["a-cooler", "c-windage", "l-rough"])
def test_shared_cases_can_be_told(case: str) -> None:
    machine = Machine.load(SHARED / case / "machine.yaml")
    recording = Recording.load(SHARED / case / "train1.csv")
    for text in (str(machine), str(simulate(machine, recording)), str(compare(machine, [recording]))):
        assert len(text.splitlines()) < 80 and max(map(len, text.splitlines())) < 150
        assert "nan" not in text and "None" not in text


def test_a_table_has_true_minus_signs_and_no_negative_nothing() -> None:
    lines = table(["name", "shift"], [["a-b", "-4.1"], ["-c", "-0.0"]], ["shift"])
    assert [line.split() for line in lines[1:]] == [["a-b", "−4.1"], ["-c", "0.0"]]
    assert [format_shift(x) for x in (-4.12, -0.04, 2.0)] == ["−4.1", "+0.0", "+2.0"]
