"""A short seed of `make torture`, what it has found so far, and that its oracle sees what it is there to see."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from torture.__main__ import attempt, share, table
from torture.agreement import compare_ways
from torture.deeds import Bench
from torture.faults import FAULTS as DISTURBANCES
from torture.faults import can_mount
from torture.log import go_on, read_numbered
from torture.minimise import minimise
from torture.mutants import PAIRS, ROOT, SMALL, Mutant, mutant, recorded, shipped
from torture.networks import KINDS, draw_network
from torture.oracle import Outcome, judge
from torture.reach import Reach
from torture.stops import stop_once
from torture.survivors import ROOMS, TESTS

from network import Machine, Scenario, simulate
from network.analysis.sweep.lumping_error import cut_finely, estimate_lumping
from network.catalogue.mechanisms.base import Link
from network.cli import commands
from network.machine.size_checks import count_pairs

FOUND = Path(__file__).parent / "torture" / "found"
COUNT = 80
posix = pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="limits the time of the processor")
pytestmark = posix


def original(command: str, source: str, folder: Path, pair: tuple[str, str] = SMALL) -> Mutant:
    files = {"m.yaml": shipped(pair[0], "machines"), "s.yaml": shipped(pair[1], "scenarios"), "r.csv": recorded(folder)}
    words = (command, "m.yaml", source, *(() if command == "check" else ("-o", "out", "--no-plots")))
    return Mutant({name: files[name] for name in ("m.yaml", source)}, words)


@pytest.mark.parametrize("pair", PAIRS)
def test_what_is_mutated_is_right_before(pair: tuple[str, str], tmp_path: Path) -> None:
    assert attempt(original("check", "s.yaml", tmp_path, pair), tmp_path).kind == "accepted"
    if pair == SMALL:
        assert attempt(original("simulate", "r.csv", tmp_path), tmp_path).kind == "accepted"


def test_some_mutants(tmp_path: Path) -> None:
    """The commands that take seconds are left to `make torture`."""
    made = [mutant(7, number, tmp_path) for number in range(COUNT)]
    quick = [each for each in made if each.words[0] in ("check", "simulate")]
    outcomes = [(each, attempt(each, tmp_path)) for each in quick]
    assert [(each.words, outcome.why) for each, outcome in outcomes if outcome.kind == "fault"] == []
    assert {outcome.kind for _, outcome in outcomes} >= {"refused", "accepted"}
    again = mutant(7, 3, tmp_path)
    assert (again.files, again.words) == (made[3].files, made[3].words)


@pytest.mark.parametrize("case", sorted(FOUND.glob("*")), ids=lambda path: path.name)
def test_what_was_found_stays_mended(case: Path, tmp_path: Path) -> None:
    words = json.loads((case / "words.json").read_text(encoding="utf-8"))["words"]
    files = {path.name: path.read_bytes().decode() for path in case.iterdir() if path.name != "words.json"}
    assert attempt(Mutant(files, tuple(words)), tmp_path).why == ""


def test_a_machine_that_stands_still_is_not_said_to_need_lumps(tmp_path: Path) -> None:
    case = FOUND / "rounding in place of heat"
    day = Scenario.load(case / "s.yaml")
    run = simulate(Machine.load(case / "m.yaml"), day)
    told = estimate_lumping(run.machine, day, run)
    assert told is not None and told.is_within and told.choice is None
    assert {change.size for change in told.changes} == {0.0}


def test_bars_that_cannot_be_cut_more_finely_are_left(monkeypatch: pytest.MonkeyPatch) -> None:
    mill = Machine.load(ROOT / "machines/vertical_mill.yaml")
    assert cut_finely(mill) is not None
    monkeypatch.setattr("network.machine.size_checks.MOST_PAIRS", sum(count_pairs(mill, each) for each in links(mill)))
    assert cut_finely(mill) is None


def test_a_run_that_only_finer_lumps_make_too_long_is_not_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    mill, day = (
        Machine.load(ROOT / "machines/vertical_mill.yaml"),
        Scenario.load(ROOT / "scenarios/warm_up_and_stop.yaml"),
    )
    run = simulate(mill, day, method="rosenbrock")
    assert estimate_lumping(mill, day, run, method="rosenbrock", asks=False) is not None
    columns = len(run.inputs) + len(run.sensors) + 2 * len(mill.nodes) + mill.lumps + 20
    monkeypatch.setattr("network.engine.simulation.MOST_VALUES", columns * len(run.t))
    assert simulate(mill, day, method="rosenbrock").t.size == run.t.size
    assert estimate_lumping(mill, day, run, method="rosenbrock", asks=False) is None


def links(machine: Machine) -> list[Link]:
    return [each for each in machine.links.values() if isinstance(each, Link)]


def test_ways_of_solving_agree_on_some_networks() -> None:
    drawn = [draw_network(1, number) for number in range(24)]
    assert {each.kind for each in drawn} == {*KINDS}
    told = [(n, each) for n, network in enumerate(drawn) for each in compare_ways(network, random.Random(n), slow=3.0)]
    assert [(n, each) for n, each in told if not each.furthest <= 1.0] == []


@pytest.mark.parametrize(
    "name", ["full disk", pytest.param("read only", marks=pytest.mark.proof), "two at once", "clock set back"]
)
def test_a_computer_that_lets_a_simulation_down(name: str, tmp_path: Path) -> None:
    if name in ("full disk", "read only") and not can_mount(tmp_path):
        pytest.skip("file systems cannot be mounted here")
    assert DISTURBANCES[name][0]("simulate", random.Random(2), Bench(tmp_path)) == ""


def test_a_command_that_is_stopped_and_what_is_tried_goes_on_where_it_was(tmp_path: Path) -> None:
    assert stop_once("export", signal.SIGTERM, 0.9, fresh=True, bench=Bench(tmp_path)) == ""
    log, tried = tmp_path / "log" / "tried.jsonl", list[int]()
    told = [go_on(log, count, lambda number: tried.append(number) or {"what": number}) for count in (2, 5, 3)]  # type: ignore[func-returns-value]
    assert tried == [0, 1, 2, 3, 4] and [[each["what"] for each in one] for one in told] == [[0, 1], tried, [0, 1, 2]]


# -- the oracle -----------------------------------------------------------------------------------------------------
FAULTS = {
    "traceback": "raise ZeroDivisionError",
    "hangs": "while True: pass",
    "form": "import sys; print('no', file=sys.stderr); sys.exit(2)",
    "slow": "import sys, time\nend = time.process_time() + 0.1\nwhile time.process_time() < end: pass\n"
    "print('m: no; yes', file=sys.stderr); sys.exit(2)",
    "leftover": "import sys, pathlib; pathlib.Path('x').touch(); print('m: no; yes', file=sys.stderr); sys.exit(2)",
    "finite": "import pathlib; pathlib.Path('results.csv').write_text('time [s],T [degC]\\n0,1\\n10,nan\\n')",
    "energy": "import pathlib; pathlib.Path('summary.json').write_text('{\"energy\": {\"closure\": 0.1}}')",
    "again": "import pathlib; pathlib.Path('results.csv').write_text('nothing')",
}


@pytest.mark.parametrize("fault", FAULTS)
def test_the_oracle_sees(fault: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("torture.oracle.run", lambda words: exec(FAULTS[fault]))
    monkeypatch.setattr("torture.oracle.QUICK", 0.2)
    monkeypatch.setattr("torture.oracle.AT_ONCE", 0.05)
    outcome = judge(("check",), tmp_path)
    assert outcome.kind == "fault" and outcome.why.startswith(fault)
    assert commands.run is not None


def test_a_mutant_is_made_as_small_as_it_stays_the_same_fault() -> None:
    def attempt_one(made: Mutant) -> Outcome:
        is_bad = "bad" in made.files["m.yaml"]
        return Outcome("fault", "traceback: bad") if is_bad else Outcome("accepted")

    made = Mutant({"m.yaml": "\n".join([*"abcdefgh", "bad", *"ijkl"])}, ("check", "m.yaml", "s.yaml", "--lumps", "3"))
    small = minimise(made, Outcome("fault", "traceback: bad"), attempt_one)
    assert small.files["m.yaml"].split("\n") == ["bad"] and small.words == ("check", "m.yaml", "s.yaml")


def test_a_change_is_looked_for_by_the_quickest_tests_that_run_its_line() -> None:
    module, quick, slow = "network/engine/units.py", "tests/test_a.py::test_quick[1]", "tests/test_a.py::test_slow"
    reach = Reach()
    reach.add({slow: {"seconds": 2.5, "lines": {module: [3, 4]}}, quick: {"seconds": 0.5, "lines": {module: [3]}}})
    assert reach.tests_of(Path(module), [3], 9.0) == [quick, slow]
    assert reach.tests_of(Path(module), [3], 2.0) == [quick]
    assert reach.tests_of(Path(module), [4], 2.0) == [slow] and reach.tests_of(Path(module), [5, 6], 9.0) == []
    assert reach.tests_of(Path("network/other.py"), [3], 9.0) == []
    assert all((ROOT / name).is_file() for name in TESTS)


PROJECT = {
    "network/engine/half.py": "def half(x):\n    if x < 0:\n        return -half(-x)\n    return x / 2\n",
    "tests/test_half.py": "import pytest\nfrom network.engine.half import half\n\n"
    "@pytest.fixture(scope='module')\ndef six():\n    return half(-12)\n\n"
    "def test_positive():\n    assert half(2) == 1\n\n"
    "def test_broken():\n    assert half(-4) == 2\n\n"
    "def test_fixture(six):\n    assert six == -6\n\n"
    "def test_fixture_again(six):\n    assert six < 0\n",
}


@pytest.mark.skipif(sys.version_info < (3, 12), reason="older ones do not tell lines")
def test_lines_are_those_of_tests_that_pass_and_of_what_they_ask_for(tmp_path: Path) -> None:
    for name, text in PROJECT.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    told = tmp_path / "lines.json"
    settings = {"LINES_OF": "network/engine", "LINES_TO": str(told), "PYTHONPATH": str(ROOT / "tests")}
    words = [sys.executable, "-m", "pytest", "-p", "torture.lines", "-p", "no:cacheprovider", "tests/test_half.py"]
    subprocess.run(words, cwd=tmp_path, env={**os.environ, **settings}, check=False, capture_output=True)
    lines = {
        test.partition("::")[2]: its["lines"]["network/engine/half.py"]
        for test, its in json.loads(told.read_text()).items()
    }
    assert {test: {2, 3, 4} & {*own} for test, own in lines.items()} == {
        "test_positive": {2, 4}, "test_fixture": {2, 3, 4}, "test_fixture_again": {2, 3, 4},
    }  # fmt: skip


def test_the_table_counts() -> None:
    told = [{"command": "check", "kind": kind} for kind in ("refused", "refused", "accepted")]
    told += [{"command": "draw", "kind": "fault"}] + [{"command": "follow", "kind": "refused"}] * 1000
    rows = [line.strip("| ").split(" | ") for line in table(told).splitlines()[2:]]
    assert rows[0] == ["follow", "1 000", "1 000", "0", "0", "0"] and rows[1] == ["check", "3", "2", "0", "1", "0"]
    assert rows[3] == ["all", "1 004", "1 002", "0", "1", "1"]


def test_mutants_are_shared_and_gone_on_with_where_they_were_stopped(tmp_path: Path) -> None:
    done = tmp_path / "done-7.jsonl"
    done.write_text(
        '{"command": "check", "kind": "refused"}\n{"number": 3, "command": "check", "kind": "accepted"}\n{"nu'
    )
    assert {*read_numbered(done)} == {0, 3}
    share(2, lambda which: done.with_name(f"{which}").touch())
    assert {path.name for path in tmp_path.iterdir()} == {"0", "1", done.name}
    with pytest.raises(RuntimeError, match="2 of 2"):
        share(2, lambda which: exec("raise ValueError"))


def test_what_was_tried_is_told_as_the_readme_has_it(tmp_path: Path) -> None:
    logs = {
        "done-0.jsonl": [{"command": "check", "kind": "refused"}],
        "stops.jsonl": [{"what": "simulate SIGINT", "why": ""}, {"what": "sweep SIGKILL", "why": "mixed: a"}],
        "faults.jsonl": [{"what": "full disk: simulate", "why": ""}],
        "agreement.jsonl": [{"kind": "linear", "parts": 7, "apart": {"energy": 0.5, "expm": 2.0}}],
        "survivors.jsonl": [
            {"number": 3, "room": ROOMS[0], "where": "a.py:1", "outcome": "survived", "tests": 2, "diff": "-x"}
        ],
    }
    for name, lines in logs.items():
        (tmp_path / name).write_text("".join(json.dumps(line) + "\n" for line in lines))
    words = [sys.executable, "-m", "torture.told", "--folder", str(tmp_path)]
    run = subprocess.run(words, cwd=ROOT / "tests", capture_output=True, text=True, check=False,
                         env={**os.environ, "PYTHONPATH": str(ROOT)})  # fmt: skip
    assert run.returncode == 1 and "| all | 1 | 1 | 0 | 0 | 0 |" in run.stdout
    assert (
        "2 commands stopped (1 by Ctrl-C, 0 by SIGTERM, 1 by SIGKILL): 1 of 2 held\nsweep SIGKILL: mixed: a"
        in run.stdout
    )
    assert "1 times (1 full disk): 1 of 1 held" in run.stdout and "7 to 7 parts (1 linear)" in run.stdout
    row = "| modes or subspace with `expm` | 1 | 1e-9 K per kelvin, and what `krylov` tells of itself | 2 | 1 |"
    assert row in run.stdout and f"| `{ROOMS[0]}` | 1 | 1 |" in run.stdout and "a.py:1 (3, 2 tests)\n-x" in run.stdout
