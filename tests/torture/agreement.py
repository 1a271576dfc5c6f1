"""Random networks solved in every way that serves them: the ways agree, energy closes, a file written out is the same
machine, and numbers hidden in a recording are found again.

    python -m torture.agreement --count 10000
"""

from __future__ import annotations

import argparse
import random
import sys
from collections import Counter
from dataclasses import dataclass

import numpy as np
import yaml
from build import machine

from network import Machine, simulate
from network.engine.trajectory import Trajectory
from torture.networks import Drawn, draw_network

EXACT = 1e-9
"""K per kelvin of rise: ways that are exact."""
STEPPED = 2e-6
"""K per kelvin of rise, at least of 2.5 K: rosenbrock and solve_ivp, 1e-7 of the temperatures each step."""
STEPPERS = ("LSODA", "BDF", "Radau", "RK45")
LARGE = 40
"""Parts from which the slow ways are left out, as they take minutes."""
SLOW = 0.3
"""Of the networks with relays, how many solve_ivp is tried on, which takes ten seconds for each."""


@dataclass(frozen=True)
class Compared:
    """way: of two; furthest: apart, in units of what is allowed."""

    way: str
    furthest: float


def compare_ways(drawn: Drawn, chance: random.Random) -> list[Compared]:
    """Every way that serves the network against the one that `auto` takes."""
    run = simulate(drawn.machine, drawn.schedule)
    small = len(drawn.machine.nodes) <= LARGE
    told = [Compared("energy", abs(run.energy.closure) / (1e-9 if run.method in ("modal", "expm") else 1e-4))]
    told.append(_apart("written and read", run, simulate(read_again(drawn.machine), drawn.schedule), 0.0))
    if drawn.kind in ("linear", "stream", "stiff"):
        told.append(_apart("expm", run, simulate(drawn.machine, drawn.schedule, method="expm"), EXACT))
    if drawn.kind == "bent":
        told.append(_apart("rosenbrock", run, simulate(drawn.machine, drawn.schedule, method="rosenbrock"), STEPPED))
    if small and drawn.kind != "stiff" and (drawn.kind != "relay" or chance.random() < SLOW):
        way = chance.choice(STEPPERS if drawn.kind != "relay" else ("LSODA",))
        allowed = STEPPED * max(len(run.switches), 1) ** 0.5  # it begins anew, with an error of its own, at each
        told.append(_apart(way, run, simulate(drawn.machine, drawn.schedule, method=f"solve_ivp:{way}"), allowed))
    return told


def read_again(told: Machine) -> Machine:
    """The machine of the YAML that it would be written as."""
    plain = yaml.safe_load(yaml.safe_dump(told.to_plain(), sort_keys=False))
    sections = {name: plain[name] for name in ("links", "sources", "sensors") if name in plain}
    return machine(plain["nodes"], plain["reference"], **sections)


def _apart(way: str, run: Trajectory, other: Trajectory, allowed: float) -> Compared:
    here, there = (np.array([*each.sensors.values()]) for each in (run, other))
    rise = max(float(np.ptp(here)), 1.0)
    floor = 2.5 * STEPPED if allowed >= STEPPED else 0.0
    return Compared(way, float(np.abs(here - there).max()) / (max(allowed * rise, floor) or np.finfo(float).tiny))


def main() -> int:
    parser = argparse.ArgumentParser(prog="torture.agreement", description=__doc__)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    tried, broken, furthest = Counter[str](), 0, dict[str, float]()
    for number in range(given.count):
        drawn = draw_network(given.seed, number)
        for each in compare_ways(drawn, random.Random(number)):
            name = f"{drawn.kind}: {each.way}"
            tried[name] += 1
            furthest[name] = max(furthest.get(name, 0.0), each.furthest)
            if not each.furthest <= 1.0:
                broken += 1
                print(f"{number} {name}: {each.furthest:.3g} times what is allowed", file=sys.stderr, flush=True)
        if number % 500 == 499:
            print(f"{number + 1}/{given.count}", file=sys.stderr, flush=True)
    for name, n in sorted(tried.items()):
        print(f"{n:6} {name:28} furthest {furthest[name]:.2g} of what is allowed")
    return int(broken > 0)


if __name__ == "__main__":
    sys.exit(main())
