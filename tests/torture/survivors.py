"""Mutation testing: one letter of the code is changed, the tests of its room are run, and a change that no test sees is
a survivor. In a copy of the project; what is done stays done when it is stopped and begun again.

    pip install -e '.[mutants]'
    python -m torture.survivors --count 400 --log ../.torture/survivors.jsonl

Changes that cannot be seen are left out: of annotations, of decorators, of what `raise … from` names.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
ROOMS = {
    "network/engine/solvers": (
        "random_networks", "switchings", "nonlinear", "states_and_guards", "physics", "moving_contact",
    ),
    "network/analysis/calibration": (
        "calibration_core", "calibration_noise", "calibration_slopes", "run_constants", "bands", "start", "calibrate",
    ),
    "network/analysis/diagnosis": (
        "invariants", "location", "timed_search", "relay_search", "diagnosis_search", "advice", "diagnosis",
    ),
}  # fmt: skip
"""The rooms whose decisions matter most, and the tests of each."""
FEW = 4
"""Test files for a module, those that name it most often first."""
BLIND = ("ReplaceBinaryOperator_BitOr", "RemoveDecorator", "ExceptionReplacer")
LIMIT = 600.0
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


def files_testing(room: str, module: Path) -> list[str]:
    """The test files that name a module, then those of its room: a change that is seen is seen soon."""
    dotted = ".".join(module.with_suffix("").parts)
    named = {str(path.relative_to(ROOT)): path.read_text(encoding="utf-8").count(dotted)
             for path in sorted((ROOT / "tests").glob("test_*.py"))}  # fmt: skip
    own = sorted((name for name, count in named.items() if count), key=lambda name: -named[name])
    return [*dict.fromkeys([*own[:FEW], *(f"tests/test_{name}.py" for name in ROOMS[room])])]


def command_of(room: str, module: Path) -> str:
    tests = " ".join(files_testing(room, module))
    return f"{sys.executable} -m pytest -x -q -p no:cacheprovider -m 'not speed' {tests}"


def check_tests(modules: Iterable[tuple[str, Path]]) -> None:
    """Raises SystemExit where tests fail without any change, which would make every change look seen."""
    for command in sorted({command_of(room, module) for room, module in modules}):
        if subprocess.run(shlex.split(command), check=False).returncode:
            raise SystemExit(f"it fails without any change: {command}")


def try_mutation(room: str, mutation: Any) -> dict[str, object]:
    from cosmic_ray.mutating import mutate_and_test

    result = mutate_and_test([mutation], command_of(room, _inside(mutation)), LIMIT)
    outcome = result.test_outcome.value if result.test_outcome else "none"
    where = f"{mutation.module_path}:{mutation.start_pos[0]}"
    return {"room": room, "where": where, "operator": mutation.operator_name, "outcome": outcome,
            "diff": (result.diff or "") if outcome == "survived" else ""}  # fmt: skip


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
        check_tests({(room, _inside(mutation)) for room, mutation in chosen[len(told) :]})
        with log.open("a", encoding="utf-8") as lines:
            for room, mutation in chosen[len(told) :]:
                told.append(try_mutation(room, mutation))
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
