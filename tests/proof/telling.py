"""A score as plain text: what it adds up to, the scored classes, the confusion matrix, and a line for each case."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from proof.judgement import VISIBLE, Judgement

if TYPE_CHECKING:
    from proof.score import Score

HEAD = ("case", "machine", "class", "concealed", "answered", "name", "place", "besides", "held out", "time [s]",
        "visible [σ]")  # fmt: skip


def tell(score: Score) -> str:
    return "\n".join([*totals(score), "", *classes(score), "", *confusion(score), "", *cases(score)])


def totals(score: Score) -> Iterator[str]:
    faint = sum(bool(each.expected) and not each.seen for each in score.judgements)
    yield (
        f"{len(score.judgements)} cases{sort_of(score)}: {len(score.effects)} with effects of the catalogue, "
        f"{len(score.of('innocent'))} with nothing concealed, {len(score.of('outside'))} with something outside the "
        f"catalogue; {faint} too faint to be asked for by name (below {VISIBLE:g} σ)"
    )
    for name, rate in score.rates.items():
        yield f"  {name:44} {rate}"
    for name, value in score.figures.items():
        yield f"  {name:44} {shown(value, *measure(name))}"
    yield "  (before: as the diagnosis calibrated it; after: the written machine simulated, where that was done)"


def sort_of(score: Score) -> str:
    if score.development is None:
        return ""
    return f" of seed {score.seed}, {'development' if score.development else 'scored'}"


def measure(name: str) -> tuple[float, str]:
    """Scale and unit of a figure."""
    return (100, " %") if name.startswith("held-out") else (1, " s") if name.startswith("seconds") else (1, "")


def shown(value: float | None, scale: float, unit: str) -> str:
    return "–" if value is None else f"{value * scale:.3g}{unit}"


def classes(score: Score) -> Iterator[str]:
    """Each scored class with its rates."""
    for group, rates in score.shares.items():
        yield f"{group} ({len(score.of(group))})"
        for name, rate in rates.items():
            yield f"  {name:44} {rate}"


def confusion(score: Score) -> Iterator[str]:
    """What was concealed, and how it was answered how often, the most frequent first."""
    yield "concealed → answered"
    counted = score.confusion
    for expected in sorted({expected for expected, _ in counted}):
        answers = sorted(((n, told) for (what, told), n in counted.items() if what == expected), reverse=True)
        yield f"  {expected:36} {', '.join(f'{told} × {n}' for n, told in answers)}"


def cases(score: Score) -> Iterator[str]:
    yield from columns([HEAD, *(row(each) for each in score.judgements)])


def columns(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Lines whose cells stand below each other."""
    widths = [max(len(line[i]) for line in rows) for i in range(len(rows[0]))]
    for line in rows:
        yield "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()


def row(each: Judgement) -> list[str]:
    concealed = each.expected or f"nothing ({each.what})"
    moved = "" if each.before is None or each.after is None else f"{each.before:.2f} → {each.after:.2f}"
    told = [moved, "" if each.seconds is None else f"{each.seconds:.0f}", f"{each.visible:.1f}"]
    return [each.case, each.layout, each.group, concealed, each.answer, *verdicts(each), *told]


def verdicts(each: Judgement) -> list[str]:
    """Name, place, and what is named besides."""
    besides = str(each.besides or "")
    if each.innocent:
        return ["accused" if each.accused else "", "", ""]
    if not each.seen:
        return ["too faint", "", str(each.stray or "")]
    return ["right" if each.first else "wrong", "right" if each.placed else "wrong", besides]
