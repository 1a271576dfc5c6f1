"""Random networks solved in every way that serves them: the ways agree, energy closes, a file written out is the same
machine; of some, slopes are those of differences, and numbers hidden in a recording are found again.

    python -m torture.agreement --count 10000 --log ../.torture/agreement.jsonl
"""

from __future__ import annotations

import argparse
import random
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import yaml
from build import machine

from network import Machine, simulate
from network.engine.trajectory import Trajectory
from torture.log import Told, go_on
from torture.networks import Drawn, draw_network
from torture.numbers import Compared, compare_numbers

EXACT = 1e-9
"""K per kelvin of rise: ways that are exact."""
STEPPED = 2e-6
"""K per kelvin of rise, at least of 2.5 K: rosenbrock and solve_ivp, 1e-7 of the temperatures each step."""
STEPPERS = ("LSODA", "BDF", "Radau", "RK45")
FINER = 1e-9
"""A hundredth of the usual tolerance: of what steps alone compute, and of what switches, where their errors add up."""
LARGE = 40
"""Parts from which the slow ways are left out, as they take minutes."""
STEPPED_SHARE, RELAYS_SHARE, NUMBERS_SHARE = 0.05, 0.02, 0.2
"""Of the networks without and with relays, how many solve_ivp is tried on, which takes half a second and ten seconds
for each; of those that are linear, of how many the numbers are looked for."""


def compare_ways(drawn: Drawn, chance: random.Random, slow: float = 1.0) -> list[Compared]:
    """Every way that serves the network against the one that `auto` takes; slow: what shares count with."""
    run = simulate(drawn.machine, drawn.schedule)
    small = len(drawn.machine.nodes) <= LARGE
    stepped = STEPPED * max(len(run.switches), 1) ** 0.5  # steps begin anew, with an error of their own, at each
    told = [Compared("energy", _gap(run))]
    told.append(_apart("written and read", run, simulate(read_again(drawn.machine), drawn.schedule), 0.0))
    if drawn.kind in ("linear", "stream", "stiff"):
        exact = simulate(drawn.machine, drawn.schedule, method="expm")
        told.append(_apart("expm", run, exact, EXACT, run.error if run.method == "krylov" else 0.0))
    if drawn.kind == "bent" or (small and drawn.kind != "stiff"):
        finer = FINER if drawn.kind in ("bent", "relay") else None
        steps = simulate(drawn.machine, drawn.schedule, method="rosenbrock", rtol=finer)
        told.append(_apart("rosenbrock, finer" if finer else "rosenbrock", run, steps, stepped))
    if drawn.kind in ("linear", "stream") and small and chance.random() < slow * NUMBERS_SHARE:
        told.extend(compare_numbers(drawn, chance))
    share = RELAYS_SHARE if drawn.kind == "relay" else STEPPED_SHARE
    if small and drawn.kind != "stiff" and chance.random() < slow * share:
        way = chance.choice(STEPPERS if drawn.kind != "relay" else ("LSODA",))
        told.append(_apart(way, run, simulate(drawn.machine, drawn.schedule, method=f"solve_ivp:{way}"), stepped))
    return told


def _gap(run: Trajectory) -> float:
    """Of the energy account, in units of what is allowed: stepped 1e-4 of the heat; exact 1e-9 of it, or what warms the
    machine by 1e-11 K, as heat is told from its temperatures, which rounding and modes keep to some 1e-13 K each."""
    network, account = run.network, run.energy
    if run.method not in ("modal", "expm"):
        return abs(account.closure) / 1e-4
    warmed = float(network.capacity[network.free].sum())
    size = max(account.in_, account.out, abs(account.total_stored))
    return abs(account.in_ - account.out - account.total_stored) / (1e-9 * size + 1e-11 * warmed)


def read_again(told: Machine) -> Machine:
    """The machine of the YAML that it would be written as."""
    plain = yaml.safe_load(yaml.safe_dump(told.to_plain(), sort_keys=False))
    sections = {name: plain[name] for name in ("links", "sources", "sensors") if name in plain}
    return machine(plain["nodes"], plain["reference"], **sections)


def _apart(way: str, run: Trajectory, other: Trajectory, allowed: float, told: float = 0.0) -> Compared:
    """allowed: per kelvin of rise; told: of the error that a run states of itself [K]."""
    here, there = (np.array([*each.sensors.values()]) for each in (run, other))
    rise = max(float(np.ptp(here)), 1.0)
    floor = 2.5 * STEPPED if allowed >= STEPPED else 0.0
    return Compared(
        way, float(np.abs(here - there).max()) / (max(allowed * rise + told, floor) or np.finfo(float).tiny)
    )


def main() -> int:
    parser = argparse.ArgumentParser(prog="torture.agreement", description=__doc__)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--log", type=Path, help="what is in it is not tried again")
    given = parser.parse_args()
    told = go_on(given.log, given.count, lambda number: _compare(given.seed, number))
    print(table(told))
    return int(any(furthest > 1 for each in told for furthest in each["apart"].values()))


def _compare(seed: int, number: int) -> Told:
    drawn, apart = draw_network(seed, number), dict[str, float]()
    for each in compare_ways(drawn, random.Random(number)):
        apart[each.way] = max(apart.get(each.way, 0.0), each.furthest if each.furthest == each.furthest else np.inf)
        if not each.furthest <= 1.0:
            told = f"{number} {drawn.kind}: {each.way}: {each.furthest:.3g} times what is allowed"
            print(told, file=sys.stderr, flush=True)
    return {"kind": drawn.kind, "parts": len(drawn.machine.nodes), "apart": apart}


def table(told: list[Told]) -> str:
    """Networks by kind; by way, how many were compared, how far they are apart at most, and how many too far."""
    kinds = Counter(each["kind"] for each in told)
    ways = dict[str, list[float]]()
    for each in told:
        for way, furthest in each["apart"].items():
            ways.setdefault(way, []).append(furthest)
    rows = [", ".join(f"{count} {kind}" for kind, count in kinds.most_common())]
    for way, found in sorted(ways.items()):
        broken = sum(furthest > 1 for furthest in found)
        rows.append(f"{len(found):6} {way:28} furthest {max(found):.2g} of what is allowed, {broken} beyond")
    return "\n".join(rows)


if __name__ == "__main__":
    sys.exit(main())
