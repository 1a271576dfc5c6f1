"""From which lumps the steps go: from the best of them, then from those of the machine as written.

Lumps bend to what is missing as numbers do: where a slow sensor or a mass that nobody told is all that is missing,
finer ones explain much of it, and hide it. So where they leave much, it is first seen whether one thing explains
everything on those that were written: then the steps go from there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from network.analysis.diagnosis.hypotheses.falling_short import share_shown
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.lumps.coarse_surrogate import SMALL
from network.analysis.diagnosis.lumps.lump_refinement import MANY
from network.analysis.diagnosis.screening.screening import Screening, leaves_something, screen_candidates
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.refit import start_trials


class Track(NamedTuple):
    """What the steps go from, and what could be missing there; nothing where that was not looked at."""

    begin: Hypothesis
    screened: Screening


def list_levels(levels: Sequence[Hypothesis], best: Hypothesis) -> list[Hypothesis]:
    """The best refinement, and the machine as written where that is another and not far behind."""
    written = levels[0]
    is_alone = best is written or best.chi < SETTINGS.noise or written.chi > SETTINGS.hopeless * best.chi
    return [best] if is_alone else [best, written]


def list_tracks(
    null: Hypothesis, written: Hypothesis, levels: Sequence[Hypothesis], seed: int, jobs: int
) -> Iterator[Track]:
    """Those of some levels, each screened when it is asked for, that of the null first: after that of the machine as
    written where one thing explains everything there."""
    first = _explain_all(written, seed, jobs) if _may_hide(null, written) else None
    if first is not None:
        yield first
    yield _screen(null, seed, jobs)
    if first is None:
        yield from (_screen(h, seed, jobs) for h in levels if h is not null)


def _screen(h: Hypothesis, seed: int, jobs: int) -> Track:
    is_told = not leaves_something(h) and h.machine.lumps > MANY
    return Track(h, Screening(h) if is_told else screen_candidates(h, seed, jobs))


def _may_hide(null: Hypothesis, written: Hypothesis) -> bool:
    """Whether finer lumps than those of the machine as written leave much."""
    is_other = null.machine.lumps > written.machine.lumps
    return is_other and null.chi > SETTINGS.adequate and written.machine.lumps <= SMALL


def _explain_all(written: Hypothesis, seed: int, jobs: int) -> Track | None:
    """The machine as written where one candidate leaves nothing of it; only those are fitted that show half of that."""
    seen = screen_candidates(written, seed, jobs)
    likely = [s for s in seen.scores if share_shown(seen.before, s.gain) >= SETTINGS.half]
    if not likely:
        return None
    ranked = start_trials(seen.before, seen.proposed, likely, jobs).rank(jobs)
    return Track(written, seen) if ranked and ranked[0].chi <= SETTINGS.noise else None
