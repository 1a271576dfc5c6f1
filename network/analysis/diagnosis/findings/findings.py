"""Findings as they are told: what was found, its size, what speaks for it, and what else it could be."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.findings.finding import Finding, Quantity, Rival
from network.analysis.diagnosis.findings.invariants import doubt_search, list_doubts
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.ranking import belief_in_nothing, distinct, share_of, shares
from network.analysis.diagnosis.steps.strength import standard_errors
from network.engine.response.parameters import Parameter
from network.machine.machine import Machine
from network.platform.quantities.number_format import format_amount
from network.platform.wording import name_of, sentence

if TYPE_CHECKING:
    from network.analysis.diagnosis.search_record import Search

HARDLY, FAR = 1.015, 3.0
"""Misfit over that of the best that is hardly more, and prior σ by which a number is far from the file."""
STRAY = 2.0
"""Standard deviations at which unknown heat counts."""


def list_findings(search: Search, after: Machine) -> list[Finding]:
    """What was wrong with readings, then what was found, in the machine with its numbers; a fault that leaves much, and
    for which there was no time to see what is found without it, comes last."""
    faults, found = [*_faults(search, after)], [*_findings(search, after)]
    is_open = search.fault is not None and search.fault.competes and search.best.chi > SETTINGS.adequate
    return [*found, *faults] if is_open and search.ended else [*faults, *found]


def _faults(search: Search, after: Machine) -> Iterator[Finding]:
    """What was wrong with readings; what is a part of the machine from now on, or leaves what it competes for, is
    doubted as other parts are."""
    if (e := search.fault) is not None:
        run, windows = next((i, w) for i, w in enumerate(e.windows) if w)
        is_part = bool(e.patch) or (e.competes and search.best.chi > SETTINGS.adequate)
        doubts = tuple(doubt_search(search)) if is_part else ()
        yield Finding(
            e.kind, e.section, (), e.channels, min(e.confidence, SETTINGS.barred) if doubts else e.confidence,
            e.quantities, sentence(e.told), e.patch.as_in(after.tree), e.gain, search.threshold, windows, e.rivals,
            doubts=doubts, share=e.confidence, nothing=belief_in_nothing(e.gain, search.best.chi), run=run,
        )  # fmt: skip


def _findings(search: Search, after: Machine) -> Iterator[Finding]:
    for i, c in enumerate(search.best.found):
        k, unseen = search.selection.step_of(c), search.selection.unseen_of(c)
        ranked = search.steps[k]
        rivals = list(list_rivals(ranked, search.befores[k], c.key))
        doubts = tuple(list_doubts(search, c, unseen))
        is_first = ranked[0].found[-1].key == c.key
        holds = search.share_that_holds
        sure = shares(distinct(ranked))[0] * holds if is_first else SETTINGS.barred
        gain = search.gains[i] if i < len(search.gains) else 0.0
        most = SETTINGS.barred if doubts else SETTINGS.most_sure
        yield Finding(
            c.kind.kind, c.section, c.places, c.channels, float(min(sure, most)),
            _quantities(search.told, c), _sentence(search.told, c, after), c.patch.as_in(after.tree), gain,
            search.threshold, windows_of(search.located),
            tuple(r for r in rivals if r.confidence < 0.3 or r.gain < search.best.evidence)[:5],
            tuple(_alike(ranked, c)), doubts, unseen=unseen, share=share_of(ranked, c.key), holds=float(holds),
            nothing=None if i or search.fault else belief_in_nothing(gain, search.best.chi),
        )  # fmt: skip


def list_rivals(ranked: Sequence[Hypothesis], null: Hypothesis, but: tuple[str, ...] = ()) -> Iterator[Rival]:
    """Explanations that were fitted beside each other, each with its share of belief and what speaks against it; null:
    what stood before them; but: the key of one that is left out."""
    apart = distinct(ranked)
    for h, p in zip(apart, shares(apart), strict=True):
        c = h.found[-1]
        if c.key != but and h.evidence > null.evidence - SETTINGS.alike:
            gain = h.weighed - null.weighed
            yield Rival(c.kind.kind, c.places, c.channels, float(p), h.chi, gain, why_not(h, ranked[0]))


def why_not(h: Hypothesis, best: Hypothesis) -> str:
    """What speaks against it. Its misfit, which counts coloured noise and starts as a table of rmse does not, is told
    relative to that of what was found."""
    worse = best.weighed - h.weighed
    if worse <= SETTINGS.alike:
        return "these recordings do not tell it apart"
    moved = float(np.abs(h.shift).max(initial=0.0))
    strained = f", and moves a number of the file by {moved:.0f} times its ±" if moved > FAR else ""
    return f"{_worse(h.chi / max(best.chi, 1e-9))}{strained}"


def _worse(times: float) -> str:
    if times < HARDLY:
        return "fits nearly as well"
    return f"fits {100 * (times - 1):.0f} % worse" if times < 2 else f"fits {times:.2g} times worse"


def _alike(ranked: Sequence[Hypothesis], c: Candidate) -> Iterator[Rival]:
    """Other explanations within SETTINGS.alike nats of the best."""
    for r in list_rivals(ranked, ranked[0], c.key):
        if -r.gain <= SETTINGS.alike:
            yield r


def _quantities(h: Hypothesis, c: Candidate) -> dict[str, Quantity]:
    std = standard_errors(h)
    index = {p.path: i for i, p in enumerate(h.fit.problem.parameters)}
    free = c.own[:1] if c.is_timed else c.own
    return {p.field.key: _quantity(p, float(h.fit.theta[index[p.path]]), float(std[index[p.path]]) * (p in free))
            for p in c.own if p.path in index}  # fmt: skip


def _quantity(p: Parameter, theta: float, spread: float) -> Quantity:
    return Quantity(p.value(theta), p.std(theta, spread), p.field.unit)


def _sentence(h: Hypothesis, c: Candidate, after: Machine) -> str:
    """What is missing and how large it is, with its uncertainty."""
    index = {p.path: i for i, p in enumerate(h.fit.problem.parameters)}
    first = c.own[0]
    spread = float(standard_errors(h)[index[first.path]])
    unit = "K" if first.field.unit == "degC" else first.field.unit
    std = format_amount(first.std(float(h.fit.theta[index[first.path]]), spread), unit, 2)
    return f"{sentence(c.kind.told(after, c.patch))} ({name_of(first.field.key)} ± {std})."


def is_shadow(search: Search) -> bool:
    """Whether all that was found adds nothing beside heat of any course, or lowers it by less than half: it may then
    only be bent to that."""
    is_little = search.selection.added < SETTINGS.alike or search.selection.share_of_rest < SETTINGS.half
    return is_little and bool(search.located)


def windows_of(located: Sequence[UnknownHeat]) -> tuple[tuple[float, float], ...]:
    """When the most probable unknown heat of the first recording differs from none."""
    if not located:
        return ()
    t, away = located[0].t[0], np.abs(located[0].heat[0]) > STRAY * located[0].std[0]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], away, [False]]).astype(int)))
    return tuple((float(t[a]), float(t[b - 1])) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a > 1)
