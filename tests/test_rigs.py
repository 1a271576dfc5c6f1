"""The score on real rigs: nothing but what is concealed is hidden, and a right answer is known from a wrong one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bench.rigs.answers import Answer, Score, named, score
from bench.rigs.case import Case, Concealment, laid_over, read
from bench.rigs.concealments import CONCEALMENTS, the_stop
from bench.rigs.figures import Figures, Left, Size, pooled
from bench.rigs.hiding import heated, of_the_feed, stop, without_stop
from bench.rigs.recovered import Recovered, recovered
from bench.rigs.rows import Measured, Row
from bench.rigs.running import Processes, answered, fingerprint
from bench.rigs.splits import RECORDINGS, ROOT, SPLITS, Run, Split, split
from bench.rigs.tables import markdown, short, tables
from rich.console import Console

from network.machine.machine import Machine
from network.recordings.recording import Recording

needs_recordings = pytest.mark.skipif(
    not RECORDINGS.is_dir(), reason="the recordings in ../shared/recordings are not here"
)
RIG = "tclab-apm", "two_heater_rig"
NAMES = {c.name: c for c in CONCEALMENTS}
LATHE: dict[str, Any] = {
    "nodes": {"saddle": {}, "room": {"temperature": "ambient"}},
    "sources": {
        "x feed motor": {"kind": "heat_source", "with": "feed", "into": {"saddle@0.2": 0.5, "bed": 0.5}},
        "guides": {"kind": "guide_friction", "input": "feed", "into": {"saddle": 1}},
        "bearings": {"kind": "bearing_friction", "into": {"headstock": 1}},
    },
    "tcp": {"z": {"headstock grows": {"kind": "stretching"}, "bed grows": {"kind": "stretching"}}},
}
"""As much of a lathe's file as answers are read from."""


def here(wanted: Split) -> None:
    """Skips where a rig's machine is not in the project; one without its mappings fails."""
    if not wanted.machine_file.exists() and wanted.rig == "cnc-lathe":
        pytest.skip(f"{wanted.lacks[0].name} is not here")


def finding(kind: str, *places: str, channels: tuple[str, ...] = (), **rest: Any) -> dict[str, Any]:
    return {"kind": kind, "places": list(places), "channels": list(channels), "confidence": 0.9, **rest}


def driven(kind: str, place: str, by: str) -> dict[str, Any]:
    return finding(kind, place, patch={"sources": {"new": {"kind": kind, "into": {place: 1}, "with": by}}})


def about(*window: float) -> dict[str, Any]:
    return finding("unknown", "spindle", evidence={"windows": [list(window)]})


RIGHT: Mapping[str, dict[str, Any]] = {
    "Q2": finding("timed_source", "heater 2"),
    "heaters-apart": finding("convection", "heater 2", "heater 1"),
    "swap": finding("sensor_swap", channels=("T2", "T1")),
    "P-heating": finding("heat_source", "radiators"),
    "P-heating-source": driven("heat_source", "radiators", "P_heating"),
    "outdoor": finding("ambient_drift", "outdoor"),
    "elements": finding("hidden_mass", "elements"),
    "bed-frame": finding("radiation", "bed", "frame"),
    "NTC7": finding("sensor_fault", channels=("NTC7",)),
    "feed-heat": driven("heat_source", "saddle", "running"),
    "room": finding("ambient_drift", "room"),
    "stop": about(150 * 60, 212 * 60),
    "expansion": finding("bending", "tcp.z"),
}
PART: Mapping[str, dict[str, Any]] = {
    "Q2": finding("unknown", "heater 2"),
    "heaters-apart": finding("sunlight", "heater 2", indistinguishable=[finding("radiation", "heater 1", "heater 2")]),
    "swap": finding("sensor_offset", channels=("T1", "T2")),
    "P-heating": finding("unknown", "radiators"),
    "P-heating-source": driven("heat_source", "radiators", "always"),
    "elements": finding("unknown", "air"),
    "bed-frame": finding("unknown", "bed", "frame"),
    "feed-heat": driven("heat_source", "bed", "always"),
    "stop": about(130 * 60, 212 * 60),
    "expansion": finding("unknown", "tcp.z"),
}
WRONG: Mapping[str, dict[str, Any]] = {
    "Q2": finding("timed_source", "heater 1"),
    "heaters-apart": finding("convection", "heater 1", "room"),
    "swap": finding("sensor_swap", channels=("T1", "T3")),
    "P-heating": finding("unknown", "envelope"),
    "P-heating-source": driven("heat_source", "indoor", "P_heating"),
    "outdoor": finding("radiation", "radiators", "outdoor"),
    "elements": finding("sensor_offset", channels=("T_air",)),
    "bed-frame": finding("convection", "frame", "room"),
    "NTC7": finding("sensor_fault", channels=("NTC6",)),
    "feed-heat": driven("heat_source", "headstock", "running"),
    "room": finding("convection", "saddle", "room"),
    "stop": about(20 * 60, 60 * 60),
    "expansion": finding("stretching", "tcp.x"),
}


def answer(name: str) -> Answer:
    if name == "stop" and not RECORDINGS.is_dir():
        pytest.skip("the recordings in ../shared/recordings are not here")
    return NAMES[name].answer(LATHE)


def scored(name: str, *findings: dict[str, Any], correlation: float | None = 0.9) -> Score:
    return score({"verdict": "missing_physics", "findings": list(findings)}, answer(name), correlation)


@pytest.mark.parametrize("name", NAMES)
def test_a_right_answer_is_known_from_a_wrong_one(name: str) -> None:
    assert scored(name, RIGHT[name]).grade == "right"
    assert scored(name, WRONG[name]) == Score("missed")
    assert scored(name).grade == "missed"
    assert scored(name, WRONG[name], RIGHT[name]).grade == "right"


@pytest.mark.parametrize("name", PART)
def test_a_part_of_the_truth_is_called_a_part(name: str) -> None:
    assert scored(name, PART[name]).grade == "part"


@pytest.mark.parametrize("name", ["Q2", "P-heating"])
def test_heat_that_does_not_follow_what_was_hidden_is_a_part(name: str) -> None:
    assert [scored(name, RIGHT[name], correlation=r).grade for r in (0.2, None)] == ["part", "part"]


def test_a_name_that_is_not_believed_is_a_part() -> None:
    assert scored("NTC7", {**RIGHT["NTC7"], "confidence": 0.004}).grade == "part"


def test_no_answer_in_time_is_told_as_such() -> None:
    assert score(None, answer("Q2")).grade == "no answer"


def test_what_was_named_is_told_with_its_confidence() -> None:
    assert scored("bed-frame", RIGHT["bed-frame"]).by == "radiation bed – frame (0.90)"


def test_numbers_of_what_was_named_are_told_with_their_units() -> None:
    parameters = {"conductance": {"value": 0.00335, "std": 0.0005, "unit": "W/K"}, "gain": {"value": 3.1, "unit": "1"}}
    told = named(finding("conduction", "heater 1", "heater 2", parameters=parameters))
    assert told == "conduction heater 1 – heater 2 (0.90), conductance 0.00335 ± 0.0005 W/K, gain 3.1"


def test_every_concealment_is_scored_here() -> None:
    assert {*RIGHT} == {*WRONG} == {*NAMES} and len(NAMES) == len(CONCEALMENTS)


# -- files ----------------------------------------------------------------------------------------------------------
@needs_recordings
def test_every_rig_has_its_split() -> None:
    assert {s.rig for s in SPLITS} == {path.name for path in RECORDINGS.iterdir() if path.is_dir()}


@needs_recordings
@pytest.mark.parametrize("wanted", SPLITS, ids=lambda s: s.name)
def test_every_split_has_machine_and_mappings(wanted: Split, tmp_path: Path) -> None:
    here(wanted)
    case = Case(wanted)
    case.write(tmp_path)
    inputs = Machine.load(tmp_path / "machine.yaml").inputs
    for name in (*case.train, *case.holdout):
        recording = Recording.load(tmp_path / name)
        assert inputs.keys() <= {*recording.columns, *recording.constants} and len(recording.t) > 50


@needs_recordings
@pytest.mark.parametrize("wanted", SPLITS, ids=lambda s: s.name)
def test_nothing_is_both_learned_from_and_held_out(wanted: Split) -> None:
    here(wanted)
    learned, held = ([laid_over(run) for run in some] for some in (wanted.train, wanted.holdout))
    for one in learned:
        assert all(one["file"] != other["file"] or one.get("until") == other.get("from") for other in held)


def test_a_mapping_gives_its_file_on_a_line_of_its_own() -> None:
    for path in (ROOT / "tests" / "recordings").glob("*.yaml"):
        (line,) = (line for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("file"))
        assert line == f"file: {read(path)['file']}"


HIDDEN = {
    "Q2": ({"sources.heating 2"}, {"Q2"}),
    "heaters-apart": ({"links.film between", "links.glow between"}, set()),
    "swap": (set(), {"T1", "T2"}),
    "P-heating": ({"sources.heating", "links.pump"}, {"P_heating"}),
    "P-heating-source": ({"sources.heating"}, set()),
    "outdoor": (set(), {"outdoor"}),
    "elements": ({"nodes.elements"}, set()),
    "bed-frame": ({"links.bed to frame"}, set()),
    "NTC7": ({"sensors.NTC7"}, {"NTC7"}),
    "room": (set(), {"ambient"}),
    "stop": (set(), {"speed", "feed"}),
}
"""Entries of the machine and columns of recordings in which a concealed pair differs from the whole one."""


def hidden(c: Concealment) -> tuple[set[str], set[str]]:
    """Those two, read from the machine file where it is not for the score to say how its entries are called."""
    tree = Case(split(c.split)).tree
    if c.name == "feed-heat":
        return {f"sources.{name}" for name in of_the_feed(tree)}, set()
    if c.name == "expansion":
        return {f"tcp.z.{next(iter(tree['tcp']['z']))}"}, set()
    return HIDDEN[c.name]


def entries(machine: Machine) -> dict[str, Any]:
    tree = machine.to_plain()
    told = {f"{s}.{n}": e for s in ("nodes", "links", "sources", "sensors") for n, e in tree.get(s, {}).items()}
    return told | {f"tcp.{axis}.{n}": e for axis, some in tree.get("tcp", {}).items() for n, e in some.items()}


def differing(a: Mapping[str, Any], b: Mapping[str, Any]) -> set[str]:
    return {name for name in {*a, *b} if name not in a or name not in b or not same(a[name], b[name])}


def same(a: Any, b: Any) -> bool:
    return np.array_equal(a, b, equal_nan=True) if isinstance(a, np.ndarray) else bool(a == b)


def columns(recording: Recording) -> dict[str, np.ndarray]:
    return {name: column.values for name, column in recording.columns.items()}


@needs_recordings
@pytest.mark.parametrize("concealed", CONCEALMENTS, ids=lambda c: c.name)
def test_nothing_else_is_concealed(concealed: Concealment, tmp_path: Path) -> None:
    here(split(concealed.split))
    whole, case = Case(split(concealed.split)), Case(split(concealed.split), concealed)
    for each, where in ((whole, "whole"), (case, "case")):
        each.write(tmp_path / where)
    machines = [Machine.load(tmp_path / where / "machine.yaml") for where in ("whole", "case")]
    assert differing(*map(entries, machines)) == hidden(concealed)[0]
    changed: set[str] = set()
    for name in (*case.train, *case.holdout):
        pair = [Recording.load(tmp_path / where / name) for where in ("whole", "case")]
        assert np.array_equal(pair[0].t, pair[1].t)
        changed |= differing(*map(columns, pair))
    assert changed == hidden(concealed)[1]


STOPPED = [["t", "speed"], *([str(i), str(v)] for i, v in enumerate([5, 5, 0, 0, 7, 7, 0]))]


def test_a_stop_goes_on_as_before_it_and_the_end_stays() -> None:
    assert stop(STOPPED, "speed") == (3, 5)
    assert [row[1] for row in without_stop("speed", "speed")(STOPPED)[1:]] == ["5", "5", "5", "5", "7", "7", "0"]
    assert without_stop("speed", "speed")(STOPPED[:4]) == STOPPED[:4]


@needs_recordings
def test_the_stop_that_is_hidden_took_an_hour() -> None:
    window = the_stop(LATHE).window
    assert window is not None and window[1] - window[0] == pytest.approx(3600, abs=60)


def test_what_the_feed_heats_is_read_from_the_file() -> None:
    assert of_the_feed(LATHE) == ("x feed motor", "guides")
    assert heated(LATHE, of_the_feed(LATHE)) == {"saddle", "bed"}


# -- figures --------------------------------------------------------------------------------------------------------
def test_runs_are_pooled_sample_by_sample() -> None:
    some = [Left("T", "K", np.array([0.3]), 0.1), Left("T", "K", np.full(3, 0.1), 0.1)]
    found = pooled([*some, Left("dz", "µm", np.full(4, 4.0), 2.0)])
    assert found.channels["T"].rms == pytest.approx(np.sqrt(0.12 / 4))
    assert found.noise == pytest.approx(np.sqrt((9 + 3 + 4 * 4) / 8))


@needs_recordings
def test_an_answer_of_the_same_files_is_kept(tmp_path: Path) -> None:
    def mark(where: str, limit: str) -> str:
        Case(Split("a", "a", *RIG, (Run("tclab_mhe", {"until": limit}),), ())).write(tmp_path / where)
        return fingerprint(sorted((tmp_path / where).iterdir()))

    assert mark("one", "5 min") == mark("other", "5 min") != mark("third", "6 min")


@needs_recordings
def test_heat_that_was_put_back_is_all_that_was_hidden(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bench.rigs.recovered.PIECES", 4)
    whole, case = Case(split("two-heaters")), Case(split("two-heaters"), NAMES["Q2"])
    for each, where in ((whole, "whole"), (case, "case")):
        each.write(tmp_path / where)
    machines = [tmp_path / where / "machine.yaml" for where in ("whole", "case")]
    truth = [tmp_path / "whole" / case.train[1]]
    assert recovered(machines[0], ("heating 2",), machines[1], machines[1], truth, truth) is None
    found = recovered(machines[0], ("heating 2",), machines[0], machines[1], truth, truth)
    assert found is not None and (found.correlation, found.energy) == pytest.approx((1, 1))


class Told(Processes):
    """Ends as it is told to, at once."""

    def run(self, words: Sequence[str], folder: Path, log: Path) -> tuple[int | None, float]:
        log.write_text("machine.yaml:1: no such machine\n")
        return (None if self.limit < 9 else 2), self.limit


@needs_recordings
def test_only_what_a_longer_limit_may_change_is_run_again(tmp_path: Path) -> None:
    case = Case(split("two-heaters-mhe"))
    told = [answered(case, tmp_path, Told(limit)).diagnosed for limit in (5.0, 2.0, 9.0, 99.0)]
    assert [ending.limit for ending in told] == [5, 5, 9, 9]
    assert [ending.told for ending in told[1:3]] == [
        "no answer in 5 s", "failed with status 2: machine.yaml:1: no such machine",
    ]  # fmt: skip


def some_rows() -> list[Row]:
    of = {stage: Figures(16.0, {"T1": Size(1.5, "K", 15.0, 200)}) for stage in ("as written", "calibrated")}
    plain = Row("a", "two heaters", "", "", "no answer in 300 s", 300.0, "", (), None, Measured({}, of))
    measured = Measured({}, of, recovered=Recovered(0.83, 0.9))
    told = ("timed_source heater 2 (0.90)",)
    concealed = Row("b", "two heaters", "Q2", "heat at heater 2", "answered", 20.0, "unexplained", told,
                    Score("right", *told), measured)  # fmt: skip
    return [plain, concealed]


def test_tables_tell_both_units_the_grade_and_what_did_not_end() -> None:
    console = Console(width=300, record=True, file=StringIO())
    for table in tables(some_rows()):
        console.print(table)
    text = console.export_text()
    for told in ("1.5 K (15 σ)", "16 σ → –", "no answer in 300 s", "1 right", "r = 0.83, 90 % of the energy"):
        assert told in text


def test_figures_are_told_without_exponents() -> None:
    assert [short(x) for x in (0.0123, 1.5, 123.4, 7834.0)] == ["0.0123", "1.5", "123", "7834"]
    assert short(123.4, 2) == "123"


def test_markdown_is_one_table() -> None:
    lines = markdown(some_rows()).splitlines()
    assert len(lines) == 4 and {line.count("|") for line in lines} == {8}
    assert "T1 1.5 K, 16 σ" in lines[2] and "**right: timed_source heater 2 (0.90)**" in lines[3]
