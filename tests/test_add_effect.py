"""The page "Add an effect" walked: its file put into a copy of the package, and used in every way."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[1]
MACHINE = """\
machine: A block and a fan
reference: 20 degC
nodes:
  hot: {heat_capacity: 1 kJ/K}
  cold: {temperature: 20 degC}
links:
  fan: {kind: controlled_fan, between: [hot, cold], conductance: 2 W/K ± 30 %, growth: 0.2 1/K, set: 30 degC}
sources:
  heater: {kind: heat_source, into: {hot: 1}, power: 120 W}
sensors: {T_hot: {measures: hot, noise: 0.05 K}}
"""
SCENARIO = "scenario: on\nduration: 4 h\noutput: 60 s\ninputs: {}\n"
PROPOSED = """
from network import Machine
from network.analysis.diagnosis.candidates.candidates import candidates
skin = {"kind": "convection", "between": ["other", "cold"], "conductance": "2 W/K"}
patch = {"links": {"skin": skin}, "nodes": {"other": {"heat_capacity": "2 kJ/K"}}}
machine = Machine.load("machine.yaml").patched(patch)
print([c.name for c in candidates(machine, ()) if c.kind.kind == "controlled_fan"])
"""


@pytest.fixture(scope="module")
def house(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the package with the file of the page in it, and a machine that uses it."""
    folder = tmp_path_factory.mktemp("house")
    shutil.copytree(ROOT / "network", folder / "network", ignore=shutil.ignore_patterns("__pycache__"))
    page = (ROOT / "README.md").read_text(encoding="utf-8").partition("## Add an effect")[2]
    code = re.search(r"```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    assert code
    (folder / "network" / "catalogue" / "mechanisms" / "controlled_fan.py").write_text(code[1], encoding="utf-8")
    (folder / "machine.yaml").write_text(MACHINE, encoding="utf-8")
    (folder / "on.yaml").write_text(SCENARIO, encoding="utf-8")
    return folder


def run(house: Path, *words: str) -> str:
    environment = {**os.environ, "PYTHONPATH": str(house)}
    done = subprocess.run(
        [sys.executable, *words], cwd=house, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_it_has_a_page_and_reads_back(house: Path) -> None:
    page = run(house, "-m", "network.cli", "catalogue", "controlled_fan")
    assert "while it idles" in page and "growth [1/K]" in page and "{kind: controlled_fan" in page
    assert "controlled_fan" in run(house, "-m", "network.cli", "schema")


def test_it_carries_what_its_equation_says(house: Path) -> None:
    """Settled at 40 °C, 20 K over the cold: 120 W = 2 (1 + 0.2 · 10) 20."""
    run(house, "-m", "network.cli", "simulate", "machine.yaml", "on.yaml", "-o", "out", "--no-plots")
    rows = (house / "out" / "results.csv").read_text(encoding="utf-8").splitlines()
    T = float(rows[-1].split(",")[rows[0].split(",").index("T_hot [degC]")])
    assert pytest.approx(40.0, abs=0.01) == T
    assert np.isclose(2 * (1 + 0.2 * (40 - 30)) * (40 - 20), 120)


def test_it_is_proposed_where_it_could_be_missing(house: Path) -> None:
    assert "controlled_fan" in run(house, "-c", PROPOSED)


def test_its_contract_is_tested_unasked(house: Path) -> None:
    """Slopes, bounds, reading back, sentence and page, by the tests that go over the catalogue."""
    shutil.copytree(ROOT / "tests", house / "tests", ignore=shutil.ignore_patterns("__pycache__", "proof", "bench"))
    for name in ("machines", "scenarios"):
        shutil.copytree(ROOT / name, house / name)
    shutil.copy(ROOT / "README.md", house)
    files = [f"tests/test_catalogue{name}.py" for name in ("", "_proposals", "_pages", "_numbers", "_equations")]
    told = run(house, "-m", "pytest", "-q", "-p", "no:cacheprovider", *files, "-k", "controlled_fan")
    passed = re.search(r"(\d+) passed", told)
    assert passed and int(passed[1]) > 15
