"""Python as good as the command: the prompt, a notebook, plots, tables, types in a user's project."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import network
from network import (
    Comparison,
    Machine,
    Recording,
    Refused,
    Scenario,
    Start,
    Trajectory,
    bands_of,
    calibrate,
    choose_lumps,
    compare,
    diagnose,
    estimate_lumping,
    sample,
    simulate,
    superpose,
    sweep,
)
from network.platform.printing import brief

ROOT = Path(__file__).parents[1]
GANTRY, WARM = ROOT / "machines" / "gantry_spindle.yaml", ROOT / "scenarios" / "warm_up_and_stop.yaml"
LONG = 700
"""Characters that still are short at a prompt."""


@pytest.fixture(scope="module")
def gantry() -> Machine:
    return Machine.load(GANTRY)


@pytest.fixture(scope="module")
def run(gantry: Machine) -> Trajectory:
    return simulate(gantry, Scenario.load(WARM))


@pytest.fixture(scope="module")
def recording(run: Trajectory, tmp_path_factory: pytest.TempPathFactory) -> Recording:
    from network.report.files.result_files import write_run

    where = tmp_path_factory.mktemp("run")
    write_run(simulate(run.machine, Scenario.load(WARM), noise_seed=1), where)
    return Recording.load(where / "results.csv")


@pytest.fixture(scope="module")
def comparison(gantry: Machine, recording: Recording) -> Comparison:
    return compare(gantry, recording)


@pytest.fixture(scope="module")
def results(gantry: Machine, run: Trajectory, recording: Recording, comparison: Comparison) -> dict[str, Any]:
    warm = Scenario.load(WARM)
    calibration = calibrate(gantry, recording)
    return {
        "machine": gantry, "scenario": warm, "run": run, "recording": recording, "comparison": comparison,
        "shares": superpose(run), "levels": sweep(gantry, warm, levels=[1, 2]), "calibration": calibration,
        "grid": sweep(gantry, warm, vary=["links.flange.conductance=20,40 W/K"]),
        "lumping": estimate_lumping(gantry, warm), "choice": choose_lumps(gantry, warm),
    }  # fmt: skip


# -- at the prompt and in a notebook --------------------------------------------------------------------------------
def test_every_result_is_short_at_the_prompt_and_whole_in_a_notebook(results: dict[str, Any]) -> None:
    for name, result in results.items():
        assert len(repr(result)) < LONG and "\n" not in repr(result), name
        page = result._repr_html_()
        assert page.startswith("<pre") and page.endswith("</pre>") and "<" not in page[20:-6].partition(">")[2], name
        assert str(result).splitlines()[0].split()[0] in page, name


def test_what_results_hold_is_short_too(results: dict[str, Any]) -> None:
    calibration, run = results["calibration"], results["run"]
    inner = (calibration.fit, calibration.fit.at, calibration.known, calibration.parameters[0], calibration.bands[0][0],
             calibration.data[0], run.network, run.energy, run.schedule, results["comparison"].recordings[0],
             results["recording"].columns["dz"], results["levels"].levels[0])  # fmt: skip
    for held in inner:
        assert len(repr(held)) < LONG, type(held)


def test_a_value_in_a_few_words() -> None:
    assert brief(np.zeros((3, 4))) == "[3 × 4]" and brief(0.1 + 0.2) == "0.3" and brief(()) == "()"
    assert brief({str(k): k for k in range(9)}) == "{0, 1, 2, 3, 4, 5, … 9 in all}"
    assert len(brief("x" * 1000)) < 100 and brief([np.zeros(2)] * 3) == "3 × ndarray"


def test_public_names_are_listed_and_are_there() -> None:
    assert {"Machine", "simulate", "calibrate", "choose_lumps"} <= set(dir(network))
    assert all(getattr(network, name) is not None for name in dir(network))


# -- channels in their units ----------------------------------------------------------------------------------------
def test_columns_are_in_the_units_they_are_labelled_with(run: Trajectory) -> None:
    columns = {name: (unit, values) for name, unit, values in [*run.columns(), *run.part_columns()]}
    assert columns["dz"][0] == "um" and columns["dz"][1].max() == pytest.approx(55.73, abs=0.01)
    assert columns["speed"][0] == "rpm" and columns["speed"][1].max() == pytest.approx(8000)
    assert columns["heat.housing"][1] == pytest.approx(run.heat["housing"] / 1e3)
    for name in ("dz", "speed", "tcp.z", "T.housing", "tcp.z.housing grows"):
        assert run.shown(name) == pytest.approx(columns[name][1])
    assert run.shown("z") == pytest.approx(run.tcp["z"] * 1e6) and run.shown("housing") is not None
    shares = {name: (unit, values) for name, unit, values in superpose(run).columns()}
    assert shares["from.z.motor loss"][0] == "um" and 20 < shares["from.z.motor loss"][1].max() < 40


def test_a_recording_shows_what_its_file_says(recording: Recording) -> None:
    assert recording.shown("dz").max() == pytest.approx(55.7, abs=1) and recording.shown("speed").max() == 8000


@pytest.mark.parametrize(("name", "said"), [("dz2", "did you mean 'dz'?"), ("T_hosing", "did you mean 'T_housing'?")])
def test_a_wrong_name_is_answered_with_those_there_are(
    run: Trajectory, recording: Recording, comparison: Comparison, name: str, said: str
) -> None:
    with pytest.raises(KeyError) as none:
        run.shown(name)
    assert str(none.value).endswith(said) and not str(none.value).startswith("'")
    with pytest.raises(KeyError, match="has no column"):
        recording.shown(name)
    with pytest.raises(KeyError, match="to plot; did you mean"):
        comparison.plot(name)


# -- other numbers --------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "patch",
    [
        {"links.flange.conductance": "60 W/K"},
        {"links": {"flange": {"conductance": "60 W/K"}}},
        {"links": {"flange": {"conductance": "60 W/K"}}, "tcp": {"z": {"nose grows": None}}},
        {"links.flange.conductance": "60 W/K", "tcp": {"y": {"beam grows": {"direction": 1}}}},
    ],
)
def test_single_numbers_are_patched(gantry: Machine, patch: dict[str, Any]) -> None:
    patched = gantry.patched(patch)
    assert (
        float(patched.links["flange"].conductance)
        == 60
        == float(
            Machine.load(GANTRY, sets=["links.flange.conductance=60 W/K"]).links["flange"].conductance  # type: ignore[union-attr]
        )
    )  # type: ignore[union-attr]
    assert patched.links["flange"].between == gantry.links["flange"].between  # type: ignore[union-attr]
    assert ("nose grows" in patched.tcp["z"]) == (patch.get("tcp", {}).get("z") is None)
    assert patched.tcp["y"]["beam grows"].direction == (1 if "y" in patch.get("tcp", {}) else -1)


def test_a_patch_that_leads_nowhere_is_refused(gantry: Machine) -> None:
    for patch in ({"links.flang.conductance": "60 W/K"}, {"links": {"new": {"conductance": "60 W/K"}}}):
        with pytest.raises(Refused):
            gantry.patched(patch)


# -- plots and tables -----------------------------------------------------------------------------------------------
def test_plots_return_axes(results: dict[str, Any]) -> None:
    from matplotlib import pyplot

    for name in ("machine", "run", "comparison", "shares", "levels", "grid", "calibration"):
        axes = results[name].plot()
        assert axes.has_data() and axes.figure is not None, name
        own = pyplot.subplots()[1]
        assert results[name].plot(axes=own) is own
    lines = results["run"].plot("z").get_lines()
    assert lines[0].get_ydata() == pytest.approx(results["run"].shown("z"))
    with pytest.raises(Refused, match="are in um and degC; plot channels of one unit"):
        results["run"].plot("dz", "T_nose")
    pyplot.close("all")


def test_without_pandas_it_is_said_what_to_do(run: Trajectory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match=r"pip install 'lptn\[pandas\]'"):
        run.to_pandas()


def test_tables_are_data_frames(results: dict[str, Any]) -> None:
    pytest.importorskip("pandas")
    run = results["run"]
    frame = run.to_pandas(parts=True)
    assert frame["dz [um]"].max() == pytest.approx(55.73, abs=0.01) and frame.index.name == "time [s]"
    assert frame["T.housing [degC]"].iloc[0] == pytest.approx(21.6)
    assert results["recording"].to_pandas().shape == (1441, 11)
    assert list(results["comparison"].to_pandas()["channel"])[-1] == "dy"
    assert len(results["calibration"].to_pandas()) == 18 and len(results["levels"].to_pandas()) == 3
    assert len(results["grid"].to_pandas()) == 2 and "from.z.motor loss [um]" in results["shares"].to_pandas()


# -- in a project ---------------------------------------------------------------------------------------------------
def test_the_session_shipped_runs(tmp_path: Path) -> None:
    script = ROOT / "scenarios" / "python_session.py"
    lines = [line for line in script.read_text().splitlines() if line.strip()]
    assert 45 <= len(lines) <= 75
    settings = os.environ | {"MPLBACKEND": "Agg", "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, str(script)], cwd=tmp_path, env=settings, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "parameters_only" in done.stdout and "0.0 µm apart" in done.stdout and "Lumps: shaft 8" in done.stdout


USER = """
from network import Machine, Recording, Scenario, calibrate, compare, simulate

machine = Machine.load("m.yaml", sets=["links.skin.conductance=5 W/K"])
run = simulate(machine, Scenario.load("s.yaml"))
reveal_type(run)
peak: float = float(run.shown("dz").max())
for name, unit, values in run.columns():
    print(name, unit, values.max())
fit = calibrate(machine, Recording.load("r.csv"))
reveal_type(compare(machine, [Recording.load("r.csv")]).rmse_in_noise)
reveal_type(fit.plot("dz"))
wrong: int = run.shown("dz")
simulate(machine, 3)
"""


def test_types_tell_what_comes_out_and_what_is_wrong(tmp_path: Path) -> None:
    """The package says that it is typed: mypy knows what a program that uses it gets, and where it is wrong."""
    pytest.importorskip("mypy")
    user = tmp_path / "user.py"
    user.write_text(USER)
    # among the project's own files, for what mypy knows of the package is kept from `make test`
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", str(user)], cwd=ROOT, capture_output=True, text=True
    )
    told = done.stdout
    assert 'Revealed type is "network.engine.trajectory.Trajectory"' in told
    assert 'Revealed type is "float"' in told.replace("builtins.", "")
    faults = [line for line in told.splitlines() if "user.py:" in line and " error: " in line]
    assert len(faults) == 2 and "wrong" not in faults[1] and "simulate" in faults[1], told
    assert (ROOT / "network" / "py.typed").exists() and "py.typed" in (ROOT / "pyproject.toml").read_text()


def test_summaries_are_json(results: dict[str, Any]) -> None:
    for name in ("run", "comparison", "levels", "calibration", "lumping", "choice"):
        json.dumps(results[name].summary(), allow_nan=True)


def test_other_things_than_machines_and_recordings_are_told(results: dict[str, Any]) -> None:
    machine, day = results["run"].machine, Scenario.of("still", "1 h", {"ambient": "20 degC"})
    with pytest.raises(TypeError, match=r"machine is a Machine, not a str: Machine.load\('m.yaml'\)"):
        simulate("m.yaml", day)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="machine is a Machine, not a Scenario: look at their order"):
        simulate(day, machine)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="recording is a Recording, not a str"):
        compare(machine, ["r.csv"])  # type: ignore[list-item]
    nothing_read = "recording is a Recording, not a Scenario: nothing is measured in a scenario"
    for call in (compare, calibrate, diagnose):
        with pytest.raises(TypeError, match=nothing_read):
            call(machine, day)  # type: ignore[arg-type]
        with pytest.raises(TypeError, match=r"recording is a Recording, not a str: Recording.load\('r.csv'\)"):
            call(machine, "r.csv")  # type: ignore[arg-type]
        with pytest.raises(TypeError, match=r"is a [RM][a-z]*, not a [MS][a-z]*: look at their order"):
            call(day, machine)  # type: ignore[arg-type]
    for run in (simulate, sweep, estimate_lumping, choose_lumps, bands_of):
        with pytest.raises(TypeError, match="machine is a Machine, not a Scenario: look at their order"):
            run(day, machine)  # type: ignore[operator]
        with pytest.raises(TypeError, match=r"source is a Scenario or Recording or Schedule, not a str: Scenario.load"):
            run(machine, "s.yaml")  # type: ignore[operator]
    with pytest.raises(TypeError, match="count is an int or integer, not a str"):
        sample(machine, day, "5")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="run is a Trajectory, not a Machine"):
        superpose(machine)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"start is a Start, not an int: Start\(others=22.0\) is 22 °C everywhere"):
        simulate(machine, day, start=22)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="patch is a mapping like"):
        machine.patched("links.joint.conductance=5 W/K")  # type: ignore[arg-type]
    for several in (calibrate, diagnose):
        with pytest.raises(Refused, match="recordings: there is none; give at least one"):
            several(machine, [])
    with pytest.raises(AttributeError, match="did you mean 'simulate'"):
        network.simulat  # noqa: B018


def test_one_word_or_several_mean_the_same() -> None:
    """`lumps`, `sets`, `levels` and `vary` of one entry are no letters."""
    blocks, day = ROOT / "machines" / "two_blocks.yaml", Scenario.of("still", "1 h", {"ambient": "20 degC"})
    assert Machine.load(blocks, lumps=3).nodes["hot"].lumps == 3 == Machine.load(blocks, lumps=[3]).nodes["cold"].lumps
    one = Machine.load(blocks, sets="links.joint.conductance=5 W/K")
    assert one.links["joint"].conductance == 5.0
    assert [run.level for run in sweep(one, day, levels="1,2").levels][-2:] == ["1", "2"]
    assert len(sweep(one, day, vary="links.joint.conductance=3..9 W/K:3").runs) == 3
    assert simulate(one, day, start=Start(others=25.0)).parts["hot"][0] == pytest.approx(25.0)


def test_auto_is_no_number_of_lumps() -> None:
    with pytest.raises(Refused, match="choose_lumps"):
        Machine.load(ROOT / "machines" / "two_blocks.yaml", lumps="auto")
