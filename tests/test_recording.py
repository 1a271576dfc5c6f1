"""Recordings: what is read is what was written, mappings of foreign files, and what the user reads when refused."""

from __future__ import annotations

import math
import os
import time
from pathlib import Path

import numpy as np
import pytest

from network.platform.quantities.units import BadNumber, unit
from network.platform.refusal import Refused
from network.recordings.columns import Column
from network.recordings.csv_table import write_csv
from network.recordings.inputs import Start
from network.recordings.recording import Recording

SHARED = Path(__file__).parents[2] / "shared"
HEAD = "time [s],speed [rpm],T [degC]\n"
FIRST_ROW = "the first row is like `time [s],speed [rpm],T_housing [degC]`"
NUMBER = "write a number, or leave the field empty for a gap"
COMMA = 'write 21.5, or say `decimal: ","` in a mapping'
FIELDS = "separate columns by one comma, and write decimals with a point"
FINITE = "give a finite number, or an empty field for a gap"
CLOCK = "`time: {column: …, unit: …}` or `interval: 10 s`"
UTF8 = "is not UTF-8 text; save it as CSV in UTF-8"
TIME = "has no time column; name one `time [s]`, `time [min]` or `time [h]`"
START = "give a temperature like `22 degC`, `{housing: 24 degC, others: 22 degC}` or `steady`"
KEEP = "keep or map one of them"
ORDER = "give rows in the order of time, each time once"
FOREIGN = 'sample,T_amb,utc,Q1\n0,20,a_b,0\n1,,"c,d",100\n2,22,d,50\n3,,e,\n'
needs_shared = pytest.mark.skipif(not SHARED.is_dir(), reason="the folder shared/ is not beside this repository")


def no_unit(text: str) -> str:
    """What the units say themselves."""
    with pytest.raises(BadNumber) as error:
        unit(text)
    return str(error.value)


def load(folder: Path, text: str | bytes, name: str = "r.csv") -> Recording:
    path = folder / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return Recording.load(path)


def mapped(folder: Path, text: str) -> Recording:
    (folder / "f.csv").write_text(FOREIGN)
    return load(folder, f"recording: x\nfile: f.csv\n{text}", "m.yaml")


@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_a_csv_in_si_with_gaps(tmp_path: Path, ends: str, mark: str) -> None:
    text = mark + "time [min],speed [rpm],T [degF],door [1],level [%]\n5,60,50,0,50\n6,,nan,1,\n7, ,NaN,,0\n"
    recording = load(tmp_path, text.replace("\n", ends))
    assert (recording.name, recording.file) == ("r", str(tmp_path / "r.csv"))
    assert list(recording.t) == [300.0, 360.0, 420.0] and recording.start is None
    expected = {"speed": [2 * math.pi, np.nan, np.nan], "T": [10, np.nan, np.nan], "door": [0, 1, np.nan]}
    for name, values in {**expected, "level": [0.5, np.nan, 0]}.items():
        np.testing.assert_allclose(recording.measured(name).values, values)
    assert recording.measured("T").unit == "degF"


@pytest.mark.parametrize("quoted", [False, True])
def test_what_is_written_is_read_again(tmp_path: Path, quoted: bool) -> None:
    random = np.random.default_rng(1)
    t = np.cumsum(random.uniform(0.1, 1, 500)) + 1e6 / 3
    T, dz = random.normal(22, 5, 500), random.normal(0, 1e-5, 500)
    T[7] = np.nan
    write_csv(tmp_path / "w.csv", t, {"T, inside": ("degC", T), "dz": ("um", dz), "speed": ("rpm", abs(T))})
    text = (tmp_path / "w.csv").read_text()
    assert text.startswith('time [s],"T, inside [degC]",dz [um],speed [rpm]\n')
    again = load(tmp_path, text.replace(f"\n{t[1]!r},", f'\n"{t[1]!r}",') if quoted else text)
    assert np.array_equal(again.t, t)
    for name, values in {"T, inside": T, "dz": dz, "speed": abs(T)}.items():
        np.testing.assert_allclose(again.measured(name).values, values, rtol=6e-7)


def test_writing_replaces_the_whole_file_or_nothing(tmp_path: Path) -> None:
    t = np.array([0.0, 10.0])
    write_csv(tmp_path / "w.csv", t, {"T": ("degC", t)})
    assert (tmp_path / "w.csv").read_text() == "time [s],T [degC]\n0,0\n10,10\n"
    assert os.listdir(tmp_path) == ["w.csv"]
    with pytest.raises(Refused, match="cannot be written: No such file or directory; give a folder that exists"):
        write_csv(tmp_path / "none" / "w.csv", t, {})


@pytest.mark.speed
def test_large_files_are_quick(tmp_path: Path) -> None:
    t, values = np.arange(28801) * 10.0, np.random.default_rng(0).normal(22, 3, (10, 28801))
    begin = time.process_time()
    write_csv(tmp_path / "w.csv", t, {f"T{k}": ("degC", column) for k, column in enumerate(values)})
    assert len(Recording.load(tmp_path / "w.csv").t) == len(t)
    assert time.process_time() - begin < 1.5


def test_inputs_of_a_mapping(tmp_path: Path) -> None:
    text = 'columns: {T_amb: "ambient [degC]", Q1: "level [%]"}\ninterval: 2 min\ninputs: {speed: 60 rpm}\n'
    recording = mapped(tmp_path, text + "start: steady\nfill: {ambient: linear, level: hold}\n")
    assert (recording.name, recording.file, recording.start) == ("x", str(tmp_path / "m.yaml"), Start(steady=True))
    schedule = recording.schedule(["ambient", "level", "speed"])
    assert list(schedule.t) == [0, 120, 240, 360] and schedule.start == Start(steady=True)
    halfway = schedule.t + 60
    assert list(schedule.signals["ambient"].at(halfway)) == [20.5, 21.5, 22, 22]
    assert list(schedule.signals["level"].at(halfway)) == [0, 1, 0.5, 0.5]
    assert list(schedule.signals["speed"].at(halfway)) == pytest.approx([2 * math.pi] * 4)


@pytest.mark.parametrize(("unit_text", "values", "is_held"), [
    ("A", [0, 0, 0, 2, 2, 2, 2, 1, 1], True), ("W", [5, 5, 5, 5], True), ("A", [0, 0.3, 0.9, 0.9, 1.4, 1.2], False),
    ("degC", [20, 20, 20, 21, 21, 21], False), ("rpm", [0, 1, 2, 3], True),
])  # fmt: skip
def test_a_power_or_current_that_is_set_in_steps_holds(unit_text: str, values: list[float], is_held: bool) -> None:
    t = np.arange(len(values)) * 10.0
    recording = Recording("r", "r.csv", t, {"Q": Column("Q", unit_text, np.array(values, float))})
    assert recording.signal("Q").is_held == is_held


def test_a_mapping_says_how_it_runs_between_samples(tmp_path: Path) -> None:
    columns = 'columns: {sample: "time [h]", T_amb: "ambient [degC]", Q1: "level [%]"}\n'
    ways = "fill: {ambient: hold, level: linear}\nbetween: {ambient: held, level: linear}"
    recording = mapped(tmp_path, columns + ways)
    t = np.array([1800.0, 5400.0, 9000.0])
    assert list(recording.signal("ambient").at(t)) == [20, 20, 22]
    assert list(recording.signal("level").at(t)) == [0.5, 0.75, 0.5]


CSV_FAULTS = [
    ("", f": is empty; {FIRST_ROW}"),
    ("\n \n", f": is empty; {FIRST_ROW}"),
    (HEAD, ": has a header and no values; give at least two rows below the header"),
    (HEAD + "0,1,2\n\n", ": has only one row of values; give at least two rows below the header"),
    ((HEAD + "0,1,2\n1,2,°\n").encode("latin-1"), f":3: column 'T [degC]' has the text '°'; {NUMBER}"),
    (HEAD.encode("utf-16-le"), f":1: {UTF8}"),
    ("t [s],T [K]\n0,1\n1,2\n", f":1: {TIME}"),
    ("Time [s],a [1]\n0,1\n1,2\n", f":1: {TIME} (did you mean 'Time [s]'?)"),
    ("time [m],a [1]\n0,1\n1,2\n", ":1: column 'time [m]': time is in m; give it in s, min or h"),
    ("time [s],speed\n0,1\n1,2\n", ":1: column 'speed': has no unit; write `speed [unit]`, as in `speed [rpm]`"),
    ("time [s],T (°C)\n0,1\n1,2\n", ":1: column 'T (°C)': has no unit; write `T [unit]`, as in `T [degC]`"),
    ("time [s],T [foo]\n0,1\n1,2\n", f":1: column 'T [foo]': {no_unit('foo')}"),
    ("time [s],T [K],T [degC]\n0,1,2\n1,2,3\n", f":1: the column 'T' is there 2 times; {KEEP}"),
    (HEAD + "0,1,2\n1,off,2\n", f":3: column 'speed [rpm]' has the text 'off'; {NUMBER}"),
    (HEAD + "0,1,2\n1,1_0,2\n", f":3: column 'speed [rpm]' has the text '1_0'; {NUMBER}"),
    (HEAD + '0,1,2\n1,2,"21,5"\n', f":3: column 'T [degC]' has the text '21,5'; {COMMA}"),
    (HEAD + "0,1,2\n1,2,21,5\n", f":3: has 4 fields, the header has 3; {FIELDS}"),
    (HEAD + "0,1,2\n1,2\n", ":3: has 2 fields, the header has 3; keep the comma of an empty field"),
    (HEAD + '0,1,2\n1,2,"3\n"\n', ":3: has a line break inside of quotes; keep a row in one line"),
    (HEAD + "0,1,2\n1,-inf,3\n", f":3: column 'speed [rpm]' is infinite; {FINITE}"),
    (HEAD + "0,1,2\n,2,3\n2,3,4\n", ":3: has no time; give every row a time"),
    (HEAD + "0,1,2\n20,2,3\n10.5,3,4\n", f":4: the time goes back from 20 s to 10.5 s; {ORDER}"),
    (HEAD + "0,1,2\n20,2,3\n20,3,4\n", f":4: the time 20 s stands twice; {ORDER}"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "message"), CSV_FAULTS)
def test_refused_csv_files_as_the_user_reads_it(tmp_path: Path, text: str | bytes, message: str) -> None:
    with pytest.raises(Refused) as refused:
        load(tmp_path, text)
    assert str(refused.value) == f"{tmp_path / 'r.csv'}{message}"


def test_all_faults_are_told_and_of_many_the_first(tmp_path: Path) -> None:
    with pytest.raises(Refused) as refused:
        load(tmp_path, HEAD + "0,a,b\n0,1,inf\n-1,2\n5,6,7\n")
    assert [refusal.spot.line for refusal in refused.value.refusals] == [2, 2, 3, 4]
    with pytest.raises(Refused) as refused:
        load(tmp_path, HEAD + "".join(f"{k},x,1\n" for k in range(1000)))
    like = "column 'speed [rpm]' has the text 'x' (999 more rows like it, the last in line 1001)"
    assert str(refused.value) == f"{tmp_path / 'r.csv'}:2: {like}; {NUMBER}"


def test_files_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(Refused, match=r"a.csv: there is no such file; give the path of a recording"):
        Recording.load(tmp_path / "a.csv")
    with pytest.raises(Refused, match=r"is not a file; give the path of a recording"):
        Recording.load(tmp_path)
    (tmp_path / "big.csv").touch()
    os.truncate(tmp_path / "big.csv", 501_000_000)
    with pytest.raises(Refused, match=r"big.csv: has 501 MB, more than 500 MB; split it, or take fewer samples"):
        Recording.load(tmp_path / "big.csv")
    with pytest.raises(Refused, match=r"ggg.csv: there is no such file; give the path of a recording"):
        Recording.load(tmp_path / f"{'g' * 300}.csv")


SWITCH = "only a switch (0 or 1) goes without"
AMBIENT = 'columns: {T_amb: "ambient [degC]"}\n'
TIMED = AMBIENT + "interval: 1 s\n"
TWO = "the recording goes from 0 s to 3 s, keep at least two samples"
MAPPING_FAULTS = [
    (TIMED + "intervall: 1 s", "5: the mapping has an unknown key 'intervall'; did you mean 'interval'?"),
    ("interval: 1 s", "1: the mapping has no `columns`; add `columns: {theirs: \"ours [unit]\"}`"),
    ("columns: {}\ninterval: 1 s", "3: columns: is not a mapping of names; write `columns: {name: …}`"),
    (AMBIENT, f'3: no column is mapped to time; map one to "time [s]", or give {CLOCK}'),
    ('columns: {sample: "time [s]"}\ninterval: 1 s', "4: interval is given beside a time column; keep one of them"),
    (AMBIENT + "interval: 0 s", "4: interval: '0 s' is not above zero; give a time above zero"),
    ('columns: {T_am: "T [degC]"}\ninterval: 1 s', "3: the file f.csv has no column 'T_am'; did you mean 'T_amb'?"),
    (
        "columns: {T_amb: ambient}\ninterval: 1 s",
        "3: columns.T_amb: has no unit; write `ambient [unit]`, as in `ambient [degC]`",
    ),
    ('columns: {T_amb: "a [K]", Q1: "a [%]"}\ninterval: 1 s', f"3: the column 'a' is there 2 times; {KEEP}"),
    (TIMED + "inputs: {ambient: 3 K}", "5: the input 'ambient' is a column as well; keep one of them"),
    (TIMED + "fill: {ambent: hold}", "5: fill names 'ambent', which is no column; did you mean 'ambient'?"),
    (TIMED + "between: {ambient: hold}", "5: between.ambient: is 'hold'; write linear or held"),
    (TIMED + "inputs: {n: 8000}", f"5: inputs.n: '8000' has no unit; write it like `8000 rpm`, {SWITCH}"),
    (TIMED + "start: {a: 5 m}", f"5: start.a: '5 m' is in m; {START}"),
    (TIMED + "zero: {ambent: start}", "5: zero names 'ambent', which is no column; did you mean 'ambient'?"),
    (TIMED + "zero: {ambient: end}", "5: zero.ambient: is 'end'; write start"),
    (TIMED + "from: 5", "5: from: '5' has no unit; give a time, like `1 h`"),
    (TIMED + "until: 1 s", f"5: `from` and `until` leave 1 of 4 samples; {TWO}"),
    (TIMED + "from: 1 h", f"5: `from` and `until` leave 0 of 4 samples; {TWO}"),
    (TIMED + "from: 2 s\nuntil: 1 s", f"5: `from` and `until` leave 0 of 4 samples; {TWO}"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "message"), MAPPING_FAULTS)
def test_refused_mappings_as_the_user_reads_it(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(Refused) as refused:
        mapped(tmp_path, text)
    assert str(refused.value) == f"{tmp_path / 'm.yaml'}:{message}"


def test_the_file_behind_a_mapping_is_refused_with_its_own_lines(tmp_path: Path) -> None:
    with pytest.raises(Refused) as refused:
        mapped(tmp_path, 'columns: {sample: "time [s]", utc: "door [1]"}')
    like = "(3 more rows like it, the last in line 5)"
    text = f"{tmp_path / 'f.csv'}:2: column 'utc' has the text 'a_b' {like}; {NUMBER}"
    assert str(refused.value) == text
    with pytest.raises(Refused, match=r"m.yaml:2: file: there is no file '.*g.csv'; give its path relative to the map"):
        load(tmp_path, f"recording: x\nfile: g.csv\n{TIMED}", "m.yaml")
    with pytest.raises(
        Refused, match=r"m.yaml:2: file: there is no file '.*g{300}.csv'; give its path relative to the"
    ):
        load(tmp_path, f"recording: x\nfile: {'g' * 300}.csv\n{TIMED}", "m.yaml")
    (tmp_path / "g.csv").write_text("T_amb,T_amb\n1,2\n2,3\n")
    with pytest.raises(Refused, match=r"m.yaml:3: the column 'T_amb' is there 2 times; keep or map one of them"):
        load(tmp_path, f"recording: x\nfile: g.csv\n{TIMED}", "m.yaml")


def test_inputs_that_are_missing_or_have_gaps(tmp_path: Path) -> None:
    recording = load(tmp_path, "time [s],Speed [rpm],ambient [degC],empty [1]\n0,1,20,\n10,2,,\n20,3,,\n")
    lacks = "the machine needs the input `{0}`, which the recording lacks; "
    lacks += "add a column `{0} [{1}]`, or `inputs: {{{0}: …}}` in a mapping"
    with pytest.raises(Refused) as refused:
        recording.schedule(["speed", "ambient", "door", "empty"])
    fill = "fill them in, or read it through a mapping with `fill: {ambient: linear}` (or hold)"
    file = tmp_path / "r.csv"
    assert str(refused.value).splitlines() == [
        f"{file}: {lacks.format('door', 'unit')}",
        f"{file}: {lacks.format('speed', 'rpm')} (did you mean 'Speed'?)",
        f"{file}:2: the input 'empty' has no value at 3 of 3 times, first at 0 s; give it values, it has none",
        f"{file}:3: the input 'ambient' has no value at 2 of 3 times, first at 10 s; {fill}",
    ]
    with pytest.raises(Refused, match=r"r.csv: the recording 'r' has no column 'ambiant'; did you mean 'ambient'\?"):
        recording.measured("ambiant")


PARTED = 'columns: {sample: "time [h]", z: "dz [um]", n: "speed [rpm]"}\n'
ROWS = "sample,z,n\n" + "".join(f"{k},{44 + k},{100 * k if k != 3 else ''}\n" for k in range(6))


def parted(folder: Path, text: str) -> Recording:
    (folder / "g.csv").write_text(ROWS)
    return load(folder, f"recording: x\nfile: g.csv\n{PARTED}{text}", "m.yaml")


def test_two_mappings_part_a_recording_without_overlap(tmp_path: Path) -> None:
    early, late = parted(tmp_path, "until: 2 h"), parted(tmp_path, "from: 120 min")
    assert early.t.tolist() == [0, 3600] and late.t.tolist() == [7200, 10_800, 14_400, 18_000]
    assert early.measured("dz").values * 1e6 == pytest.approx([44, 45])
    assert late.measured("dz").values * 1e6 == pytest.approx([46, 47, 48, 49])
    assert len(parted(tmp_path, "from: 1 h\nuntil: 4 h").t) == 3


def test_a_zeroed_channel_begins_at_zero_where_the_part_begins(tmp_path: Path) -> None:
    late = parted(tmp_path, "from: 2 h\nzero: {dz: start}")
    assert late.measured("dz").values * 1e6 == pytest.approx([0, 1, 2, 3])
    assert np.isnan(late.measured("speed").values[1]), "other channels stay as they are"
    with pytest.raises(Refused, match=r"g.csv:5: the input 'speed' has no value at 1 of 4 times, first at 10800 s"):
        late.schedule(["speed"])


@needs_shared
def test_cases_are_read_as_they_are() -> None:
    recording = Recording.load(SHARED / "cases" / "a-cooler" / "train1.csv")
    assert list(recording.columns)[:3] == ["speed", "ambient", "T_shaft_nose"]
    assert len(recording.t) == 1081 and recording.t[-1] == 10800
    assert recording.measured("dy").values[:2] == pytest.approx([-0.1e-6, -0.3e-6])


@needs_shared
@pytest.mark.parametrize(
    ("file", "columns", "rows"),
    [
        ("building-darkgrey/first26days.csv", 'time_s: "time [s]", T_outdoor_C: "ambient [degC]"', 624),
        ("voron-frame/run_2021-06-13_05-41.csv", 'time_s: "time [s]", z_um: "dz [um]"', 1203),
        ("tclab-apm/mhe.csv", 'time_s: "time [s]", Q1_pct: "Q1 [%]"', 200),
        ("toaster-oven/heating_full_power.csv", 'time_s: "time [s]", T_air_C: "T_air [degC]"', 1124),
    ],
)
def test_real_recordings_through_a_mapping(tmp_path: Path, file: str, columns: str, rows: int) -> None:
    path = SHARED / "recordings" / file
    recording = load(tmp_path, f"recording: real\nfile: {path}\ncolumns: {{{columns}}}\n", "m.yaml")
    assert len(recording.t) == rows and len(recording.columns) == 1


@needs_shared
def test_the_lathe_has_no_times(tmp_path: Path) -> None:
    path = SHARED / "recordings" / "ace-lathe" / "day01.csv"
    columns = 'columns: {T_ambient_C: "ambient [degC]", dia_disp: "dx [um]"}\ninterval: 120 s\n'
    recording = load(tmp_path, f"recording: day 1\nfile: {path}\n{columns}", "m.yaml")
    assert recording.t[-1] == 206 * 120 and recording.signal("ambient").start[0] == 19.14
