"""A warm-up in words: what serves, and what every speed that was tried needs or leaves."""

from __future__ import annotations

from typing import TYPE_CHECKING

from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import digits, table
from network.platform.quantities.units import unit
from network.report.words.lump_words import tell_cut

if TYPE_CHECKING:
    from network.analysis.sweep.warm_up import Attempt, WarmUp


def tell_warm_up(found: WarmUp) -> str:
    """One sentence, and a row for every speed."""
    header = [found.input, "shortest [min]", f"left [{pretty(found.tolerance.unit.text)}]"]
    rows = [[name_speed(found, a), _minutes(a), _left(found, a.leaves)] for a in found.attempts]
    lines = ["", *table(header, rows, header[1:])] if found.is_needed else []
    cut = tell_cut(found.lumping)
    return "\n".join([_sentence(found), *lines, *(["", *cut] if cut else [])])


def _sentence(found: WarmUp) -> str:
    shown, name = pretty(found.tolerance.unit.text), found.scenario.name
    without = f"{_left(found, found.none)} {shown}"
    limit = f"{found.tolerance.unit.from_si(found.tolerance.value):.4g} {shown}"
    if not found.is_needed:
        return f"No warm-up is needed: over {name!r} the tool centre point moves by {without}, within {limit}."
    chosen = found.chosen
    left, speed = f"{_left(found, chosen.leaves)} {shown}", name_speed(found, chosen)
    if chosen.shortest is None:
        best = f"the best tried, {chosen.best / 60:.0f} min at {speed}, leaves {left}; without it is {without}"
        return f"No warm-up tried brings it within {limit} over {name!r}: {best}."
    return f"{_minutes(chosen)} min at {speed} leave {left} over {name!r}, within {limit}; without it is {without}."


def name_speed(found: WarmUp, attempt: Attempt) -> str:
    return f"{unit(found.unit).from_si(attempt.value):.5g} {pretty(found.unit)}"


def _minutes(attempt: Attempt) -> str:
    return "–" if attempt.shortest is None else f"{attempt.shortest / 60:.0f}"


def _left(found: WarmUp, value: float) -> str:
    return digits(found.tolerance.unit.from_si(value), 3)
