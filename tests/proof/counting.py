"""What is counted over the cases of a proof, and among which of them."""

from __future__ import annotations

from collections.abc import Sequence

from proof.judgement import SURE, TOLERANCE, Judgement
from proof.rates import Rate, rate

ALONG = 0.8
"""Correlation from which a told course is that of the concealed heat."""


def rates_of(cases: Sequence[Judgement]) -> dict[str, Rate]:
    """Counts by what they mean. What is too faint is not asked for by name; innocents are counted if answered."""
    effects = [each for each in cases if each.seen and not each.outside]
    outside = [each for each in cases if each.seen and each.outside]
    return {
        **of_effects(effects), **of_two([each for each in effects if each.group == "two"]),
        **of_silence(cases), **of_outside(outside), **of_all(cases),
    }  # fmt: skip


def of_effects(some: Sequence[Judgement]) -> dict[str, Rate]:
    """Names by the first finding's kind alone; sets by whether they hold the truth, and by their size."""
    with_sets = [each for each in some if each.sizes]
    return {
        "first name right": rate(each.first for each in some),
        "right place": rate(each.placed for each in some),
        "right name at the right place": rate(each.both for each in some),
        "visible but called unknown": rate(each.unknown for each in some),
        "visible but nothing said": rate(each.silent for each in some),
        "something else named besides": rate(each.besides > 0 for each in some),
        "truth in the told sets": rate(each.covered for each in with_sets),
        "sets of a single name": rate(size == 1 for each in with_sets for size in each.sizes),
    }


def of_two(some: Sequence[Judgement]) -> dict[str, Rate]:
    return {
        "two at once: both named": rate(each.named for each in some),
        "two at once: both placed": rate(each.placed for each in some),
        "two at once: both named and placed": rate(each.both for each in some),
    }


def of_silence(cases: Sequence[Judgement]) -> dict[str, Rate]:
    faint = [each for each in cases if each.expected and not each.seen and each.answered]
    innocent = [each for each in cases if each.innocent and each.answered]
    return {
        "innocents accused": rate(each.accused for each in innocent),
        "too faint to ask for: something else named": rate(each.stray > 0 for each in faint),
    }


def of_outside(some: Sequence[Judgement]) -> dict[str, Rate]:
    told = [each.course for each in some if each.course is not None]
    return {
        "outside: unknown, or near as a part": rate(each.named for each in some),
        "outside: so, and at its place": rate(each.both for each in some),
        "outside: near told as the whole": rate(each.near_whole for each in some),
        f"outside: course told, correlation ≥ {ALONG}": rate(r >= ALONG for r in told),
    }


def of_all(cases: Sequence[Judgement]) -> dict[str, Rate]:
    fitted = [each for each in cases if each.before is not None and each.after is not None]
    simulated = [each for each in cases if each.overclaimed is not None]
    return {
        f"confident (> {SURE}) and wrong": rate(each.sure_and_wrong for each in cases if (each.confidence or 0) > SURE),
        "held out worse than before": rate(each.worse for each in fitted),
        "claims more than its file does": rate(bool(each.overclaimed) for each in simulated),
        "file and claim differ": rate(differ(each) for each in simulated),
        "no answer in time": rate(not (each.answered or each.failed) for each in cases),
        "no answer but an error": rate(each.failed for each in cases),
        "the same found on two cores": rate(each.same_on_two for each in cases if each.same_on_two is not None),
    }


def differ(each: Judgement) -> bool:
    """By more than 2 %, either way."""
    low, high = sorted((each.claimed or 0.0, each.simulated or 0.0))
    return each.does_not_run or high > TOLERANCE * low


def shares_of(group: str, some: Sequence[Judgement]) -> dict[str, Rate]:
    """The rates of a scored class, by name."""
    if group == "innocent":
        sorts = dict.fromkeys(each.what for each in some)
        answered = [each for each in some if each.answered]
        by_sort = {f"accused, {what}": rate(e.accused for e in answered if e.what == what) for what in sorts}
        return {"accused": rate(each.accused for each in answered), **(by_sort if len(sorts) > 1 else {})}
    seen = [each for each in some if each.seen]
    return {
        "first name right": rate(each.first for each in seen), "right place": rate(each.placed for each in seen),
        "right name at the right place": rate(each.both for each in seen),
        "answered": rate(each.answered for each in seen),
    }  # fmt: skip
