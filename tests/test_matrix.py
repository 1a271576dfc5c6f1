"""What `make test-matrix` covers: every declared dependency at its lower bound, and every Python that may be used."""

from __future__ import annotations

import os
import re
import tomllib
from pathlib import Path

import pytest
from matrix import LOWEST, NEWEST, PYTHONS, ROOT, environments, find_python, requirements


def test_every_dependency_has_a_lower_bound_that_is_tested() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lowest = requirements(LOWEST)
    assert all(re.fullmatch(r"[A-Za-z0-9_-]+==[0-9.]+", text) for text in lowest)
    assert {text.replace("==", ">=") for text in lowest} >= set(project["dependencies"])
    assert [text.replace("==", ">=") for text in lowest] == requirements(NEWEST)
    assert project["requires-python"] == f">={PYTHONS[0]}"


def test_lowest_versions_run_where_they_are_oldest_and_the_newest_everywhere() -> None:
    assert environments() == [("3.11", LOWEST), *((python, NEWEST) for python in PYTHONS)]


@pytest.mark.skipif(os.name == "nt", reason="scripts of a shell")
def test_a_python_that_does_not_run_is_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A shim of pyenv, on the path, for a version that it has but that is not chosen."""
    shim, own = tmp_path / "python3.98", tmp_path / "versions" / "3.98.2" / "bin" / "python"
    own.parent.mkdir(parents=True)
    for script, status in ((shim, 127), (own, 0)):
        script.write_text(f"#!/bin/sh\nexit {status}\n")
        script.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("PYENV_ROOT", str(tmp_path))
    assert find_python("3.98") == str(own)
    own.unlink()
    assert find_python("3.98") is None
