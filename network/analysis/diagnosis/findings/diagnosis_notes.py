"""What a diagnosis says beside its findings: what the recordings are worth, what did not hold, what was set right."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from network.analysis.diagnosis.findings.result import Fits
from network.analysis.diagnosis.screening.screening import leaves_something
from network.analysis.diagnosis.settings import SETTINGS
from network.engine.response.followed_relays import MODE
from network.platform.wording import sentence
from network.recordings.recording import Recording

if TYPE_CHECKING:
    from network.analysis.diagnosis.search_record import Search


def tell_refuted(refuted: Sequence[str]) -> Iterator[str]:
    """Why something is not told."""
    yield from (f"{sentence(told)}: it is not added." for told in refuted)


def tell_recordings(search: Search) -> Iterator[str]:
    """What the recordings are worth, as sentences."""
    runs = search.case.recordings
    yield from (_tell_switchings(name, runs) for name in runs[0].modes)
    if len(search.best.found) >= SETTINGS.findings and leaves_something(search.best):
        yield "More may be missing than is looked for at once: diagnose the machine that is written to look further."
    for data in search.best.fit.problem.data:
        for name, channel in data.channels.items():
            if channel.apart.any():
                count = int(channel.apart.sum())
                yield f"{data.recording.name}: {count} readings of {name} are outliers and were excluded."
    tinted = [n for n, (s, _) in search.best.case.noise.coloured.items() if s]
    if tinted:
        yield f"The noise of {', '.join(tinted)} is coloured; evidence counts it as such."


def tell_unseen(fits: Fits) -> Iterator[str]:
    """That runs held out are told much worse than those fitted."""
    if fits.holdout_after is not None:
        seen, unseen = fits.train_after.rmse_in_noise, fits.holdout_after.rmse_in_noise
        yield (
            f"What was held out is left at {unseen:.2g} σ, what was fitted at {seen:.2g} σ: something differs between "
            "these runs that the file does not know – a room, a start, or what acts in some of them only."
        )


def tell_corrections(search: Search, holdout: Sequence[Recording], fits: Fits) -> Iterator[str]:
    """What was set right in runs held out."""
    if search.fault is not None and fits.holdout_after is not None:
        for given, told in zip(holdout, fits.holdout_after.recordings, strict=True):
            if said := search.fault.tell_correction(given, told.recording):
                yield said


def _tell_switchings(name: str, runs: Sequence[Recording]) -> str:
    """How often a relay whose modes are read switched, over which runs, and how it was used."""
    count = sum(len(run.modes[name].t) - 1 for run in runs)
    over = "in the fitted run" if len(runs) == 1 else f"in the {len(runs)} fitted runs together"
    return (
        f"{name.removeprefix(MODE)} switched {'once' if count == 1 else f'{count} times'} {over}, as readings show; it "
        "was followed while something was looked for, and switches by itself in what is told."
    )
