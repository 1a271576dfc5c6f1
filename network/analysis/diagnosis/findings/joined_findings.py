"""One thing told once: what takes two of one kind at one place, and what a fault of a channel leaves there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from network.analysis.diagnosis.findings.finding import Finding
from network.analysis.diagnosis.findings.invariants import MAY_BE_ONE
from network.catalogue.declaration.patch import Patch

NOT_ALL = "it does not tell all that shows there"


def join_alike(findings: Sequence[Finding]) -> list[Finding]:
    """The first of one kind at one place, with the others of it, and a fault of a channel with what it leaves there:
    their form is not exactly that of the kind. Numbers and evidence stay those of the first; the others stand in the
    sentence and in the machine."""
    told: list[Finding] = []
    for f in findings:
        k = next((k for k, first in enumerate(told) if _is_one(first, f)), None)
        if k is None:
            told.append(f)
        else:
            told[k] = _take_in(told[k], f)
    return told


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
