"""The score of the CNC lathe as a table in the terminal, as markdown, and for machines."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from bench.cnc_lathe_figures import Miss, over_days
from rich.console import Console
from rich.table import Table

Scores = Mapping[str, Mapping[str, Sequence[Miss]]]
"""By what is left out (day, climate), by method."""
HEADINGS = ("X", "Z", "X, mean out", "Z, mean out")


def title(by: str, misses: Mapping[str, Sequence[Miss]]) -> str:
    days = len(next(iter(misses.values())))
    return f"CNC lathe, one {by} left out: rms over {days} days while the spindle turns [µm]"


def rows(misses: Mapping[str, Sequence[Miss]], days: bool) -> Iterator[tuple[str, ...]]:
    """Method, what is left out, and the figures; with days, each of them above their rms."""
    for name, some in misses.items():
        shown = [*some, over_days(some)] if days else [over_days(some)]
        for one in shown:
            label = name if one is shown[-1] else f"{name}: {one.day} ({one.climate})"
            yield label, *(f"{value:.1f}" for value in (*one.absolute, *one.mean_out))


def table(scores: Scores, days: bool) -> None:
    for by, misses in scores.items():
        made = Table(title=title(by, misses))
        made.add_column("told by")
        for heading in HEADINGS:
            made.add_column(heading, justify="right")
        for row in rows(misses, days):
            made.add_row(*row)
        Console(width=110).print(made)


def markdown(scores: Scores, days: bool) -> str:
    lines = []
    for by, misses in scores.items():
        lines += [title(by, misses), "", f"| told by | {' | '.join(HEADINGS)} |", "|---|" + "---|" * len(HEADINGS)]
        lines += [f"| {' | '.join(row)} |" for row in rows(misses, days)] + [""]
    return "\n".join(lines)


def as_json(scores: Scores) -> str:
    """By what is left out, by method: `all`, and every day."""
    plain = {
        by: {name: {m.day: _plain(m) for m in (over_days(some), *some)} for name, some in misses.items()}
        for by, misses in scores.items()
    }
    return json.dumps(plain, indent=1, ensure_ascii=False)


def _plain(one: Miss) -> dict[str, Any]:
    figures = {"x": one.absolute[0], "z": one.absolute[1], "x_mean_out": one.mean_out[0], "z_mean_out": one.mean_out[1]}
    return {"climate": one.climate, "unit": "um"} | {name: round(float(v), 3) for name, v in figures.items()}
