"""`lptn diagnose` and `lptn prove` as a user meets them: arguments, files, refusals; the diagnosis itself is made by
hand."""

from __future__ import annotations

import ast
import json
import os
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from diagnosed import diagnosed, saved
from fits import ANOTHER, USUAL, recorded, speeds

import network
from network import Machine
from network.analysis.diagnosis.findings.finding import UNKNOWN
from network.analysis.diagnosis.findings.holdout_admission import admit_runs
from network.catalogue.declaration.discovery import kinds, open_rooms
from network.catalogue.declaration.registry import sections
from network.cli import main
from network.recordings.columns import Column
from network.recordings.csv_table import write_csv
from network.recordings.recording import Recording
from network.report.files.diagnosis_files import PICTURES
from network.report.words.verdict_words import MEANING

ROOT = Path(network.__file__).parent


def run(*words: str) -> int:
    """The exit status of `lptn words…`."""
    with pytest.raises(SystemExit) as end:
        main(words)
        raise SystemExit(0)
    return int(end.value.code or 0)


def save(recording: Recording, path: Path) -> None:
    write_csv(path, recording.t, {n: (c.unit, c.values) for n, c in recording.columns.items()})


class Called:
    """In place of the search: takes recordings in as it does, and remembers what it was asked."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.asked = folder, dict[str, Any]()

    def __call__(self, machine: Machine, recordings: Any, holdout: Any = (), **options: Any) -> Any:
        let_in = admit_runs(machine, recordings, holdout, options["start"])
        self.asked = {"machine": machine, "recordings": let_in.recordings, "holdout": let_in.holdout, **options}
        self.warnings = let_in.warnings
        options["progress"](0.5)
        return diagnosed(self.folder, holdout=bool(holdout))


@pytest.fixture
def called(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Called:
    """A folder with a machine and three recordings, and no search."""
    import network.analysis.diagnosis.diagnose as diagnosing

    monkeypatch.chdir(tmp_path)
    machine = saved(tmp_path)
    for i, steps in enumerate((USUAL, ANOTHER, ((0.0, 7000), (2.0, 4000)))):
        save(recorded(machine, speeds(*steps, every=30.0), i), tmp_path / f"run{i}.csv")
    fake = Called(tmp_path)
    monkeypatch.setattr(diagnosing, "diagnose", fake)
    return fake


# -- diagnose -------------------------------------------------------------------------------------------------------
def test_files_words_and_options(called: Called, capsys: pytest.CaptureFixture[str]) -> None:
    options = ("--holdout", "run2.csv", "-o", "found", "--seed", "3", "--jobs", "2", "--start", "20 degC")
    assert run("diagnose", "blocks.yaml", "run0.csv", "run1.csv", *options) == 0
    assert [p.name for p in Path("found").glob("*.yaml")] == ["machine.diagnosed.yaml"]
    assert {p.suffix for p in Path("found").iterdir()} == {".html", ".json", ".png", ".yaml"}
    told = capsys.readouterr().out
    assert "test lacks one effect" in told and "Written: found/report.html, found/machine.diagnosed.yaml" in told
    assert called.asked["seed"] == 3 and called.asked["jobs"] == 2 and called.asked["start"].others == 20.0
    assert [r.file for r in called.asked["recordings"]] == ["run0.csv", "run1.csv"]
    assert [r.file for r in called.asked["holdout"]] == ["run2.csv"]


def test_json_without_plots_and_without_holdout(called: Called, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("diagnose", "blocks.yaml", "run0.csv", "-o", "found", "--json", "--no-plots") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["fit"]["holdout"] is None and told["verdict"] == "missing_physics"
    assert {p.name for p in Path("found").iterdir()} == {"diagnosis.json", "machine.diagnosed.yaml", "report.html"}
    assert json.loads(Path("found/diagnosis.json").read_text()) == told


def test_pictures_of_the_result_before_go_with_it(called: Called) -> None:
    for folder in ("found", "other"):
        assert run("diagnose", "blocks.yaml", "run0.csv", "-o", folder) == 0
        assert {*Path(folder).glob("*fit-*.png"), Path(folder, "candidates.png")} <= {*Path(folder).iterdir()}
    mine, later = Path("found/photo.png"), Path("found/network.png")
    later.unlink()
    for path in (mine, later):
        path.write_text("not of the diagnosis")
    os.utime(mine, (0, 0))
    os.utime(later, (2e9, 2e9))
    assert run("diagnose", "blocks.yaml", "run0.csv", "-o", "found", "--no-plots") == 0
    assert {*Path("found").glob("*.png")} == {mine, later}
    assert run("diagnose", "blocks.yaml", "run0.csv", "-o", "other") == 0
    assert [*Path("other").glob("fit-*.png")]


def test_the_patterns_of_pictures_know_every_picture(called: Called) -> None:
    assert run("diagnose", "blocks.yaml", "run0.csv", "--holdout", "run2.csv") == 0
    assert all(any(path.match(pattern) for pattern in PICTURES) for path in Path("out").glob("*.png"))


def test_the_machine_is_taken_as_options_change_it(called: Called) -> None:
    assert run("diagnose", "blocks.yaml", "run0.csv", "--no-plots", "--set", "links.skin.conductance=9 W/K") == 0
    assert called.asked["machine"].links["skin"].conductance == 9.0
    assert Path("out/machine.diagnosed.yaml").is_file()


def changed(path: str, **columns: Any) -> None:
    recording = Recording.load("run0.csv")
    new = {n: Column(n, recording.columns[n].unit, values) for n, values in columns.items()}
    save(replace(recording, columns={**recording.columns, **new}), Path(path))


def test_bad_input_is_refused_before_anything_is_searched(called: Called, capsys: pytest.CaptureFixture[str]) -> None:
    still = np.full(len(Recording.load("run0.csv").t), 20.0)
    changed("still.csv", T_motor=still, T_body=still, dz=still * 0)
    Path("lacking.csv").write_text("time [s],speed [rpm],T_motor [degC]\n0,0,20\n60,1000,21\n")
    for words, wrong in (
        (("run0.csv", "--holdout", "run0.csv"), "is held out and calibrated on"),
        (("run0.csv", "run0.csv"), "is given twice"),
        (("nowhere.csv",), "there is no such file"),
        (("still.csv",), "every channel reads the same at all times"),
        (("lacking.csv",), "the machine needs the input `ambient`"),
        (("run0.csv", "--holdout", "lacking.csv"), "the machine needs the input `ambient`"),
        (("run0.csv", "-o", "run1.csv"), "cannot be a folder"),
        (("run0.csv", "--start", "warm"), "warm"),
    ):
        assert run("diagnose", "blocks.yaml", *words) == 2
        assert wrong in capsys.readouterr().err
    assert run("diagnose", "blocks.yaml") == 2
    assert not called.asked and not Path("out").exists()


def test_a_channel_that_hangs_is_left_out_with_a_warning(called: Called) -> None:
    changed("hangs.csv", T_body=np.full(len(Recording.load("run0.csv").t), 20.0))
    assert run("diagnose", "blocks.yaml", "hangs.csv", "--no-plots") == 0
    assert any("T_body reads the same at all times; it is left out" in warning for warning in called.warnings)
    assert not np.isfinite(called.asked["recordings"][0].columns["T_body"].values).any()


def test_columns_that_may_be_sensors_are_told(called: Called, capsys: pytest.CaptureFixture[str]) -> None:
    Path("names.csv").write_text(Path("run0.csv").read_text().replace("T_body", "Temp_body", 1))
    assert run("diagnose", "blocks.yaml", "names.csv", "--no-plots") == 0
    told = "names.csv: Temp_body is no sensor of this machine (did you mean T_body?)"
    assert f"warning: {told}" in capsys.readouterr().err and called.warnings[0] == told


def test_a_result_is_not_written_over_what_it_extends(called: Called, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("diagnose", "blocks.yaml", "run0.csv", "--no-plots") == 0
    called.asked = {}
    assert run("diagnose", "out/machine.diagnosed.yaml", "run0.csv") == 2
    assert "give another -o" in capsys.readouterr().err and not called.asked


def test_it_can_be_stopped(called: Called, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    import network.analysis.diagnosis.diagnose as diagnosing

    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(diagnosing, "diagnose", stop)
    assert run("diagnose", "blocks.yaml", "run0.csv") == 130
    assert "nothing half-written was left" in capsys.readouterr().err and not Path("out").exists()


def test_the_name_is_handed_out_when_it_is_first_used() -> None:
    assert "diagnose" in network.__all__
    assert network._HOME["diagnose"] == "analysis.diagnosis.diagnose"


# -- no physics is named --------------------------------------------------------------------------------------------
QUANTITIES = ("thermal_test_words.py",)
"""Where the standard's terms for what is measured (a tilt) are names of kinds, too."""
BLIND = ("diagnosis_*.py", "*_words.py", "heat_figure.py", "explanations_figure.py", "lit_figure.py", "page.py")


def blind_files() -> list[Path]:
    report = ROOT / "report"
    diagnosis = (ROOT / "analysis" / "diagnosis").rglob("*.py")
    told = (p for pattern in BLIND for p in report.rglob(pattern))
    return [*diagnosis, *(p for p in told if p.name not in QUANTITIES)]


def words_in(path: Path) -> set[str]:
    """Identifiers and words of string literals, without docstrings."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    docs = {id(n.body[0].value) for n in ast.walk(tree)  # type: ignore[attr-defined]
            if isinstance(n, documented) and n.body and isinstance(n.body[0], ast.Expr)}  # fmt: skip
    bare = {id(n.value) for n in ast.walk(tree) if isinstance(n, ast.Expr) and isinstance(n.value, ast.Constant)}
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docs | bare:
            found.update(re.findall(r"\w+", node.value))
        found.update(str(getattr(node, field, "")) for field in ("id", "attr", "name", "arg", "module"))
    return found


def test_no_kind_is_named_where_physics_is_found_and_told() -> None:
    open_rooms()
    told = "lumping"  # what finer lumps would change is told beside every figure, whatever the physics
    named = {kind for section in sections() for kind in kinds(section)} - {*MEANING, UNKNOWN, told}
    assert len(named) > 25 and len(blind_files()) > 20
    for path in blind_files():
        assert not words_in(path) & named, path.name
    template = (ROOT / "report" / "templates" / "diagnosis.html.j2").read_text(encoding="utf-8")
    assert not set(re.findall(r"\w+", template)) & named


def test_the_test_would_see_a_kind_named(tmp_path: Path) -> None:
    path = tmp_path / "x.py"
    path.write_text('"""radiation"""\nwindage = 1\nif kind == "convection": pass\n')
    assert {"windage", "convection"} <= words_in(path) and "radiation" not in words_in(path)


def test_starting_the_command_loads_neither_search_nor_page() -> None:
    import subprocess

    code = "import sys, network.cli; print([m for m in ('scipy', 'jinja2', 'matplotlib', 'numpy') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
