"""What recordings tell of a machine: its parts and what they follow; and, where nobody says so, which temperature is
that of its surroundings, and which is where its heat comes from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from network.analysis.drafting.channel_roles import Roles
from network.analysis.drafting.lag_bench import AROUND, LagBench, list_gapless, set_up
from network.analysis.drafting.part_models import PartModel, Progress, group_alike, link_parts
from network.catalogue.declaration.declare import Array
from network.recordings.recording import Recording

FEWEST_BESIDE, MOST = 2, 0.5
"""Temperatures besides the surroundings that must be there to tell them, and the share of them that must follow."""


@dataclass(frozen=True, eq=False)
class Identified(LagBench):
    """What was recorded, with the parts that it tells of. models: from the fastest part to the slowest."""

    models: tuple[PartModel, ...]


def identify(runs: Sequence[Recording], roles: Roles, tell: Progress = lambda _: None) -> Identified:
    """Where no input is recorded, the temperature that the others follow is held. Raises Refused for inputs with
    gaps."""
    roles = _with_surroundings(runs, roles)
    found = _identify(runs, roles, tell)
    leader = "" if found.roles.inputs or roles.held else find_leader(found)
    if not leader:
        return found
    rest = tuple(name for name in roles.temperatures if name != leader)
    return _identify(runs, replace(roles, held=(leader,), temperatures=rest, leader=leader), tell)


def _with_surroundings(runs: Sequence[Recording], roles: Roles) -> Roles:
    """Where no name tells of surroundings: the temperature that no input drives and that most others follow."""
    open_to = [name for name in roles.temperatures if name in list_gapless(runs, roles)]
    if roles.ambient or not roles.inputs or len(roles.temperatures) < FEWEST_BESIDE + 1 or not open_to:
        return roles
    gains = _list_gains_around(set_up(runs, roles), open_to)
    gains = {name: row for name, row in gains.items() if np.mean(row > 0) > MOST}
    if not gains:
        return roles
    found = max(gains, key=lambda name: float(gains[name].sum()))
    rest = tuple(name for name in roles.temperatures if name != found)
    return replace(roles, ambient=found, temperatures=rest, is_by_behaviour=True)


def find_leader(found: Identified) -> str:
    """The sensor of the part whose temperature explains best those that are nearer to the surroundings than it is, by
    the nats that they gain: heat comes from there. '' where they gain none. One without gaps, for it becomes an
    input."""
    parts, gapless = found.models, list_gapless(found.runs, found.roles)
    rises = [float(np.nanmean(m.group.mean**2)) for m in parts]
    whole = [[n for n in m.group.sensors if n in gapless] for m in parts]
    gains = [
        sum(max(m.gains.get(k, 0.0), 0.0) for m, rise in zip(parts, rises, strict=True) if rise < rises[k])
        for k in range(len(parts))
    ]
    open_to = [k for k in range(len(parts)) if whole[k] and gains[k] > 0]
    return whole[max(open_to, key=lambda k: gains[k])][0] if open_to else ""


def _list_gains_around(bench: LagBench, names: Sequence[str]) -> dict[str, Array]:
    """Of every name that no input drives, the nats by which each other temperature is better told with it as
    surroundings than with constant ones."""
    names = [n for n in names if bench.is_in_all(bench.rise(n))]
    bank = bench.bank({f"other {n}": bench.rise(n) for n in names})
    fittings = {n: bench.fitting(bank, bench.rise(n), bench.floor([n])) for n in bench.known}
    told = {name: fitting.select([AROUND], bench.roles.inputs) for name, fitting in fittings.items()}
    gains = dict[str, Array]()
    for name in (n for n in names if told[n].gain_over(fittings[n].fit([AROUND])) <= 0):
        others = {n: f.select([f"other {name}"], bench.roles.inputs) for n, f in fittings.items() if n != name}
        gains[name] = np.array([fit.gain_over(told[n]) for n, fit in others.items()])
    return gains


def _identify(runs: Sequence[Recording], roles: Roles, tell: Progress) -> Identified:
    bench = set_up(runs, roles)
    return Identified(**vars(bench), models=link_parts(bench, group_alike(bench, tell), tell))
