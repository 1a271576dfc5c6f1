"""A score as plain text: what it adds up to, the confusion matrix, and a line for each case."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from proof.judging import Judgement

if TYPE_CHECKING:
    from proof.score import Score


def tell(score: Score) -> str:
    return "\n".join([*totals(score), "", *confusion(score), "", *cases(score)])


def totals(score: Score) -> Iterator[str]:
    yield (
        f"{len(score.judgements)} cases: {len(score.effects)} with effects of the catalogue, {len(score.nulls)} with "
        f"nothing concealed, {len(score.outsiders)} with something outside the catalogue"
    )
    for name, rate in score.rates.items():
        yield f"  {name:32} {rate}"
    yield f"  {'held-out excess removed, median':32} {shown(score.removed, 100, ' %')}"
    yield f"  {'calibration error':32} {shown(score.calibration_error, 100, ' %')}"
    yield f"  {'time of a diagnosis, median':32} {shown(score.seconds, 1, ' s')}"


def shown(value: float | None, scale: float, unit: str) -> str:
    return "–" if value is None else f"{value * scale:.3g}{unit}"


def confusion(score: Score) -> Iterator[str]:
    """What was concealed, and how it was answered how often, the most frequent first."""
    yield "concealed → answered"
    counted = score.confusion
    for expected in sorted({expected for expected, _ in counted}):
        answers = sorted(((n, told) for (what, told), n in counted.items() if what == expected), reverse=True)
        yield f"  {expected:36} {', '.join(f'{told} × {n}' for n, told in answers)}"


def cases(score: Score) -> Iterator[str]:
    head = ["case", "machine", "truth", "concealed", "answered", "name", "place", "held out", "time [s]", "visible [σ]"]
    rows = [head, *(row(each) for each in score.judgements)]
    widths = [max(len(line[i]) for line in rows) for i in range(len(rows[0]))]
    for line in rows:
        yield "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()


def row(each: Judgement) -> list[str]:
    concealed = each.expected or f"nothing ({each.what})"
    right = ["accused" if each.accused else "", ""] if each.innocent else [yes(each.named), yes(each.placed)]
    moved = "" if each.before is None or each.after is None else f"{each.before:.2f} → {each.after:.2f}"
    told = [moved, "" if each.seconds is None else f"{each.seconds:.0f}", f"{each.visible:.1f}"]
    return [each.case, each.layout, each.truth, concealed, each.answer, *right, *told]


def yes(right: bool) -> str:
    return "right" if right else "wrong"
