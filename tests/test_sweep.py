"""Sweeps: levels converge, grids hold what was asked for, processes change nothing, refusals say what helps."""

from __future__ import annotations

import csv
import json
import os
import pickle
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from build import machine

from network import Machine, Recording, Refused, Scenario, simulate, sweep
from network.analysis.comparison.compare import compare
from network.analysis.sweep.grid_runs import GridJob, VariedRun, run_varied
from network.analysis.sweep.sweep import Sweep
from network.analysis.sweep.variations import parse_variation
from network.cli import main
from network.report.files.sweep_files import write_sweep

ROOT = Path(__file__).parent.parent
GANTRY, WARM_UP = ROOT / "machines/gantry_spindle.yaml", ROOT / "scenarios/warm_up_and_stop.yaml"
HOUR = Scenario.of("an hour at 8000 rpm", "1 h", {"speed": "8000 rpm", "ambient": "21.6 degC"}, output="60 s")
GUIDEWAY = "links.guideway.conductance"


@pytest.fixture(scope="module")
def gantry() -> Machine:
    return Machine.load(GANTRY)


@pytest.fixture(scope="module")
def levels(gantry: Machine) -> Sweep:
    return sweep(gantry, HOUR, levels=["paper", 1, 2, 4, "fine"], tolerance="2 um")


def heated_bar(**changes: Any) -> Machine:
    """A steel bar heated at one end and cooled at the other; half of it moves z."""
    sections: dict[str, Any] = {
        "links": {"skin": {"kind": "convection", "between": ["bar@0.9..1", "air"], "conductance": "20 W/K"}},
        "sources": {"heater": {"kind": "heat_source", "into": {"bar@0..0.1": 1}, "power": "50 W"}},
        "tcp": {"z": {"grows": {"kind": "stretching", "of": "bar@0..0.5", "direction": 1}}},
    }
    bar = {"material": "steel", "length": "400 mm", "area": "20 cm^2"}
    return machine({"bar": bar, "air": {"temperature": "20 degC"}}, **(sections | changes))


# -- levels ---------------------------------------------------------------------------------------------------------
def test_levels_converge_on_a_bar() -> None:
    """Twice the lumps, a quarter of the difference: the lumps of a bar are of second order."""
    result = sweep(heated_bar(), Scenario.of("half an hour", "30 min"), levels=[10, 20, 40, 320])
    gaps = [result.gap(run, "z") for run in result.levels if run.level != "as written"]
    largest, rms = ([getattr(gap, what) for gap in gaps if gap] for what in ("largest", "rms"))
    for sizes in (largest, rms):
        assert 3.2 < sizes[0] / sizes[1] < 4.8 and 3.2 < sizes[1] / sizes[2] < 4.8
        assert sizes[3] == 0
    warm = [result.temperature_gap(run) or 0.0 for run in result.levels]
    assert sorted(warm, reverse=True) == warm


def test_levels_are_the_machines_they_name(gantry: Machine, levels: Sweep) -> None:
    assert [run.level for run in levels.levels] == ["paper", "as written", "1", "2", "4", "fine"]
    assert [run.lumps for run in levels.levels] == [2, 9, 6, 12, 24, 80]
    assert levels.finest.level == "fine"
    evenly = [Machine.load(GANTRY, lumps=[count]) for count in (1, 2, 4)]
    machines = [gantry, *evenly, Machine.load(GANTRY, level="fine")]
    for run, same in zip(levels.levels[1:], machines, strict=True):
        direct = simulate(same, HOUR)
        assert all(run.tcp[axis] == pytest.approx(direct.tcp[axis], rel=1e-9, abs=1e-15) for axis in direct.tcp)
        assert run.solve_seconds > 0


def test_difference_is_to_the_finest(levels: Sweep) -> None:
    for run in levels.levels:
        for axis in ("y", "z"):
            off, gap = run.tcp[axis] - levels.finest.tcp[axis], levels.gap(run, axis)
            assert gap is not None
            assert (gap.largest, gap.rms) == pytest.approx((np.abs(off).max(), np.sqrt((off**2).mean())), rel=1e-12)
    assert levels.temperature_gap(levels.levels[0]) is None  # the closed form has no sensors inside
    assert list(levels.finest.temperatures) == ["T_nose", "T_stator", "T_housing", "T_headstock", "T_beam"]


def test_coarsest_within_the_tolerance(gantry: Machine, levels: Sweep) -> None:
    assert levels.coarsest_within is not None and levels.coarsest_within.level == "4"
    assert "\n4 lumps stay within 2 µm of 'fine': " in str(levels)
    told = levels.summary()["tolerance"]
    assert (told["value"], told["unit"], told["level"]) == (2.0, "um", "4")
    assert told["sentence"].count("µm") == 3 and "µm at most along z, " in told["sentence"]
    tight = sweep(gantry, HOUR, levels=[1, 2, 4], tolerance="1 nm")
    assert tight.coarsest_within is None
    assert "No level stays within 1 nm of 4 lumps; nearest is 2 lumps: " in str(tight)


def test_usual_levels(gantry: Machine) -> None:
    names = [run.level for run in sweep(gantry, HOUR).levels]
    assert names == ["paper", "as written", "1", "2", "4", "8", "16", "coarse", "fine"]
    assert [run.level for run in sweep(heated_bar(), HOUR).levels] == ["1", "2", "4", "8", "16"]


def test_recording_is_laid_beside_every_level(gantry: Machine, tmp_path: Path) -> None:
    """Rms in noise is that of compare; the closed form is judged by its displacements alone."""
    from network.report.files.result_files import write_run

    write_run(simulate(gantry, HOUR, noise_seed=1), tmp_path)
    recording = Recording.load(tmp_path / "results.csv")
    result = sweep(gantry, recording, levels=["paper", 1, 4])
    for run, lumps in ((result.levels[2], 1), (result.levels[3], 4)):
        apart = compare(Machine.load(GANTRY, lumps=[lumps]), [recording])
        assert run.in_noise == pytest.approx(apart.rmse_in_noise, rel=1e-9)
    paper = result.levels[0]
    assert paper.in_noise == paper.tcp_in_noise > 10
    assert "rmse [σ]" in str(result) and "rmse [σ]" not in str(sweep(gantry, HOUR, levels=[1, 2]))


# -- values ---------------------------------------------------------------------------------------------------------
def test_values_of_a_variation() -> None:
    ranged = parse_variation("links.skin.conductance=3..9 W/K:4")
    assert (ranged.path, ranged.values, ranged.unit) == ("links.skin.conductance", (3.0, 5.0, 7.0, 9.0), "W/K")
    listed = parse_variation(" sources.a b.torque = 100, 2e2,300 N mm")
    assert (listed.path, listed.values, listed.unit) == ("sources.a b.torque", (100.0, 200.0, 300.0), "N mm")
    assert listed.setting(200.0) == "sources.a b.torque=200 N mm"
    assert parse_variation("nodes.beam.lumps=1,8").setting(8.0) == "nodes.beam.lumps=8"
    assert parse_variation("reference=-5..-1 degC:2").values == (-5.0, -1.0)


def test_grid_is_the_product_in_order(gantry: Machine) -> None:
    result = sweep(gantry, HOUR, vary=[f"{GUIDEWAY}=5..15 W/K:3", "nodes.beam.lumps=1,4"])
    assert [run.values for run in result.runs] == [(G, n) for G in (5.0, 10.0, 15.0) for n in (1.0, 4.0)]
    for run in result.runs:
        direct = simulate(
            Machine.load(GANTRY, sets=[f"{GUIDEWAY}={run.values[0]} W/K", f"nodes.beam.lumps={run.values[1]:g}"]), HOUR
        ).summary()["tcp"]
        for axis, told in direct.items():
            found = run.tcp[axis]
            extremes = (told["max"], told["min"], told["final"])
            assert (found.highest, found.lowest, found.final) == pytest.approx(extremes, rel=1e-9, abs=1e-9)
            assert found.unit == told["unit"]
    assert "6 runs over links.guideway.conductance, nodes.beam.lumps" in str(result)


def test_unknown_number_may_be_varied() -> None:
    skin = {"kind": "convection", "between": ["bar@0.9..1", "air"], "conductance": "unknown"}
    result = sweep(heated_bar(links={"skin": skin}), HOUR, vary=["links.skin.conductance=5,50 W/K"])
    assert result.runs[0].tcp["z"].final > result.runs[1].tcp["z"].final


# -- processes ------------------------------------------------------------------------------------------------------
def test_processes_change_nothing(gantry: Machine, levels: Sweep) -> None:
    heard: list[float] = []
    apart = sweep(gantry, HOUR, levels=["paper", 1, 2, 4, "fine"], tolerance="2 um", jobs=2, progress=heard.append)
    assert heard == pytest.approx([k / 6 for k in range(1, 7)])
    assert [run.level for run in apart.levels] == [run.level for run in levels.levels]
    for one, two in zip(levels.levels, apart.levels, strict=True):
        assert all(np.array_equal(one.tcp[axis], two.tcp[axis]) for axis in one.tcp)
    vary = [f"{GUIDEWAY}=5..15 W/K:5"]
    assert sweep(gantry, HOUR, vary=vary, jobs=2).summary() == sweep(gantry, HOUR, vary=vary).summary()


def test_refusal_comes_whole_out_of_a_process(gantry: Machine) -> None:
    with pytest.raises(Refused, match=r"nodes\.beam: lumps is '1\.5'") as caught:
        sweep(gantry, HOUR, vary=["nodes.beam.lumps=" + ",".join(["1"] * 60) + ",1.5"], jobs=2)
    assert pickle.loads(pickle.dumps(caught.value)).refusals == caught.value.refusals


def alive(group: int) -> int:
    """How many processes of a group are running."""
    listed = subprocess.run(["ps", "-A", "-o", "pgid=,stat="], capture_output=True, text=True, check=True).stdout
    rows = [line.split() for line in listed.splitlines()]
    return sum(row[0] == str(group) and not row[1].startswith("Z") for row in rows)


def within(seconds: float, is_so: Callable[[], bool]) -> bool:
    end = time.monotonic() + seconds
    while not is_so() and time.monotonic() < end:
        time.sleep(0.1)
    return is_so()


@pytest.mark.skipif(shutil.which("ps") is None, reason="counts processes with ps")
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
def test_nothing_is_left_running(how: signal.Signals) -> None:
    """Ctrl-C, or a sweep that is killed: its two processes go too."""
    sweeping = [sys.executable, "-m", "network.cli", "sweep", str(GANTRY), str(WARM_UP), "--jobs", "2"]
    with subprocess.Popen(
        [*sweeping, "--vary", f"{GUIDEWAY}=5..15 W/K:9000"], cwd=ROOT, start_new_session=True,
        stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True,
    ) as running:  # fmt: skip
        assert within(60, lambda: alive(running.pid) >= 3)
        time.sleep(0.5)
        if how == signal.SIGINT:
            os.killpg(running.pid, how)
        else:
            running.kill()
        said = running.communicate(timeout=60)[1]
    assert within(30, lambda: alive(running.pid) == 0)
    if how == signal.SIGINT:
        assert running.returncode == 130
        assert "Traceback" not in said and "lptn: stopped" in said


def test_cluster_gives_the_same(gantry: Machine) -> None:
    distributed = pytest.importorskip("distributed")
    vary = [f"{GUIDEWAY}=5..15 W/K:3"]
    with distributed.LocalCluster(n_workers=1, processes=False, dashboard_address=None) as cluster:
        result = sweep(gantry, HOUR, vary=vary, cluster=cluster.scheduler_address)
    assert result.summary() == sweep(gantry, HOUR, vary=vary).summary()


def test_cluster_without_dask(gantry: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(Refused, match=r"needs dask, which is not installed; pip install 'lptn\[cluster\]'"):
        sweep(gantry, HOUR, levels=[1, 2], cluster="tcp://127.0.0.1:8786")


# -- what is written ------------------------------------------------------------------------------------------------
def test_files(levels: Sweep, gantry: Machine, tmp_path: Path) -> None:
    table, summary, picture = write_sweep(levels, tmp_path / "levels")
    rows = list(csv.DictReader(table.open(encoding="utf-8")))
    assert [row["level"] for row in rows] == [run.level for run in levels.levels]
    gap = levels.gap(levels.levels[2], "z")
    assert gap is not None and float(rows[2]["Δz max [um]"]) == pytest.approx(gap.largest * 1e6, rel=1e-6)
    told = json.loads(summary.read_text(encoding="utf-8"))
    assert told == json.loads(json.dumps(levels.summary()).replace("NaN", "null"))
    assert picture.read_bytes()[:4] == b"\x89PNG"
    grid = sweep(gantry, HOUR, vary=[f"{GUIDEWAY}=5,10 W/K"])
    written = write_sweep(grid, tmp_path / "grid")
    assert sorted(path.name for path in (tmp_path / "grid").iterdir()) == ["sweep.csv", "sweep.json", "sweep.png"]
    assert written[0].read_text(encoding="utf-8").startswith("links.guideway.conductance [W/K],z max [um],z min [um],")


def test_json_shape(levels: Sweep, capsys: pytest.CaptureFixture[str]) -> None:
    told = levels.summary()
    assert [*told] == ["machine", "source", "levels", "finest", "closed_form", "tolerance"]
    keys = ["level", "lumps", "tcp", "temperature_difference", "rmse_in_noise", "tcp_rmse_in_noise", "solve_seconds"]
    assert [*told["levels"][1]] == [*keys, "method"]
    assert [*told["levels"][1]["tcp"]["z"]] == ["max", "min", "final", "unit", "difference"]
    main(["sweep", str(GANTRY), str(WARM_UP), "--vary", f"{GUIDEWAY}=5,10 W/K", "--json"])
    vary = json.loads(capsys.readouterr().out)
    assert vary["vary"] == [{"path": GUIDEWAY, "unit": "W/K", "values": [5.0, 10.0]}]
    assert vary["runs"][1]["values"] == {GUIDEWAY: 10.0}
    assert [*vary["runs"][0]["tcp"]["y"]] == ["max", "min", "final", "unit"]


def test_levels_that_do_not_differ_are_drawn_too(tmp_path: Path) -> None:
    """A bar that is heated and cooled all along has one temperature, however many lumps it has."""
    even = heated_bar(
        links={"skin": {"kind": "convection", "between": ["bar", "air"], "conductance": "20 W/K"}},
        sources={"heater": {"kind": "heat_source", "into": {"bar": 1}, "power": "50 W"}},
    )
    for tolerance in (None, "1 um"):
        result = sweep(even, Scenario.of("half an hour", "30 min"), levels=[1, 2], tolerance=tolerance)
        assert all(gap.largest < 1e-12 for run in result.levels if (gap := result.gap(run, "z")))
        assert write_sweep(result, tmp_path)[-1].stat().st_size > 1000


# -- refusals -------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("wish", "said"),
    [
        ({"levels": ["1", "fin"]}, "there is no level 'fin'; did you mean 'fine'?"),
        ({"levels": ["1", "x7"]}, "no level 'x7'; known are: paper, auto, coarse, fine, and any number"),
        ({"levels": ["2", "0"]}, "there is no level '0'"),
        ({"levels": ["as written"]}, "one level has nothing to be compared with; give two or more"),
        ({"levels": ["1", "2"], "vary": [f"{GUIDEWAY}=5,10 W/K"]}, "levels and values are two different sweeps"),
        ({"vary": [f"{GUIDEWAY}=5,10 W/K"], "tolerance": "1 um"}, "compares levels, and --vary gives none"),
        ({"tolerance": "1"}, "has no unit; write it like '1 um'"),
        ({"tolerance": "1 K"}, "is no movement of this machine's tool centre point; give it in um"),
        ({"tolerance": "0 um"}, "is not above zero"),
        ({"vary": [GUIDEWAY]}, "is not path=values; write it like 'links.skin.conductance=3..9 W/K:20'"),
        ({"vary": [f"{GUIDEWAY}=3..9 W/K"]}, "is a range without a number of values; write it like"),
        ({"vary": [f"{GUIDEWAY}=9..3 W/K:5"]}, "runs from 9 to 3; write the smaller value first"),
        ({"vary": [f"{GUIDEWAY}=3..9 W/K:1"]}, "asks for 1 values; give 2 to 10000"),
        ({"vary": [f"{GUIDEWAY}=three W/K"]}, "'three W/K' is not values with a unit; write it like"),
        ({"vary": [f"{GUIDEWAY}=3,9"]}, "conductance '3' has no unit; a unit like W/K is needed"),
        ({"vary": ["links.guidway.conductance=3,9 W/K"]}, "links has no 'guidway'; did you mean 'guideway'?"),
        ({"vary": [f"{GUIDEWAY}=3,9 W/K", f"{GUIDEWAY}=4,5 W/K"]}, "links.guideway.conductance is varied twice"),
        ({"vary": [f"{GUIDEWAY}=3..9 W/K:200", "nodes.beam.lumps=1..51:51"]}, "makes 10200 runs; give fewer values"),
        ({"jobs": 0}, "0 is not a number of processes"),
    ],
)
def test_refusals(gantry: Machine, wish: dict[str, Any], said: str) -> None:
    with pytest.raises(Refused) as caught:
        sweep(gantry, HOUR, **wish)
    assert said in str(caught.value)


def test_refuses_what_no_sweep_can_look_at() -> None:
    with pytest.raises(Refused, match="the machine moves no tool centre point"):
        sweep(heated_bar(tcp={}), HOUR)
    with pytest.raises(Refused, match="needs to know which part is the spindle; write `closed_form:"):
        sweep(heated_bar(), HOUR, levels=["paper", 1])
    lump = {"air": {"temperature": "20 degC"}, "block": {"heat_capacity": "1 kJ/K"}}
    skin = {"kind": "convection", "between": ["block", "air"], "conductance": "1 W/K"}
    grows = {"kind": "stretching", "of": "block", "length": "1 m", "expansion": "1e-5 1/K", "direction": 1}
    with pytest.raises(Refused, match="level 1 means lumps, and the machine has no bar"):
        sweep(machine(lump, links={"skin": skin}, tcp={"z": {"grows": grows}}), HOUR, levels=[1, 2])


def test_command_exits_with_two(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["sweep", str(GANTRY), str(WARM_UP), "--levels", "1,fin", "--tolerance", "1 um"])
    assert left.value.code == 2
    assert capsys.readouterr().err == "--levels: there is no level 'fin'; did you mean 'fine'?\n"


def test_a_stopped_grid_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    vary, kept, done = ["links.skin.conductance=10..30 W/K:5", "sources.heater.power=20,50 W"], tmp_path / "kept", []
    scenario = Scenario.of("half an hour", "30 min")
    whole = sweep(heated_bar(), scenario, vary=vary, resume=kept)
    lines = kept.read_text().split("\n")
    kept.write_text("\n".join([*lines[:5], lines[5][:9]]))

    def count(shared: GridJob, values: tuple[float, ...]) -> VariedRun:
        done.append(values)
        return run_varied(shared, values)

    monkeypatch.setattr("network.analysis.sweep.grid_runs.run_varied", count)
    again = sweep(heated_bar(), scenario, vary=vary, resume=kept)
    assert done == [run.values for run in whole.runs[4:]]
    assert [(run.values, run.tcp) for run in again.runs] == [(run.values, run.tcp) for run in whole.runs]
    assert again.runs[0].tcp == sweep(heated_bar(), scenario, vary=vary).runs[0].tcp
    with pytest.raises(Refused, match="belongs to another sweep"):
        sweep(heated_bar(), scenario, vary=[vary[0], "sources.heater.power=20,60 W"], resume=kept)
    with pytest.raises(Refused, match="keeps the runs of a grid"):
        sweep(heated_bar(), scenario, levels=[1, 2], resume=kept)
