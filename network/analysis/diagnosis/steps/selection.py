"""What the steps of a search have chosen."""

from __future__ import annotations

from dataclasses import dataclass, replace

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.hypotheses.case_noise import have_same_noise
from network.analysis.diagnosis.hypotheses.few_runs import SEARCHED
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.screening.crossed_splits import UnseenTest
from network.analysis.diagnosis.settings import SETTINGS


@dataclass(frozen=True, eq=False)
class Selection:
    """Where the steps from one null led: the best, what stood before each step and its rivals, the evidence that each
    finding adds, and what chance reaches; is_checked: whether all findings were tested again beside each other and on
    runs that they were not fitted to, and what share of the misfit there they explain; added, share_of_rest: what they
    add to heat of any course beside them [nats], and by what share its variance falls; unseen: of each step, whether
    what half of the recordings picks out shows in the other half."""

    best: Hypothesis
    befores: tuple[Hypothesis, ...] = ()
    steps: tuple[tuple[Hypothesis, ...], ...] = ()
    gains: tuple[float, ...] = ()
    threshold: float = SETTINGS.least
    is_checked: bool = False
    explained: float = 0.0
    added: float = float("inf")
    share_of_rest: float = 1.0
    unseen: tuple[UnseenTest | None, ...] = ()

    @property
    def is_doubted(self) -> bool:
        """Whether recordings that did not choose the first finding neither show nor choose it."""
        test = self.unseen_of(self.best.found[0]) if self.best.found else None
        return test is not None and bool(test.doubt) and not test.halves_agree

    def keep_steps_found(self) -> Selection:
        """Without the steps of which the finding is not there any more."""
        keys = {c.key for c in self.best.found}
        held = [k for k, ranked in enumerate(self.steps) if ranked[0].found[-1].key in keys]
        return replace(
            self, befores=tuple(self.befores[k] for k in held), steps=tuple(self.steps[k] for k in held),
            unseen=tuple(self.unseen[k] for k in held if k < len(self.unseen)),
        )  # fmt: skip

    def went_from(self, h: Hypothesis) -> bool:
        """Whether a step went from these findings under the same noise and on the same runs: it would lead there
        again."""
        count = len(h.found)
        if count >= len(self.befores) or len(h.case.recordings) > SEARCHED:
            return False
        is_there = [c.key for c in self.befores[count].found] == [c.key for c in h.found]
        return is_there and have_same_noise(self.best.case, h.case)

    def step_of(self, c: Candidate) -> int:
        """The step in which a finding was made, or the one in the place of which it came."""
        made = [k for k, ranked in enumerate(self.steps) if ranked[0].found[-1].key == c.key]
        keys = [own.key for own in self.best.found]
        return made[0] if made else min(keys.index(c.key) if c.key in keys else 0, len(self.steps) - 1)

    def unseen_of(self, c: Candidate) -> UnseenTest | None:
        """What recordings that a finding was not chosen on say of its step; None where that was not asked."""
        k = self.step_of(c)
        return None if c.is_searched_apart or k >= len(self.unseen) else self.unseen[k]
