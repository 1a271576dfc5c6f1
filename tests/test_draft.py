"""Drafts: what is known of a made machine is found again, and drafts of real rigs calibrate and foretell."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import network
from network import Machine, Recording, Refused, calibrate
from network.analysis.comparison.compare import Comparison
from network.analysis.drafting.channel_names import axis_in, is_set_point, name_part, nearness
from network.analysis.drafting.channel_roles import Wishes
from network.analysis.drafting.lag_bank import lag
from network.analysis.drafting.lag_fit import TwoLags
from network.analysis.drafting.machine_draft import Draft, draft
from network.catalogue.declaration.declare import Array
from network.cli import main
from network.recordings.columns import Column

RECORDINGS = Path(__file__).resolve().parents[2] / "shared" / "recordings"
MAPPINGS = Path(__file__).resolve().parent / "recordings"
here = pytest.mark.skipif(not RECORDINGS.is_dir(), reason="the recordings in ../shared/recordings are not here")
RPM = 2 * np.pi / 60
STEP = 20.0
T = STEP * np.arange(901)
SPINDLE, BED = 900.0, 3600.0
"""s: τ of a spindle that follows the speed and of a bed that follows the spindle."""
GAIN, SHARE = 12.0 / (3000 * RPM), 0.6


def made(seed: int, noise: float = 0.03) -> Recording:
    """Five hours of two masses: a spindle with two thermometers, which loses its heat to the room alone, and a bed that
    follows it and the room; the tool moves by 3 µm/K of the spindle and −9 µm/K of the bed."""
    rng = np.random.default_rng(seed)
    speed = RPM * np.repeat(rng.choice([0, 1500, 3000, 4500], 13), 72)[: len(T)] * (T > 600)
    room = 20 + 0.8 * np.sin(2 * np.pi * T / 2e4 + seed)
    spindle = 20 + exact(GAIN * speed + room - 20, SPINDLE)
    bed = 20 + exact(SHARE * (spindle - 20) + (1 - SHARE) * (room - 20), BED)
    dz = 3e-6 * (spindle - spindle[0]) - 9e-6 * (bed - bed[0])
    noisy = {name: x + rng.normal(0, noise, len(T)) for name, x in
             {"T1": spindle, "T2": spindle + 0.2, "T_bed": bed, "ambient": room}.items()}  # fmt: skip
    columns = {"speed": Column("speed", "rpm", speed), "dz": Column("dz", "um", dz + rng.normal(0, 2e-7, len(T)))}
    columns |= {name: Column(name, "degC", x) for name, x in noisy.items()}
    return Recording(f"run {seed}", f"run{seed}.csv", T, columns)


def exact(x: Array, tau: float) -> Array:
    """y with τ dy/dt = x − y, y = 0 at first, x held over each step."""
    y = np.zeros(len(x))
    for k in range(1, len(x)):
        y[k] = x[k - 1] + (y[k - 1] - x[k - 1]) * np.exp(-STEP / tau)
    return y


@pytest.fixture(scope="module")
def drafted() -> Draft:
    return draft([made(1), made(2)])


def without(recording: Recording, *names: str) -> Recording:
    return replace(recording, columns={n: c for n, c in recording.columns.items() if n not in names})


def with_column(recording: Recording, name: str, unit: str, values: Array) -> Recording:
    return replace(recording, columns={**recording.columns, name: Column(name, unit, values)})


def test_a_draft_is_at_hand_from_python_for_one_recording_too() -> None:
    assert network.draft is draft
    assert network.draft(made(1)).found.models[0].group.sensors == ("T1", "T2")


# -- a made machine -------------------------------------------------------------------------------------------------
def test_two_masses_are_two_parts_with_their_drivers_and_time_constants(drafted: Draft) -> None:
    spindle, bed = drafted.found.models
    assert spindle.group.sensors == ("T1", "T2") and bed.group.sensors == ("T_bed",)
    assert set(spindle.fit.weights) >= {" surroundings", "speed"} and bed.parent == 0
    assert spindle.fit.tau == pytest.approx(SPINDLE, rel=0.05) and bed.fit.tau == pytest.approx(BED, rel=0.2)
    assert spindle.fit.weights["speed"] == pytest.approx(GAIN, rel=0.03)
    assert bed.fit.weights[" part it follows"] == pytest.approx(SHARE, rel=0.1)


def test_the_tool_is_moved_by_the_parts_that_move_it(drafted: Draft) -> None:
    (path,) = drafted.paths
    assert path.axis == "z" and path.slopes[0] == pytest.approx(3e-6, rel=0.1)
    assert path.slopes[1] == pytest.approx(-9e-6, rel=0.1)
    entries = drafted.machine.tcp["z"]
    assert [entry.direction for entry in entries.values()] == [1 if k > 0 else -1 for k in path.slopes.values()]


def test_the_file_reads_back_and_every_size_has_a_spread(drafted: Draft, tmp_path: Path) -> None:
    file = tmp_path / "machine.yaml"
    file.write_text(drafted.text, encoding="utf-8")
    machine = Machine.load(file)
    assert machine.to_plain() == drafted.machine.to_plain()
    sizes = [entry for section in ("nodes", "links", "sources") for entry in machine.to_plain()[section].values()]
    keys = "heat_capacity", "conductance", "torque"
    told = [body[key] for body in sizes for key in keys if key in body]
    assert len(told) == 6 and all("±" in text for text in told)
    assert drafted.found.noise["T1"] == pytest.approx(0.03, rel=0.15)
    assert 0.85 * 0.03 < machine.sensors["T1"].sigma < 2 * 0.03


def test_the_noise_told_is_what_the_parts_leave() -> None:
    """A bed that also follows something nobody records, by 0.5 K: its noise says so, not the 0.03 K of its readings."""
    runs = [made(k) for k in (1, 2)]
    strange = 0.5 * np.sqrt(2) * np.sin(2 * np.pi * T / 5000)
    runs = [with_column(run, "T_bed", "degC", run.columns["T_bed"].values + strange) for run in runs]
    found = draft(runs)
    assert found.found.noise["T_bed"] < 0.1
    assert found.machine.sensors["T_bed"].sigma == pytest.approx(found.found.models[1].fit.rms, rel=0.1)
    assert 0.2 < found.machine.sensors["T_bed"].sigma < 0.7


def test_what_a_part_loses_follows_from_its_lag(drafted: Draft) -> None:
    """C/G of the bed, which nothing follows, is its time constant."""
    bed, fit = drafted.sizes[1], drafted.found.models[1].fit
    assert bed.to_parent is not None
    assert bed.capacity / (bed.around + bed.to_parent) == pytest.approx(fit.tau, rel=1e-9)


def test_a_recorded_power_tells_the_scale() -> None:
    """30 W, τ = 900 s, 0.4 K/W in the end: G = 2.5 W/K, C = 2250 J/K."""
    power = np.where((T > 2000) & (T < 9000), 30.0, 0.0)
    rise = exact(0.4 * power, 900.0) + np.random.default_rng(0).normal(0, 0.02, len(T))
    columns = {"heater": Column("heater", "W", power), "T": Column("T", "degC", 21 + rise)}
    found = draft([Recording("heated", "heated.csv", T, columns)])
    assert found.sizes[0].is_known and found.sizes[0].capacity == pytest.approx(2250, rel=0.03)
    assert found.sizes[0].around == pytest.approx(2.5, rel=0.03)
    assert found.machine.to_plain()["sources"]["T by heater"]["power"].startswith("1 W")


def test_a_room_without_a_name_is_told_by_how_it_moves() -> None:
    runs = [without(made(k), "ambient") for k in (1, 2)]
    room = [made(k).columns["ambient"].values for k in (1, 2)]
    named = [with_column(run, "TC08", "degC", values) for run, values in zip(runs, room, strict=True)]
    found = draft(named).found.roles
    assert found.ambient == "TC08" and found.is_by_behaviour
    assert draft(runs).found.roles.ambient == ""


def test_a_room_that_stands_still_is_a_room() -> None:
    run = with_column(made(1), "ambient", "degC", 0 * T + 20.4)
    assert draft([run]).found.roles.ambient == "ambient"
    with pytest.raises(Refused, match="no temperature of a part is recorded that moves"):
        draft([replace(run, columns={name: run.columns[name] for name in ("speed", "ambient")})])


def test_a_source_of_heat_that_nobody_records_is_held() -> None:
    found = draft([without(made(k), "speed", "T2") for k in (1, 2)])
    assert found.found.roles.held == ("T1",) and found.machine.nodes["T1"].is_held
    kept = draft([without(made(k), "speed", "T2") for k in (1, 2)], Wishes(sensors=("T1",)))
    assert kept.found.roles.held == () and "T1" in kept.machine.sensors


def test_a_late_reading_is_a_lag_of_the_sensor() -> None:
    run = without(made(1), "T2", "T_bed", "dz")
    late = 20 + exact(run.columns["T1"].values - 20, 240.0)
    fit = draft([with_column(run, "T1", "degC", late)]).found.models[0].fit
    assert fit.lags is not None and fit.lags.is_late and 120 < fit.lags.short < 480


def test_two_lags_are_those_of_two_masses() -> None:
    """C₁ = 3, C₂ = 8, G = 2, G₁₂ = 0.5: the eigenvalues and the zero lead back to them."""
    C1, C2, G, G12 = 3.0, 8.0, 2.0, 0.5
    rates = -np.linalg.eigvals(np.array([[-(G + G12) / C1, G12 / C1], [G12 / C2, -G12 / C2]]))
    short, long = sorted(1 / rates)
    lags = TwoLags(short, long, (C2 / G12 - short) / (long - short))
    assert lags.own * G == pytest.approx(C1) and lags.behind * G == pytest.approx(C2)
    assert lags.behind * G / lags.zero == pytest.approx(G12)


def test_a_lag_is_exact_where_its_input_is_constant() -> None:
    step, tau = 7.0, 50.0
    ends = step * np.arange(1, 41)
    means = 1 - tau / step * np.exp(-ends / tau) * (np.exp(step / tau) - 1)
    assert np.allclose(lag(np.ones(40), step, tau), means, rtol=1e-12)


# -- columns as they come -------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("name", "rank"),
    [("T_amb", 1), ("Umgebungsluft", 1), ("Raumtemperatur", 2), ("T_outdoor_C", 0), ("troom", 2), ("室温", 2),
     ("Arbeitsraum", None), ("T_frame", None), ("broom", None), ("T_coolant_wall", None), ("T_air", None)],
)  # fmt: skip
def test_names_tell_surroundings(name: str, rank: int | None) -> None:
    assert nearness(name) == rank


def test_names_tell_axes_set_points_and_parts() -> None:
    assert [axis_in(n) for n in ("disp_x_um", "dz", "Verlagerung Z", "dia_disp")] == ["x", "z", "z", ""]
    assert is_set_point("T_bed_set") and is_set_point("Sollwert") and not is_set_point("T_bed")
    assert name_part(["T_spindle_front_C", "T_spindle_rear_C"], []) == "spindle"
    assert name_part(["PT01"], ["PT01"]) == "PT01 2" and name_part(["A", "B", "C"], []) == "A and alike"


def test_what_drives_nothing_is_told_with_its_reason() -> None:
    run = made(1)
    run = with_column(run, "pump", "W", 0 * T)
    run = with_column(run, "T9", "degC", 0 * T + 21)
    run = with_column(run, "way", "mm", (T % 600) * 1e-3)
    run = with_column(run, "tcp.x", "um", 0 * T)
    unused = draft([run]).found.roles.unused
    assert unused["pump"] == "it is zero at all times" and unused["T9"] == "it never moves"
    assert "an axis's way" in unused["way"] and "means a displacement" in unused["tcp.x"]


def test_gaps_in_readings_are_borne_and_gaps_in_inputs_refused() -> None:
    run = made(1)
    gaps = {n: replace(c, values=np.where((T > 4000) & (T < 6000), np.nan, c.values)) for n, c in run.columns.items()}
    of = draft([replace(run, columns={**run.columns, "T_bed": gaps["T_bed"], "dz": gaps["dz"]})])
    assert of.found.models[1].fit.tau == pytest.approx(BED, rel=0.3)
    with pytest.raises(Refused, match=r"fill: \{speed: linear\}"):
        draft([replace(run, columns={**run.columns, "speed": gaps["speed"]})])


def test_a_single_sensor_without_any_input_is_a_machine() -> None:
    run = made(1)
    alone = draft([replace(run, columns={"T1": run.columns["T1"]})])
    assert alone.machine.to_plain()["nodes"].keys() == {"T1", "ambient"}
    assert "±" in alone.machine.to_plain()["nodes"]["ambient"]["temperature"]


@pytest.mark.parametrize(
    ("columns", "wishes", "told"),
    [(("speed", "dz"), Wishes(), "no temperature of a part is recorded"),
     (("speed", "T1"), Wishes(inputs=("sped",)), "did you mean 'speed'"),
     (("speed", "T1"), Wishes(ambient="speed"), "name a temperature"),
     (("speed", "T1"), Wishes(inputs=("T1",), sensors=("T1",)), "named as something else"),
     (("speed", "T1"), Wishes(inputs=("T1",)), "no temperature of a part is recorded")],
)  # fmt: skip
def test_what_cannot_be_drafted_is_refused(columns: Sequence[str], wishes: Wishes, told: str) -> None:
    run = made(1)
    with pytest.raises(Refused, match=told):
        draft([replace(run, columns={name: run.columns[name] for name in columns})], wishes)


def test_a_recording_that_is_too_short_is_refused() -> None:
    with pytest.raises(Refused, match="too few for a time constant"):
        draft([made(1).before(100)])


# -- the command ----------------------------------------------------------------------------------------------------
def written(folder: Path) -> Path:
    path, run = folder / "run.csv", without(made(1), "T2", "T_bed", "dz")
    rows = zip(T, run.columns["speed"].values / RPM, run.columns["T1"].values, strict=True)
    text = "\n".join(f"{t:g},{n:g},{x:.3f}" for t, n, x in rows)
    path.write_text(f"time [s],speed [rpm],T_front [degC]\n{text}\n", encoding="utf-8")
    return path


def test_the_command_writes_prints_and_keeps_what_was_worked_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run, machine = written(tmp_path), tmp_path / "new" / "machine.yaml"
    main(["draft", str(run), "-o", str(machine), "--json"])
    summary = json.loads(capsys.readouterr().out)
    assert summary["machine"] == str(machine) and summary["parts"][0]["name"] == "front"
    main(["draft", str(run), "-o", str(machine)])
    assert "front follows speed" in capsys.readouterr().out
    main(["draft", str(run)])
    assert capsys.readouterr().out == machine.read_text(encoding="utf-8")
    machine.write_text("machine: mine\n", encoding="utf-8")
    with pytest.raises(SystemExit) as left:
        main(["draft", str(run), "-o", str(machine)])
    assert left.value.code == 2 and "was not drafted" in capsys.readouterr().err
    assert machine.read_text(encoding="utf-8") == "machine: mine\n"


# -- real rigs ------------------------------------------------------------------------------------------------------
RIGS = {
    "two heaters": (("tclab_second_order", "tclab_energy_balance"), ("tclab_mhe",)),
    "gantry": (("voron_2021_06_13",), ("voron_2021_06_05",)),
    "lathe": (("lathe_day01",), ("lathe_day02",)),
    "oven": (("toaster_full_power",), ()),
    "building": (("building_train",), ()),
    "blocks": (("three_blocks",), ()),
    "turning centre": (("cnc_lathe 20200615", "cnc_lathe 20200810"), ("cnc_lathe 20200818",)),
}
"""Mappings that are drafted from, and those held out; without any, the second part of the only one."""
FEW = ("speed", "feed", "ambient", "Spindle_motor", "X_motor", "PT02", "PT08", "disp_z")
"""Columns of the turning centre, that the test stays short."""


def runs_of(rig: str, folder: Path) -> tuple[list[Recording], list[Recording]]:
    """Without starts, which name the parts of another machine."""
    train, holdout = ([_load(name, folder) for name in names] for names in RIGS[rig])
    if holdout:
        return train, holdout
    (whole,) = train
    middle = whole.t[0] + 0.6 * (whole.t[-1] - whole.t[0])
    return [whole.before(middle)], [whole._keep(whole.t >= middle)]


def _load(name: str, folder: Path) -> Recording:
    """A mapping, or that of another day of the same rig."""
    mapping, _, day = name.partition(" ")
    path = MAPPINGS / f"{mapping}.yaml"
    if day:
        text = path.read_text(encoding="utf-8").replace("../../../shared/recordings", str(RECORDINGS))
        path = folder / f"{day}.yaml"
        path.write_text(re.sub("run_[0-9]+", f"run_{day}", text), encoding="utf-8")
    run = Recording.load(path)
    return replace(run, start=None, columns={n: c for n, c in run.columns.items() if not day or n in FEW})


def nothing(told: Comparison) -> float:
    """rms in noise of channels that stay where they begin, over the readings that are counted."""
    squares = list[Array]()
    for one in told.recordings:
        for name, channel in one.channels.items():
            values = one.recording.columns[name].values
            early = values[one.recording.t <= one.recording.t[0] + 60]
            change = values - np.nanmean(early if np.isfinite(early).any() else values[np.isfinite(values)][:1])
            squares.append((change[np.isfinite(values)] / channel.sigma) ** 2)
    return float(np.sqrt(np.concatenate(squares).mean()))


@here
@pytest.mark.parametrize("rig", RIGS)
def test_a_draft_of_a_rig_calibrates_and_foretells_better_than_nothing(rig: str, tmp_path: Path) -> None:
    train, holdout = runs_of(rig, tmp_path)
    file = tmp_path / "machine.yaml"
    file.write_text(draft(train).text, encoding="utf-8")
    found = calibrate(Machine.load(file), train, holdout)
    assert found.after_holdout is not None
    assert found.after_holdout.rmse_in_noise < nothing(found.after_holdout)
