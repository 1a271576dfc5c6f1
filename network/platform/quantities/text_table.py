"""A table in plain text: words to the left, numbers to the right, units in the header."""

from __future__ import annotations

import math
from collections.abc import Sequence

MOST_ROWS = 40


def table(header: Sequence[str], rows: Sequence[Sequence[str]], numbers: Sequence[str] = ()) -> list[str]:
    """Lines of a table, indented by two; the columns named in `numbers` stand to the right. Long tables are cut."""
    shown = [header, *([write_sign(c) if n in numbers else c for n, c in zip(header, row, strict=True)]
                       for row in rows[:MOST_ROWS])]  # fmt: skip
    widths = [max(len(row[k]) for row in shown) for k in range(len(header))]
    lines = []
    for row in shown:
        cells = (
            cell.rjust(width) if name in numbers else cell.ljust(width)
            for name, cell, width in zip(header, row, widths, strict=True)
        )
        lines.append(("  " + "  ".join(cells)).rstrip())
    more = len(rows) - MOST_ROWS
    return [*lines, f"  … and {more} more"] if more > 0 else lines


def write_sign(cell: str) -> str:
    """A cell with a true minus, and none before nothing."""
    if not cell.startswith("-"):
        return cell
    return f"−{cell[1:]}" if cell.strip("-0.") else cell[1:]


def format_shift(value: float, places: int = 1) -> str:
    """A shift with its sign: +2.5, −0.1; nothing is +0.0."""
    return f"{round(value, places) + 0.0:+.{places}f}".replace("-", "−")


def digits(value: float, most: int = 4) -> str:
    """A number to so many digits, without exponent where it can be read without; – for none."""
    if not math.isfinite(value):
        return "–"
    if value == 0 or 1e-3 <= abs(value) < 1e6:
        places = most - 1 - int(f"{value:.{most - 1}e}".partition("e")[2]) if value else 0
        return f"{value:.{max(places, 0)}f}"
    return f"{value:.{most}g}"


def span(seconds: float) -> str:
    """A time in the unit that reads best: 42 s, 12 min, 3.5 h, 4.2 d."""
    for name, length in (("d", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if abs(seconds) >= 2 * length:
            return f"{seconds / length:.3g} {name}"
    return f"{seconds:.3g} s"
