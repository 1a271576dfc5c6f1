"""The house: which room may use which, over all imports, those inside functions and for types only too."""

from __future__ import annotations

import ast
import re
import tomllib
from collections import Counter
from pathlib import Path

import networkx as nx

import network

ROOT = Path(network.__file__).parent
ROOMS = (
    "platform", "catalogue", "machine", "recordings", "engine", "analysis.comparison", "analysis.sweep",
    "analysis.acceptance", "analysis.correction", "analysis.calibration", "analysis.drafting", "analysis.diagnosis",
    "analysis.change", "report", "cli",
)  # fmt: skip
"""From the ground up: a room uses itself and those before it."""
SHARED = {"base"}
"""Names that several rooms may give a module, each for the same: the conventions of its entries."""
LONGEST = 40


def modules() -> dict[str, Path]:
    files = {".".join(p.relative_to(ROOT.parent).with_suffix("").parts): p for p in ROOT.rglob("*.py")}
    return {name.removesuffix(".__init__"): path for name, path in files.items()}


MODULES = {name: path for name, path in modules().items() if not name.startswith(("network.machines", "network.scen"))}
TREES = {name: ast.parse(path.read_text(encoding="utf-8")) for name, path in MODULES.items()}


def imported(name: str) -> set[str]:
    """What a module imports of the package, wherever in it."""
    found: set[str] = set()
    for node in ast.walk(TREES[name]):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            assert not node.level, f"{name} imports by dots"
            found |= {f"{node.module}.{alias.name}" for alias in node.names} | {node.module}
    return {other for other in found if other in MODULES and other != name}


def room_of(name: str) -> str:
    parts = name.split(".")[1:]
    return ".".join(parts[: 2 if parts[0] == "analysis" else 1])


def test_every_room_uses_only_those_below_it() -> None:
    inside = [name for name in MODULES if name.count(".") > 1]
    wrong = [
        f"{name} uses {other}"
        for name in inside
        for other in imported(name) - {"network", "network.analysis"}
        if ROOMS.index(room_of(other)) > ROOMS.index(room_of(name))
    ]
    assert not wrong and len(inside) > 250


def test_no_import_runs_in_a_circle() -> None:
    packages = {name for name, path in MODULES.items() if path.name == "__init__.py"}
    arrows = [(name, other) for name in MODULES for other in imported(name) - packages]
    circles = [sorted(group) for group in nx.strongly_connected_components(nx.DiGraph(arrows)) if len(group) > 1]
    assert not circles


def test_the_wheel_carries_every_room() -> None:
    settings = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))
    rooms = {name for name, path in MODULES.items() if path.name == "__init__.py"}
    assert rooms | {"network.machines", "network.scenarios"} == {*settings["tool"]["setuptools"]["packages"]}


def test_every_room_is_on_the_map() -> None:
    text = network.__doc__ or ""
    top = {path.name for path in ROOT.iterdir() if path.name not in ("__pycache__", "machines", "scenarios")}
    assert len(top) <= 10
    for room in {room.partition(".")[0] for room in ROOMS} | {room.rpartition(".")[2] for room in ROOMS}:
        assert re.search(rf"^ *{room} ", text, re.MULTILINE), room
    assert top == {"__init__.py", "py.typed", *(room.partition(".")[0] for room in ROOMS)}


def test_a_name_of_a_module_means_one_thing() -> None:
    stems = Counter(path.stem for path in MODULES.values() if not path.stem.startswith("__"))
    assert {stem for stem, count in stems.items() if count > 1} <= SHARED


def test_functions_fit_a_screen_and_the_catalogue_knows_its_machine() -> None:
    for name, tree in TREES.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef):
                assert (node.end_lineno or 0) - node.lineno < LONGEST, f"{name}.{node.name}"
    assert not any("machine: Any" in path.read_text(encoding="utf-8") for path in MODULES.values())


def test_words_of_the_field_are_found() -> None:
    names = " ".join(MODULES).replace("_", " ")
    texts = " ".join(path.read_text(encoding="utf-8").lower() for path in MODULES.values())
    for word in ("forward selection", "surrogate", "multistart", "limit cycle", "change points", "data quality"):
        assert word in names, word
    for word in ("resampl", "cross-validation", "change point", "forward selection"):
        assert word in texts, word
