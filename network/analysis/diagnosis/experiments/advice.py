"""What to run next: programs that would tell apart what these recordings cannot, with one more sensor where need be."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.experiments.experiment import CLEAR, FAINT, Experiment
from network.analysis.diagnosis.experiments.programs import Program, programs
from network.analysis.diagnosis.experiments.separation import Outcome, Pair, about, outcome
from network.analysis.diagnosis.findings.isolability import count_kinds, name_candidate
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.screening.screen import score_candidates
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.ranking import best_first, distinct, shares
from network.catalogue.declaration.declare import Effect
from network.platform.refusal import Failed, Refused

if TYPE_CHECKING:
    from network.analysis.diagnosis.search_record import Search

DOUBT = 0.1
"""Belief in a rival, beside the finding, from which it is worth a run."""
PAIRS = 2
MOST_SENSORS = 6
"""Parts at which a further sensor is tried."""


def experiments(search: Search, unseen: Sequence[Candidate] = ()) -> Iterator[Experiment]:
    """For each pair in doubt the run that tells it apart; where nothing was found, the one that shows most of what the
    recordings could not have shown (`unseen`)."""
    for pair in in_doubt(search):
        yield from separating(pair)
    if unseen and not search.best.found:
        yield from revealing(search.screened.before, unseen)


def separating(pair: Pair) -> Iterator[Experiment]:
    """The program that tells a pair apart fastest; where none does so clearly, the best one with a further sensor;
    where that does not help either, the best one, said to be not enough."""
    tried = [(e, p) for p in _programs(pair) if (e := experiment(pair, p)) is not None]
    clear = [e for e, _ in tried if e.sigma >= CLEAR]
    if clear:
        yield max(clear, key=lambda e: e.sigma**2 / e.hours)
    elif tried:
        best, program = max(tried, key=lambda each: each[0].sigma)
        more = with_sensor(pair, program)
        yield more if more is not None and more.sigma >= CLEAR else _tell_in_vain(best, more)


def _tell_in_vain(best: Experiment, more: Experiment | None) -> Experiment:
    """The best that was tried, said to be not enough; a run that tells nothing is not written."""
    told = replace(best, text=_in_vain(best, more))
    return replace(told, scenario={}) if best.sigma < FAINT else told


def _in_vain(best: Experiment, more: Experiment | None) -> str:
    sensor = ", nor does one with a further temperature sensor" if more is not None else ""
    told = f"No schedule that was tried tells {' from '.join(best.separates)}"
    if best.sigma < FAINT:
        return f"{told}{sensor}"
    run = best.text[:1].lower() + best.text[1:]
    return f"{told} clearly{sensor}. Nearest comes: {run}"


def revealing(null: Hypothesis, unseen: Sequence[Candidate]) -> Iterator[Experiment]:
    """The program in which most of what could not be seen would be."""
    revealed = []
    for program in programs([null.machine, *(c.machine for c in unseen)], null.case.recordings):
        try:
            scores = score_candidates(about(null, program), unseen, null.values)
        except (Failed, Refused, np.linalg.LinAlgError, FloatingPointError):
            continue
        revealed.append((program, [s for s in scores if s.detectable >= CLEAR]))
    if any(seen for _, seen in revealed):
        program, seen = max(revealed, key=lambda each: len(each[1]))
        told = f"{len(seen)} of {len(unseen)} effects that these recordings could not show would be seen"
        kinds = count_kinds([(s.candidate,) for s in seen])
        sigma = float(np.median([s.detectable for s in seen]))
        yield Experiment(f"{program.text}: {told} ({kinds})", (), sigma, program.hours, program.scenario())


def in_doubt(search: Search) -> list[Pair]:
    """Findings, each with the rival that came nearest, where that is near; the nearest pairs first."""
    pairs = []
    for i, c in enumerate(search.best.found):
        ranked = distinct(search.steps[min(i, len(search.steps) - 1)]) if search.steps else []
        holds = next((h for h in ranked if h.found[-1].key == c.key), None)
        rest = [h for h in ranked if h is not holds]
        if holds is not None and rest and _is_near(holds, rest[0]):
            pairs.append(Pair(holds, rest[0]))
    return sorted(pairs, key=lambda p: abs(p.holds.evidence - p.rival.evidence))[:PAIRS]


def _is_near(holds: Hypothesis, rival: Hypothesis) -> bool:
    both = best_first(holds, rival)
    return both[0].evidence - both[1].evidence <= SETTINGS.alike or float(shares(both)[1]) > DOUBT


def _programs(pair: Pair) -> list[Program]:
    try:
        return programs([pair.holds.machine, pair.rival.machine], pair.holds.case.recordings, _inputs_of(pair))
    except Refused:
        return []


def _inputs_of(pair: Pair) -> set[str]:
    """What the two explanations themselves read: it has to move for them to differ."""
    last = [h.found[-1] for h in (pair.holds, pair.rival)]
    entries = [c.machine.by_path.get(path) for c in last for path, _ in c.patch.by_name()]
    return {name for entry in entries if isinstance(entry, Effect) for name in entry.needs()}


def experiment(pair: Pair, program: Program) -> Experiment | None:
    """How far a program would tell a pair apart; None where it cannot be computed."""
    found = _try_program(pair, program)
    return None if found is None else _describe_experiment(pair, program, program.text, found.sigma())


def with_sensor(pair: Pair, program: Program) -> Experiment | None:
    """The program with one more sensor where that helps most."""
    parts = _list_unsensed(pair)[:MOST_SENSORS]
    outcome = _try_program(pair, program, parts) if parts else None
    if outcome is None:
        return None
    part = max(parts, key=lambda p: outcome.sigma((p,)))
    sensed = {s.place.node for s in pair.rival.machine.sensors.values() if s.place}
    which = "another temperature sensor" if part in sensed else "a temperature sensor"
    return _describe_experiment(pair, program, f"Put {which} on {part}. {program.text}", outcome.sigma((part,)))


def _list_unsensed(pair: Pair) -> list[str]:
    """Parts where a further sensor may help: those behind a channel in doubt, those named, the others."""
    sensors = pair.rival.machine.sensors
    last = [h.found[-1] for h in (pair.holds, pair.rival)]
    doubted = [s.place.node for c in last for n in c.channels if (s := sensors[n]).place]
    sensed = {s.place.node for s in sensors.values() if s.place}
    named = {n for c in last for n in c.places}
    parts = [n for n, node in pair.rival.root.nodes.items() if node.is_part and n not in sensed]
    return [*dict.fromkeys([*doubted, *sorted(parts, key=lambda n: n not in named)])]


def _try_program(pair: Pair, program: Program, parts: list[str] | None = None) -> Outcome | None:
    try:
        return outcome(pair, program, parts or ())
    except (Failed, Refused, np.linalg.LinAlgError, FloatingPointError):
        return None


def _describe_experiment(pair: Pair, program: Program, text: str, sigma: float) -> Experiment | None:
    names = name_candidate(pair.holds.found[-1]), name_candidate(pair.rival.found[-1])
    return Experiment(text, names, sigma, program.hours, program.scenario()) if np.isfinite(sigma) else None
