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
machine: Two blocks and a heat pipe
reference: 20 degC
nodes:
  hot: {heat_capacity: 1 kJ/K}
  cold: {temperature: 20 degC}
links:
  pipe: {kind: heat_pipe, between: [hot, cold], conductance: 12 W/K ± 30 %, limit: 150 W}
sources:
  heater: {kind: heat_source, into: {hot: 1}, power: 100 W}
sensors: {T_hot: {measures: hot, noise: 0.05 K}}
"""
SCENARIO = "scenario: on\nduration: 4 h\noutput: 60 s\ninputs: {}\n"
PROPOSED = """
from network import Machine
from network.analysis.diagnosis.candidates import candidates
skin = {"kind": "convection", "between": ["other", "cold"], "conductance": "2 W/K"}
patch = {"links": {"skin": skin}, "nodes": {"other": {"heat_capacity": "2 kJ/K"}}}
machine = Machine.load("machine.yaml").patched(patch)
print([c.name for c in candidates(machine, ()) if c.kind.kind == "heat_pipe"])
"""


@pytest.fixture(scope="module")
def house(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the package with the file of the page in it, and a machine that uses it."""
    folder = tmp_path_factory.mktemp("house")
    shutil.copytree(ROOT / "network", folder / "network", ignore=shutil.ignore_patterns("__pycache__"))
    page = (ROOT / "README.md").read_text(encoding="utf-8").partition("## Add an effect")[2]
    code = re.search(r"```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    assert code
    (folder / "network" / "catalogue" / "mechanisms" / "heat_pipe.py").write_text(code[1], encoding="utf-8")
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
    page = run(house, "-m", "network.cli", "catalogue", "heat_pipe")
    assert "capillary limit" in page and "limit [W]" in page and "{kind: heat_pipe" in page
    assert "heat_pipe" in run(house, "-m", "network.cli", "schema")


def test_it_carries_what_its_equation_says(house: Path) -> None:
    """Settled: 100 W = 12 ΔT/(1 + 12 ΔT/150), so ΔT = 25 K."""
    run(house, "-m", "network.cli", "simulate", "machine.yaml", "on.yaml", "-o", "out", "--no-plots")
    rows = (house / "out" / "results.csv").read_text(encoding="utf-8").splitlines()
    T = float(rows[-1].split(",")[rows[0].split(",").index("T_hot [degC]")])
    assert pytest.approx(45.0, abs=0.01) == T
    assert np.isclose(12 * 25 / (1 + 12 * 25 / 150), 100)


def test_it_is_proposed_where_it_could_be_missing(house: Path) -> None:
    assert "heat_pipe" in run(house, "-c", PROPOSED)


def test_its_contract_is_tested_unasked(house: Path) -> None:
    """Slopes, bounds, reading back, sentence and page, by the tests that go over the catalogue."""
    shutil.copytree(ROOT / "tests", house / "tests", ignore=shutil.ignore_patterns("__pycache__", "proof", "bench"))
    for name in ("machines", "scenarios"):
        shutil.copytree(ROOT / name, house / name)
    shutil.copy(ROOT / "README.md", house)
    files = [f"tests/test_catalogue{name}.py" for name in ("", "_proposals", "_pages", "_numbers", "_equations")]
    told = run(house, "-m", "pytest", "-q", "-p", "no:cacheprovider", *files, "-k", "heat_pipe")
    passed = re.search(r"(\d+) passed", told)
    assert passed and int(passed[1]) > 15
