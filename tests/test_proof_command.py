"""`lptn prove` as it is run: which cases, what is kept, what is refused. The diagnosis itself is a script."""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from bench import ablated
from proof import cases
from proof.sealed import seal_of
from test_stopping import HANGS, PROVE, begun, is_gone

from network.cli import main, proof, proof_case
from network.cli.proof import prove
from network.cli.proof_case import Runs, Way, diagnose
from network.platform.refusal import Refused

DIAGNOSE = """
import json, pathlib, sys, time
words = sys.argv[1:]
pathlib.Path("asked.txt").open("a").write(" ".join(words) + "\\n")
name = pathlib.Path.cwd().name
if words[0] == "compare":
    pathlib.Path(words[-1]).write_text(json.dumps({"rmse_in_noise": 1.3}))
    sys.exit(0)
out = pathlib.Path(words[words.index("-o") + 1])
out.mkdir()
fit = {"holdout": {"before": {"rmse_in_noise": 2.0}, "after": {"rmse_in_noise": 1.1}}}
(out / "diagnosis.json").write_text(json.dumps({"verdict": "adequate", "findings": [], "fit": fit}))
if name == "case-002":
    time.sleep(60)
sys.exit(3 if name == "case-003" else 0)
"""
KEY = {
    "layout": "mill",
    "truth": "fine",
    "class": "innocent",
    "kinds": [],
    "places": [],
    "in_noise": {"after_calibration": 0},
}


def make(folder: Path, count: int, seed: int, jobs: int = 1) -> list[str]:
    """Cases that hold nothing but what they are asked with; the second has a limit of its own."""
    names = [f"case-{i + 1:03d}" for i in range(count)]
    (folder / "keys").mkdir(parents=True, exist_ok=True)
    for name in names:
        (folder / name).mkdir(exist_ok=True)
        about = {"train": ["a.csv", "b.yaml"], "holdout": ["last.csv"], "seconds_limit": 0.5}
        (folder / name / "case.json").write_text(
            json.dumps(about if name == "case-002" else {**about, "seconds_limit": None})
        )
        (folder / "keys" / f"{name}.json").write_text(json.dumps(KEY))
    seals = {name: {"sha256": seal_of(json.dumps(KEY))} for name in names}
    (folder / "cases.json").write_text(json.dumps({"seed": seed, "cases": seals}))
    return names


@pytest.fixture
def where(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "diagnose.py").write_text(DIAGNOSE)
    monkeypatch.setattr(proof_case, "COMMAND", (sys.executable, str(tmp_path / "diagnose.py")))
    monkeypatch.setattr(cases, "make_cases", make)
    return tmp_path / "cases"


def asked(where: Path, name: str) -> list[str]:
    """What the commands of a case were asked, one after the other."""
    return (where / name / "asked.txt").read_text().splitlines()


def test_it_makes_diagnoses_simulates_and_scores(where: Path) -> None:
    said: list[str] = []
    total = prove(3, 5, 1, where, lambda *told: said.append("{}/{} {}".format(*told)))
    first, *others = total.judgements
    assert [each.answered for each in total.judgements] == [True, False, False] and total.development
    assert first.claimed == 1.1 and first.simulated == 1.3 and first.overclaimed
    assert [each.how for each in others] == ["no answer in time", "failed with status 3"]
    assert said[0].startswith("1/3 case-001: answered after") and "no answer in time" in said[1]
    diagnosed, compared = asked(where, "case-001")
    assert diagnosed == ("diagnose machine.yaml a.csv b.yaml --holdout last.csv -o out --no-plots --jobs 1 --seed 5")
    assert compared == "compare out/machine.diagnosed.yaml last.csv --held-out --json out/held_out.json"


def test_a_resumed_proof_runs_only_what_is_left_and_may_grow(where: Path) -> None:
    before = prove(1, 1005, 1, where, resume=True)
    said: list[tuple[int, int]] = []
    after = prove(3, None, 1, where, lambda done, of, _: said.append((done, of)), resume=True)
    assert said == [(2, 3), (3, 3)] and len(asked(where, "case-001")) == 2
    assert after.judgements[0].seconds == before.judgements[0].seconds and after.seed == 1005 and not after.development
    again = prove(None, 1005, 1, where, resume=True)
    assert len(again.judgements) == 3 and len(asked(where, "case-003")) == 1
    assert len(prove(1, None, 1, where, resume=True).judgements) == 1 and (where / "case-003").is_dir()


def test_a_case_without_a_record_is_run_again_from_nothing(where: Path) -> None:
    prove(1, 5, 1, where, resume=True)
    (where / "case-001" / "out" / "run.json").unlink()
    (where / "case-001" / "out" / "stale.txt").touch()
    prove(1, 5, 1, where, resume=True)
    assert len(asked(where, "case-001")) == 4 and not (where / "case-001" / "out" / "stale.txt").exists()


@pytest.mark.parametrize("resume", [True, False])
def test_only_a_resumed_proof_keeps_what_it_has_when_it_is_stopped(where: Path, resume: bool) -> None:
    def stop(done: int, of: int, told: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        prove(2, 5, 1, where, stop, resume=resume)
    assert (where / "case-001" / "out" / "run.json").exists() is resume and where.exists() is resume
    assert not (where / "case-002" / "out" / "run.json").exists()


SLOW = """
import os, pathlib, sys, time
if sys.argv[1] == "diagnose" and pathlib.Path.cwd().name == "case-000":
    pathlib.Path("out").mkdir()
    pathlib.Path("out/diagnosis.json").write_text("{}")
    sys.exit(0)
if pathlib.Path.cwd().name != "case-000":
    pathlib.Path("../../..", f"{os.getpid()}.pid").touch()
    time.sleep(1000)
"""


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="process groups")
def test_ctrl_c_leaves_the_answers_of_a_resumed_proof(tmp_path: Path) -> None:
    (tmp_path / "slow.py").write_text(SLOW)
    code = PROVE.replace("sleeper.py", str(tmp_path / "slow.py")).replace('"2", "-o"', '"1", "--resume"')
    program = begun(code, tmp_path, 1)
    program.send_signal(signal.SIGINT)
    _, said = program.communicate(timeout=HANGS)
    assert program.returncode == 130 and "1/3 case-000: answered" in said
    (pid,) = (int(path.stem) for path in tmp_path.glob("*.pid"))
    assert is_gone(pid) and [path.parent.parent.name for path in tmp_path.rglob("run.json")] == ["case-000"]


def test_what_was_stopped_leaves_no_record(where: Path) -> None:
    make(where, 2, 5)
    (where / "case-002" / "case.json").unlink()
    runs = Runs()
    threading.Timer(0.3, runs.end).start()
    diagnose(where / "case-002", Way(proof_case.COMMAND, "out", 5), runs, 30.0)
    assert not (where / "case-002" / "out" / "run.json").exists()


def test_a_proof_that_was_stopped_while_its_cases_were_made_goes_on(
    where: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(folder: Path, *_: Any) -> None:
        (folder / "keys").mkdir()
        raise KeyboardInterrupt

    monkeypatch.setattr(cases, "make_cases", stop)
    with pytest.raises(KeyboardInterrupt):
        prove(1, 1005, 1, where, resume=True)
    monkeypatch.setattr(cases, "make_cases", make)
    with pytest.raises(Refused, match="holds cases of seed 1005"):
        prove(1, 5, 1, where, resume=True)
    assert len(prove(None, None, 1, where, resume=True).judgements) == 1


def test_another_seed_is_not_mixed_in(where: Path) -> None:
    prove(1, 5, 1, where)
    with pytest.raises(Refused, match="holds cases of seed 5, not of 6; give --seed 5"):
        prove(1, 6, 1, where, resume=True)


def test_some_cases_are_timed_on_two_cores_once_more(where: Path) -> None:
    said: list[str] = []
    total = prove(3, 5, 1, where, lambda *told: said.append("{}/{} {}".format(*told)), timed=1)
    assert said[-1].startswith("1/1 case-001: answered after") and said[-1].endswith("by 2 processes")
    assert total.judgements[0].seconds_two is not None and total.judgements[0].same_on_two
    assert total.judgements[2].seconds_two is None
    assert "-o out-two-cores --no-plots --jobs 2 --seed 5" in asked(where, "case-001")[2]


def test_it_is_refused_outside_a_clone_and_over_other_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "letter.txt").write_text("dear")
    for resume in (True, False):
        with pytest.raises(Refused, match="something else"):
            prove(1, 0, 1, tmp_path, resume=resume)
    monkeypatch.setattr(proof, "TESTS", tmp_path)
    with pytest.raises(Refused, match="clone the repository"):
        prove(1, 0, 1, tmp_path / "new")


# -- ablations --------------------------------------------------------------------------------------------------------
def test_a_stage_that_is_none_is_refused_with_those_there_are(tmp_path: Path) -> None:
    with pytest.raises(
        Refused, match=r"'noise' is no stage .* give file-noise, as-written, seen-runs, no-latent, no-crossed, no-swi"
    ):
        prove(1, 0, 1, tmp_path / "new", ablate="noise")
    assert not (tmp_path / "new").exists()


def test_an_ablation_answers_beside_the_full_diagnosis(where: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    prove(1, 5, 1, where, resume=True)
    command = (*proof_case.COMMAND,)
    monkeypatch.setattr(proof, "_leave_out", lambda stage: (command, f"out-{stage}"))
    total = prove(1, 5, 1, where, resume=True, ablate="as-written")
    assert total.answers == "out-as-written" and total.judgements[0].answered
    assert (where / "case-001" / "out" / "run.json").is_file()


def test_an_ablation_goes_through_its_wrapper() -> None:
    command, answers = proof._leave_out("file-noise")
    assert command == (sys.executable, "-m", "bench.ablated", "file-noise") and answers == "out-file-noise"


@pytest.mark.parametrize("stage", ablated.STAGES)
def test_every_stage_has_functions_to_replace(stage: str, monkeypatch: pytest.MonkeyPatch) -> None:
    replaced: list[str] = []
    monkeypatch.setattr(ablated, "setattr", lambda module, word, value: replaced.append(word), raising=False)
    ablated.switch_off(stage)
    names = {path.rpartition(".")[2] for path in ablated.STAGES[stage]}
    assert names <= {*replaced}


# -- the command ------------------------------------------------------------------------------------------------------
class Told:
    """In place of a score."""

    def summary(self) -> dict[str, int]:
        return {"cases": 7}

    def __str__(self) -> str:
        return "seven"


def fake(heard: dict[str, Any]) -> Callable[..., Told]:
    def run(count: Any, seed: Any, jobs: int, folder: Path, progress: Any, **more: Any) -> Told:
        heard.update(count=count, seed=seed, jobs=jobs, folder=folder.as_posix(), **more)
        progress(1, count or 40, "case-1: answered after 3 s")
        return Told()

    return run


def test_the_command_hands_on_what_it_is_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    heard: dict[str, Any] = {}
    monkeypatch.setattr(proof, "prove", fake(heard))
    main(["prove", "--cases", "7", "--seed", "2", "--jobs", "2", "-o", "there"])
    assert capsys.readouterr() == ("seven\n", "1/7 case-1: answered after 3 s\n")
    usual = {"count": 7, "seed": 2, "jobs": 2, "folder": "there", "resume": False, "ablate": None, "timed": 0}
    assert heard == usual
    file = tmp_path / "new" / "score.json"
    words = ["--resume", "here", "--ablate", "as-written", "--time-two-cores", "3", "--json", str(file), "--jobs", "1"]
    main(["prove", *words])
    asked = {
        "count": None,
        "seed": None,
        "jobs": 1,
        "folder": "here",
        "resume": True,
        "ablate": "as-written",
        "timed": 3,
    }
    assert heard == asked and json.loads(file.read_text()) == {"cases": 7}
    capsys.readouterr()
    main(["prove", "--json", "-"])
    assert json.loads(capsys.readouterr().out) == {"cases": 7}
