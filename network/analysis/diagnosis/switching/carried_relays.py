"""Relays that keep step on coarse lumps, on finer ones: there the same numbers switch them at other instants, and no
slope leads back.

So the heat of the last one follows the instants that it had on the coarse lumps first, beside which a machine with no
other relay is straight; from the numbers that this takes it keeps step, or is led over ever more of the runs.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from network.analysis.calibration.expansion_point import move_points
from network.analysis.calibration.linearised import Linearised
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.compact_fit import fit_or_none
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_findings
from network.analysis.diagnosis.steps.ranking import best_of
from network.analysis.diagnosis.switching.certain_levels import find_relay, make_certain
from network.analysis.diagnosis.switching.relay_levels import read_levels
from network.analysis.diagnosis.switching.shown_relays import SLACK, STEPS, ShownRelay, follow_moved
from network.catalogue.declaration.entry_path import EntryPath
from network.engine.response.followed_relays import TRACED
from network.engine.response.prediction import Prediction
from network.machine.machine import Machine
from network.platform.refusal import Failed
from network.recordings.relay_mode import RelayMode

SPREAD = 60.0
"""s: 1σ of an instant on finer lumps about that on coarse ones."""


def carry_in_step(
    case: Case, root: Machine, laid: Sequence[Candidate], coarse: Hypothesis, is_quick: bool
) -> Hypothesis | None:  # fmt: skip
    """Findings that keep step on coarse lumps, laid over a machine with finer ones: the best fit from the levels there
    and from those where the last relay follows the instants that it had there, the first that leaves no more than
    either; is_quick: at once from the levels there, and nothing else. None where it brings none, or that runs away."""
    shown = _keep_instants(laid, coarse)
    first = None if shown is None else _fit_followed(case, laid, shown, coarse.values)
    if shown is None or first is None:
        return None
    followed, shown = follow_moved(first, shown, partial(_fit_followed, case, laid))
    about, best = replace(case, began=tuple(move_points(followed.fit))), None
    least = min(followed.chi, coarse.chi) * (1 + SLACK)
    for values in _list_starts(followed, shown, coarse):
        for in_step in (True, False):
            best = best_of(best, fit_findings(about, root, laid, values, in_step, STEPS))
            if is_quick or (best is not None and best.chi < least):
                return best
    return best


def _list_starts(followed: Hypothesis, shown: ShownRelay, coarse: Hypothesis) -> Iterator[Mapping[str, float]]:
    """Numbers where the relay follows, with the levels that it has on coarse lumps, and with those that are read."""
    yield {**coarse.values, **followed.values}
    if levels := read_levels(followed, shown):
        yield {**followed.values, **levels}


def _keep_instants(laid: Sequence[Candidate], coarse: Hypothesis) -> ShownRelay | None:
    """The last relay of some findings, with levels that are certain and the instants at which it switched on coarse
    lumps; None where none of them brings one, or that has no levels or does not switch by itself."""
    relays = [(c, found) for c in laid if (found := find_relay(c)) is not None]
    if not relays:
        return None
    c, (path, relay) = relays[-1]
    carried, levels = replace(c, machine=laid[-1].machine), relay.levels()
    certain = make_certain(carried, *sorted(levels[1:])) if levels else None
    try:
        runs = _run_again(coarse) if certain else []
    except (Failed, np.linalg.LinAlgError):
        return None
    if certain is None or any(str(path) not in _list_relays(p) for p in runs):
        return None
    return ShownRelay(carried, certain.candidate, {}, {i: _read_mode(p, path) for i, p in enumerate(runs)})


def _run_again(h: Hypothesis) -> Sequence[Prediction]:
    """The runs of a hypothesis, of which only the numbers may have been kept."""
    return h.fit.predictions if isinstance(h.fit, Linearised) else h.fit.problem.model.predict(h.fit.theta)


def _list_relays(prediction: Prediction) -> list[str]:
    """Paths of what switches by itself in a run, in the order of its modes."""
    network = prediction.course.problem.plan.network
    return [network.mechanisms[entry] for group in network.relays for entry in group.entry]


def _read_mode(prediction: Prediction, path: EntryPath) -> RelayMode:
    """When a relay was on in a run in which it keeps step."""
    plan = prediction.course.problem.plan
    on = np.asarray(plan.modes, float)[:, _list_relays(prediction).index(str(path))]
    switched = np.flatnonzero(np.diff(on)) + 1
    t = np.array([plan.edges[0], *plan.edges[switched]])
    return RelayMode(TRACED + path.name, t, np.full(len(switched), SPREAD), float(on[0]))


def _fit_followed(
    case: Case, laid: Sequence[Candidate], shown: ShownRelay, start: Mapping[str, float]
) -> Hypothesis | None:  # fmt: skip
    """The finer machine where the relay's heat follows its instants."""
    runs = zip(case.recordings, shown.modes.values(), strict=True)
    beside = replace(case, recordings=tuple(replace(r, modes={**r.modes, m.name: m}) for r, m in runs))
    levels = {p.path for p in shown.candidate.own} - {p.path for p in shown.followed.own}
    found = [*laid[:-1], replace(laid[-1], machine=shown.followed.machine)]
    return fit_or_none(beside, found, [p for c in laid for p in c.own if p.path not in levels], start, STEPS)
