"""Baselines beside lptn on the same concealed cases, judged by the same scorer.

`python -m bench.baselines [--cases 40] [--seed N] [--folder DIR]` from the folder tests/. lptn's own row is there if
the folder was proved: `lptn prove --resume DIR`.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Callable, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from bench.baselines.evidence import white_evidence
from bench.baselines.given import Given
from bench.baselines.residual import largest_residual
from bench.baselines.sindy import by_sindy
from proof.cases import make_cases
from proof.rates import Rate
from proof.score import OUT, Score, score
from rich.console import Console
from rich.table import Table

from network.platform.refusal import Failed

ROOT = Path(__file__).parents[3]
Way = Callable[[Given], dict[str, Any]]
WAYS: Mapping[str, Way] = {
    "largest residual": largest_residual, "white-noise evidence": white_evidence, "PySINDy": by_sindy,
}  # fmt: skip
RATES = ("first name right", "right place", "right name at the right place", "innocents accused",
         "outside: so, and at its place", "confident (> 0.9) and wrong")  # fmt: skip


def folder_of(way: str) -> str:
    """Of a case, where the answer of a way lies."""
    return f"out-{way.replace(' ', '-').lower()}"


def answer(case: Path, way: str) -> None:
    """Writes the answer of a way beside the others; none where it fails."""
    where = case / folder_of(way)
    if (where / "run.json").is_file():
        return
    where.mkdir(exist_ok=True)
    began, how = time.monotonic(), "answered"
    try:
        told = WAYS[way](Given.load(case))
        (where / "diagnosis.json").write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    except (Failed, np.linalg.LinAlgError) as failed:
        how = str(failed)
    run = {"seconds": time.monotonic() - began, "how": how}
    (where / "run.json").write_text(json.dumps(run) + "\n", encoding="utf-8")


def cases_in(folder: Path, count: int, seed: int) -> list[str]:
    """The first cases of a folder, made where there are too few."""
    path = folder / "cases.json"
    there = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {"seed": seed, "cases": {}}
    if there["seed"] != seed:
        sys.exit(f"{folder} holds cases of seed {there['seed']}, not of {seed}")
    if len(there["cases"]) < count:
        make_cases(folder, count, seed, 1)
        there = json.loads(path.read_text(encoding="utf-8"))
    return sorted(there["cases"])[:count]


def row(way: str, told: Score) -> tuple[str, ...]:
    seconds = told.figures["seconds on one core, median"]
    return way, *(short(told.rates[name]) for name in RATES), "–" if seconds is None else f"{seconds:.1f}"


def short(rate: Rate) -> str:
    return f"{rate.hits}/{rate.of} ({100 * rate.low:.0f}–{100 * rate.high:.0f} %)" if rate.of else "–"


def table_of(scores: Mapping[str, Score]) -> Table:
    first = next(iter(scores.values()))
    kind = "development" if first.development else "scored"
    table = Table(title=f"{len(first.judgements)} concealed cases of seed {first.seed}, {kind}; 95 % intervals")
    for heading in ("way", *RATES, "seconds, median"):
        table.add_column(heading)
    for way, told in scores.items():
        table.add_row(*row(way, told))
    return table


def main(words: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m bench.baselines", description=__doc__)
    parser.add_argument("--cases", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--folder", type=Path, default=ROOT / "out" / "baselines")
    asked = parser.parse_args(words)
    names = cases_in(asked.folder, asked.cases, asked.seed)
    ways = [way for way in WAYS if way != "PySINDy" or find_spec("pysindy")]
    if len(ways) < len(WAYS):
        print("PySINDy is left out: it is not installed (pip install -e '.[bench]')", file=sys.stderr)
    for i, name in enumerate(names, 1):
        for way in ways:
            answer(asked.folder / name, way)
        print(f"{i}/{len(names)} {name}", file=sys.stderr)
    scores = {way: score(asked.folder, names, folder_of(way)) for way in ways}
    if any((asked.folder / name / OUT / "diagnosis.json").is_file() for name in names):
        scores["lptn"] = score(asked.folder, names)
    Console(width=200).print(table_of(scores))


if __name__ == "__main__":
    main()
