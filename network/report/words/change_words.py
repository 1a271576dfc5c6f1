"""Then and now in words: what changed, by how much, what that means and how far it moves the tool."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from typing import TYPE_CHECKING

from network.engine.trajectory import axis_unit
from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import digits, span, table
from network.platform.quantities.units import unit
from network.platform.wording import join_names, sentence

if TYPE_CHECKING:
    from network.analysis.change.changes import Change, Changes

WIDTH, FINEST = 110, 3
BEYOND = 2.0
"""Misfit from which it is told that the machine does not explain its recordings."""


def tell_changes(found: Changes) -> str:
    """What was compared, a row for every change, and what each means."""
    head = f"{found.machine.name}: then and now ({span(found.seconds)}, seed {found.seed})"
    paragraphs = [_compared(found), *(explain(found, change) for change in found.found), *_doubts(found)]
    lines = [line for text in paragraphs for line in textwrap.wrap(text, WIDTH)]
    return "\n".join([head, *_rows(found), *lines])


def _rows(found: Changes) -> list[str]:
    if not found.found:
        return []
    header = ["changed", "then", "now", "±", "beyond", "moves the tool"]
    rows = [[c.number, f"{digits(c.then, 4)} {pretty(c.unit)}".strip(), digits(c.now, 4), digits(c.std, 2),
             f"{digits(c.sigma, 2)} σ", moves(c)] for c in found.found]  # fmt: skip
    return ["", *table(header, rows, header[1:]), ""]


def moves(change: Change) -> str:
    """How far at most, along which axis."""
    axis, far = change.most
    if not axis:
        return "–"
    return f"{digits(far / unit(axis_unit(axis)).scale, 2)} {pretty(axis_unit(axis))} in {axis}"


def _compared(found: Changes) -> str:
    limit = f"{len(found.tested)} numbers and sensors could show a change, from {digits(found.limit, 2)} σ on"
    chance = "which a machine that has not changed reaches in one of them once in a thousand times"
    if not found.found:
        finest = [f"{name} by {digits(100 * by, 2)} %" for name, by in [*found.least.items()][:FINEST]]
        seen = f" A change of {join_names(finest)} would have been told." if finest else ""
        return f"{tell_nothing(found)} {sentence(limit)}, {chance}.{seen}"
    return f"Seen by {_runs(found)}; {limit}, {chance}."


def tell_nothing(found: Changes) -> str:
    return f"Nothing has changed that {_runs(found)} would show."


def _runs(found: Changes) -> str:
    return f"{count(found.then)} of then and {count(found.now)} of now"


def count(files: tuple[str, ...]) -> str:
    return f"{len(files)} recording{'s' if len(files) > 1 else ''}"


def explain(found: Changes, change: Change) -> str:
    """What it means, in a sentence, and what would explain it as well."""
    alike = f"; {join_names(list(change.alike))} would explain it as well" if change.alike else ""
    return f"{change.number}: {meaning(found, change)}{alike}."


def meaning(found: Changes, change: Change) -> str:
    """By its kind in the catalogue: friction that fell, a joint that loosened, a sensor that drifted."""
    has_grown = change.now > change.then
    if change.parameter is None:
        far = digits(abs(change.now - change.then), 2)
        way = "more" if has_grown else "less"
        return f"a sensor that drifted: it reads {far} {pretty(change.unit)} {way} than then"
    entry = found.machine.by_path[change.parameter.entry]
    told = entry.changed.get(change.parameter.attribute)
    way = "grew" if has_grown else "fell"
    what = told[0 if has_grown else 1] if told else f"{change.parameter.field.meaning} {way}"
    parts = dict.fromkeys(place for place in _places(entry))
    return f"{what} ({', '.join(parts)})" if parts else what


def _places(entry: object) -> Iterator[str]:
    """Parts that an entry names."""
    for name in ("between", "through"):
        yield from (place.node for place in getattr(entry, name, None) or ())
    yield from (place.node for place, _ in getattr(entry, "into", None) or ())


def _doubts(found: Changes) -> Iterator[str]:
    worst = max(found.scales)
    if worst > BEYOND:
        yield (
            f"What the machine leaves weighs {digits(worst, 2)} times what noise would (it lasts, so that its readings "
            "count as few): some physics is missing from it, and only what stands out beyond that is told. "
            "`lptn diagnose` without --reference looks for it."
        )
    if found.after.lumps > found.machine.lumps:
        was = f"({found.machine.lumps} in the file)"
        yield f"Parts are cut into {found.after.lumps} lumps {was}, as these recordings ask."
