"""A finding in words: its size, how sure it is, what speaks for it, and what else it could be."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from network.analysis.diagnosis.findings.conformal import NOTHING, shipped
from network.analysis.diagnosis.findings.finding import UNKNOWN
from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import digits
from network.platform.quantities.units import difference, show, unit
from network.platform.wording import join_either, join_names, name_of
from network.report.words.heat_words import THROUGHOUT, when
from network.report.words.recording_names import name_recording

if TYPE_CHECKING:
    from network.analysis.diagnosis.findings.finding import Finding, Quantity, Rival
    from network.analysis.diagnosis.findings.result import Diagnosis

MOST_RIVALS = 4
MOST_WINDOWS = 3
SURE = ((95, "nearly certain"), (75, "probable"), (55, "more likely than not"), (45, "an even chance"), (0, "doubtful"))
"""Words for a confidence, from so many percent."""
EVEN = 0.1
"""Confidences nearer than this are called the same."""
PREFIXED = ("W", "J", "N")
BENCH = (
    "Confidence is by the bench: it was set on simulated machines of which the truth is known. On a real one it may be "
    "too high."
)


def plus_minus(q: Quantity) -> str:
    """790 ± 30 W: the standard error to two digits and the value to as many places; alone where it was not free."""
    std = q.std / difference(unit(q.unit)).scale
    value = float(show(q.value, q.unit, 12).partition(" ")[0])
    if not (math.isfinite(std) and std > 0):
        return f"{digits(value, 4)} {format_unit(q.unit)}".rstrip()
    prefix, scale = _prefix(max(abs(value), std), q.unit)
    value, std = value / scale, std / scale
    places = 1 - int(f"{std:.1e}".partition("e")[2])
    low, near = (f"{round(x, places) + 0.0:.{max(places, 0)}f}".replace("-", "−") for x in (value, std))
    return f"{low} ± {near} {prefix}{format_unit(q.unit)}".rstrip()


def format_unit(unit_text: str) -> str:
    return pretty(unit_text).replace("–", "")


def _prefix(size: float, unit_text: str) -> tuple[str, float]:
    """kilo or mega where that saves digits."""
    if unit_text.partition("/")[0] not in PREFIXED or size < 1e4:
        return "", 1.0
    return ("M", 1e6) if size >= 1e6 else ("k", 1e3)


def sizes(finding: Finding) -> list[tuple[str, str]]:
    """Every number of it, with its standard error."""
    return [(name_of(name), plus_minus(q)) for name, q in finding.parameters.items()]


def sure_word(confidence: float) -> str:
    """A confidence as a word: of the percent that are shown, so that one number has one word."""
    return next(word for least, word in SURE if round(100 * confidence) >= least)


def sure_words(finding: Finding) -> str:
    """The confidence as a word and a number; beside what cannot be told from it, what that has."""
    p, alike = finding.confidence, {rival_name(r): finding.confidence_of(r) for r in finding.indistinguishable}
    if not alike:
        why = f"; a part of the truth at most, for {join_names(list(finding.doubts))}" if finding.doubts else ""
        return f"{sure_word(p)}, {percent(p)}{why}"
    if all(abs(p - q) < EVEN for q in alike.values()):
        return f"{percent(p)}: as likely as {join_names([*alike])}"
    return f"{percent(p)}, beside {join_names([f'{percent(q)} for {name}' for name, q in alike.items()])}"


def evidence_words(finding: Finding) -> str:
    """How clearly it stands out, and what chance reaches: as the σ of a single number that adds so much."""
    if not math.isfinite(finding.gain):
        return "Without it the machine cannot be fitted at all."
    own, chance = (digits(max(to_sigma(nats), 0.0), 2) for nats in (finding.gain, finding.threshold))
    if finding.gain < finding.threshold:
        return f"It stands out by {own} σ, less than chance alone may ({chance} σ)."
    return f"It stands out by {own} σ; chance alone may reach {chance} σ."


def to_sigma(nats: float) -> float:
    """Log evidence as the σ by which a single number would have to stand out to add as much: z²/2 nats."""
    return math.copysign(math.sqrt(2 * abs(nats)), nats)


def windows_words(d: Diagnosis, finding: Finding) -> str:
    """When it showed most, on the recording that tells it; nothing where that was always, or is that of an earlier
    finding, or of a stop, whose sentence says so."""
    if finding.is_stop:
        return ""
    earlier = d.findings[: d.findings.index(finding)] if finding in d.findings else ()
    if (finding.run, finding.windows) in [(f.run, f.windows) for f in earlier]:
        return ""
    longest = sorted(finding.windows, key=lambda w: w[0] - w[1])[:MOST_WINDOWS]
    shown = d.fits.train_before.recordings[finding.run]
    t, name = shown.trajectory.t, name_recording(d, shown)
    told = [when(first, last, t, name) for first, last in sorted(longest)]
    if not told or any(text.startswith(THROUGHOUT) for text in told):
        return ""
    words = [text[:1].lower() + text[1:] for text in told]
    short = [text.removesuffix(f" of {name}") for text in words[:-1]] + words[-1:]
    return f"It showed most {join_names(short)}{', and at other times' if len(finding.windows) > MOST_WINDOWS else ''}."


def rival_name(rival: Rival) -> str:
    """Kind and place, as a reader says it."""
    seats = rival.places or rival.channels
    return f"{name_of(rival.kind)} ({', '.join(seats)})" if seats else name_of(rival.kind)


def rivals_words(finding: Finding) -> Iterator[str]:
    """What else was fitted, and what speaks against each; without what cannot be told from it."""
    alike = {rival_name(r) for r in finding.indistinguishable}
    apart = [r for r in finding.alternatives if rival_name(r) not in alike]
    for rival in apart[:MOST_RIVALS]:
        yield f"{rival_name(rival)}, {percent(finding.confidence_of(rival))}: {rival.why_not}"


def percent(share: float) -> str:
    return "below 1 %" if share < 0.01 else f"{100 * share:.0f} %"


def set_words(finding: Finding) -> str:
    """The explanations between which it leaves the choice, where cases of the bench say how many that takes."""
    names = [_member_name(name) for name in finding.members]
    if len(names) < 2 or shipped().least(finding.truth) is None:
        return ""
    return f"By the bench it is one of these: {join_either(names)}."


def _member_name(name: str) -> str:
    kind, _, seats = name.partition("@")
    what = {NOTHING: "nothing at all", UNKNOWN: "something without a name"}.get(kind, name_of(kind))
    return f"{what} ({', '.join(seats.split('|'))})" if seats else what


def bench_words(d: Diagnosis) -> str:
    """Where confidences come from, once."""
    return BENCH if d.findings else ""


def alike_words(finding: Finding) -> str:
    """What these recordings cannot tell it from."""
    names = [rival_name(rival) for rival in finding.indistinguishable]
    return f"These recordings cannot tell it from {join_names(names)}." if names else ""
