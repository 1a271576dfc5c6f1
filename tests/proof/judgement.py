"""How one case went, and what follows from that."""

from __future__ import annotations

from dataclasses import dataclass

VISIBLE = 0.9
"""Noise units rms that an effect has to leave after calibration to be asked for by name."""
SURE = 0.9
"""Confidence beyond which a wrong answer is worse than none."""
TOLERANCE = 1.02
"""Held-out misfit over another from which the two differ."""


@dataclass(frozen=True)
class Judgement:
    """How a case went. named, placed, both: of the first finding, of all effects where two are concealed; covered: the
    truth is in the sets; besides: further findings that are not there; stray: all that are not there."""

    case: str
    layout: str
    truth: str
    group: str
    what: str
    expected: str
    visible: float
    answer: str = "no answer"
    verdict: str = ""
    how: str = ""
    first: bool = False
    named: bool = False
    placed: bool = False
    both: bool = False
    covered: bool = False
    sizes: tuple[int, ...] = ()
    unknown: bool = False
    silent: bool = False
    near_whole: bool = False
    accused: bool = False
    besides: int = 0
    stray: int = 0
    confidence: float | None = None
    course: float | None = None
    before: float | None = None
    claimed: float | None = None
    simulated: float | None = None
    does_not_run: bool = False
    seconds: float | None = None
    seconds_two: float | None = None
    same_on_two: bool | None = None

    @property
    def answered(self) -> bool:
        return bool(self.verdict)

    @property
    def failed(self) -> bool:
        """It ended with an error."""
        return not self.answered and self.how.startswith("failed")

    @property
    def innocent(self) -> bool:
        """Nothing was concealed."""
        return self.group == "innocent"

    @property
    def outside(self) -> bool:
        return self.group == "outside"

    @property
    def seen(self) -> bool:
        """Something was concealed that leaves enough to be asked for."""
        return not self.innocent and self.visible >= VISIBLE

    @property
    def right(self) -> bool:
        """What was said first is right, or that nothing was said: `unknown` claims a place, everything else a name. Of
        what is too faint, nothing need be said."""
        if self.innocent:
            return self.answered and not self.accused
        if self.unknown:
            return self.placed
        return self.first if self.seen or not self.silent else self.answered

    @property
    def sure_and_wrong(self) -> bool:
        return (self.confidence or 0) > SURE and not self.right

    @property
    def after(self) -> float | None:
        """Held-out misfit of the machine that was written; the claimed one where that was not simulated."""
        return self.claimed if self.simulated is None else self.simulated

    @property
    def removed(self) -> float | None:
        """Share of the held-out excess over the noise that went away: (before − after)/(before − 1)."""
        if self.before is None or self.after is None or self.before <= TOLERANCE:
            return None
        return (self.before - self.after) / (self.before - 1)

    @property
    def worse(self) -> bool:
        """The held-out recording is predicted worse than before, by more than 2 %."""
        return self.before is not None and self.after is not None and self.after > TOLERANCE * self.before

    @property
    def overclaimed(self) -> bool | None:
        """The file that was written predicts worse than claimed, by more than 2 %, or not at all; None: not known."""
        if self.does_not_run:
            return True
        if self.claimed is None or self.simulated is None:
            return None
        return self.simulated > TOLERANCE * self.claimed
