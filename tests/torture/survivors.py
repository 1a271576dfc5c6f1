"""Mutation testing: one letter of the code is changed, the tests that run its line are run, the quickest of them first,
and a change that none of them sees is a survivor. In a copy of the project; what is done stays done when it is stopped
and begun again.

    pip install -e '.[mutants]'
    python -m torture.survivors --count 400 --log ../.torture/survivors.jsonl

With Python 3.12 or newer, which tells the lines that tests run. Changes that cannot be seen are left out: of
annotations, of decorators, of what `raise … from` names.
"""

from __future__ import annotations

import argparse
import compileall
import difflib
import json
import os
import random
import shutil
import signal
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from torture.asked import ask
from torture.log import Told, read_numbered
from torture.reach import Reach, trace

ROOT = Path(__file__).parents[2]
ROOMS = ("network/engine/solvers", "network/analysis/calibration", "network/analysis/diagnosis")
"""The rooms whose decisions matter most."""
TESTS = tuple(f"tests/test_{name}.py" for name in (
    "steps", "switchings", "nonlinear", "states_and_guards", "krylov", "random_networks", "physics", "moving_contact",
    "latent_heat", "small_decisions", "start", "run_constants", "calibration_noise", "calibration_core",
    "calibration_slopes", "calibration_kalman", "bands", "beginnings", "invariants", "advice", "location",
    "relay_search", "timed_search", "diagnosis_search", "courses", "counted_readings", "input_gates", "episodes",
    "null", "guards", "sensor_fault", "heard", "residuals", "measuring_side", "superposition", "calibration_figures",
    "diagnosis_report", "draft", "late_kinds", "growing_horizon", "concealed_kinds", "concealed_films",
    "cooled_supply", "calibrate", "reading_faults", "rigs", "then_and_now", "calibrate_cli", "diagnose_cli",
    "diagnosis",
))  # fmt: skip
"""Which are asked, quick ones first."""
BLIND = ("ReplaceBinaryOperator_BitOr", "RemoveDecorator", "ExceptionReplacer")
BUDGET = 8.0
"""s of tests for a change, as long as they take a processor without it."""
LONGER, AT_LEAST = 4.0, 20.0
"""Times what tests take, and s besides, after which they count as having seen the change: most that hang do so for
ever."""


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


def tests_for(reach: Reach, mutation: Any, budget: float) -> list[str]:
    """Those that run the changed lines; of a line that is run once, when it is imported, those that run the module."""
    module = _inside(mutation)
    lines = range(mutation.start_pos[0], mutation.end_pos[0] + 1)
    return reach.tests_of(module, lines, budget) or reach.tests_of(module, reach.lines.get(str(module), {}), budget)


def try_mutation(room: str, mutation: Any, tests: Sequence[str], limit: float) -> Told:
    from cosmic_ray.mutating import use_mutation
    from cosmic_ray.plugins import get_operator

    outcome = "survived"  # as it does where no test comes by
    operator = get_operator(mutation.operator_name)(**mutation.operator_args)
    with use_mutation(Path(mutation.module_path), operator, mutation.occurrence) as (before, after):
        if tests and after is not None:
            outcome = "killed" if ask(tests, limit) else "survived"
    where = f"{_inside(mutation)}:{mutation.start_pos[0]}"
    return {"room": room, "where": where, "operator": mutation.operator_name, "outcome": outcome, "tests": len(tests),
            "diff": _changes(before, after or before) if outcome == "survived" else ""}  # fmt: skip


def _changes(before: str, after: str) -> str:
    told = [*difflib.unified_diff(before.splitlines(), after.splitlines(), lineterm="", n=0)][3:]
    return "\n".join(line for line in told if line[:1] in "+-")


def main() -> int:
    parser = argparse.ArgumentParser(prog="torture.survivors", description=__doc__)
    parser.add_argument("--count", type=int, default=400)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--log", type=Path, default=Path(".torture/survivors.jsonl"))
    parser.add_argument("--budget", type=float, default=BUDGET, help="s of tests for a change")
    parser.add_argument("--again", action="store_true", help="those that were left, on the tests as they are now")
    parser.add_argument("--told", action="store_true", help="only tell what is in the log")
    given = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # what it has begun ends with it
    log = given.log.resolve()
    log.parent.mkdir(parents=True, exist_ok=True)
    told = read_numbered(log)
    if not given.told:
        with tempfile.TemporaryDirectory(prefix="survivors-") as folder:
            try_all(copy_project(Path(folder)), given, log, told)
    print(table([*told.values()]))
    return 0


def try_all(root: Path, given: argparse.Namespace, log: Path, told: dict[int, Told]) -> None:
    every = list_mutations(root)
    chosen = random.Random(given.seed).sample(every, min(given.count, len(every)))
    left = [n for n in range(len(chosen)) if n not in told or (given.again and told[n]["outcome"] == "survived")]
    print(f"{len(every)} places, {len(chosen)} drawn, {len(left)} to try", file=sys.stderr)
    reach = trace(TESTS, ROOMS, log.parent / "reach")
    for n in left:
        room, mutation = chosen[n]
        tests = tests_for(reach, mutation, given.budget)
        limit = LONGER * sum(reach.seconds[test] for test in tests) + AT_LEAST
        told[n] = {"number": n, **try_mutation(room, mutation, tests, limit)}
        with log.open("a", encoding="utf-8") as lines:
            print(json.dumps(told[n]), file=lines)
        print(n, told[n]["where"], told[n]["outcome"], file=sys.stderr, flush=True)


def copy_project(folder: Path) -> Path:
    """Into which this process changes, as tests find their project by where they lie."""
    for name in ("network", "tests", "machines", "scenarios"):
        shutil.copytree(ROOT / name, folder / "lptn" / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md"):
        shutil.copy(ROOT / name, folder / "lptn" / name)
    if (shared := ROOT.parent / "shared").exists():
        (folder / "shared").symlink_to(shared)
    compileall.compile_dir(folder / "lptn", quiet=2)
    os.environ["PYTHONDONTWRITEBYTECODE"] = "1"  # what is compiled of a changed module must not be found again
    sys.dont_write_bytecode = True
    os.chdir(folder / "lptn")
    os.environ["PYTHONPATH"] = str(folder / "lptn")
    return folder / "lptn"


def table(told: list[Told]) -> str:
    """Room by room: tried, left; and each that is left."""
    rows = ["| room | tried | unseen |", "|---|---|---|"]
    for room in (*ROOMS, "network"):
        own = [each["outcome"] for each in told if each["room"].startswith(room)]
        rows.append(f"| {f'`{room}`' if room in ROOMS else 'all'} | {len(own)} | {own.count('survived')} |")
    left = [each for each in told if each["outcome"] == "survived"]
    each = (f"\n{one['where']} ({one['number']}, {one['tests']} tests)\n{one['diff']}" for one in left)
    return "\n".join([*rows, *each])


if __name__ == "__main__":
    sys.exit(main())
