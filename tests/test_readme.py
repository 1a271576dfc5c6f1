"""Everything the README shows is run: its commands, its Python, its files, its refusals."""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import shutil
from pathlib import Path

import pytest
import yaml

from network import Machine, Recording, Refused, Scenario, simulate
from network.cli import main

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w*)\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)


def blocks(language: str, begin: str) -> list[str]:
    return [text for kind, text in BLOCKS if kind == language and text.startswith(begin)]


@pytest.fixture
def clone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the shipped files, to work in."""
    for name in ("machines", "scenarios"):
        shutil.copytree(ROOT / name, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def command_lines() -> list[str]:
    shown = "\n".join(blocks("", "lptn")).replace("\\\n", " ")
    inline = re.findall(r"`(lptn (?:check|catalogue|schema|draw|paper)[^`]*)`", README)
    lines = [line for line in [*shown.splitlines(), *inline] if line.startswith("lptn ")]
    return [f"{line} --budget '1 h'" if line.startswith("lptn diagnose ") else line for line in lines]  # a busy machine


def test_every_command_runs_in_the_order_shown(clone: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert len(command_lines()) >= 8
    told = ""
    for line in command_lines():
        with contextlib.suppress(SystemExit):
            main(shlex.split(line)[1:])
        out = capsys.readouterr()
        told += out.out
        assert not out.err, line
    assert (clone / "out" / "compared" / "results.png").exists()
    first, *rest = blocks("", "Gantry mill")[0].splitlines()
    assert first in " ".join(told.split())
    for line in rest:
        assert any(is_like(line, other) for other in told.splitlines()), line


def test_the_tables_shown_are_what_comes_out(clone: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Displacement and energy of section 2, residuals of section 4, to the last digit; times and closure aside.
    What section 5 finds, to two digits."""
    for line in command_lines():
        if line.startswith(("lptn simulate", "lptn compare", "lptn calibrate")):
            with contextlib.suppress(SystemExit):
                main(shlex.split(line)[1:])
    out = capsys.readouterr().out.replace("−", "-")
    shown = [block.replace("−", "-") for block in blocks("", "  ") if "level" not in block]
    assert len(shown) == 3
    for line in "".join(shown[:2]).splitlines():
        assert line.partition("; closure")[0] in out, line
    for line in [*shown[2].splitlines(), *blocks("", "This schedule")[0].splitlines()]:
        assert any(is_like(line, other) for other in out.splitlines()), line


NUMBER = r"[-+±]?\d+\.?\d*"


def is_like(line: str, other: str) -> bool:
    """The same words, and numbers that differ by 3 % or 0.1."""
    texts = [re.sub(r"\s+", " ", re.sub(NUMBER, "#", x)).strip() for x in (line, other)]
    pairs = [[float(n.lstrip("±")) for n in re.findall(NUMBER, x)] for x in (line, other)]
    return texts[0] == texts[1] and pairs[0] == pytest.approx(pairs[1], rel=0.03, abs=0.1)


def test_the_python_runs(clone: Path) -> None:
    (code,) = blocks("python", "from network import")
    told = io.StringIO()
    with contextlib.redirect_stdout(told):
        exec(compile(code, "README.md", "exec"), {})
    assert "tool centre point" in told.getvalue() and " kJ" in told.getvalue()


def test_the_machine_shown_is_the_one_shipped(tmp_path: Path) -> None:
    (text,) = blocks("yaml", "machine:")
    (tmp_path / "m.yaml").write_text(text)
    shipped = Machine.load(ROOT / "machines" / "two_blocks.yaml")
    assert Machine.load(tmp_path / "m.yaml").to_plain() == shipped.to_plain()


def test_the_refusals_shown_are_what_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (text,), (told,) = blocks("yaml", "machine:"), blocks("", "my.yaml")
    Path("my.yaml").write_text(text.replace("3 W/K ± 30 %", "3").replace("[hot, room]", "[hot, rooom]"))
    with pytest.raises(Refused) as refused:
        Machine.load("my.yaml")
    assert str(refused.value) == told.strip()


def test_the_files_shown_load(tmp_path: Path) -> None:
    (scenario,), (mapping,), (csv,) = blocks("yaml", "scenario:"), blocks("yaml", "recording:"), blocks("", "time [s]")
    (tmp_path / "s.yaml").write_text(scenario)
    assert set(Scenario.load(tmp_path / "s.yaml").schedule.signals) == {"speed", "ambient"}
    (tmp_path / "r.csv").write_text(csv + csv.splitlines()[1].replace("0,0,", "10,0,", 1) + "\n")
    assert Recording.load(tmp_path / "r.csv").columns["dz"].unit == "um"
    (tmp_path / "m.yaml").write_text(mapping)
    (tmp_path / "run_20200615.csv").write_text("time_min,PT01,speed_rpm,TC08\n0,21,0,20\n1,22,100,20.5\n")
    assert Recording.load(tmp_path / "m.yaml").signal("ambient").t[-1] == 60.0


def test_phases_signs_and_levels_shown_do_what_is_said(tmp_path: Path) -> None:
    (phases,), (signs,), (levels,) = (blocks("yaml", f"{name}:") for name in ("phases", "tcp", "levels"))
    (tmp_path / "s.yaml").write_text(f"scenario: rows\n{phases}")
    shown = Scenario.load(tmp_path / "s.yaml")
    assert shown.duration == 55 * 60 and set(shown.schedule.signals) == {"speed", "feed", "ambient"}
    mill = yaml.safe_load((ROOT / "machines" / "gantry_spindle.yaml").read_text(encoding="utf-8"))
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(mill | {"levels": yaml.safe_load(levels)["levels"]}))
    few, fine, bare = (Machine.load(tmp_path / "m.yaml", level=n) for n in ("coarse", "fine", "without jacket"))
    assert "spindle" in few.nodes and fine.nodes["beam"].lumps == 20 and "coolant jacket" not in bare.links
    heights = {
        "column": 20e-6 / 10 / 1.13e-5,
        "table": 5e-6 / 10 / 1.13e-5 / 0.15,
    }  # m, and the share of 150 mm, at +10 K
    bar = {"material": "steel", "length": f"{heights['column']} m", "area": "100 cm^2"}
    nodes = {"column": bar, "table": {"heat_capacity": "9 kJ/K", "material": "steel"}}
    heat = {name: {"kind": "heat_source", "into": {name: 1}, "power": "1 W"} for name in nodes}
    tree = {
        "machine": "m",
        "reference": "20 degC",
        "nodes": nodes,
        "sources": heat,
        "tcp": yaml.safe_load(signs)["tcp"],
    }
    (tmp_path / "t.yaml").write_text(yaml.safe_dump(tree))
    start = {"column": "30 degC", "table": f"{20 + 10 * heights['table']} degC"}
    run = simulate(Machine.load(tmp_path / "t.yaml"), Scenario.of("still", "1 min", start=start))
    assert run.shown("tcp.z")[0] == pytest.approx(15.0, rel=1e-3)


def test_every_heading_that_is_pointed_to_is_there() -> None:
    heads = re.findall(r"^#+ (.*)$", re.sub(r"^```.*?^```$", "", README, flags=re.MULTILINE | re.DOTALL), re.MULTILINE)
    anchors = {re.sub(r"[^\w -]", "", head.lower()).replace(" ", "-") for head in heads}
    assert set(re.findall(r"\]\(#([^)]*)\)", README)) <= anchors
    order = [
        head for head in heads if head in ("Words", "From Python", "Evidence", "Changes") or head.startswith("Figures")
    ]
    assert order == ["Words", "From Python", "Evidence", "Figures, and the commands behind them", "Changes"]


def test_every_command_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    from network.cli.commands import cli

    assert [name for name in cli.commands if f"lptn {name}" not in README] == []
