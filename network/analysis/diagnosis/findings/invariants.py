"""What every answer obeys, in one place: what takes a finding away, and what bars it from being told as sure."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import norm
from scipy.stats import t as student

from network.analysis.calibration.multistart import AT_BOUND, at_bound
from network.analysis.comparison.compare import Comparison, RecordingResidual
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.findings.result import Fits
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.screening.crossed_splits import UnseenTest
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.selection import Selection
from network.analysis.diagnosis.steps.strength import errors_from_nothing, strength_in_errors
from network.catalogue.declaration.sections import TCP
from network.engine.response.parameters import Parameter
from network.platform.wording import name_of

if TYPE_CHECKING:
    from network.analysis.diagnosis.search_record import Search

MAY_BE_ONE = "another finding sits in the same place: they may be one thing that the catalogue does not have"
BLOCKS = 12
"""Of a run, each longer than its errors last."""


def find_worse_runs(before: Comparison | None, after: Comparison | None) -> list[str]:
    """Runs that are told worse after than before, by more than the scatter of the difference between blocks."""
    if before is None or after is None:
        return []
    pairs = [*zip(before.recordings, after.recordings, strict=True)]
    return [a.recording.name for b, a in pairs if is_worse(b, a, len(pairs))]


def is_worse(before: RecordingResidual, after: RecordingResidual, runs: int = 1) -> bool:
    """The mean of the paired differences of squares over blocks of time against its standard error, which is that of
    their bootstrap: all channels of a block are one value, for what is left moves them together. As improbable by
    chance in any of so many runs as in one alone (Student's t; Šidák)."""
    names = [n for n in before.channels if n in after.channels]
    if not names or not after.rmse_in_noise > SETTINGS.worse * before.rmse_in_noise:
        return False
    each = np.stack([after.channels[n].in_noise ** 2 - before.channels[n].in_noise ** 2 for n in names])
    blocks = [np.nanmean(b) for b in np.array_split(each, BLOCKS, axis=1) if np.isfinite(b).any()]
    if len(blocks) < 2:
        return False
    most = float(student.ppf(norm.cdf(SETTINGS.paired) ** (1 / runs), len(blocks) - 1))
    return bool(np.mean(blocks) > most * np.std(blocks, ddof=1) / np.sqrt(len(blocks)))


def list_refutations(selection: Selection, fits: Fits) -> list[str]:
    """Why findings are not told: that one may as well not be there, and runs, fitted or held out, that they make worse
    when simulated. Held-out ones are judged together by what is left: nothing speaks for what mispredicts them."""
    best, gains = selection.best, selection.gains
    sure = [errors_from_nothing(gain, best.chi) >= SETTINGS.errors for gain in gains]
    faint = [c.name for c, is_sure in zip(best.found, sure, strict=True) if not is_sure]
    before, after = fits.holdout_before, fits.holdout_after
    is_worse_held = before and after and after.rmse_in_noise > SETTINGS.worse * before.rmse_in_noise
    held = [r.recording.name for r in after.recordings] if after and is_worse_held else find_worse_runs(before, after)
    return [
        *(f"{name} is less than {SETTINGS.errors:.0f} standard errors from not there" for name in faint),
        *(f"with what was found {name} is told worse than without"
          for name in find_worse_runs(fits.train_before, fits.train_after)),
        *(f"with what was found {name}, held out, is told worse than without" for name in held),
    ]  # fmt: skip


def list_doubts(search: Search, c: Candidate, unseen: UnseenTest | None = None) -> Iterator[str]:
    """What bars a finding from being told as sure, and makes it a part of the truth at most; unseen: of its step."""
    yield from doubt_search(search)
    if unseen is not None and unseen.doubt:
        yield unseen.doubt
    yield from list_strains(search.best, c)


def doubt_search(search: Search) -> Iterator[str]:
    """The same for all findings of a search."""
    best = search.best
    if search.ended or not search.selection.is_checked:
        yield "it was not tested to the end"
    if len(search.case.recordings) < 2:
        yield "there is one recording, which cannot both tell it and test it"
    if best.chi > SETTINGS.adequate:
        yield f"much is left beside it (χ = {best.chi:.2g})"


def doubt_unseen(fits: Fits) -> str:
    """What runs that were held out say against findings being all of the truth; empty where that is nothing."""
    if fits.holdout_after is None:
        return ""
    seen, unseen = fits.train_after.rmse_in_noise, fits.holdout_after.rmse_in_noise
    if not unseen > SETTINGS.doubtful * max(seen, 1.0):
        return ""
    return f"much is left of what was held out ({unseen:.2g} σ, {seen:.2g} σ of what was fitted)"


def doubt_fitted(fits: Fits) -> str:
    """What the runs that were fitted say against it, in the noise of their sensors: the noise that a search estimates
    may have taken up what else is missing."""
    seen = fits.train_after.rmse_in_noise
    return f"much is left of what was fitted ({seen:.2g} σ)" if seen > SETTINGS.doubtful else ""


def list_strains(h: Hypothesis, c: Candidate) -> Iterator[str]:
    """What of a fit speaks against believing one of its findings."""
    index = {p.path: i for i, p in enumerate(h.fit.problem.parameters)}
    own = [index[p.path] for p in c.own if p.path in index]
    if own and strength_in_errors(h, c) < SETTINGS.errors:
        yield f"its size is less than {SETTINGS.errors:.0f} of its standard errors"
    numbers, theta = h.fit.problem.parameters, h.fit.theta
    bounded = [i for i in at_bound(numbers, theta) if i in own and not _is_expected(numbers[i], theta[i])]
    yield from (f"its {name_of(numbers[i].field.key)} stands at its bound" for i in bounded)
    if any(is_one_thing(c, other) for other in h.found if other is not c):
        yield MAY_BE_ONE
    if h.is_bent:
        yield f"a number of the file is bent by more than {SETTINGS.errors:.0f} of its ±"


def _is_expected(p: Parameter, x: float) -> bool:
    """Whether a number is where a proposal begins, as one of which there may be none."""
    return bool(abs(x - p.centre) < AT_BOUND * p.spread)


def is_one_thing(a: Candidate, b: Candidate) -> bool:
    """Whether the heat of two findings sits in the same parts, or that of one in a part that the other brings."""
    if TCP in (a.section, b.section):
        return False
    brought = [{name for name in c.patch.get("nodes", ()) if name not in c.base.nodes} for c in (a, b)]
    return bool(a.parts and a.parts == b.parts) or bool(brought[0] & b.parts) or bool(brought[1] & a.parts)
