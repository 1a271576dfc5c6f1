"""Explanations between which these recordings do not choose: they share the headline of a finding."""

from __future__ import annotations

from typing import TYPE_CHECKING

from network.catalogue.declaration.entry_path import axis_of
from network.platform.wording import join_either, join_names, name_of

if TYPE_CHECKING:
    from network.analysis.diagnosis.findings.finding import Finding, Rival
    from network.analysis.diagnosis.findings.result import Diagnosis

BARE = 3.0
"""Odds up to which one explanation is no better than another: Kass and Raftery, Bayes factors, J. Am. Stat. Assoc. 90
(1995), call 1 to 3 not worth more than a bare mention."""


def ties(finding: Finding) -> list[Rival]:
    """What cannot be told from it, and what is as likely but for odds of BARE; the likeliest first, each once."""
    own = {(finding.kind, finding.places, finding.channels)}
    near = [r for r in finding.alternatives if BARE * finding.confidence_of(r) >= finding.confidence]
    told = []
    for r in (*finding.indistinguishable, *sorted(near, key=lambda r: -r.confidence)):
        if (r.kind, r.places, r.channels) not in own:
            own.add((r.kind, r.places, r.channels))
            told.append(r)
    return told


def title_words(d: Diagnosis, finding: Finding) -> str:
    """Kind and seat, with those of its ties: cutting heat at table or workpiece."""
    told: list[Finding | Rival] = [finding, *ties(finding)]
    each = [(name_of(f.kind), seat_words(d, f)) for f in told]
    kinds, seats = (list(dict.fromkeys(column)) for column in zip(*each, strict=True))
    if len(kinds) > 1 and len(seats) > 1:
        return join_either([f"{kind}{f' at {seat}' if seat else ''}" for kind, seat in each])
    where = join_either([seat for seat in seats if seat])
    return join_either(kinds) + (f" at {where}" if where else "")


def seats_words(d: Diagnosis, finding: Finding) -> str:
    """Where it sits, or where as likely."""
    told: list[Finding | Rival] = [finding, *ties(finding)]
    seats = dict.fromkeys(seat_words(d, f) for f in told)
    return join_either([seat for seat in seats if seat])


def seat_words(d: Diagnosis, finding: Finding | Rival) -> str:
    """Where it sits; behind the parts, along which axes they move the tool centre point."""
    seats = seats_of(d, finding)
    axes = [axis for seat in seats if (axis := axis_of(seat))]
    parts = [seat for seat in seats if not axis_of(seat)]
    if not axes:
        return join_names(parts)
    return (
        f"{join_names(parts)} (movement along {join_names(axes)})"
        if parts
        else f"the tool centre point ({join_names(axes)})"
    )


def seats_of(d: Diagnosis, finding: Finding | Rival) -> tuple[str, ...]:
    """Where it sits, as its reader says it: a channel, parts rather than what is held, or an axis."""
    nodes = d.machine.nodes
    parts = tuple(name for name in finding.places if name not in nodes or not nodes[name].is_held)
    return finding.channels or parts or finding.places
