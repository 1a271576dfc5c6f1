"""What a diagnosis says of itself in the terminal."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Iterator
from itertools import count
from typing import TYPE_CHECKING

from network.analysis.diagnosis.experiments.experiment import CLEAR, FAINT, experiment_file
from network.analysis.diagnosis.findings.isolability import DETAILS
from network.platform.quantities.text_table import digits, span, table
from network.platform.wording import name_of
from network.report.words.effect_words import effect_words
from network.report.words.finding_words import (
    alike_words,
    bench_words,
    evidence_words,
    rivals_words,
    set_words,
    sizes,
    sure_words,
    windows_words,
)
from network.report.words.heat_words import (
    POINTS,
    heat_words,
    is_found_at,
    is_named,
    seats_in,
    suspects_of,
    where_words,
)
from network.report.words.moved_words import describe_moved
from network.report.words.verdict_words import next_words, verdict_words
from network.report.words.words import rmse_by_channel, rmse_rows

if TYPE_CHECKING:
    from network.analysis.comparison.compare import Comparison
    from network.analysis.diagnosis.experiments.experiment import Experiment
    from network.analysis.diagnosis.findings.finding import Finding
    from network.analysis.diagnosis.findings.result import Diagnosis

WIDTH = 110
BEFORE = "  before: as written, its numbers calibrated"


def tell_diagnosis(d: Diagnosis) -> str:
    """Verdict; findings with size, evidence and rivals; where; what moved back; fits before and after; advice."""
    header, rows = fit_rows(d)
    fits = [*table(header, rows, header[1:]), *([] if is_unchanged(d) else [BEFORE])]
    blocks = [
        _verdict(d), *(_finding(d, i, f) for i, f in enumerate(d.findings, 1)), _paragraphs([bench_words(d)]),
        _paragraphs(where_lines(d)),
        _paragraphs(describe_moved(d)), "\n".join(fits),
        _paragraphs(map(shorten_note, d.notes)), _paragraphs(map(_next_experiment, count(1), d.advice)),
        _paragraphs([next_words(d)]),
    ]  # fmt: skip
    return "\n\n".join(block for block in blocks if block)


def _verdict(d: Diagnosis) -> str:
    head = f"{d.machine.name}: {name_of(d.verdict)} ({span(d.seconds)}, seed {d.seed})"
    return "\n".join([head, *textwrap.wrap(verdict_words(d), WIDTH)])


def _finding(d: Diagnosis, number: int, finding: Finding) -> str:
    first, then = (f"{number}. ", "   ") if len(d.findings) > 1 else ("  ", "  ")
    lines = textwrap.wrap(finding.whole_sentence, WIDTH, initial_indent=first, subsequent_indent=then)
    rows = [
        ("alike", alike_words(finding)), ("one of", set_words(finding)), ("effect", effect_words(d, finding)),
        ("size", "; ".join(f"{name} {size}" for name, size in sizes(finding))), ("sure", sure_words(finding)),
        ("evidence", " ".join([evidence_words(finding), windows_words(d, finding)])),
        *(("or", told) for told in rivals_words(finding)),
    ]  # fmt: skip
    for name, told in rows:
        start = f"   {name:<9} "
        lines += textwrap.wrap(told, WIDTH, initial_indent=start, subsequent_indent=" " * len(start))
    return "\n".join(lines)


def where_lines(d: Diagnosis) -> list[str]:
    """Where it differed, and how, as far as no name says it: what was found is told instead of the heat that its place
    seemed to lack while other numbers were bent to hide it."""
    if not d.findings or is_named(d):
        return []
    told = [u for u in suspects_of(d, 1) if is_found_at(u, seats_in(d)) or u.probability >= POINTS]
    return [line for line in [*(heat_words(d, u) for u in told), where_words(d)] if line]


def fit_rows(d: Diagnosis) -> tuple[list[str], list[list[str]]]:
    """Header and rows: rms residual of every channel in noise units, before and after; once where
    both are the same."""
    return rmse_rows(list(_columns(d)))


def _columns(d: Diagnosis) -> Iterator[tuple[str, Comparison]]:
    fits = d.fits
    sides = (("fitted", fits.train_before, fits.train_after), ("held out", fits.holdout_before, fits.holdout_after))
    for name, before, after in sides:
        if before is not None and after is not None:
            yield from ((name, after),) if is_unchanged(d) else ((f"{name}, before", before), (f"{name}, after", after))


def is_unchanged(d: Diagnosis) -> bool:
    """Whether the machine is as before: nothing was added to it, nothing cut more finely."""
    before, after = (rmse_by_channel(comparison) for comparison in (d.fits.train_before, d.fits.train_after))
    return before == after


def _next_experiment(number: int, experiment: Experiment) -> str:
    told = advice_words(experiment)
    if experiment.sigma >= CLEAR:
        told = f"Next experiment: {told}"
    return f"{told} It is written as {experiment_file(number)}." if experiment.scenario else told


def advice_words(experiment: Experiment) -> str:
    """A run, what it would separate, how clearly and how fast."""
    text = _HOLDS.sub(_shorten_holds, " ".join(experiment.text.split()).rstrip("."))
    if not experiment.separates:
        return f"{text}."
    apart = f"{digits(experiment.sigma, 2)} σ in {span(3600 * experiment.hours)}"
    if experiment.sigma < CLEAR:
        return f"{text}, with {apart}." if experiment.sigma >= FAINT else f"{text}."
    return f"{text}. It would tell {' from '.join(experiment.separates)} by {apart}."


_HOLDS = re.compile(r"held for ([\d., ]+) min in turn")


def _shorten_holds(found: re.Match[str]) -> str:
    """A dozen durations as their range: all of them stand in the scenario."""
    minutes = [float(word) for word in found[1].split(",")]
    return f"in holds of {min(minutes):g} to {max(minutes):g} min"


def shorten_note(note: str) -> str:
    """A note without what only the report goes into."""
    return note.partition(f" {DETAILS}")[0]


def _paragraphs(sentences: Iterable[str]) -> str:
    return "\n".join(line for sentence in sentences for line in textwrap.wrap(sentence, WIDTH))
