"""Recordings as users have them: time stamps, commas, comments, workbooks, several files, several runs in one."""

from __future__ import annotations

import sys
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest

from network import Machine, Recording, calibrate, compare, diagnose, simulate
from network.cli import main
from network.platform.refusal import Refused
from network.recordings.csv_table import write_csv
from network.recordings.gap_bridging import hinders
from network.recordings.scenario import Scenario
from network.recordings.time_order import FALSE_ALARM, longest_interval

HEAD = "time [s],T [degC],speed [rpm]\n"
COLUMNS = 'columns: {T: "T [degC]"}\n'


def load(folder: Path, text: str | bytes, mapping: str | None = None) -> Recording:
    (folder / "r.csv").write_bytes(text.encode() if isinstance(text, str) else text)
    if mapping is None:
        return Recording.load(folder / "r.csv")
    (folder / "m.yaml").write_text(f"recording: x\n{mapping}" + ("" if "file" in mapping else "file: r.csv\n"))
    return Recording.load(folder / "m.yaml")


def refused(folder: Path, text: str | bytes, mapping: str | None = None) -> str:
    with pytest.raises(Refused) as error:
        load(folder, text, mapping)
    return str(error.value).replace(f"{folder}/", "")


def rows(t: range | list[int], speed: float = 100.0) -> str:
    return "".join(f"{x},{20 + x / 1000},{speed}\n" for x in t)


STAMPED = [
    ("2020-06-15T08:00:00,1\n2020-06-15 08:00:10,2\n2020-06-15T08:01:00.5,3\n", [0, 10, 60.5]),
    ("2020-06-15T08:00:00Z,1\n2020-06-15T08:00:10+00:00,2\n2020-06-15T10:01:00+02:00,3\n", [0, 10, 60]),
    ("0:00:10,1\n0:00:20,2\n0:00:30,3\n", [10, 20, 30]),
    ("23:59:40,1\n23:59:50,2\n00:00:10,3\n", [86380, 86390, 86410]),
    ("23:59:40,1\n24:00:00,2\n24:00:20,3\n", [86380, 86400, 86420]),
    ("08:00,1\n08:10,2\n08:30,3\n", [28800, 29400, 30600]),
]


@pytest.mark.parametrize(("text", "t"), STAMPED)
@pytest.mark.parametrize("mapping", [None, "time: {column: time}\ncolumns: {'T [degC]': 'T [degC]'}\n"])
def test_time_stamps_are_seconds(tmp_path: Path, text: str, t: list[float], mapping: str | None) -> None:
    recording = load(tmp_path, "time,T [degC]\n" + text, mapping)
    assert recording.t.tolist() == t and recording.measured("T").values.tolist() == [1, 2, 3]


CLOCKS = [
    ("iso", ["2020-06-15 08:00:00", "2020-06-15 08:00:30", "2020-06-15 08:02:00"]),
    ('"%d.%m.%Y %H:%M:%S"', ["15.06.2020 08:00:00", "15.06.2020 08:00:30", "15.06.2020 08:02:00"]),
    ('"%m/%d/%y %I:%M:%S %p"', ["06/15/20 11:59:00 PM", "06/15/20 11:59:30 PM", "06/16/20 12:01:00 AM"]),
    ('"%I:%M:%S %p"', ["11:59:00 PM", "11:59:30 PM", "12:01:00 AM"]),
    ('"hh:mm:ss"', ["23:59:00", "23:59:30", "00:01:00"]),
    ('"%H:%M:%S"', ["25:59:00", "25:59:30", "26:01:00"]),
]


@pytest.mark.parametrize(("form", "texts"), CLOCKS)
def test_forms_of_time_stamps(tmp_path: Path, form: str, texts: list[str]) -> None:
    text = "when,T\n" + "".join(f"{when},{k}\n" for k, when in enumerate(texts))
    recording = load(tmp_path, text, f"time: {{column: when, format: {form}}}\n{COLUMNS}")
    assert (recording.t - recording.t[0]).tolist() == [0, 30, 120]


@pytest.mark.parametrize(
    ("time", "t"),
    [("{column: a, unit: min}", [0, 30]), ("{column: a, unit: h}", [0, 1800]), ("{interval: 2 min}", [0, 120])],
)
def test_times_of_a_mapping(tmp_path: Path, time: str, t: list[float]) -> None:
    assert load(tmp_path, "a,T\n0,1\n0.5,2\n", f"time: {time}\n{COLUMNS}").t.tolist() == t


ODD = [
    ('# made by a logger\n# "quoted\ntime [s],T [degC]\n0,1\n# pause\n10,2.5\n', "utf-8"),
    ("# made by a logger\n# time [s],T [degC]\n0,1\n10,2.5\n", "utf-8"),
    ("\n\ntime [s],T [degC],\n0,1,\n\n10,2.5,\n,,\n", "utf-8"),
    ("time [s],T [degC]\n0,1,\n10,2.5,\n", "utf-8"),
    ("\ufefftime [s];T [°C]\r\n0;1\r\n10;2,5\r\n", "utf-8"),
    ("time [s];T [°C]\n0;1,0\n10;2,5\n", "cp1252"),
    ("time [s]\tT [°C]\n0\t1,0\n10\t2,5\n", "utf-16"),
    ('"time [s]","T [degC]"\n"0","1"\n"10","2.5"\n', "utf-8"),
    ("time,T\ns,°C\n0,1\n10,2.5\n", "cp1252"),
    ("time;T\n[s];[degC]\n\n0;1\n10;2,5\n", "utf-8"),
]


@pytest.mark.parametrize(("text", "encoding"), ODD)
def test_odd_files_are_read(tmp_path: Path, text: str, encoding: str) -> None:
    recording = load(tmp_path, text.encode(encoding))
    assert recording.t.tolist() == [0, 10] and recording.measured("T").values.tolist() == [1, 2.5]


def test_words_for_a_gap(tmp_path: Path) -> None:
    words = ["NaN", "n/a", "#N/A", "null", "None", "--", "", "1.#QNAN"]
    recording = load(tmp_path, HEAD + "".join(f"{k},{word},1\n" for k, word in enumerate([*words, "5"])))
    assert np.isnan(recording.measured("T").values).tolist() == [True] * len(words) + [False]


MAPPED = [
    ("% by x\nt,T\n0,1\n% pause\n10,2.5\n", 'comment: "%"\ncolumns: {t: "time [s]", T: "T [degC]"}\n'),
    ("0;1\n10;2,5\n", 'header: none\ncolumns: {1: "time [s]", 2: "T [degC]"}\n'),
    ("0,0;1,0\n10,0;2,5\n", 'header: none\ncolumns: {1: "time [s]", 2: "T [degC]"}\n'),
    ('0,"1"\n10,"2,5"\n', 'header: none\ndecimal: ","\ncolumns: {1: "time [s]", 2: "T [degC]"}\n'),
    ("t,T\n[s],[degC]\n0,1\n10,2.5\n", 'columns: {t: "time [s]", T: "T [degC]"}\n'),
]


@pytest.mark.parametrize(("text", "mapping"), MAPPED)
def test_mappings_of_odd_files(tmp_path: Path, text: str, mapping: str) -> None:
    recording = load(tmp_path, text, mapping)
    assert recording.t.tolist() == [0, 10] and recording.measured("T").values.tolist() == [1, 2.5]


STAMP = "or give its form with `time:` in a mapping"
UNIT = "write `time [s]`, `time [min]` or `time [h]`; without a unit it is stamps like 2020-06-15T08:30 or 08:30:00"
FAULTS = [
    ("time,T [degC]\n0,1\n1,2\n", None, f"r.csv:1: column 'time' has no unit, and no time stamps; {UNIT}"),
    (
        "time,T [degC]\n08:00:00,1\n8 o'clock,2\n9 o'clock,2\n",
        None,
        "r.csv:3: column 'time' has the text '8 o'clock', which is no time stamp in the form hh:mm:ss "
        f"(1 more row like it in line 4); write it like 08:30:00, {STAMP}",
    ),
    (
        "time [s],T [degC]\n08:00:00,1\n08:00:10,2\n",
        None,
        "r.csv:2: column 'time [s]' has the text '08:00:00' (1 more row like it in line 3); head the column `time`, "
        "without a unit, and time stamps are read; or say `time:` in a mapping",
    ),
    (
        "when,T\n2020-06-15,1\n",
        f'time: {{column: when, format: "%d.%m.%Y"}}\n{COLUMNS}',
        "r.csv:2: column 'when' has the text '2020-06-15', which is no time stamp in the form %d.%m.%Y; "
        f"write it like 15.06.2020, {STAMP}",
    ),
    (
        "time,T [degC]\n2020-06-15T08:00Z,1\n2020-06-15T08:01,2\n",
        None,
        "r.csv:3: column 'time' has the text '2020-06-15T08:01', which is no time stamp in the form iso; "
        f"write it like 2020-06-15T08:30:00, {STAMP}",
    ),
    (
        "a,T\n0,1\n",
        f"time: {{column: b, unit: s}}\n{COLUMNS}",
        "m.yaml:2: the file r.csv has no column 'b'; known are: a, T",
    ),
    ("a,T\n0,1\n", f"time: {{column: a, unit: m}}\n{COLUMNS}", "m.yaml:2: time.unit: is m; give s, min or h"),
    (
        "a,T\n0,1\n",
        f"time: {{column: a, unit: s, format: iso}}\n{COLUMNS}",
        "m.yaml:2: time has a unit beside a format; a stamp has no unit, keep one",
    ),
    (
        "a,T\n0,1\n",
        f"time: 5 s\n{COLUMNS}",
        "m.yaml:2: time: does not say where times are; write `{column: time_min, unit: min}`, "
        "`{column: when, format: iso}` or `{interval: 120 s}`",
    ),
    (
        "a,T\n0,1\n",
        f"time: {{interval: 1 s}}\ninterval: 1 s\n{COLUMNS}",
        "m.yaml:3: interval is given beside time; keep one of them",
    ),
    ("T\n1\n", f"interval: 1 s\nheader: no\n{COLUMNS}", "m.yaml:3: header: is 'no'; write none, or leave the key away"),
    (
        "T\n1\n",
        f"interval: 1 s\nfiles: r.csv\n{COLUMNS}",
        "m.yaml:3: files: is not a list of files; write `files: [a.csv, b.csv]`, in the order of time",
    ),
    (
        "T\n1\n",
        f"interval: 1 s\nfile: r.csv\nfiles: [r.csv]\n{COLUMNS}",
        "m.yaml:4: files is given beside file; keep one of them",
    ),
    (
        "a,T\n0,1\n\n0.5,2\n",
        f"interval: 1 s\n{COLUMNS}",
        "r.csv:3: is an empty line; take it out, or write nan for a gap, for rows without a time count by their place",
    ),
    (
        HEAD + "0,1,2\n" + "1,2\n" * 9,
        None,
        "r.csv:3: has 2 fields, the header has 3 (8 more rows like it, the last in line 11); "
        "keep the comma of an empty field",
    ),
    (
        HEAD + rows([0, 10, 20, 15, 30, 40]),
        None,
        "r.csv:5: the time goes back from 20 s to 15 s; give rows in the order of time, each time once",
    ),
    (
        HEAD + rows([0, 10, 20, 99999, 30, 40]),
        None,
        "r.csv:6: the time goes back from 99999 s to 30 s; give rows in the order of time, each time once",
    ),
    (
        HEAD + rows(range(500, 0, -10)),
        None,
        "r.csv:3: the time goes back from 500 s to 490 s (48 more rows like it, the last in line 51); "
        "give rows in the order of time, each time once",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("text", "mapping", "told"), FAULTS)
def test_refusals_as_the_user_reads_them(tmp_path: Path, text: str, mapping: str | None, told: str) -> None:
    assert refused(tmp_path, text, mapping) == told


def test_files_continue_each_other(tmp_path: Path) -> None:
    parts = {"a": range(0, 500, 10), "b": range(500, 900, 10), "c": range(300, 900, 10)}
    for name, t in parts.items():
        (tmp_path / f"{name}.csv").write_text(HEAD + rows(t))
    columns = 'columns: {"time [s]": "time [s]", "T [degC]": "T [degC]"}\n'
    one = load(tmp_path, "", f"files: [a.csv, b.csv]\n{columns}")
    assert one.t.tolist() == list(range(0, 900, 10)) and one.pieces == (one,)
    order = "list them in the order of time, each piece of time once"
    told = refused(tmp_path, "", f"files: [b.csv, a.csv]\n{columns}")
    assert told == f"a.csv:2: lies before b.csv, behind which it is listed; {order}"
    told = refused(tmp_path, "", f"files: [a.csv, c.csv]\n{columns}")
    assert told == f"c.csv:2: overlaps with a.csv: the time goes back from 490 s to 300 s; {order}"
    again = load(tmp_path, "", f"files: [a.csv, a.csv]\n{columns}")
    assert [len(piece.t) for piece in again.pieces] == [50, 50], "a clock of its own"


def test_stamps_run_on_from_file_to_file(tmp_path: Path) -> None:
    for day in (15, 16):
        (tmp_path / f"{day}.csv").write_text(
            "when,T\n" + "".join(f"2020-06-{day}T{hour:02}:30,{hour}\n" for hour in range(24))
        )
    one = load(tmp_path, "", f"files: [15.csv, 16.csv]\ntime: {{column: when, format: iso}}\n{COLUMNS}")
    assert np.array_equal(one.t, np.arange(48) * 3600.0) and not one.cuts


def test_several_runs_in_one_file(tmp_path: Path) -> None:
    one = load(tmp_path, HEAD + rows(range(0, 1000, 10)) + rows(range(0, 500, 10)))
    assert [piece.file.removeprefix(f"{tmp_path}/") for piece in one.pieces] == ["r.csv, part 1", "r.csv, part 2"]
    assert [piece.t[[0, -1]].tolist() for piece in one.pieces] == [[0, 990], [0, 490]]
    why = "the clock goes back from 990 s to 0 s, where another run begins"
    runs = "is parted into 2 runs (16.5 min, 8.17 min), each with a start of its own"
    assert one.remarks == (f"{one.file} {runs}: {why}",)
    assert [len(p.t) for p in load(tmp_path, HEAD + rows([0, 10, 20]) + rows([0, 10, 20])).pieces] == [3, 3]


def gapped(change: float = 0.0, speed: float = 100.0, begins: int = 5600) -> str:
    before = rows(range(0, 5000, 10))
    return HEAD + before + "".join(f"{x},{20 + x / 1000 + change},{speed}\n" for x in range(begins, begins + 3500, 10))


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (gapped(), ""),
        (HEAD + rows([*range(0, 1000, 10), *range(1100, 2000, 10)], 7.0), ""),
        (gapped(speed=200.0), "speed is another after it"),
        (gapped(change=-3.0), "T moved in it as under other inputs"),
        (gapped(begins=50000), "it is longer than what is recorded beside it"),
    ],
)
def test_a_gap_parts_what_inputs_cannot_bridge(tmp_path: Path, text: str, why: str) -> None:
    one = load(tmp_path, text)
    assert len(one.pieces) == (2 if why else 1)
    assert all(remark.endswith(f", and {why}") for remark in one.remarks)


def test_chance_rarely_parts_a_recording() -> None:
    random = np.random.default_rng(5)
    drawn = [np.cumsum(random.exponential(10.0, 1000)) for _ in range(4000)]
    alarms = sum(np.diff(t).max() > longest_interval(t) for t in drawn)
    assert alarms <= 4000 * FALSE_ALARM + 4 * np.sqrt(4000 * FALSE_ALARM)
    bridged = 0
    for _ in range(400):
        t = np.concatenate([np.arange(0, 3000, 10.0), np.arange(3400, 6000, 10.0)])
        column = load_column(t, 40 - 10 * np.exp(-t / 2000) + random.normal(0, 0.05, len(t)))
        bridged += hinders(t, [column], 300, 0) == ""
    assert bridged >= 396


def load_column(t: np.ndarray, values: np.ndarray) -> object:
    from network.recordings.columns import Column

    return Column("T", "degC", values)


def test_a_lone_sample_between_gaps_is_left_out(tmp_path: Path) -> None:
    one = load(tmp_path, HEAD + rows([*range(0, 1000, 10), 40000, *range(80000, 82000, 10)]))
    assert [len(piece.t) for piece in one.pieces] == [100, 200]
    assert one.remarks[1].endswith("1 sample that stands alone is left out")


@pytest.fixture(scope="module")
def two_runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two warm-ups of the blocks, a day apart in one file."""
    machine, path = Machine.load("machines/two_blocks.yaml"), tmp_path_factory.mktemp("parted") / "days.csv"
    starts = ("21.6 degC", "30 degC")
    runs = [
        simulate(machine, Scenario.of("x", "2 h", {"ambient": "22 degC"}, start=start), noise_seed=k)
        for k, start in enumerate(starts)
    ]
    columns = {
        name: (unit, np.concatenate([values, again]))
        for (name, unit, values), (_, _, again) in zip(*(run.columns_in_si() for run in runs), strict=True)
    }
    write_csv(path, np.concatenate([runs[0].t, runs[1].t + 86400]), columns)
    return path


def test_every_command_takes_a_parted_recording(two_runs: Path) -> None:
    machine, recording = Machine.load("machines/two_blocks.yaml"), Recording.load(two_runs)
    run = simulate(machine, recording)
    assert np.array_equal(run.t, recording.t) and len(run.tcp["z"]) == len(run.t)
    assert run.sensors["T_hot"][721] == pytest.approx(30, abs=0.6), "begins anew at its first readings"
    assert abs(run.energy.closure) < 1e-9 and recording.remarks[0] in run.warnings
    names = [f"{two_runs}, part 1", f"{two_runs}, part 2"]
    assert [r.recording.file for r in compare(machine, recording).recordings] == names
    found = calibrate(machine, recording)
    assert [d.recording.file for d in found.data] == names and recording.remarks[0] in found.warnings
    told = diagnose(machine, recording)
    assert told.verdict in ("adequate", "parameters_only") and recording.remarks[0] in told.notes


def test_one_results_file_on_the_clock_of_the_recording(two_runs: Path, tmp_path: Path) -> None:
    main(["simulate", "machines/two_blocks.yaml", str(two_runs), "-o", str(tmp_path), "--no-plots"])
    again = Recording.load(tmp_path / "results.csv")
    assert np.array_equal(again.t, Recording.load(two_runs).t) and len(again.pieces) == 2


def test_a_workbook_is_refused_without_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    (tmp_path / "r.xlsx").write_bytes(b"PK")
    with pytest.raises(Refused, match=r"which this installation does not read; pip install 'lptn\[excel\]', or save"):
        Recording.load(tmp_path / "r.xlsx")


def test_workbooks(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for name, offset in (("Warm", 20.0), ("Cold", 0.0)):
        sheet = book.create_sheet(name)
        sheet.append(["when", "T", "n"])
        for k in range(4):
            sheet.append([datetime(2020, 6, 15, 23, 59, 40 + 5 * k), offset + k if k else None, 100])
    del book["Sheet"]
    book.save(tmp_path / "r.xlsx")
    keys = f"file: r.xlsx\ntime: {{column: when, format: iso}}\n{COLUMNS}"
    one = load(tmp_path, "", f"{keys}sheet: Warm\n")
    assert one.t.tolist() == [0, 5, 10, 15]
    np.testing.assert_array_equal(one.measured("T").values, [np.nan, 21, 22, 23])
    assert refused(tmp_path, "", f"{keys}sheet: Worm\n") == "r.xlsx: has no sheet 'Worm'; did you mean 'Warm'?"
    told = refused(tmp_path, "", keys)
    assert told == "r.xlsx: has 2 sheets (Warm, Cold); say which in a mapping, as in `sheet: Warm`"
    (tmp_path / "r.xlsx").write_bytes(b"no book")
    assert refused(tmp_path, "", keys) == "r.xlsx: is no Excel workbook; save it again as .xlsx, or as CSV"
