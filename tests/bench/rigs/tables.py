"""The rows as tables for the terminal, and as one in markdown."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bench.rigs.answers import GRADES
from bench.rigs.figures import Figures
from bench.rigs.rows import STAGES, Row
from rich.table import Table

WHOLE = ("nothing", "ridge on inputs")
"""Baselines that tell every channel."""
BASELINES = (*WHOLE, "ridge on temperatures")
DASH = "–"


def tables(rows: Sequence[Row]) -> Iterator[Table]:
    splits, concealed = [r for r in rows if not r.hides], [r for r in rows if r.hides]
    if splits:
        yield _split_table(splits)
        yield _channel_table(splits)
    if concealed:
        yield _concealed_table(concealed)


def _table(title: str, headings: Sequence[str], lines: Sequence[Sequence[str]]) -> Table:
    table = Table(title=title)
    for heading in headings:
        table.add_column(heading)
    for line in lines:
        table.add_row(*line)
    return table


def _split_table(rows: Sequence[Row]) -> Table:
    headings = ("rig, learned from → held out", "learned from", *WHOLE, *STAGES, "verdict", "named", "s")
    lines = [(r.title, pooled_over(r), *_held_out(r), verdict(r), "; ".join(r.named) or DASH, f"{r.seconds:.0f}")
             for r in rows]  # fmt: skip
    return _table("Real rigs: rms over all channels of the held-out runs, in units of declared noise", headings, lines)


def _held_out(row: Row) -> list[str]:
    measured = row.measured
    return [noise(of.get(name)) for of, names in ((measured.baselines, WHOLE), (measured.holdout, STAGES))
            for name in names]  # fmt: skip


def pooled_over(row: Row) -> str:
    """Of the runs learned from, by stage."""
    return " → ".join(noise(row.measured.train.get(stage)) for stage in STAGES)


def noise(figures: Figures | None) -> str:
    return f"{short(figures.noise)} σ" if figures else DASH


def short(value: float, digits: int = 3) -> str:
    """To as many digits, and whole where it has more."""
    return f"{value:.0f}" if value >= 10**digits else f"{value:.{digits}g}"


def verdict(row: Row) -> str:
    return row.verdict or row.told


def _channel_table(rows: Sequence[Row]) -> Table:
    lines = [line for row in rows for line in _channel_lines(row)]
    headings = ("rig", "channel", *BASELINES, *STAGES)
    return _table("Held out, channel by channel: rms, and in units of declared noise", headings, lines)


def _channel_lines(row: Row) -> Iterator[tuple[str, ...]]:
    told = [*(row.measured.baselines.get(b) for b in BASELINES), *(row.measured.holdout.get(s) for s in STAGES)]
    for name in dict.fromkeys(name for figures in told if figures for name in figures.channels):
        yield (row.title, name, *(channel(figures, name) for figures in told))


def channel(figures: Figures | None, name: str) -> str:
    """`0.82 K (8.2 σ)`."""
    if figures is None or name not in figures.channels:
        return DASH
    size = figures.channels[name]
    return f"{short(size.rms)} {size.unit} ({short(size.noise)} σ)"


def _concealed_table(rows: Sequence[Row]) -> Table:
    headings = ("rig", "hidden", "right answer", "score", "verdict", "named", "held out: calibrated → diagnosed",
                "heat found", "s")  # fmt: skip
    lines = [(r.title, r.hides, r.right, graded(r), verdict(r), "; ".join(r.named) or DASH, gained(r), heat(r),
              f"{r.seconds:.0f}") for r in rows]  # fmt: skip
    return _table(f"Concealed on real rigs: {tally(rows)}", headings, lines)


def tally(rows: Sequence[Row]) -> str:
    grades = [r.score.grade for r in rows if r.score]
    return ", ".join(f"{grades.count(grade)} {grade}" for grade in GRADES if grade in grades)


def graded(row: Row) -> str:
    if row.score is None:
        return DASH
    return f"{row.score.grade}: {row.score.by}" if row.score.by else row.score.grade


def gained(row: Row) -> str:
    held = row.measured.holdout
    return f"{noise(held.get('calibrated'))} → {noise(held.get('diagnosed'))}"


def heat(row: Row) -> str:
    found = row.measured.recovered
    return f"r = {found.correlation:.2f}, {100 * found.energy:.0f} % of the energy" if found else DASH


def markdown(rows: Sequence[Row]) -> str:
    """One table: splits, then concealments."""
    headings = ("rig, learned from → held out", "without physics", *STAGES, "named (confidence)", "s")
    lines = [headings, ["---"] * len(headings), *map(_markdown_line, rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _markdown_line(row: Row) -> tuple[str, ...]:
    measured = row.measured
    best = "; ".join(f"{name} {sizes(f)}" for name, f in measured.baselines.items()) or DASH
    title = f"{row.title}, without {row.hides}: **{graded(row)}**" if row.hides else row.title
    stages = [sizes(measured.holdout.get(stage)) for stage in STAGES]
    told = f"{verdict(row)}: {'; '.join(row.named) or 'nothing'}" if row.verdict else row.told
    return (title, best, *stages, told, f"{row.seconds:.0f}")


def sizes(figures: Figures | None) -> str:
    """`T1 1.5, T2 1.7 K, 16 σ`."""
    if figures is None:
        return DASH
    units = dict.fromkeys(size.unit for size in figures.channels.values())
    told = [
        ", ".join(f"{n} {short(s.rms, 2)}" for n, s in figures.channels.items() if s.unit == u) + f" {u}" for u in units
    ]
    return f"{', '.join(told)}, {short(figures.noise)} σ"
