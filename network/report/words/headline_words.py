"""What was found in one clause: what the machine lacks, which channels do not read true, what has no name."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from network.analysis.diagnosis.findings.finding import UNKNOWN
from network.platform.wording import join_names
from network.report.words.tie_words import seats_words

if TYPE_CHECKING:
    from network.analysis.diagnosis.findings.finding import Finding
    from network.analysis.diagnosis.findings.result import Diagnosis

COUNTS = ("nothing", "one effect", "two effects", "three effects", "four effects")


def found_words(d: Diagnosis) -> str:
    """All that was found."""
    machine = list(_tell_machine(d))
    told = [*machine, *_tell_readings(d), *_tell_nameless(d)]
    start = "" if machine else f"In the recordings of {d.machine.name} "
    return start + ", and ".join([", ".join(told[:-1]), told[-1]] if len(told) > 1 else told)


def added_words(d: Diagnosis) -> str:
    """What of it the better machine counts in."""
    if any(f.kind == UNKNOWN for f in d.findings):
        return "what has a name counted in"
    if any(f.channels or f.is_cut for f in d.findings):
        return "all that counted in"
    return "it in" if len(d.findings) < 2 else "them in"


def misread_words(d: Diagnosis) -> str:
    """Which channels do not read true, and what stood."""
    return ", and ".join(_tell_readings(d)) or "a channel does not read true"


def place_words(d: Diagnosis) -> str:
    """Where it sits: what has no name, if something has none."""
    return _at(d, [f for f in d.findings if f.kind == UNKNOWN] or d.findings)


def finer_words(d: Diagnosis) -> str:
    """Which parts have more lumps in the better machine; nothing where none has."""
    finer = [f for f in d.findings if f.is_cut]
    return f"with more lumps{_at(d, finer)}" if finer else ""


def _tell_machine(d: Diagnosis) -> Iterator[str]:
    effects = [f for f in d.findings if not (f.channels or f.kind == UNKNOWN or f.is_cut)]
    finer = [f for f in d.findings if f.is_cut]
    told = [f"lacks {_count(effects)} that its recordings show{_at_each(d, effects)}"] if effects else []
    told += [f"is cut too coarsely{_at(d, finer)}"] if finer else []
    if told:
        yield f"{d.machine.name} {', and '.join(told)}"


def _tell_readings(d: Diagnosis) -> Iterator[str]:
    told = [f for f in d.findings if f.kind != UNKNOWN]
    channels = list(dict.fromkeys(n for f in told if not f.is_stop for n in f.channels))
    if channels:
        yield f"{join_names(channels)} {'does' if len(channels) == 1 else 'do'} not read true"
    for f in (f for f in told if f.is_stop):
        is_one = len(f.channels) == 1
        yield f"when {join_names(list(f.channels))} stood still is not in {'its' if is_one else 'their'} recordings"


def _tell_nameless(d: Diagnosis) -> Iterator[str]:
    nameless = [f for f in d.findings if f.kind == UNKNOWN and not f.is_withheld]
    unsure = [f for f in d.findings if f.is_withheld]
    if nameless:
        yield f"something is left{_at(d, nameless)} that nothing in the catalogue explains"
    if unsure:
        yield f"something{_at(d, unsure)} has no sure name"


def _count(effects: Sequence[Finding]) -> str:
    return COUNTS[len(effects)] if len(effects) < len(COUNTS) else f"{len(effects)} effects"


def _at_each(d: Diagnosis, findings: Sequence[Finding]) -> str:
    """One at each place where no two share one."""
    seats = list(dict.fromkeys(seats_words(d, f) for f in findings))
    if len(findings) == 1 or len(seats) < len(findings) or not all(seats):
        return _at(d, findings)
    return f", {join_names([f'one at {seat}' for seat in seats])}"


def _at(d: Diagnosis, findings: Sequence[Finding]) -> str:
    seats = list(dict.fromkeys(seats_words(d, f) for f in findings))
    return f" at {join_names(seats)}" if seats and all(seats) else ""
