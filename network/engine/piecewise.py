"""Runs of the pieces of a parted recording as one trajectory, on the clock of the recording, begun anew at each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TypeVar

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.energy import EnergyAccount
from network.engine.solvers.courses import LazyCourses
from network.engine.trajectory import Trajectory
from network.recordings.recording import Recording

Key = TypeVar("Key")


def join_runs(recording: Recording, runs: Sequence[Trajectory]) -> Trajectory:
    """One behind the other. Heat counts from the start of each piece, the account sums over all of them; the error is
    the largest, and T_start and T_end are those of the first and of the last."""
    first, last = runs[0], runs[-1]
    t = np.concatenate([run.t for run in runs])
    schedule = replace(first.schedule, name=recording.name, file=recording.file, t=t)
    warnings = dict.fromkeys(warning for run in runs for warning in run.warnings)
    return replace(
        first, schedule=schedule, t=t, inputs=_joined(runs, lambda run: run.inputs),
        sensors=_joined(runs, lambda run: run.sensors), tcp=_joined(runs, lambda run: run.tcp),
        contributions=_joined(runs, lambda run: run.contributions), parts=_joined(runs, lambda run: run.parts),
        heat=_joined(runs, lambda run: run.heat), states=_joined(runs, lambda run: run.states), T_end=last.T_end,
        energy=_sum_accounts([run.energy for run in runs]), switches=tuple(s for run in runs for s in run.switches),
        solve_seconds=sum(run.solve_seconds for run in runs), error=max(run.error for run in runs),
        warnings=(*warnings, *recording.remarks), pieces=tuple(runs),
    )  # fmt: skip


def _joined(runs: Sequence[Trajectory], of: Callable[[Trajectory], Mapping[Key, Array]]) -> Mapping[Key, Array]:
    return LazyCourses({name: partial(_join, [of(run) for run in runs], name) for name in of(runs[0])})


def _join(several: Sequence[Mapping[Key, Array]], name: Key) -> Array:
    return np.concatenate([each[name] for each in several])


def _sum_accounts(accounts: Sequence[EnergyAccount]) -> EnergyAccount:
    names = ("heat_into", "heat_by_mechanism", "heat_stored")
    sums = {name: np.sum([getattr(account, name) for account in accounts], axis=0) for name in names}
    return replace(accounts[0], **sums)
