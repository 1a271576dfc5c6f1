"""A short seed of `make torture`, what it has found so far, and that its oracle sees what it is there to see."""

from __future__ import annotations

import json
import random
import signal
from pathlib import Path

import pytest
from torture.__main__ import attempt, table
from torture.agreement import compare_ways
from torture.deeds import Bench
from torture.faults import FAULTS as DISTURBANCES
from torture.faults import can_mount
from torture.log import go_on
from torture.minimise import minimise
from torture.mutants import PAIRS, ROOT, SMALL, Mutant, mutant, recorded, shipped
from torture.networks import KINDS, draw_network
from torture.oracle import Outcome, judge
from torture.reach import Reach
from torture.stops import stop_once
from torture.survivors import TESTS

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


def links(machine: Machine) -> list[Link]:
    return [each for each in machine.links.values() if isinstance(each, Link)]


def test_ways_of_solving_agree_on_some_networks() -> None:
    drawn = [draw_network(1, number) for number in range(24)]
    assert {each.kind for each in drawn} == {*KINDS}
    told = [(n, each) for n, network in enumerate(drawn) for each in compare_ways(network, random.Random(n), slow=3.0)]
    assert [(n, each) for n, each in told if not each.furthest <= 1.0] == []


@pytest.mark.parametrize("name", ["full disk", "read only", "two at once", "clock set back"])
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
    took = "2.50s call tests/test_a.py::test_slow\n0.10s setup tests/test_a.py::test_quick\n"
    took += "0.20s call     tests/test_a.py::test_quick[1]\n0.20s call     tests/test_a.py::test_quick[2]\n"
    contexts = {"3": ["", "test_a.test_slow", "test_a.test_quick"], "4": ["test_a.test_slow"], "5": [""]}
    reach, module = Reach(), Path("network/engine/units.py")
    reach.add(took, {str(module): {"contexts": contexts}})
    assert reach.seconds["tests/test_a.py::test_quick"] == pytest.approx(0.5)
    quick, slow = "tests/test_a.py::test_quick", "tests/test_a.py::test_slow"
    assert reach.tests_of(module, [3], 9.0) == [quick, slow] and reach.tests_of(module, [3], 2.0) == [quick]
    assert reach.tests_of(module, [4], 2.0) == [slow] and reach.tests_of(module, [5, 6], 9.0) == []
    assert reach.tests_of(Path("network/other.py"), [3], 9.0) == []
    assert all((ROOT / name).is_file() for name in TESTS)


def test_the_table_counts() -> None:
    told = [{"command": "check", "kind": kind} for kind in ("refused", "refused", "accepted")]
    assert table(told).splitlines()[1].split() == ["check", "3", "2", "0", "1", "0"]
