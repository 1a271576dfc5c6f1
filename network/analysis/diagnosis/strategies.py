"""How what is missing is looked for: every strategy, what it is for, and why it cannot look where that is so.

A candidate belongs to the first strategy that is for it. What it cannot look for is told with the diagnosis, so that
silence never passes for absence. Lumps (lump_refinement), what a sensor does by fits and starts (intermittent) and
sensors that are mixed up (exchange) are looked for before anything is proposed.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Container, Sequence
from typing import ClassVar

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.findings.result import Unsearched
from network.analysis.diagnosis.screening.screening import Screening
from network.analysis.diagnosis.switching.relay_search import tell_unsearched

CUT_SHORT = {
    "budget": "the time was up before all of it was looked for",
    "stopped": "the search was stopped before all of it was looked for",
    "broken": "runs broke down before all of it was looked for",
}
"""Why a search that ended early did not look for the rest."""
UNRECORDED = (
    "surroundings of which nobody recorded a course explain more than what was tried; record it, diagnose again"
)
"""Why a search that such surroundings end does not look for relays."""


class Strategy(ABC):
    """A way to look for candidates."""

    name: ClassVar[str]

    @abstractmethod
    def applies(self, c: Candidate) -> bool:
        """Whether it is for a candidate."""

    def unsearched(self, seen: Screening, of: Sequence[Candidate]) -> Sequence[Candidate]:
        """Those of its candidates that it cannot look for, if it cannot look for some."""
        return _silent(seen, of)

    @abstractmethod
    def why_not(self, seen: Screening, of: Sequence[Candidate]) -> str:
        """Why it cannot look for some of them about a fit; empty where it can."""


class Switching(Strategy):
    """Relays: those whose switching shows are followed; draws in one batch on an affine machine, the best fitted on the
    machine itself (switching)."""

    name = "switching"

    def applies(self, c: Candidate) -> bool:
        return c.switches

    def unsearched(self, seen: Screening, of: Sequence[Candidate]) -> Sequence[Candidate]:
        return of

    def why_not(self, seen: Screening, of: Sequence[Candidate]) -> str:
        return tell_unsearched(seen.before, of)


class Timed(Strategy):
    """Heat at instants of its own, drawn and scored linearly (timed_search)."""

    name = "timed"

    def applies(self, c: Candidate) -> bool:
        return c.is_timed

    def why_not(self, seen: Screening, of: Sequence[Candidate]) -> str:
        return _tell_silent(seen, of)


class Linear(Strategy):
    """All else: the answer at a usual strength scored about the fit, the best fitted in full (screen, refit)."""

    name = "linear"

    def applies(self, c: Candidate) -> bool:
        return True

    def why_not(self, seen: Screening, of: Sequence[Candidate]) -> str:
        return _tell_silent(seen, of)


STRATEGIES: tuple[Strategy, ...] = (Switching(), Timed(), Linear())


def strategy_of(c: Candidate) -> Strategy:
    """The first that is for a candidate."""
    return next(s for s in STRATEGIES if s.applies(c))


def list_unsearched(
    seen: Screening, ended: str, tried: Container[str], is_unrecorded: bool = False
) -> list[Unsearched]:  # fmt: skip
    """What was not looked for about a fit; ended: what cut the search short, if anything did; tried: the kinds of which
    something was fitted until then; is_unrecorded: whether surroundings of any course ended it."""
    if ended:
        rest = sorted({c.kind.kind for c in seen.proposed if c.kind.kind not in tried})
        return [Unsearched("all", tuple(rest), CUT_SHORT[ended])] if rest or not seen.proposed else []
    if is_unrecorded:
        relays = sorted({c.kind.kind for c in seen.proposed if c.switches})
        return [Unsearched(Switching.name, tuple(relays), UNRECORDED)] if relays else []
    groups = ((s, [c for c in seen.proposed if strategy_of(c) is s]) for s in STRATEGIES)
    told = ((s, of, s.why_not(seen, of) if of else "") for s, of in groups)
    return [Unsearched(s.name, tuple(sorted({c.kind.kind for c in s.unsearched(seen, of)})), why)
            for s, of, why in told if why]  # fmt: skip


def _silent(seen: Screening, of: Sequence[Candidate]) -> list[Candidate]:
    """Those of which no channel could show anything, by kinds of which that holds everywhere."""
    shown = {s.candidate.kind for s in seen.scores}
    return [c for c in of if c.kind not in shown]


def _tell_silent(seen: Screening, of: Sequence[Candidate]) -> str:
    return "no channel of these recordings would show it" if _silent(seen, of) else ""
