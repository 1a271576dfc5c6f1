"""Mutation testing: one letter of the code is changed, the tests that run its line are run, the quickest of them first,
and a change that none of them sees is a survivor. In a copy of the project; what is done stays done when it is stopped
and begun again.

    pip install -e '.[mutants]'
    python -m torture.survivors --count 400 --log ../.torture/survivors.jsonl

Changes that cannot be seen are left out: of annotations, of decorators, of what `raise … from` names.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from torture.reach import Reach, trace

ROOT = Path(__file__).parents[2]
ROOMS = {
    "network/engine/solvers": (
        "steps", "switchings", "nonlinear", "states_and_guards", "krylov", "random_networks", "physics",
        "moving_contact", "latent_heat",
    ),
    "network/analysis/calibration": (
        "start", "run_constants", "calibration_noise", "calibration_core", "calibration_slopes", "bands", "calibrate",
    ),
    "network/analysis/diagnosis": (
        "invariants", "advice", "location", "relay_search", "timed_search", "diagnosis_search", "diagnosis",
    ),
}  # fmt: skip
"""The rooms whose decisions matter most, and the tests of each."""
TESTS = tuple(dict.fromkeys(f"tests/test_{name}.py" for names in ROOMS.values() for name in names))
BLIND = ("ReplaceBinaryOperator_BitOr", "RemoveDecorator", "ExceptionReplacer")
BUDGET = 8.0
"""s of tests for a change, as long as they take without it."""
LIMIT = 120.0
"""s after which tests count as having seen the change: most that hang do so for ever."""


def _inside(mutation: Any) -> Path:
    """Its module, from the project's folder on."""
    parts = Path(mutation.module_path).parts
    return Path(*parts[len(parts) - 1 - parts[::-1].index("network") :])


def list_mutations(root: Path) -> list[tuple[str, Any]]:
    """Room and mutation, everywhere in the rooms, in the same order each time."""
    from cosmic_ray.commands import init
    from cosmic_ray.work_db import WorkDB, use_db

    found = []
    for room in ROOMS:
        modules = sorted((root / room).rglob("*.py"))
        with use_db(root / "mutations.sqlite", WorkDB.Mode.create) as db:
            init(modules, db, {})
            each = [item.mutations[0] for item in db.work_items]
        seen = [one for one in each if not any(word in one.operator_name for word in BLIND)]
        found += [(room, one) for one in sorted(seen, key=_place)]
    return found


def _place(mutation: Any) -> tuple[str, tuple[int, int], str, int]:
    return str(mutation.module_path), mutation.start_pos, mutation.operator_name, mutation.occurrence


def tests_for(reach: Reach, mutation: Any) -> list[str]:
    """Those that run the changed lines; of a line that is run once, when it is imported, those that run the module."""
    module = _inside(mutation)
    lines = range(mutation.start_pos[0], mutation.end_pos[0] + 1)
    return reach.tests_of(module, lines, BUDGET) or reach.tests_of(module, reach.lines.get(str(module), {}), BUDGET)


def command_of(tests: Iterable[str]) -> str:
    return f"{sys.executable} -m pytest -x -q -p no:cacheprovider -p no:xdist -m 'not speed' {' '.join(tests)}"


def try_mutation(room: str, mutation: Any, tests: Sequence[str]) -> dict[str, object]:
    from cosmic_ray.mutating import mutate_and_test

    outcome, diff = "survived", ""  # as it does where no test comes by
    if tests:
        result = mutate_and_test([mutation], command_of(tests), LIMIT)
        outcome, diff = result.test_outcome.value if result.test_outcome else "none", result.diff or ""
    where = f"{_inside(mutation)}:{mutation.start_pos[0]}"
    return {"room": room, "where": where, "operator": mutation.operator_name, "outcome": outcome, "tests": len(tests),
            "diff": diff if outcome == "survived" else ""}  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(prog="torture.survivors", description=__doc__)
    parser.add_argument("--count", type=int, default=400)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--room", choices=[*ROOMS], action="append")
    parser.add_argument("--log", type=Path, default=Path(".torture/survivors.jsonl"))
    given = parser.parse_args()
    given.log.parent.mkdir(parents=True, exist_ok=True)
    log = given.log.resolve()
    told = [json.loads(line) for line in log.read_text().splitlines()] if log.is_file() else []
    with tempfile.TemporaryDirectory(prefix="survivors-") as folder:
        root = copy_project(Path(folder))
        every = [each for each in list_mutations(root) if each[0] in (given.room or ROOMS)]
        chosen = random.Random(given.seed).sample(every, min(given.count, len(every)))
        print(f"{len(every)} places, {len(chosen)} drawn, {len(told)} done", file=sys.stderr)
        reach = trace(TESTS, [*ROOMS], log.parent / "reach")
        with log.open("a", encoding="utf-8") as lines:
            for room, mutation in chosen[len(told) :]:
                told.append(try_mutation(room, mutation, tests_for(reach, mutation)))
                print(json.dumps(told[-1]), file=lines, flush=True)
    print(table(told))
    return 0


def copy_project(folder: Path) -> Path:
    """Into which this process changes, as tests find their project by where they lie."""
    for name in ("network", "tests", "machines", "scenarios"):
        shutil.copytree(ROOT / name, folder / "lptn" / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md"):
        shutil.copy(ROOT / name, folder / "lptn" / name)
    if (shared := ROOT.parent / "shared").exists():
        (folder / "shared").symlink_to(shared)
    os.chdir(folder / "lptn")
    os.environ["PYTHONPATH"] = str(folder / "lptn")
    return folder / "lptn"


def table(told: list[dict[str, Any]]) -> str:
    """Room by room: tried, seen, survived; and each survivor."""
    counts = Counter((each["room"], each["outcome"]) for each in told)
    rows = [f"{'room':32} {'tried':>6} {'survived':>9}"]
    for room in sorted({each["room"] for each in told}):
        tried = sum(n for (other, outcome), n in counts.items() if other == room and outcome in ("killed", "survived"))
        rows.append(f"{room:32} {tried:6} {counts[room, 'survived']:9}")
    return "\n".join([*rows, *(f"\n{each['where']}\n{each['diff']}" for each in told if each["outcome"] == "survived")])


if __name__ == "__main__":
    sys.exit(main())
