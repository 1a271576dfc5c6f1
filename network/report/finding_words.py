"""A finding in words: its size, how sure it is, what speaks for it, and what else it could be."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from network.report.canvas import pretty
from network.report.heat_words import when
from network.report.naming import called
from network.report.table import digits
from network.residuals.amounts import joined
from network.units import difference, show, unit

if TYPE_CHECKING:
    from network.diagnosis.verdict import Diagnosis, Finding, Quantity, Rival

MOST_RIVALS = 4
MOST_WINDOWS = 3


def plus_minus(q: Quantity) -> str:
    """790 ± 30 W: as many places as the standard error has two digits of; without it where it was not free."""
    std = q.std / difference(unit(q.unit)).scale
    value = float(show(q.value, q.unit, 12).partition(" ")[0])
    text = pretty(q.unit).replace("–", "")
    if not (math.isfinite(std) and std > 0):
        return f"{digits(value, 4)} {text}".rstrip()
    places = max(1 - int(f"{std:.1e}".partition("e")[2]), 0)
    return f"{value:.{places}f} ± {std:.{places}f} {text}".rstrip()


def name_of(kind: str) -> str:
    return kind.replace("_", " ")


def sizes(finding: Finding) -> list[tuple[str, str]]:
    """Every number of it, with its standard error."""
    return [(name_of(name), plus_minus(q)) for name, q in finding.parameters.items()]


def sure_words(finding: Finding) -> str:
    """The confidence as a word and a number."""
    p = finding.confidence
    word = "nearly certain" if p > 0.95 else "probable" if p > 0.75 else "likely" if p > 0.5 else "doubtful"
    return f"{word}, {100 * p:.0f} %"


def evidence_words(finding: Finding) -> str:
    """What it adds to the log evidence, against what chance adds."""
    if not math.isfinite(finding.gain):
        return "Without it the machine cannot be fitted at all."
    times = finding.gain / finding.threshold if finding.threshold > 0 else math.inf
    told = f"It adds {_nats(finding.gain)} nats of log evidence, where chance reaches {_nats(finding.threshold)}"
    return f"{told}: {times:.0f} times as much." if 2 <= times < 200 else f"{told}."


def _nats(value: float) -> str:
    return f"{value:.0f}" if abs(value) >= 100 else digits(value, 2)


def windows_words(d: Diagnosis, finding: Finding) -> str:
    """When it showed most, on the first recording."""
    if not finding.windows:
        return ""
    longest = sorted(finding.windows, key=lambda w: w[0] - w[1])[:MOST_WINDOWS]
    t, name = d.fits.train_before.recordings[0].trajectory.t, called(d, d.fits.train_before.recordings[0])
    told = [when(first, last, t, name) for first, last in sorted(longest)]
    words = [text[:1].lower() + text[1:] for text in told]
    short = [text.removesuffix(f" of {name}") for text in words[:-1]] + words[-1:]
    return f"It showed most {joined(short)}{', and at other times' if len(finding.windows) > MOST_WINDOWS else ''}."


def rival_name(rival: Rival) -> str:
    """Kind and place, as a reader says it."""
    seats = rival.places or rival.channels
    return f"{name_of(rival.kind)} ({', '.join(seats)})" if seats else name_of(rival.kind)


def rivals_words(finding: Finding) -> Iterator[str]:
    """What else was fitted, and what speaks against each."""
    for rival in finding.alternatives[:MOST_RIVALS]:
        against = " ".join(rival.why_not.split()).rstrip(".")
        yield f"{rival_name(rival)}, {percent(rival.confidence)}: {against}"


def percent(share: float) -> str:
    return "below 1 %" if share < 0.01 else f"{100 * share:.0f} %"


def alike_words(finding: Finding) -> str:
    """What these recordings cannot tell it from."""
    names = [rival_name(rival) for rival in finding.indistinguishable]
    return f"These recordings cannot tell it from {joined(names)}." if names else ""
