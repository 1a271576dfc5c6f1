"""Are p-values of the test on runs not seen uniform, or too large, where nothing is missing?

`python -m bench.p_values [--cases N] [--seed S] [--resume DIR] [--small M]` from tests/: so many innocent cases of the
proof, the small ones of each seed from S on in turn, or the first M cases of each seed in place of the small ones. Of
each: what the search comes to as its null, everything that could be missing screened about it, chosen on one half of
the recordings and tested on the other, crossed. DIR keeps the cases and what was found; p_values.png stands there.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from matplotlib.figure import Figure
from proof.cases import make_cases
from proof.plan import CHEAP, slot
from rich.console import Console
from rich.table import Table
from scipy.stats import kstest

from network import Failed, Machine, Recording, Refused
from network.analysis.calibration.null import estimate_null
from network.analysis.diagnosis.findings.holdout_admission import admit_runs
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.screening.crossed_splits import UnseenTest
from network.analysis.diagnosis.screening.screening import screen_candidates
from network.analysis.diagnosis.search import search
from network.engine.response.parameters import free_parameters
from network.platform.threads import on_one_thread

LEVELS = (0.01, 0.05, 0.1, 0.2, 0.5)
QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
COLUMNS = {"p_ab": "chosen on A, tested on B", "p_ba": "the other way round", "p": "crossed: twice the mean"}
DRAWN = (("#0072B2", "-"), ("#D55E00", "--"), ("#009E73", "-."))


def list_innocents(count: int, seed: int, of_each: int) -> Iterator[tuple[int, int]]:
    """Seeds and numbers of cases that conceal nothing: those of the first cases of each seed, the smallest first."""
    while count > 0:
        among = [i for i in range(of_each) if slot(seed, i).group == "innocent"]
        kept = sorted(among, key=lambda i: len(slot(seed, i).layout.parts) * slot(seed, i).runs)[:count]
        yield from ((seed, i) for i in kept)
        count, seed = count - len(kept), seed + 1


@on_one_thread
def find_null(machine: Machine, runs: Sequence[Recording]) -> tuple[Hypothesis, UnseenTest | None]:
    """What a search comes to as its null, and the test about it."""
    let_in = admit_runs(machine, runs, (), None)
    null = estimate_null(machine, free_parameters(machine), let_in.data)
    case = Case(machine, let_in.recordings)
    for now in search(case, null, 0, 1, lambda share: None):
        if now.screened.proposed:
            return now.null, now.screened.unseen
    return now.null, screen_candidates(now.null, 0, 1).unseen


def examine(folder: Path, name: str) -> dict[str, Any]:
    """The p-values of one case."""
    began, about = time.process_time(), json.loads((folder / name / "case.json").read_text(encoding="utf-8"))
    runs = [Recording.load(folder / name / file) for file in about["train"]]
    try:
        null, told = find_null(Machine.load(folder / name / "machine.yaml"), runs)
    except (Failed, Refused, np.linalg.LinAlgError) as error:
        return {"why": str(error)}
    seconds = time.process_time() - began
    about = {"chi": null.chi, "lumps": null.machine.lumps, "runs": len(runs), "seconds": seconds}
    return {**about, **_numbers(told)} if told else {"why": "no half can be told"}


def _numbers(told: UnseenTest) -> dict[str, Any]:
    a, b = told.p_values
    return {"p_ab": a, "p_ba": b, "p": told.p_value, "agree": told.halves_agree, "chosen": told.chosen}


def gather(folder: Path, cases: Sequence[tuple[int, int]]) -> list[dict[str, Any]]:
    """Of every case, also of those that were examined before."""
    told = []
    for seed, index in cases:
        at, what = folder / f"{seed}", slot(seed, index).what
        at.mkdir(parents=True, exist_ok=True)
        [name] = make_cases(at, 0, seed, only=[index])
        kept = at / f"{name}.p.json"
        if not kept.is_file():
            kept.write_text(json.dumps({"what": what, **examine(at, name)}) + "\n", encoding="utf-8")
        told.append(json.loads(kept.read_text(encoding="utf-8")))
        print(seed, name, told[-1], file=sys.stderr, flush=True)
    return told


def tabulate(told: Sequence[dict[str, Any]]) -> Table:
    """Shares of p-values below usual levels, their quantiles, and Kolmogorov's test against the diagonal, to the side
    of too small ones alone and to both."""
    n = len(told)
    table = Table(title=f"p-values of {n} innocent cases; standard error of a share s: √(s(1 − s)/{n})")
    for heading in ("", *(f"p ≤ {x:g}" for x in LEVELS), *(f"{100 * q:.0f} %" for q in QUANTILES), "too small", "both"):
        table.add_column(heading, justify="right")
    for column, name in COLUMNS.items():
        p = np.array([row[column] for row in told])
        below = [f"{100 * np.mean(p <= x):.1f} %" for x in LEVELS]
        tests = [kstest(p, "uniform", alternative=side).pvalue for side in ("greater", "two-sided")]
        table.add_row(name, *below, *(f"{x:.2f}" for x in np.quantile(p, QUANTILES)), *(f"{x:.2g}" for x in tests))
    return table


def draw(told: Sequence[dict[str, Any]], path: Path) -> None:
    """Empirical distributions against the diagonal."""
    figure = Figure(figsize=(4.5, 4.2), layout="constrained")
    axes = figure.add_subplot()
    axes.plot([0, 1], [0, 1], color="0.5", lw=1, label="uniform")
    for (column, name), (colour, dash) in zip(COLUMNS.items(), DRAWN, strict=True):
        p = np.sort([row[column] for row in told])
        axes.step([0, *p, 1], [0, *np.arange(1, len(p) + 1) / len(p), 1], dash, where="post", color=colour, label=name)
    axes.set(xlabel="p-value", ylabel="share of innocent cases below", xlim=(0, 1), ylim=(0, 1), aspect="equal")
    axes.legend(loc="lower right", fontsize=8)
    figure.savefig(path, dpi=150)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=24)
    parser.add_argument("--seed", type=int, default=601)
    parser.add_argument("--small", type=int, default=CHEAP)
    parser.add_argument("--resume", type=Path)
    given = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as place:
        folder = given.resume or Path(place)
        told = gather(folder, [*list_innocents(given.cases, given.seed, given.small)])
        counted = [row for row in told if "p" in row]
        Console(width=150).print(tabulate(counted))
        print(
            f"{len(told) - len(counted)} cases without a test; "
            f"{sum(row['seconds'] for row in counted):.0f} s of a processor"
        )
        if given.resume:
            draw(counted, folder / "p_values.png")


if __name__ == "__main__":
    main()
