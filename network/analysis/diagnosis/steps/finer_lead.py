"""What shows most on finer lumps than explanations were compared on: several that are alike may come before it."""

from __future__ import annotations

from collections.abc import Sequence

from network.analysis.diagnosis.candidates.candidate import candidate
from network.analysis.diagnosis.hypotheses.compact_fit import expand
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.screening.screen import score_candidates
from network.analysis.diagnosis.steps.ranking import distinct
from network.analysis.diagnosis.steps.trial_fits import TrialFits


def find_lead(current: Hypothesis, trials: TrialFits, ranked: Sequence[Hypothesis], jobs: int) -> Hypothesis | None:
    """What scores most on the lumps of a hypothesis, of explanations and of all that was begun, where these were fitted
    on coarser ones; None where they were not, or where it runs away."""
    if trials.current is current:
        return None
    able = [h for h in distinct([*ranked, *trials.fits]) if not h.found[-1].is_searched_apart]
    about = expand(current)
    there = [candidate(about.machine, h.found[-1].kind, h.found[-1].patch) for h in able]
    scores = score_candidates(about.linearised, [c for c in there if c is not None], about.values, jobs)
    lead = next((h for s in scores[:1] for h in able if h.found[-1].key == s.candidate.key), None)
    return lead if lead is None or any(h is lead for h in ranked) else trials.fit_further(lead)
