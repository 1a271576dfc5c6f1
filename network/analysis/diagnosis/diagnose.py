"""diagnose: from a machine and its recordings to what is missing, with what speaks for it and against its rivals.

Structure first: lumps are refined where that mends more than it costs. Then step by step from the best of them, and
from the machine as written where that leaves something unexplained: locate, screen, refit, keep what holds (following).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from network.analysis.calibration.identifiability_report import describe_disagreements
from network.analysis.calibration.null import Null, estimate_null
from network.analysis.calibration.one_machine import find_disagreements
from network.analysis.diagnosis.forward_selection import Screening, screen_candidates, select_forward
from network.analysis.diagnosis.holdout_admission import admit_runs
from network.analysis.diagnosis.hypothesis import (
    Case,
    Hypothesis,
    estimate_noise,
    fit_hypothesis,
    reweight,
)
from network.analysis.diagnosis.intermittent.intermittent_fault import find_intermittent_fault
from network.analysis.diagnosis.locate import locate
from network.analysis.diagnosis.lump_convergence import refine_until_converged
from network.analysis.diagnosis.lump_refinement import FAR, FULL, refine_lumps
from network.analysis.diagnosis.result import Diagnosis
from network.analysis.diagnosis.search_record import Search
from network.analysis.diagnosis.verdict import conclude
from network.engine.response.parameters import free_parameters
from network.machine.machine import Machine
from network.platform.parallel import processes
from network.platform.threads import on_one_thread
from network.recordings.inputs import Start
from network.recordings.recording import Recording

MANY = 120
"""Lumps from which it is not worked out what would not have shown, where nothing is looked for."""
TOLD = 1.25
"""Misfit χ of what was found from one refinement, above which the machine as written is followed, too."""
BEHIND = 3.0
"""Misfit of the machine as written over that of its best refinement, beyond which it is not looked at by itself."""


@on_one_thread
def diagnose(
    machine: Machine, recordings: Recording | Iterable[Recording], holdout: Iterable[Recording] = (), *,
    start: Start | None = None, seed: int = 0, jobs: int = 1, progress: Callable[[float], None] | None = None,
) -> Diagnosis:  # fmt: skip
    """Finds out which physics a machine lacks. holdout: recordings never used in any fit; jobs: processes; progress:
    told the share that is done.

    The same seed gives the same diagnosis. Raises Refused for recordings that cannot tell anything.
    """
    began, tell = time.perf_counter(), progress or (lambda share: None)
    given = (recordings,) if isinstance(recordings, Recording) else tuple(recordings)
    let_in = admit_runs(machine, given, tuple(holdout), start)
    with processes(jobs, __name__):
        null = estimate_null(machine, free_parameters(machine), let_in.data, start, seed, lambda x: tell(0.05 * x))
        found = _search(Case(machine, let_in.recordings, start), null, seed, jobs, tell)
        apart = find_disagreements(null, let_in.data)
        told = conclude(found, let_in.holdout, (*let_in.warnings, *describe_disagreements(apart)), seed, jobs)
    return replace(told, disagreements=apart, seconds=time.perf_counter() - began)


def _search(case: Case, calibrated: Null, seed: int, jobs: int, tell: Callable[[float], None]) -> Search:
    given = case
    levels = refine_lumps(case, fit_hypothesis(case, case.machine, start=calibrated.values))
    tell(0.1)
    faulty = find_intermittent_fault(max(levels, key=lambda h: h.evidence)) if levels[-1].chi > FULL else None
    if faulty is not None:
        case = faulty[1].case
        levels = refine_lumps(case, fit_hypothesis(case, case.machine, start=calibrated.values))
    tell(0.15)
    written, best = levels[0], max(levels, key=lambda h: h.evidence)
    case = estimate_noise(case, best)
    tracks = [reweight(case, h) for h in _tracks(levels, best)]
    as_written = reweight(case, written)
    if best is not written and tracks[0].chi < FAR:
        tracks[0] = refine_until_converged(case, tracks[0])
    null = max(tracks, key=lambda h: h.evidence)
    located = locate(null.linearised, null.machine)
    is_told = null.chi < FULL and null.machine.lumps > MANY
    seen = Screening(null, (), ()) if is_told else screen_candidates(null, jobs)
    found = [select_forward(null, seen, located, seed, jobs, tell)]
    for track in tracks:
        if track is not null and not any(f.best.chi < TOLD for f in found):
            found.append(select_forward(track, screen_candidates(track, jobs), located, seed, jobs, tell))
    won = max(found, key=lambda f: reweight(case, f.best).evidence)
    steps, fault = (won.befores, won.steps), None if faulty is None else faulty[0]
    return Search(
        given, case, fault, as_written, calibrated, null, won.best, *steps, won.gains, located, won.threshold, seen
    )


def _tracks(levels: Sequence[Hypothesis], best: Hypothesis) -> list[Hypothesis]:
    """The best refinement, and the machine as written where that is another and not far behind."""
    written = levels[0]
    return [best] if best is written or best.chi < FULL or written.chi > BEHIND * best.chi else [best, written]
