"""What `make test-matrix` covers: every declared dependency at its lower bound, and every Python that may be used."""

from __future__ import annotations

import re
import tomllib

from matrix import LOWEST, NEWEST, PYTHONS, ROOT, environments, requirements


def test_every_dependency_has_a_lower_bound_that_is_tested() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lowest = requirements(LOWEST)
    assert all(re.fullmatch(r"[A-Za-z0-9_-]+==[0-9.]+", text) for text in lowest)
    assert {text.replace("==", ">=") for text in lowest} >= set(project["dependencies"])
    assert [text.replace("==", ">=") for text in lowest] == requirements(NEWEST)
    assert project["requires-python"] == f">={PYTHONS[0]}"


def test_lowest_versions_run_where_they_are_oldest_and_the_newest_everywhere() -> None:
    assert environments() == [("3.11", LOWEST), *((python, NEWEST) for python in PYTHONS)]
