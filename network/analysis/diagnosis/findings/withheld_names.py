"""Names that are less likely than not: beside what is told first they are told as something without a name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from network.analysis.diagnosis.findings.finding import UNKNOWN, Finding, Rival
from network.analysis.diagnosis.findings.joined_findings import lay_together
from network.analysis.diagnosis.settings import SETTINGS
from network.platform.wording import join_names, sentence


def withhold_names(findings: Sequence[Finding]) -> list[Finding]:
    """The findings, of which what is not told first has a name only where that is more likely than not, or recordings
    that did not choose it show it again; nor has the first one where another such sits in the same place, for they may
    be one thing. The machine keeps what was found: it tells the recordings better."""
    is_later = [any(not other.is_cut for other in findings[:k]) for k in range(len(findings))]
    unsure = [f for f, later in zip(findings, is_later, strict=True) if later and _is_unsure(f)]
    return _join_unnamed([_withhold(f) if _is_among(f, unsure) else f for f in findings])


def _join_unnamed(findings: Sequence[Finding]) -> list[Finding]:
    """Something without a sure name in the place of something that has none is the nearest that is known of that, and
    anywhere beside surroundings that do not stay at what is given for them, for these touch every part; that they drift
    is no other finding."""
    told = [f for f in findings if f.is_unnamed and not f.is_withheld]
    near = {id(f): [other for other in findings if _is_near(other, f)] for f in told}
    gone = {id(w) for joined in near.values() for w in joined}
    return [_join(f, near.get(id(f), ())) for f in findings if id(f) not in gone]


def _is_near(other: Finding, unnamed: Finding) -> bool:
    is_its = other.is_withheld and (other.sits_with(unnamed) or (unnamed.is_room and not other.channels))
    return other is not unnamed and (is_its or (other.sits_with(unnamed) and other.kind == unnamed.kind))


def _join(f: Finding, near: Sequence[Finding]) -> Finding:
    """A finding with all that is near to it in the machine."""
    if not near:
        return f
    names = [r for w in near for r in w.alternatives]
    return replace(lay_together(f, near), alternatives=(*names, *f.alternatives))


def _is_among(f: Finding, unsure: Sequence[Finding]) -> bool:
    """Whether it is one of some unsure findings, or unsure itself and in the same place as one of them."""
    beside = any(f.places and f.places == other.places for other in unsure)
    return any(f is other for other in unsure) or (beside and _is_unsure(f))


def _is_unsure(f: Finding) -> bool:
    """Faults of readings, which hold is None, have a test of their own."""
    is_open = not (f.is_unnamed or f.is_cut or f.holds is None) and f.confidence < SETTINGS.half
    return is_open and not (f.unseen is not None and f.unseen.shows_again and f.unseen.rejects)


def _withhold(f: Finding) -> Finding:
    """The same without its name, which becomes one of those that it may have."""
    own = Rival(f.kind, f.places, f.channels, f.confidence, 0.0, f.gain, "it tells most, but is less likely than not")
    seats = join_names([*f.places, *f.channels])
    said = f"{sentence(f'something at {seats}')} without a sure name is told best so: {f.sentence}"
    unnamed = 1 - f.confidence
    return replace(
        f, kind=UNKNOWN, sentence=said, confidence=min(unnamed, SETTINGS.barred), share=unnamed, holds=None,
        alternatives=(own, *map(f.as_told, f.alternatives)), nothing=None,
    )  # fmt: skip
