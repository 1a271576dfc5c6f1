"""Pages of results: readable as they stand, safe for any name, small, and what their script does when asked.

The script runs in node on the document of the page (page_dom.js); in a browser: test_page_browser.py."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import build as small
import numpy as np
import pytest
from diagnosed import diagnosed
from fits import recorded, speeds, two_blocks

from network import Machine, compare, simulate
from network.analysis.calibration.calibrate import calibrate
from network.cli import main
from network.engine.superposition.superpose import superpose
from network.recordings.inputs import constant
from network.report.files.diagnosis_files import write_diagnosis
from network.report.pages.chart import POINTS, Chart, Line, Plot, tell_chart
from network.report.pages.chart_page import Page, Table, fill_page
from network.report.pages.chart_svg import find_ticks
from network.report.pages.result_pages import page_of_calibration, page_of_comparison, page_of_run

ROOT = Path(__file__).parents[1]
NODE = shutil.which("node")
needs_node = pytest.mark.skipif(NODE is None, reason="node is not installed: the script of pages is not run")
VOID = {"meta", "br", "img", "hr", "input", "link"}
HOSTILE = "</script><img src=x onerror=alert(1)>&\"'`{{7*7}}"
"""A name that would end a script, open a tag, leave an attribute, and be a template."""


# -- reading a page -------------------------------------------------------------------------------------------------
class Reader(HTMLParser):
    """The tree of a page, as page_dom.js builds it."""

    def __init__(self) -> None:
        super().__init__()
        self.root: dict[str, Any] = {"tag": "root", "attributes": {}, "children": []}
        self.open = [self.root]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        node = {"tag": tag, "attributes": {k: v or "" for k, v in attrs}, "children": []}
        self.open[-1]["children"].append(node)
        if tag not in VOID:
            self.open.append(node)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.open[-1]["children"].append({"tag": tag, "attributes": {k: v or "" for k, v in attrs}, "children": []})

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop()["tag"] == tag

    def handle_data(self, data: str) -> None:
        self.open[-1]["children"].append(data)


def tree_of(page: str) -> dict[str, Any]:
    reader = Reader()
    reader.feed(page)
    assert reader.open == [reader.root], "every element is closed"
    return reader.root


def nodes(tree: Mapping[str, Any], tag: str = "") -> list[dict[str, Any]]:
    found = []
    for child in tree["children"]:
        if isinstance(child, dict):
            found += [child] * (not tag or child["tag"] == tag) + nodes(child, tag)
    return found


def text_of(tree: Mapping[str, Any]) -> str:
    return "".join(child if isinstance(child, str) else text_of(child) for child in tree["children"])


def script_of(page: str) -> str:
    (script,) = (node for node in nodes(tree_of(page), "script") if "type" not in node["attributes"])
    return text_of(script)


def in_node(page: str, *steps: Mapping[str, Any], width: int = 960) -> list[list[dict[str, Any]]]:
    """What stands in every run of the page after its script ran, and after each step."""
    assert NODE is not None
    given = {"tree": tree_of(page), "script": script_of(page), "steps": list(steps), "width": width}
    words = [NODE, str(ROOT / "tests" / "page_dom.js")]
    done = subprocess.run(words, input=json.dumps(given), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return list(json.loads(done.stdout))


# -- pages ----------------------------------------------------------------------------------------------------------
def two_runs() -> Sequence[Any]:
    machine = two_blocks()
    return machine, [recorded(machine, speeds(*steps), seed) for seed, steps in enumerate((((0, 6000),), ((0, 2000),)))]


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """A page of every command."""
    machine, recordings = two_runs()
    off = machine.patched({"links": {"skin": {"kind": "convection", "between": ["body", "air"],
                                              "conductance": "9 W/K ± 30 %"}}})  # fmt: skip
    run = simulate(machine, speeds((0, 6000), (2, 0)))
    folder = tmp_path_factory.mktemp("pages")
    write_diagnosis(diagnosed(folder), folder / "found", pictures=False)
    gantry = str(ROOT / "machines" / "gantry_spindle.yaml")
    main_quietly("iso230", gantry, "spindle_constant", "-o", str(folder / "iso"), "--page")
    return {
        "simulate": page_of_run(run, superpose(run)),
        "compare": page_of_comparison(compare(off, recordings)),
        "calibrate": page_of_calibration(calibrate(off, recordings[:1], recordings[1:])),
        "diagnose": (folder / "found" / "report.html").read_text(encoding="utf-8"),
        "iso230": (folder / "iso" / "report.html").read_text(encoding="utf-8"),
    }


def main_quietly(*words: str) -> int:
    try:
        main(list(words))
    except SystemExit as leave:
        return int(leave.code or 0)
    return 0


EACH = ("simulate", "compare", "calibrate", "diagnose", "iso230")


@pytest.mark.parametrize("name", EACH)
def test_a_page_stands_alone_and_is_small(pages: dict[str, str], name: str) -> None:
    page = pages[name]
    tree = tree_of(page)
    fetched = [n["attributes"].get(key, "data:") for n in nodes(tree) for key in ("src", "href", "srcset", "action")]
    assert all(address.startswith("data:") for address in fetched)
    assert "http:" not in page and "https:" not in page and "@import" not in page and "url(" not in page
    bare = re.sub(r"base64,[A-Za-z0-9+/=]*", "", page)
    assert len(bare.encode()) < 700_000, "less than a picture or two"


@pytest.mark.parametrize("name", EACH)
def test_it_reads_without_its_script(pages: dict[str, str], name: str) -> None:
    """Every run drawn, its axes told, tables and sentences in the text."""
    tree = tree_of(pages[name])
    figures = [n for n in nodes(tree, "figure") if n["attributes"].get("class") == "run"]
    assert figures
    for figure in figures:
        (drawing,) = (n for n in nodes(figure, "svg") if n["attributes"].get("class") == "drawing")
        lines = nodes(drawing, "path")
        assert lines and all(len(line["attributes"]["d"]) > 10 for line in lines)
        assert "time [" in text_of(drawing) and drawing["attributes"]["aria-label"]
        dead = [node for node in nodes(figure) if node["tag"] in ("button", "input", "select")]
        assert not dead, "nothing to press that does nothing"
    assert nodes(tree, "table") and nodes(tree, "h1")


@pytest.mark.parametrize("name", EACH)
def test_only_its_own_script_may_run(pages: dict[str, str], name: str) -> None:
    digest = base64.b64encode(hashlib.sha256(script_of(pages[name]).encode()).digest()).decode()
    (policy,) = (n for n in nodes(tree_of(pages[name]), "meta") if "http-equiv" in n["attributes"])
    assert policy["attributes"]["content"].endswith(f"script-src 'sha256-{digest}'")
    assert "default-src 'none'" in policy["attributes"]["content"]
    head = pages[name].partition("<body>")[0]
    assert head.index("Content-Security-Policy") < head.index("<style>")


# -- names ----------------------------------------------------------------------------------------------------------
GROWS = {"length": "1 m", "expansion": "1e-5 1/K", "direction": 1}


def hostile_machine() -> Machine:
    nodes_ = {HOSTILE: {"heat_capacity": "4 kJ/K"}, "air": {"temperature": "ambient"}}
    return small.machine(
        nodes_, machine=HOSTILE,
        links={HOSTILE: {"kind": "convection", "between": [HOSTILE, "air"], "conductance": "4 W/K ± 30 %"}},
        sources={HOSTILE: {"kind": "heat_source", "into": {HOSTILE: 1}, "power": "60 W"}},
        tcp={"z": {HOSTILE: {"kind": "stretching", "of": HOSTILE, **GROWS}}},
        sensors={HOSTILE: {"measures": HOSTILE, "noise": "0.05 K"}},
    )  # fmt: skip


def hostile_pages() -> dict[str, str]:
    machine = hostile_machine()
    schedule = small.schedule(np.arange(0.0, 3601.0, 30.0), constant("ambient", "degC", 20.0))
    recording = replace(recorded(machine, schedule, 1), name=HOSTILE, file=HOSTILE)
    run = simulate(machine, replace(schedule, name=HOSTILE))
    return {
        "simulate": page_of_run(run, superpose(run)), "compare": page_of_comparison(compare(machine, [recording])),
        "calibrate": page_of_calibration(calibrate(machine, [recording])),
    }  # fmt: skip


def test_hostile_names_are_text() -> None:
    for name, page in hostile_pages().items():
        tree = tree_of(page)
        assert not nodes(tree, "img"), name
        assert not any(key.startswith("on") for node in nodes(tree) for key in node["attributes"])
        assert HOSTILE in text_of(next(iter(nodes(tree, "h1")))), "told as it is"
        scripts = [n for n in nodes(tree, "script") if n["attributes"].get("type") == "application/json"]
        data = [json.loads(text_of(n)) for n in scripts]
        assert data and any(HOSTILE in line["key"] for plot in data[0]["plots"] for line in plot["lines"])
        assert page.count("</script>") == len(data) + 1 and "49" not in text_of(next(iter(nodes(tree, "h1"))))


@needs_node
def test_hostile_names_stay_text_when_the_script_has_run() -> None:
    for page in hostile_pages().values():
        after = in_node(page, {"key": "ArrowRight"}, {"toggle": HOSTILE}, {"toggle": HOSTILE})
        assert all("img" not in run["tags"] for seen in after for run in seen)
        assert any(HOSTILE in text for text in after[1][0]["readout"])


def test_a_unit_and_a_table_of_any_text_are_text() -> None:
    t = np.array([0.0, 1.0])
    odd = f"{HOSTILE}\u2028"
    chart = Chart(odd, [Plot(odd, "1", [Line(odd, odd, t, t, "#000000")])])
    tables = [Table([odd], [[odd]], odd)]
    page = fill_page(Page(odd, [odd], tables, [odd], [chart], odd, odd))
    tree = tree_of(page)
    assert not nodes(tree, "img") and text_of(tree).count(odd) >= 8
    assert "<" not in tell_chart(chart) and "\u2028" not in tell_chart(chart)


# -- what the script does -------------------------------------------------------------------------------------------
LAMP = np.arange(0.0, 7201.0, 60.0)


def ramps() -> str:
    """Two runs: a ramp of 1 K/h from 20 °C, and the same from 30 °C; a second channel in µm with a gap."""
    gap = np.where((LAMP > 3000) & (LAMP < 3600), np.nan, LAMP / 720)
    return fill_page(Page("ramps", [], charts=[
        Chart(name, [
            Plot("temperature", "degC", [Line("T", "T", LAMP, start + LAMP / 3600, "#0072B2")]),
            Plot("movement", "um", [Line("dz", "dz", LAMP, gap, "#D55E00")]),
        ]) for name, start in (("one", 20), ("two", 30))
    ]))  # fmt: skip


@needs_node
def test_values_under_the_pointer_and_the_keys() -> None:
    """The middle of two hours is 60 min (the clock is in minutes): 21 °C and 5 µm; the gap shows no value."""
    middle = 66 + (960 - 66 - 12) / 2
    seen = in_node(ramps(), {"move": middle}, {"key": "ArrowLeft", "shift": True}, {"key": "Home"}, {"key": "End"})
    assert seen[1][0]["readout"] == ["60 min", "T 21 °C", "dz 5 µm"] and seen[1][0]["spoken"] == "off"
    assert seen[2][0]["readout"] == ["48 min", "T 20.8 °C", "dz 4 µm"] and seen[2][0]["spoken"] == "polite"
    assert seen[3][0]["readout"][1] == "T 20 °C" and seen[4][0]["readout"][1] == "T 22 °C"
    in_gap = in_node(ramps(), {"move": 66 + (960 - 66 - 12) * 55 / 120})[1][0]["readout"]
    assert len(in_gap) == 2 and in_gap[1].startswith("T 20.9")
    assert seen[0][0]["focus"] == "0"


@needs_node
def test_zoom_by_buttons_keys_and_dragging() -> None:
    seen = in_node(ramps(), {"click": "zoom in"}, {"click": "whole run"}, {"drag": [507, 728]}, {"key": "0"},
                   {"key": "+"}, {"key": "-"})  # fmt: skip
    whole, near, again, dragged, back, closer, out = ([float(t) for t in step[0]["times"]] for step in seen)
    assert (whole[0], whole[-1]) == (0, 120) == (again[0], again[-1]) == (back[0], back[-1]) == (out[0], out[-1])
    assert near[0] >= 30 and near[-1] <= 90 and closer == near
    assert dragged[0] >= 60 and dragged[-1] <= 91
    assert "21.4" in seen[3][0]["ticks"], "its axis follows"


@needs_node
def test_channels_and_runs_are_switched() -> None:
    seen = in_node(ramps(), {"toggle": "T"}, {"move": 500}, {"toggle": "T"}, {"choose": 1}, {"move": 507})
    assert [run["hidden"] for run in seen[0]] == [False, True] and seen[0][0]["boxes"] == 2
    assert seen[0][0]["labels"] == ["temperature [°C]", "movement [µm]"] and seen[0][0]["lines"] == 2
    assert seen[1][0]["labels"] == ["movement [µm]"]
    assert all(not text.startswith("T ") for text in seen[2][0]["readout"])
    assert seen[3][0]["lines"] == 2
    assert [run["hidden"] for run in seen[4]] == [True, False]
    assert seen[5][1]["readout"][1] == "T 31 °C"


@needs_node
@pytest.mark.parametrize("width", [320, 1400])
def test_it_is_drawn_for_the_width_there_is(width: int) -> None:
    """On a narrow screen letters keep their size, and fewer times stand below."""
    (first, *_), *_ = in_node(ramps(), width=width)
    assert first["viewBox"].split()[2] == str(width)
    xs = [float(x) for d in first["paths"] for x in re.findall(r"[ML](-?[0-9.]+) ", d)]
    assert min(xs) >= 66 - 0.1 and max(xs) <= width - 12 + 0.1
    assert len(first["times"]) == {320: 5, 1400: 13}[width]


@needs_node
@pytest.mark.parametrize("name", EACH)
def test_the_script_runs_on_every_page(pages: dict[str, str], name: str) -> None:
    seen = in_node(pages[name], {"key": "ArrowRight"}, {"click": "zoom in"}, {"key": "Escape"})
    shown = next(run for run in seen[1] if not run["hidden"])
    assert len(shown["readout"]) > 1 and shown["lines"] > 1
    assert not any("NaN" in path or "undefined" in path for run in seen[2] for path in run["paths"])


# -- charts as data -------------------------------------------------------------------------------------------------
def test_long_lines_are_thinned_and_keep_their_peaks() -> None:
    t = np.arange(0.0, 100_000.0)
    values = np.sin(t / 5000)
    values[50_000] = 9.0
    values[70_000:70_100] = np.nan
    told = json.loads(tell_chart(Chart("long", [Plot("it", "1", [Line("a", "a", t, values, "#000000")])])))
    (line,) = told["plots"][0]["lines"]
    assert len(line["t"]) == len(line["v"]) <= POINTS and max(v for v in line["v"] if v is not None) == 9
    assert None in line["v"] and told["clock"] == "h" and told["end"] == pytest.approx(99_999 / 3600)


def test_a_line_of_nothing_is_a_line_of_nothing() -> None:
    t = np.arange(0.0, 60.0)
    for values, shown in ((np.full(60, np.nan), None), (np.zeros(60), 0), (np.full(60, 21.5), 21.5)):
        told = json.loads(tell_chart(Chart("long", [Plot("it", "1", [Line("a", "a", t, values, "#000000")])])))
        assert {*told["plots"][0]["lines"][0]["v"]} == {shown}


def test_many_runs_of_many_channels_stay_a_page() -> None:
    t = np.arange(0.0, 36_000.0, 10.0)
    noisy = np.random.default_rng(1).standard_normal(len(t))
    lines = [Line(f"T{i}", f"T{i}", t, 20 + i + noisy, "#000000") for i in range(3)]
    charts = [Chart(f"run {k}", [Plot(f"T{i}", "degC", lines) for i in range(20)]) for k in range(12)]
    page = fill_page(Page("many", [], charts=charts))
    assert len(page.encode()) < 2_000_000 and page.count('class="line"') == 720


def test_ticks_are_round() -> None:
    assert find_ticks(0.3, 9.7) == [2, 4, 6, 8]
    assert find_ticks(-0.013, 0.021) == pytest.approx([-0.01, 0, 0.01, 0.02])


def test_numbers_stand_to_the_right_with_a_true_minus() -> None:
    """A column of words, also of words that hold numbers, stands to the left; nothing has no sign."""
    rows = [["z [µm]", "-14.62", "housing (−11 at 134 min)", "–"], ["y [µm]", "-0.00", "-", "3 of 4"]]
    page = fill_page(Page("signs", [], [Table(["axis", "max", "from", "seen"], rows)]))
    cells = [(text_of(n), n["attributes"].get("class", "")) for n in nodes(tree_of(page), "td")]
    assert cells[:4] == [("z [µm]", ""), ("−14.62", "number"), ("housing (−11 at 134 min)", ""), ("–", "number")]
    assert cells[5] == ("0.00", "number") and cells[7] == ("3 of 4", "number")


def test_an_empty_page_has_no_script() -> None:
    page = fill_page(Page("nothing", ["No chart."]))
    assert "<script" not in page.partition("<body>")[2] and "No chart." in page


# -- the commands ---------------------------------------------------------------------------------------------------
def test_a_page_is_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    blocks, steps = (str(ROOT / folder / name) for folder, name in (
        ("machines", "two_blocks.yaml"), ("scenarios", "constant_8000.yaml")))  # fmt: skip
    out = tmp_path / "run"
    assert main_quietly("simulate", blocks, steps, "-o", str(out), "--no-plots", "--noise", "--page") == 0
    assert "report.html" in capsys.readouterr().out and (out / "report.html").is_file()
    assert main_quietly("simulate", blocks, steps, "-o", str(out), "--no-plots", "--noise") == 0
    assert not (out / "report.html").exists(), "a page of another run does not stay"
    record = str(out / "results.csv")
    assert main_quietly("compare", blocks, record, "--page") == 2
    assert "--page: has no folder to stand in; name one with -o DIR" in capsys.readouterr().err
    assert main_quietly("compare", blocks, record, "-o", str(tmp_path / "beside"), "--page") == 0
    assert (tmp_path / "beside" / "report.html").is_file()
    assert main_quietly("calibrate", blocks, record, "-o", str(tmp_path / "fit"), "--no-plots", "--page") == 0
    made = {p.name for p in (tmp_path / "fit").iterdir()}
    assert made == {"machine.calibrated.yaml", "calibration.json", "report.html"}
