"""The verdict of a diagnosis as a sentence, and what to do next."""

from __future__ import annotations

from typing import TYPE_CHECKING

from network.analysis.diagnosis.findings.finding import UNKNOWN
from network.platform.quantities.text_table import digits
from network.platform.wording import join_names
from network.report.words.headline_words import added_words, finer_words, found_words, misread_words, place_words
from network.report.words.moved_words import strained_words
from network.report.words.recording_names import name_recording

if TYPE_CHECKING:
    from network.analysis.diagnosis.findings.result import Diagnosis

MEANING = {
    "adequate": "{machine} explains its recordings: what is left, {left}, is what noise leaves. No physics is missing "
    "that these recordings would show.",
    "parameters_only": "Only numbers of {machine} were wrong. With them calibrated it explains its recordings, to "
    "{left}; no physics is missing that these recordings would show.",
    "too_coarse": "{machine} is cut too coarsely{where}. With more lumps there {falls}; nothing else is missing that "
    "these recordings would show.",
    "missing_physics": "{found}. With {added}, {falls}.",
    "sensor_fault": "The physics of {machine} holds{finer}; {misread}. With that counted in, {falls}.",
    "unexplained": "{machine} and its recordings differ{where}{also}, and nothing in the catalogue explains it: "
    "after all that was tried, {left} is left.",
}
ROOM = (
    "{machine} and its recordings differ as they would if what surrounds it did not stay what is given for it: {left} "
    "is left."
)
"""Where that is what was found first."""
UNTAKEN = (
    "{machine} is cut too coarsely{where}. With more lumps there nothing is left but noise as long as what switches "
    "follows the recordings; simulated it falls out of step with them, so that the file stays as it is, at {left}."
)
"""Where finer lumps explain all and were taken back."""
UNTRIED = (
    "{machine} may be cut too coarsely: on finer lumps it could differ by as much as is left, {left}, so that nothing "
    "more can be told from that."
)
"""Where the time was up before lumps were fine enough."""
STRAINED = (
    "With its numbers calibrated {machine} explains its recordings, to {left}. For that {strained} from the file: "
    "either the file is that wrong there, or something that is missing passes for it, which these runs do not tell."
)
"""Where only numbers were wrong, by more than their ± allows."""
UNENDED = "With its numbers calibrated {machine} leaves {left}; nothing was found so far that it lacks."
DIFFERS = (
    "{machine} and its recordings differ{where}{also}: {left} is left, and nothing that explains it was found so far."
)
MISREADS = (
    "{machine}{finer}: {misread}. With that counted in, {falls}; whether its physics holds beside that cannot be told "
    "so far."
)
COARSE = (
    "{machine} is cut too coarsely{where}. With more lumps there {falls}; whether anything else is missing cannot be "
    "told so far."
)
"""Where the search did not come to its end, a verdict says no more than that."""
SO_FAR = {
    "adequate": UNENDED, "parameters_only": UNENDED, "unexplained": DIFFERS, "too_coarse": COARSE,
    "sensor_fault": MISREADS,
}  # fmt: skip
CLEAN, UNTOLD = ("adequate", "parameters_only"), 2.0
"""Verdicts that speak of recordings as explained, and misfit of a held-out run over that of the others from which it is
not."""
FOUND, LEAVES = ("missing_physics", "sensor_fault"), 1.5
"""Verdicts that name something, and the misfit from which it is said that much is left."""
ENDED = {
    "budget": " The time was up before the search came to its end: this is the best so far, and nothing of it is sure. "
    "`--budget '10 min'` lets it go on.",
    "stopped": " It was stopped before its end: this is the best so far, and nothing of it is sure.",
    "broken": " Runs of what was tried next broke down: this is the best so far, and nothing of it is sure.",
}
NEXT = {
    "adequate": "Use the machine with its numbers as calibrated. What these recordings cannot show is not ruled out.",
    "parameters_only": "Use the calibrated numbers, and look up any that moved far from the file: a wrong drawing, "
    "material or unit shows there.",
    "too_coarse": "Keep the finer parts. Judge what else may be missing only with them.",
    "missing_physics": "Look at the machine for it. If it is there, copy its entry from machine.diagnosed.yaml into "
    "your file, or keep that file where it is: it names yours by its path.",
    "sensor_fault": "Check, move or exchange that sensor and record again.",
    "unexplained": "Look at the machine where heat or movement is unaccounted for, with its history in hand. The patch "
    "holds only what did hold.",
}
NEXT_STRAINED = "Measure these numbers before you use them, and look at the machine for what they may stand for."
"""Where numbers lie farther from the file than their ± allow."""
NEXT_UNTAKEN = (
    "Look up, or record, at what temperatures it switches, and write these into the file: with them its finer parts "
    "can be kept in step."
)
"""Where finer lumps explain all and were taken back."""
NEXT_UNTRIED = "Diagnose again with more time, or give its parts more lumps in the file."
"""Where the time was up before lumps were fine enough."""
NEXT_STOP = (
    "Ask who ran the machine what happened then. Where it did stand, record with the next runs what says so: the "
    "control's own state, a current, a speed that is measured."
)
"""Where something stood that recordings say ran."""
UNCHANGED = "Leave the physics of the machine as it is."
"""Where nothing else is missing."""
NEXT_ROOM = (
    "Hang a thermometer there, record it as a column with the next runs, and diagnose again: until then it hides what "
    "else may be missing."
)
"""Where surroundings are not what is given for them."""
NEXT_CHANNEL = (
    "Check that sensor and what it is fixed to first: it reads what no heat in this machine would make it read. The "
    "patch holds only what did hold."
)
"""Where what is unexplained sits in a channel."""


def verdict_words(d: Diagnosis) -> str:
    """What the verdict means for this machine."""
    finer = finer_words(d)
    words = {
        "machine": d.machine.name, "left": f"{digits(d.fits.train_after.rmse_in_noise, 3)} σ", "falls": falls(d),
        "found": found_words(d), "added": added_words(d), "misread": misread_words(d), "strained": strained_words(d),
        "where": place_words(d), "finer": finer and f" {finer}", "also": finer and f", also {finer}",
    }  # fmt: skip
    so_far = SO_FAR if d.ended else {}
    if _is_untaken(d):
        return (UNTRIED if _is_untried(d) else UNTAKEN).format_map(words) + ENDED.get(d.ended, "")
    told = STRAINED if _is_strained(d) else so_far.get(d.verdict, MEANING[d.verdict])
    meaning = ROOM if _is_room(d) else told
    return "".join([meaning.format_map(words), _part(d), _but(d), ENDED.get(d.ended, "")])


def _is_untaken(d: Diagnosis) -> bool:
    """Whether finer lumps explain all, or may, and are not in the file."""
    return d.verdict == "too_coarse" and (_is_untried(d) or d.after.lumps <= d.machine.lumps)


def _is_untried(d: Diagnosis) -> bool:
    """Whether the time was up before it was found which parts need them."""
    return d.ended == "budget" and not d.findings


def _is_strained(d: Diagnosis) -> bool:
    """Whether only numbers were wrong, and by more than their ± allow."""
    return d.verdict == "parameters_only" and not d.ended and bool(strained_words(d))


def _is_room(d: Diagnosis) -> bool:
    """Whether the first that was found is around the machine, and no more than what stands in for it in the file."""
    others = [f for f in d.findings if not f.is_room]
    return any(f.is_room for f in d.findings[:2]) and not any(f.patch and f.parameters for f in others)


def _part(d: Diagnosis) -> str:
    """That what was found is a part of the truth, where much is left beside it."""
    if d.verdict not in FOUND or _is_room(d) or d.fits.train_after.rmse_in_noise < LEAVES:
        return ""
    share = f", {100 * d.explained:.0f} % of what was unexplained {_name_test(d)}" if d.explained else ""
    return f" That is a part of the truth{share}: {digits(d.fits.train_after.rmse_in_noise, 3)} σ is left."


def _name_test(d: Diagnosis) -> str:
    """On what the share that is explained was tested: on what the fits use, whatever else is held out."""
    if len(d.fits.train_after.recordings) == 1:
        return "in the end of the run, told from its beginning"
    return "on the fitted runs, each told by the others"


def _but(d: Diagnosis) -> str:
    """That a held-out run is not explained, where no sentence says so yet."""
    train, held = d.fits.train_after.rmse_in_noise, d.fits.holdout_after
    if d.verdict not in CLEAN or held is None or held.rmse_in_noise < UNTOLD * max(1.0, train):
        return ""
    left, apart = digits(held.rmse_in_noise, 3), "differs from the others in something they do not show"
    return f" But it leaves {left} σ of {_name_holdout(d)}, never used in a fit: that run {apart}."


def next_words(d: Diagnosis) -> str:
    """What to do next; nothing where a clean verdict is not the last word."""
    if _is_room(d):
        return NEXT_ROOM
    if d.verdict == "unexplained" and d.findings and all(f.channels for f in d.findings if f.kind == UNKNOWN):
        return NEXT_CHANNEL
    if _is_untaken(d):
        return NEXT_UNTRIED if _is_untried(d) else NEXT_UNTAKEN
    if _is_strained(d):
        return NEXT_STRAINED
    if d.verdict == "sensor_fault":
        told = NEXT_STOP if any(f.is_stop for f in d.findings) else NEXT[d.verdict]
        return told if d.ended else f"{told} {UNCHANGED}"
    return "" if d.ended and d.verdict in CLEAN else NEXT[d.verdict]


def falls(d: Diagnosis) -> str:
    """How far the residual falls, on what was fitted and on what was held out."""
    before, after = d.fits.train_before.rmse_in_noise, d.fits.train_after.rmse_in_noise
    told = f"the residual {_falls(before, after)} noise units"
    if d.fits.holdout_before is None or d.fits.holdout_after is None:
        return told
    before, after = d.fits.holdout_before.rmse_in_noise, d.fits.holdout_after.rmse_in_noise
    return f"{told}, and {_falls(before, after)} on {_name_holdout(d)}, never used in a fit"


def _falls(before: float, after: float) -> str:
    low, high = digits(before, 3), digits(after, 3)
    return f"stays at {high}" if low == high else f"{'falls' if after < before else 'rises'} from {low} to {high}"


def _name_holdout(d: Diagnosis) -> str:
    assert d.fits.holdout_after is not None
    return join_names([name_recording(d, r) for r in d.fits.holdout_after.recordings])
