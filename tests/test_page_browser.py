"""Pages of results in a headless Chromium: what stands there, keyboard, pointer, narrow screens, print, no script.

A hand is imitated (keys go to what has the focus, the pointer to what lies under it); nothing may be logged.
"""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from browser import NAMES, Browser, find_browser, opened
from test_pages import EACH, HOSTILE, ROOT, hostile_pages, main_quietly, nodes, pages, ramps, text_of, tree_of

from network import Machine, Scenario, simulate
from network.recordings.csv_table import write_csv
from network.report.pages.chart import Chart, Line, Plot
from network.report.pages.chart_page import Page, Table, fill_page

__all__ = ["pages"]
PROGRAM = find_browser()
pytestmark = pytest.mark.skipif(
    PROGRAM is None, reason=f"no browser is found (LPTN_BROWSER, {', '.join(NAMES)}): pages are not shown in one"
)
WIDTHS = (320, 390, 768, 1280)
"""A small and a usual phone, a tablet upright, a desk [px]."""
A4 = 680
"""Width of A4 less margins of 15 mm, at 96 px an inch."""
SHEET = 940
"""Height of a letter sheet less the same margins, the lower of the two usual ones [px]."""

BESIDE = """(() => {
  const wide = document.documentElement.clientWidth, out = [];
  for (const e of document.querySelectorAll("body *")) {
    const box = e.getBoundingClientRect(), scrolled = MODE === "screen" && e.closest(".scroll, pre");
    if (box.width && !scrolled && (box.right > wide + 1 || box.left < -1)) out.push(e.tagName + " " + e.textContent);
  }
  return out.slice(0, 5);
})()"""
"""What stands beyond the left or right edge, but for what scrolls by itself."""
COLLIDING = """(() => {
  const out = [];
  for (const svg of document.querySelectorAll(".run:not([hidden]) .drawing")) {
    const boxes = [...svg.querySelectorAll("text")].map(e => [e.textContent, e.getBoundingClientRect()]);
    boxes.forEach(([a, p], i) => boxes.slice(i + 1).forEach(([b, q]) => {
      if (p.right > q.left + 1 && q.right > p.left + 1 && p.bottom > q.top + 2 && q.bottom > p.top + 2)
        out.push(a + " over " + b);
    }));
  }
  return out.slice(0, 5);
})()"""
"""Words of charts that lie over each other."""


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    assert PROGRAM is not None
    with opened(PROGRAM, tmp_path_factory.mktemp("browser") / "profile") as running:
        yield running


@pytest.fixture(scope="module")
def files(pages: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("shown")
    for name, text in {**pages, "ramps": ramps(), "wide": wide_page()}.items():
        (folder / f"{name}.html").write_text(text, encoding="utf-8")
    return {path.stem: path for path in folder.iterdir()}


LONG = "sources.front_bearing_of_the_main_spindle_with_a_name_that_has_no_place_to_break.conductance"


def wide_page() -> str:
    """More than a phone has room for: many columns, a name without a place to break, twelve channels."""
    t = np.linspace(0, 36_000, 200)
    lines = [Line(f"{LONG}{i}", f"{LONG}{i}", t, 1e4 * np.sin(t / 3000 + i), "#0072B2") for i in range(12)]
    table = Table(["number", *(f"column {i}" for i in range(9))], [[LONG, *["−1234.5 ± 67.8 W/K"] * 9]])
    return fill_page(Page(LONG, [LONG], [table], [LONG], [Chart(LONG, [Plot(LONG, "W/K", lines)])]))


# -- content --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", EACH)
def test_it_shows_what_it_holds_and_logs_nothing(browser: Browser, files: dict[str, Path], name: str) -> None:
    browser.show(files[name])
    seen = browser.tell("document.body.innerText")
    written = tree_of(files[name].read_text(encoding="utf-8"))
    (title,) = nodes(written, "h1")
    assert text_of(title) in seen
    for cell in (each for table in nodes(written, "table") for tag in ("th", "td") for each in nodes(table, tag)):
        assert " ".join(text_of(cell).split()) in " ".join(seen.split())
    runs = browser.tell("[...document.querySelectorAll('.run')].filter(e => e.offsetHeight).length")
    assert runs == 1, "one run at a time"
    drawn = browser.tell("[...document.querySelectorAll('.run:not([hidden]) .line')].map(e => e.getBBox().width)")
    assert drawn and all(width > 1 for width in drawn)
    assert browser.tell(COLLIDING) == [] and browser.said == []


@pytest.mark.parametrize("name", EACH)
def test_without_a_script_all_is_drawn(browser: Browser, files: dict[str, Path], name: str) -> None:
    browser.show(files[name], script=False)
    figures = browser.tell("[...document.querySelectorAll('.run')].map(e => e.querySelectorAll('.line').length)")
    assert figures and all(figures) and browser.tell("document.querySelectorAll('button, input').length") == 0
    assert browser.tell(BESIDE.replace("MODE", "'screen'")) == [] and browser.tell(COLLIDING) == []
    assert browser.said == []


@pytest.mark.parametrize("name", EACH)
def test_an_input_is_drawn_from_corner_to_corner(browser: Browser, files: dict[str, Path], name: str) -> None:
    """A speed that stays for hours is no pause between two samples: every input is one line over the whole run."""
    browser.show(files[name])
    lines = browser.tell("""[...document.querySelectorAll(".run:not([hidden]) .chart-data")].flatMap(data =>
      JSON.parse(data.textContent).plots.filter(plot => plot.height === 80).flatMap(plot => plot.lines))""")
    assert lines and all(None not in line["v"] for line in lines)
    assert all(line["t"][0] == 0 and line["t"][-1] > 0 for line in lines)


# -- narrow screens -------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", [*EACH, "wide"])
@pytest.mark.parametrize("width", WIDTHS)
def test_nothing_stands_beside_the_screen(browser: Browser, files: dict[str, Path], name: str, width: int) -> None:
    browser.show(files[name], width, 800, touch=width < 768)
    assert browser.tell("document.scrollingElement.scrollWidth") <= width
    assert browser.tell(BESIDE.replace("MODE", "'screen'")) == []
    assert browser.tell(COLLIDING) == []
    sizes = browser.tell("[...document.querySelectorAll('.run:not([hidden]) .tick')].map(e => "
                         "e.getBoundingClientRect().height)")  # fmt: skip
    assert min(sizes) >= 10, "letters keep their size [px]"


def test_a_window_that_is_made_narrow_is_drawn_anew(browser: Browser, files: dict[str, Path]) -> None:
    browser.show(files["ramps"], 1280)
    browser.ask("Emulation.setDeviceMetricsOverride", width=400, height=800, deviceScaleFactor=1, mobile=False)
    wide = browser.tell("document.querySelector('.run:not([hidden]) .drawing').viewBox.baseVal.width")
    assert wide == pytest.approx(browser.tell("document.querySelector('.charts').clientWidth"), abs=1)


# -- keyboard -------------------------------------------------------------------------------------------------------
HELD = "document.activeElement.textContent || document.activeElement.tagName"
TIMES = "JSON.stringify([...document.querySelectorAll('.run:not([hidden]) .tick')].slice(-3).map(e => e.textContent))"


def reach(browser: Browser, wanted: str, most: int = 60) -> None:
    """Tab until the element that a selector names has the focus; fails where it cannot be reached."""
    for _ in range(most):
        browser.press("Tab")
        if browser.tell(f"document.activeElement.matches({wanted!r})"):
            return
    raise AssertionError(f"no Tab reaches {wanted}")


def readout(browser: Browser) -> list[str]:
    shown = browser.tell("[...document.querySelector('.run:not([hidden]) .readout').children].map(e => e.textContent)")
    return [str(each) for each in shown]


def test_all_is_done_by_keyboard(browser: Browser, files: dict[str, Path]) -> None:
    """Run, channel, zoom, cursor: reached by Tab in the order in which they stand, each with a frame to be seen."""
    browser.show(files["ramps"])
    reach(browser, "select")
    browser.press("ArrowDown")
    assert browser.tell("[...document.querySelectorAll('.run')].map(e => e.hidden)") == [True, False]
    reach(browser, ".run:not([hidden]) input")
    browser.press(" ")
    assert browser.tell("document.querySelectorAll('.run:not([hidden]) .line').length") == 1
    browser.press(" ")
    reach(browser, ".run:not([hidden]) button")
    whole = browser.tell(TIMES)
    browser.press("Enter")
    assert browser.tell(TIMES) != whole
    reach(browser, ".run:not([hidden]) .drawing")
    assert float(browser.tell("parseFloat(getComputedStyle(document.activeElement).outlineWidth)")) >= 2
    browser.press("0")
    assert browser.tell(TIMES) == whole
    browser.press("Home")
    assert readout(browser) == ["0 min", "T 30 °C", "dz 0 µm"]
    browser.press("ArrowRight", shift=True)
    assert readout(browser) == ["12 min", "T 30.2 °C", "dz 1 µm"]
    browser.press("Tab")
    assert not browser.tell("document.activeElement.matches('.drawing')"), "the chart lets the focus go"
    assert browser.said == []


@pytest.mark.parametrize("name", EACH)
def test_what_has_the_focus_has_a_name(browser: Browser, files: dict[str, Path], name: str) -> None:
    """As a screen reader is told."""
    browser.show(files[name])
    told = browser.ask("Accessibility.getFullAXTree")["nodes"]

    def has(node: dict[str, Any], wanted: str) -> bool:
        return any(each["name"] == wanted and each["value"].get("value") for each in node.get("properties", ()))

    focused = [n for n in told if not n["ignored"] and has(n, "focusable") and n["role"]["value"] != "RootWebArea"]
    scrolled = {"generic", "group", "none"}
    assert len(focused) >= 5
    for node in (n for n in focused if n["role"]["value"] not in scrolled):
        assert node.get("name", {}).get("value", "").strip(), node["role"]


# -- pointer --------------------------------------------------------------------------------------------------------
def box_of(browser: Browser, selector: str) -> tuple[float, float, float, float]:
    found = browser.tell(f"(() => {{ const e = document.querySelector({selector!r}); e.scrollIntoView(); "
                         "const b = e.getBoundingClientRect(); return [b.x, b.y, b.width, b.height]; })()")  # fmt: skip
    return float(found[0]), float(found[1]), float(found[2]), float(found[3])


def test_the_pointer_tells_values_and_zooms(browser: Browser, files: dict[str, Path]) -> None:
    """From a quarter to three quarters of two hours, in the times that stand below."""
    browser.show(files["ramps"])
    x, y, wide, _ = box_of(browser, ".run:not([hidden]) .drawing")
    left, right = x + 66, x + wide - 12
    browser.point("mouseMoved", (left + right) / 2, y + 60)
    minutes, kelvin, _ = readout(browser)
    assert float(minutes.split()[0]) == pytest.approx(60, abs=0.2) and kelvin == "T 21 °C"
    quarter = (right - left) / 4
    browser.drag((left + quarter, y + 60), (right - quarter, y + 90))
    ticks = browser.tell("[...document.querySelectorAll('.run:not([hidden]) .tick')].filter(e => "
                         "e.getAttribute('text-anchor') === 'middle').map(e => Number(e.textContent))")  # fmt: skip
    assert min(ticks) >= 30 and max(ticks) <= 90
    assert browser.tell("window.getSelection().toString()") == "", "dragging marks no text"
    browser.point("mouseMoved", 2, 2)
    assert readout(browser) == [] and browser.said == []


# -- print ----------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", [*EACH, "wide"])
def test_it_fits_on_paper(browser: Browser, files: dict[str, Path], name: str, tmp_path: Path) -> None:
    """All runs, no controls, nothing beyond the edge, where nothing can be scrolled; the PDF has pages."""
    browser.show(files[name])
    browser.ask("Emulation.setEmulatedMedia", media="print")
    browser.ask("Emulation.setDeviceMetricsOverride", width=A4, height=1000, deviceScaleFactor=1, mobile=False)
    assert browser.tell(BESIDE.replace("MODE", "'print'")) == []
    assert browser.tell("[...document.querySelectorAll('.run')].every(e => e.offsetHeight > 0)")
    controls = "[...document.querySelectorAll('button, select, input')].filter(e => e.offsetHeight).length"
    assert browser.tell(controls) == 0
    tallest = browser.tell("Math.max(...[...document.querySelectorAll('.run')].map(e => e.offsetHeight))")
    assert tallest <= SHEET, "a run on one sheet"
    lines = browser.tell("[...document.querySelectorAll('.run .line')].map(e => e.getBoundingClientRect().width)")
    assert lines and all(width > 1 for width in lines), "also runs that are not shown on the screen"
    assert count_sheets(browser.paper(tmp_path / "page.pdf")) >= 1


def count_sheets(paper: Path) -> int:
    return len(re.findall(rb"/Type\s*/Page\b", paper.read_bytes()))


@pytest.mark.parametrize("name", ["calibrate", "iso230"])
def test_a_phone_prints_what_a_desk_prints(browser: Browser, files: dict[str, Path], name: str, tmp_path: Path) -> None:
    """Charts are drawn anew for paper, and for the screen again: letters are as large, and sheets as many."""
    sheets = []
    for width in (360, 1280):
        browser.show(files[name], width)
        sheets.append(count_sheets(browser.paper(tmp_path / f"{width}.pdf")))
        wide = browser.tell("document.querySelector('.run:not([hidden]) .drawing').viewBox.baseVal.width")
        assert wide == pytest.approx(browser.tell("document.querySelector('.charts').clientWidth"), abs=1)
    assert sheets[0] == sheets[1]


# -- what may run ---------------------------------------------------------------------------------------------------
def test_hostile_names_are_text(browser: Browser, tmp_path: Path) -> None:
    for name, content in hostile_pages().items():
        page = tmp_path / f"{name}.html"
        page.write_text(content, encoding="utf-8")
        browser.show(page)
        assert browser.tell("document.querySelectorAll('img').length") == 0 and browser.said == []
        assert browser.tell("document.querySelectorAll('button').length") > 0


INPUT = f"in {HOSTILE}"
ODD = HOSTILE.replace("/", "")
"""For a file, whose name has no slash."""


def hostile_files(where: Path) -> None:
    """A machine, a scenario and a recording in which everything that has a name has a hostile one."""
    part = {"material": HOSTILE, "length": "100 mm", "area": "10 cm^2"}
    steel = {"density": "7800 kg/m^3", "specific_heat": "460 J/(kg K)", "conductivity": "45 W/(m K)"}
    tree = {
        "machine": HOSTILE, "reference": "20 degC", "materials": {HOSTILE: steel | {"expansion": "12e-6 1/K"}},
        "nodes": {HOSTILE: part, f"2 {HOSTILE}": part, "air": {"temperature": "ambient"}},
        "links": {HOSTILE: {"kind": "convection", "between": [HOSTILE, "air"], "conductance": "4 W/K ± 30 %"},
                  f"2 {HOSTILE}": {"kind": "conduction", "between": [HOSTILE, f"2 {HOSTILE}"], "conductance": "2 W/K"}},
        "sources": {HOSTILE: {"kind": "heat_source", "into": {HOSTILE: 1}, "power": "60 W", "with": INPUT, "at": "1"},
                    "turns": {"kind": "bearing_friction", "into": {HOSTILE: 1}, "torque": "300 N mm"}},
        "tcp": {"z": {HOSTILE: {"kind": "stretching", "of": HOSTILE, "direction": 1}}},
        "sensors": {HOSTILE: {"measures": HOSTILE, "noise": "0.05 K"}, f"2 {HOSTILE}": {"measures": f"2 {HOSTILE}",
                                                                                      "noise": "0.05 K"}},
    }  # fmt: skip
    inputs = {INPUT: [{"for": "20 min", "at": "1"}, {"at": "0"}], "speed": "1000 rpm", "ambient": "20 degC"}
    told = {"scenario": HOSTILE, "duration": "40 min", "output": "20 s", "inputs": inputs}
    for name, content in ((f"{ODD}.yaml", tree), ("s.yaml", told)):
        (where / name).write_text(yaml.safe_dump(content, allow_unicode=True, sort_keys=False), encoding="utf-8")
    run = simulate(Machine.load(where / f"{ODD}.yaml"), Scenario.load(where / "s.yaml"), noise_seed=1)
    t = run.t
    columns = {name: ("degC", values + 0.3 * np.sin(t / 400)) for name, values in run.sensors.items()}
    columns |= {HOSTILE[1:]: ("degC", 20 + np.sin(t / 300)), "speed": ("rpm", run.inputs["speed"]),
                "ambient": ("degC", np.full(len(t), 20.0)), INPUT: ("1", run.inputs[INPUT])}  # fmt: skip
    write_csv(where / f"{ODD}.csv", t, columns)
    mapping = {f"{name} [{unit}]": f"{name} [{unit}]" for name, (unit, _) in columns.items()}
    mapping["time [s]"] = "time [s]"
    (where / "map.yaml").write_text(yaml.safe_dump({"recording": HOSTILE, "file": f"{ODD}.csv", "columns": mapping}))


CLICKING = """document.querySelectorAll("button, input, summary, figure, [tabindex]").forEach(e => {
  e.focus();
  e.dispatchEvent(new MouseEvent("click", {bubbles: true}));
})"""
COMMANDS = (
    ("simulate", "s.yaml", "--page"), ("compare", "map.yaml", "--page"), ("calibrate", f"{ODD}.csv", "--page"),
    ("diagnose", f"{ODD}.csv", "--budget", "5 s", "--jobs", "1"), ("iso230", "s.yaml"),
)  # fmt: skip


@pytest.mark.parametrize("words", COMMANDS, ids=lambda words: str(words[0]))
def test_hostile_files_make_pages_of_text(
    browser: Browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
) -> None:
    """Machine, parts, links, sources, sensors, inputs, columns, files: nothing that they hold is made, fetched or run,
    also when everything on the page is clicked, typed into or focused."""
    monkeypatch.chdir(tmp_path)
    hostile_files(tmp_path)
    assert main_quietly(words[0], f"{ODD}.yaml", *words[1:], "-o", "out") == 0
    browser.show(tmp_path / "out" / "report.html")
    assert HOSTILE in browser.tell("document.body.innerText")
    browser.tell(CLICKING)
    for key in ("ArrowRight", "End", "Escape"):
        browser.press(key)
    made = "[...document.querySelectorAll('img')].filter(e => !e.src.startsWith('data:')).length"
    assert browser.tell(made) == 0 and browser.said == []
    scripts = browser.tell("document.querySelectorAll('script:not([type])').length")
    assert scripts == 1 and "49" not in browser.tell("document.title")


def test_a_script_that_is_not_its_own_does_not_run(browser: Browser, tmp_path: Path) -> None:
    """The same script runs where the policy of the page knows it; where it does not, that is told."""
    code = "document.title = 'taken over'"
    foreign = ramps().replace("</body>", f"<script>{code}</script></body>")
    digest = base64.b64encode(hashlib.sha256(code.encode()).digest()).decode()
    for content, runs in ((foreign, False), (foreign.replace("script-src ", f"script-src 'sha256-{digest}' "), True)):
        page = tmp_path / "other.html"
        page.write_text(content, encoding="utf-8")
        browser.show(page)
        assert (browser.tell("document.title") == "taken over") is runs
        assert any("Content Security Policy" in each for each in browser.said) is not runs


# -- a whole case ---------------------------------------------------------------------------------------------------
def test_a_page_with_pictures(browser: Browser, tmp_path: Path) -> None:
    """The pictures of a test on the gantry: whole on a desk, to be scrolled on a phone so that words stay readable."""
    gantry = str(ROOT / "machines" / "gantry_spindle.yaml")
    assert main_quietly("iso230", gantry, "spindle_constant", "-o", str(tmp_path / "iso")) == 0
    for width, least in ((1280, 900.0), (360, 600.0)):
        browser.show(tmp_path / "iso" / "report.html", width)
        shown = browser.tell("[...document.querySelectorAll('figure img')].map(e => [e.naturalWidth, e.width])")
        assert shown and all(own > 0 and wide > least for own, wide in shown)
        assert browser.tell("document.scrollingElement.scrollWidth") <= width and browser.said == []
