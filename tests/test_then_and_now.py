"""Then and now: what changed is named with its size and its µm, and nothing is where nothing has."""

from __future__ import annotations

import json
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fits import ANOTHER, USUAL, recorded, speeds, two_blocks

from network import Machine, Recording, Refused, Scenario, find_changes, simulate
from network.analysis.calibration.recording_admission import admit
from network.analysis.change.change_screening import measure_difference
from network.analysis.change.change_search import is_reached, split_changes
from network.analysis.change.changes import Changes
from network.analysis.change.paired_fit import fit_sets
from network.cli import main
from network.cli.diagnose_command import spread_references
from network.engine.response.parameters import free_parameters
from network.report.files.result_files import write_run
from network.report.words.change_words import explain

ROOT = Path(__file__).parents[1]
GANTRY = ROOT / "machines" / "gantry_spindle.yaml"
RUNS = ("warm_up_and_stop", "day_of_work")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Recordings of the gantry mill: then, unchanged, with a jacket that cools worse, with a sensor 0.8 K too high."""
    folder, seed, paths = tmp_path_factory.mktemp("runs"), 0, {}
    changes = {"then": [], "same": [], "clogged": ["links.coolant jacket.conductance=20 W/K"]}
    for what, sets in changes.items():
        for name in RUNS:
            seed += 1
            where = folder / f"{what}_{name}"
            where.mkdir()
            machine = Machine.load(GANTRY, sets=sets)
            write_run(simulate(machine, Scenario.load(ROOT / "scenarios" / f"{name}.yaml"), noise_seed=seed), where)
            paths[where.name] = where / "results.csv"
    for name in RUNS:
        lines = paths[f"same_{name}"].read_text(encoding="utf-8").splitlines()
        at = lines[0].split(",").index("T_housing [degC]")
        rows = [line.split(",") for line in lines[1:]]
        more = [",".join([*row[:at], f"{float(row[at]) + 0.8:.4f}", *row[at + 1 :]]) for row in rows]
        paths[f"drifted_{name}"] = folder / f"drifted_{name}.csv"
        paths[f"drifted_{name}"].write_text("\n".join([lines[0], *more]) + "\n", encoding="utf-8")
    return paths


def compared(made: dict[str, Path], now: str) -> Changes:
    machine = Machine.load(GANTRY)
    sides = ([Recording.load(made[f"{what}_{name}"]) for name in RUNS] for what in (now, "then"))
    return find_changes(machine, *sides)


@pytest.fixture(scope="module")
def clogged(made: dict[str, Path]) -> Changes:
    return compared(made, "clogged")


def test_the_number_that_changed_is_named_with_both_values(clogged: Changes) -> None:
    """29 W/K then and 20 W/K now, within three standard errors; what else there is stays as it was."""
    (change,) = clogged.found
    assert change.number == "links.coolant jacket.conductance" and change.alike == ()
    assert change.then == pytest.approx(29, rel=0.01) and change.now == pytest.approx(20, rel=0.01)
    assert abs((change.now - change.then) + 9) < 3 * change.std and change.sigma > 50
    rest = [abs(sigma) for name, sigma in clogged.tested.items() if name != change.number]
    assert max(rest) < clogged.limit and len(rest) > 15


def test_its_um_are_what_simulations_differ_by(clogged: Changes, made: dict[str, Path]) -> None:
    """Largest movement over the recordings of now of the machine of the file with the one number and the other."""
    runs = [Recording.load(made[f"clogged_{name}"]) for name in RUNS]
    then, now = (Machine.load(GANTRY, sets=[f"links.coolant jacket.conductance={g} W/K"]) for g in (29, 20))
    differences = [simulate(now, run).tcp["z"] - simulate(then, run).tcp["z"] for run in runs]
    largest = max((float(d[np.argmax(np.abs(d))]) for d in differences), key=abs)
    axis, far = clogged.found[0].most
    assert axis == "z" and far == pytest.approx(largest, rel=0.03)


def test_nothing_is_told_where_nothing_changed(made: dict[str, Path]) -> None:
    found = compared(made, "same")
    assert found.found == () and found.verdict == "adequate"
    assert "Nothing has changed that 2 recordings of then and 2 recordings of now" in str(found)
    sigmas = np.array([*found.tested.values()])
    assert np.abs(sigmas).max() < found.limit and found.limit > 4
    path, by = next(iter(found.least.items()))
    assert by < 0.03 and f"A change of {path} by " in " ".join(str(found).split())


def test_a_sensor_that_drifted_is_no_change_of_the_machine(made: dict[str, Path]) -> None:
    found = compared(made, "drifted")
    (change,) = found.found
    assert change.number == "sensors.T_housing.offset" and found.verdict == "sensor_fault"
    assert change.now - change.then == pytest.approx(0.8, abs=0.05) and change.moved == {}
    assert "a sensor that drifted: it reads 0.80 K more than then" in explain(found, change)
    assert found.summary()["changed"][0]["um"] is None


def test_a_change_is_told_by_its_kind_and_its_way(clogged: Changes) -> None:
    said = explain(clogged, clogged.found[0])
    assert "cooled worse: a fan or a channel that clogged" in said and "(housing, coolant)" in said


@pytest.mark.parametrize(
    ("path", "grown", "says"),
    [
        ("sources.front friction.torque", False, "friction that fell"),
        ("links.flange.conductance", False, "a joint that loosened"),
        ("links.flange.conductance", True, "a joint that sits tighter"),
        ("sources.motor loss.iron", True, "a motor that loses more"),
        ("nodes.shaft.extra_heat_capacity", True, "a part that stores more heat"),
    ],
)
def test_kinds_have_their_words(clogged: Changes, path: str, grown: bool, says: str) -> None:
    from dataclasses import replace

    from network.engine.response.parameters import free_parameters

    parameter = next(p for p in free_parameters(clogged.machine) if p.path == path)
    change = replace(clogged.found[0], number=path, parameter=parameter, then=1.0, now=2.0 if grown else 0.5)
    assert says in explain(clogged, change)


def test_the_command_leaves_the_machine_of_now(
    made: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    now, then = ([str(made[f"{what}_{name}"]) for name in RUNS] for what in ("clogged", "then"))
    main(["diagnose", str(GANTRY), *now, "--reference", *then, "-o", str(tmp_path)])
    assert "links.coolant jacket.conductance  29" in capsys.readouterr().out
    assert {path.name for path in tmp_path.iterdir()} == {"changes.png", "diagnosis.json", "machine.diagnosed.yaml"}
    told: dict[str, Any] = json.loads((tmp_path / "diagnosis.json").read_text(encoding="utf-8"))
    (change,) = told["changed"]
    assert {"number", "then", "now", "sigma", "um"} <= change.keys() and told["verdict"] == "parameters_only"
    assert abs(change["um"]) > 5 and change["axis"] == "z"
    diagnosed = Machine.load(tmp_path / "machine.diagnosed.yaml")
    assert diagnosed.links["coolant jacket"].__dict__["conductance"] == pytest.approx(20, rel=0.01)


@pytest.mark.parametrize(
    ("words", "then"),
    [
        ("m new1 new2 --reference old1 old2 --seed 3", "m new1 new2 --reference old1 --reference old2 --seed 3"),
        ("m new --reference old1 --reference old2", "m new --reference old1 --reference old2"),
        ("m --reference old new", "m --reference old new"),
        ("m new --jobs 1 --reference", "m new --jobs 1 --reference"),
        ("m a b --holdout c", "m a b --holdout c"),
    ],
)
def test_all_names_behind_reference_are_of_then(words: str, then: str) -> None:
    assert spread_references(words.split()) == then.split()


def test_a_recording_on_both_sides_is_refused(made: dict[str, Path], capsys: pytest.CaptureFixture[str]) -> None:
    run = Recording.load(made["then_day_of_work"])
    with pytest.raises(Refused, match="is given twice"):
        find_changes(Machine.load(GANTRY), run, run)
    words = ["diagnose", str(GANTRY), "a.csv", "--reference", "b.csv", "--holdout", "c.csv"]
    with pytest.raises(SystemExit) as end:
        main(words)
    assert end.value.code == 2 and "leave --holdout out" in capsys.readouterr().err


def test_the_readme_shows_what_comes_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    blocks = (ROOT / "README.md").read_text(encoding="utf-8").split("```")
    at = next(i for i, block in enumerate(blocks) if "--reference out/june" in block)
    for name in ("machines", "scenarios"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    for line in blocks[at].strip().splitlines():
        main(shlex.split(line)[1:])
    head, _, rest = blocks[at + 2].strip("\n").partition("\n")
    told = capsys.readouterr().out
    assert rest in told and head.partition(" (")[0] in told
    assert (tmp_path / "out" / "changed" / "changes.png").stat().st_size > 20_000


def test_a_change_that_the_fit_did_not_follow_is_none() -> None:
    """Where slopes promise what no simulation does: the numbers stay, and the promise is not told."""
    plain = two_blocks()
    truth = two_blocks(links={"skin": {"kind": "convection", "between": ["body", "air"], "conductance": "10 W/K"}})
    runs = [recorded(one, speeds(*steps), seed) for one, steps, seed in
            ((plain, USUAL, 1), (plain, ANOTHER, 2), (truth, USUAL, 3), (truth, ANOTHER, 4))]  # fmt: skip
    data = admit(plain, free_parameters(plain), runs, None).data
    split = split_changes(plain, data[:2], data[2:])
    (entry,) = split.at.split
    assert split.at.sets.parameters[entry].path == "links.skin.conductance" and is_reached(split.at, entry)
    stuck = replace(fit_sets(split.at.sets), split=split.at.split)
    assert measure_difference(stuck, entry).sigma > split.limit and not is_reached(stuck, entry)
