"""Calibrates the sets that a diagnosis tells, on answered development cases, and says what they are worth.

`python -m bench.conformal FOLDER… [--answers out] [--write]` from tests/: folders of `lptn prove` with a seed below
1000. By class of truth: cases, how many were told their truth at all, quantile, and with each case left out in turn how
often the truth is in the set (95 % by Clopper and Pearson), how large it is, and how often it is one name. --write puts
the quantiles into the package.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from statistics import median

from bench.conformal_cases import Collected, Refused, Truth
from bench.conformal_softening import fit_softening
from proof.rates import percent, rate
from proof.sealed import Broken
from rich.console import Console
from rich.table import Table

from network.analysis.diagnosis.findings import conformal
from network.analysis.diagnosis.findings.conformal import CLASSES, FILE, Calibration, shipped
from network.analysis.diagnosis.settings import SETTINGS
from network.platform.files import write_text

HEADINGS = ("truth", "n", "told", "q", "by", "truth in the set", "median size", "one name")
SHIPPED = Path(conformal.__file__).with_name(FILE)


def collect(folders: list[Path], answers: str = "out") -> Collected:
    """Raises Refused where one of them is for the score, or no proof."""
    found = Collected()
    for folder in folders:
        found.add(folder, answers)
    return found


def calibrate(found: Collected) -> Calibration:
    return Calibration.of(found.scores(), sorted(found.seeds))


def rows(found: Collected) -> list[tuple[str, ...]]:
    """Of each class: its calibration, and what its sets are worth."""
    others = {case: Calibration.of(found.scores(case)) for case in {t.case for t in found.truths}}
    return [_row(kind, [t for t in found.truths if t.kind == kind], calibrate(found), others) for kind in CLASSES]


def _row(kind: str, truths: list[Truth], by: Calibration, others: dict[str, Calibration]) -> tuple[str, ...]:
    if not truths:
        return kind, "0", *("–",) * 6
    sizes = [len(t.names(others[t.case])) for t in truths]
    least = by.least(kind)
    covered = str(rate(t.is_covered(others[t.case]) for t in truths))
    of = ("–", "belief") if least is None else (f"{by.quantiles[kind]:.3g}", "cases")
    told = sum(any(t.told.hits) for t in truths)
    return kind, str(len(truths)), str(told), *of, covered, f"{median(sizes):g}", percent(sizes.count(1) / len(sizes))


def softening_words(found: Collected) -> str:
    """The temperature that the same cases would like best."""
    best = fit_softening(found.truths)
    if best is None:
        return "Softening: no case names its truth beside a rival."
    nats = f"{best.nats:.3g} nats" if best.first < best.count else "the less the better, for all came first"
    return (
        f"Softening by log loss over {best.count} truths named among others, {best.first} of them first: {nats} "
        f"(loss {best.loss:.3g}); at present {SETTINGS.softening:g} nats (loss {best.loss_now:.3g})."
    )


def main(folders: list[Path], answers: str, is_written: bool) -> None:
    console, found = Console(width=120), collect(folders, answers)
    table = Table(title=f"Sets by the bench, α = {1 - SETTINGS.covered:.2g}, {len(found.cases)} cases")
    for heading in HEADINGS:
        table.add_column(heading)
    for row in rows(found):
        table.add_row(*row)
    console.print(table)
    console.print(softening_words(found))
    if found.left_out:
        console.print("Left out: " + ", ".join(f"{n} {why}" for why, n in sorted(found.left_out.items())) + ".")
    if not shipped().settings:
        console.print("What is shipped was calibrated under other settings and counts for nothing.")
    if is_written and found.truths:
        write_text(SHIPPED, json.dumps(calibrate(found).summary(), indent=1) + "\n")
        console.print(f"Written: {SHIPPED}", soft_wrap=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--answers", default="out")
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    try:
        main(given.folders, given.answers, given.write)
    except (Refused, Broken) as refused:
        sys.exit(f"refused: {refused}")
