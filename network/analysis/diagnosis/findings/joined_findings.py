"""One thing told once: what takes two of one kind at one place, what says better what was found before it, and what a
fault of a channel leaves there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from network.analysis.diagnosis.findings.finding import Finding
from network.analysis.diagnosis.findings.invariants import MAY_BE_ONE
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.declaration.patch import Patch

NOT_ALL = "it does not tell all that shows there"


def join_alike(findings: Sequence[Finding]) -> list[Finding]:
    """The first of one kind at one place, with the others of it, and a fault of a channel with what it leaves there:
    their form is not exactly that of the kind. Numbers and evidence stay those of the first; the others stand in the
    sentence and in the machine. What stands in the place of an entry that was found is that entry, by its right law."""
    told: list[Finding] = []
    for f in findings:
        k = next((k for k, first in enumerate(told) if _is_one(first, f) or _replaces(f, first)), None)
        if k is None:
            told.append(f)
        else:
            told[k] = _put_in_place(f, told[k]) if _replaces(f, told[k]) else _take_in(told[k], f)
    return told


def _replaces(other: Finding, first: Finding) -> bool:
    """Whether it is the law of an entry of the machine that another finding brought."""
    entries = [{path for path, _ in each.patch.by_name()} for each in (first, other)]
    is_law = other.kind != first.kind and not (other.channels or other.is_unnamed or first.is_unnamed)
    return is_law and first.sits_with(other) and bool(entries[0] & entries[1])


def _put_in_place(other: Finding, first: Finding) -> Finding:
    """A finding with the numbers and the evidence of the one in whose place it stands."""
    doubts = tuple(d for d in other.doubts if d != MAY_BE_ONE)
    share = other.confidence if other.share is None else other.share
    sure = min(share * (1.0 if other.holds is None else other.holds), SETTINGS.most_sure)
    return replace(
        other, parameters={**first.parameters, **other.parameters}, gain=first.gain + other.gain, doubts=doubts,
        windows=first.windows, nothing=first.nothing, confidence=min(sure, other.confidence) if doubts else sure,
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
