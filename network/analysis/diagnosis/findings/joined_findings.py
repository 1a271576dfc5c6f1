"""One thing told once: what takes two of one kind at one place, what says better what was found before it, and what a
fault of a channel leaves there."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from network.analysis.diagnosis.findings.finding import Finding
from network.analysis.diagnosis.findings.invariants import MAY_BE_ONE
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.declaration.patch import Patch

NOT_ALL = "it does not tell all that shows there"
Read = Callable[[Iterable[str]], Iterable[str]]


def join_alike(findings: Sequence[Finding]) -> list[Finding]:
    """The first of one kind at one place, with the others of it, and a fault of a channel with what it leaves there:
    their form is not exactly that of the kind. Numbers and evidence stay those of the first; the others stand in the
    sentence and in the machine. What stands in the place of an entry that was found is that entry, by its right law."""
    return _fold(findings, _join)


def join_rests(findings: Sequence[Finding], read: Read) -> list[Finding]:
    """Findings, of which what is in the machine without a sure name, in the parts that a channel reads whose readings
    were set right by some size, is what that leaves there. read: the parts that some channels read."""
    return _fold(findings, lambda fault, f: _leave(fault, f) if _is_read_by(fault, f, read) else None)


def _fold(findings: Sequence[Finding], join: Callable[[Finding, Finding], Finding | None]) -> list[Finding]:
    """Each with the first of those before it that takes it in."""
    told: list[Finding] = []
    for f in findings:
        k, joined = next(((k, one) for k, first in enumerate(told) if (one := join(first, f))), (len(told), f))
        told[k:] = [joined, *told[k + 1 :]]
    return told


def _leave(fault: Finding, rest: Finding) -> Finding:
    """As sure as the fault is: that it leaves something says of its size, not of it."""
    doubts, others = dict.fromkeys((*fault.doubts, NOT_ALL)), (*fault.alternatives, *rest.alternatives)
    return replace(lay_together(fault, [rest]), doubts=tuple(doubts), alternatives=others)


def _is_read_by(fault: Finding, f: Finding, read: Read) -> bool:
    is_fault = fault.holds is None and bool(fault.parameters) and not fault.is_unnamed
    is_rest = f.is_withheld and bool(f.places) and not f.channels
    return is_fault and is_rest and {*f.places} <= {*read(fault.channels)}


def _join(first: Finding, other: Finding) -> Finding | None:
    """Both as one; None where they are two things."""
    if _is_law_of(first, other):
        return _put_in_place(other, first)
    return _take_in(first, other) if _is_one(first, other) else None


def _is_law_of(first: Finding, other: Finding) -> bool:
    """Whether the second finding is the law of an entry of the machine that the first one brought."""
    brought = {path for path, _ in first.patch.by_name()}
    laws = (path for path, body in other.patch.by_name() if body and body.get("kind") == other.kind)
    is_heat = not (other.channels or other.is_unnamed or first.is_unnamed)
    return is_heat and other.kind != first.kind and first.sits_with(other) and any(path in brought for path in laws)


def _put_in_place(other: Finding, first: Finding) -> Finding:
    """A finding with the numbers, the evidence and the doubts of the one in whose place it stands."""
    doubts = tuple(d for d in dict.fromkeys((*first.doubts, *other.doubts)) if d != MAY_BE_ONE)
    share = other.confidence if other.share is None else other.share
    sure = min(share * (1.0 if other.holds is None else other.holds), SETTINGS.most_sure)
    return replace(
        other, patch=lay_together(first, [other]).patch, parameters={**first.parameters, **other.parameters},
        gain=first.gain + other.gain, doubts=doubts, confidence=min(sure, other.confidence) if doubts else sure,
        windows=first.windows, nothing=first.nothing, course=other.course or first.course,
    )  # fmt: skip


def lay_together(first: Finding, others: Sequence[Finding]) -> Finding:
    """A finding with what others say and add to the machine."""
    entries = [entry for each in (first, *others) for entry in each.patch.by_name()]
    said = " ".join(each.sentence for each in (first, *others))
    return replace(first, patch=Patch.of(entries), sentence=said)


def _is_one(first: Finding, other: Finding) -> bool:
    is_what_it_leaves = bool(other.channels) and other.is_unnamed
    is_named = not (first.is_unnamed or first.is_cut)
    return is_named and first.sits_with(other) and (first.kind == other.kind or is_what_it_leaves)


def _take_in(first: Finding, other: Finding) -> Finding:
    """A finding with another that is the same thing."""
    doubts = [d for d in dict.fromkeys((*first.doubts, *other.doubts)) if d not in (MAY_BE_ONE, NOT_ALL)]
    joined = replace(first, doubts=tuple(doubts), course=first.course or other.course)
    return lay_together(joined, [other]).doubted(NOT_ALL)
