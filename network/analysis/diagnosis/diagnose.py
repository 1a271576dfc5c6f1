"""diagnose: from a machine and its recordings to what is missing, with what speaks for it and against its rivals."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from network.analysis.calibration.identifiability_report import describe_disagreements
from network.analysis.calibration.misfit import chi_of
from network.analysis.calibration.null import Null, estimate_null
from network.analysis.calibration.one_machine import Disagreement, find_disagreements
from network.analysis.diagnosis.findings.conclusion import conclude
from network.analysis.diagnosis.findings.holdout_admission import Intake, admit_runs
from network.analysis.diagnosis.findings.result import Diagnosis
from network.analysis.diagnosis.findings.simulated_runs import SimulatedRuns, simulate_calibrated
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.search import search
from network.analysis.diagnosis.search_end import last_of
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.time_budget import TimeBudget
from network.engine.response.parameters import free_parameters
from network.machine.machine import Machine
from network.platform.parallel import processes
from network.platform.stages import Stage, say
from network.platform.threads import on_one_thread
from network.recordings.call_arguments import as_several, expect, expect_fit
from network.recordings.inputs import Start
from network.recordings.recording import Recording


@on_one_thread
def diagnose(
    machine: Machine, recordings: Recording | Iterable[Recording], holdout: Recording | Iterable[Recording] = (), *,
    start: Start | None = None, seed: int = 0, jobs: int = 1, progress: Callable[[float], None] | None = None,
    seconds: float = float("inf"),
) -> Diagnosis:  # fmt: skip
    """Finds out which physics a machine lacks. holdout: recordings never used in any fit; jobs: processes; progress:
    told the share that is done; seconds: the time it may take, after which the best so far is told.

    The same seed gives the same diagnosis where the time is enough. Stopped, it tells the best so far, too. Raises
    Refused for recordings that cannot tell anything.
    """
    budget, tell = TimeBudget(seconds), progress or (lambda share: None)
    given = as_several(recordings)
    expect_fit(machine, given, start)
    expect("seconds", seconds, float, int)
    let_in = admit_runs(machine, given, as_several(holdout), start)
    with processes(jobs, __name__):
        parameters, ends = free_parameters(machine), (budget.is_calibrated, budget.is_begun)
        null = estimate_null(machine, parameters, let_in.data, start, seed, Stage(tell, 0.0, 0.05), *ends)
        say(tell, "simulating all runs as calibrated")
        before, searched = _simulate_first(null, let_in, start, jobs, budget)
        case = Case(machine, let_in.recordings, start, budget=searched)
        say(tell, f"{chi_of(null.fit.at):.3g} σ left; looking for what is missing")
        found = last_of(search(case, null, seed, jobs, tell), searched)
        say(tell, "judging what was found, also on what was held out")
        left = 1 if found.ended == "stopped" else jobs  # a stop ends the other processes
        told = conclude(found, before, let_in.warnings, seed, left)
        apart = _find_disagreements(null, found.best.chi, left, budget)
    notes = (*told.notes, *describe_disagreements(apart or ()))
    return replace(told, notes=notes, disagreements=apart, seconds=budget.spent)


def _find_disagreements(null: Null, chi: float, jobs: int, budget: TimeBudget) -> tuple[Disagreement, ...] | None:
    """Numbers that the runs want differently, looked for once all else is told: none where little is left (χ), None
    where there is no time to look."""
    if chi <= SETTINGS.adequate:
        return ()
    return None if budget.is_past(1.0) else find_disagreements(null, jobs)


def _simulate_first(
    null: Null, let_in: Intake, start: Start | None, jobs: int, budget: TimeBudget
) -> tuple[SimulatedRuns, TimeBudget]:
    """All runs as calibrated, which what is found is measured by, and the time that is left beside these, with what
    its own runs will take, as long again, kept back."""
    began = budget.spent
    before = simulate_calibrated(null, start, let_in.recordings, let_in.holdout, jobs)
    return before, budget.set_aside(budget.spent - began)
