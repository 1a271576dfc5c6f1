"""The demonstration: the main job on a shipped machine, told in sentences; every number is computed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from network.machine import Machine
from network.output import folder, write_run
from network.report.pictures import draw_run
from network.scenario import Scenario
from network.shipped import shipped
from network.simulation import simulate
from network.trajectory import Trajectory, axis_unit, in_difference_unit


def tell_demo(output: str | Path) -> Iterator[str]:
    """Lines of the story; the results are in the folder when the last one is told."""
    machine_file, scenario_file = (
        shipped("machines", "gantry_spindle.yaml"),
        shipped("scenarios", "warm_up_and_stop.yaml"),
    )
    machine, scenario = Machine.load(machine_file), Scenario.load(scenario_file)
    parts = sum(node.is_part for node in machine.nodes.values())
    yield f"{machine.name}: {parts} parts, {len(machine.links)} links, {len(machine.sources)} heat sources, in YAML"
    yield f"  {machine_file}"
    yield f"It runs '{scenario.name}' ({scenario.duration / 3600:g} h), from cold."
    run = simulate(machine, scenario)
    closes = f"the energy account closes to {abs(run.energy.closure):.0e}"
    yield f"Solved in {run.solve_seconds * 1e3:.1f} ms; {run.why}; {closes}."
    yield ""
    yield from _temperatures(run)
    for axis in run.tcp:
        yield from _movement(run, axis)
    yield from _heat(run)
    where = folder(output)
    written = [*write_run(run, where), *draw_run(run, where)]
    yield ""
    yield f"Pictures and results are in {where}:"
    yield from (f"  {path.name:18s} {_MEANING[path.name]}" for path in written)


_MEANING = {
    "results.csv": "every channel over time, in a recording's format",
    "summary.json": "extremes, energy account, method",
    "run.png": "temperatures and displacement over the speed schedule",
    "contributions.png": "which part moves the tool centre point, and when",
    "network.png": "the machine as a network, with the mean heat flows",
}


def _temperatures(run: Trajectory) -> Iterator[str]:
    parts = {name: T for name, T in run.parts.items() if run.machine.nodes[name].is_part}
    hottest = max(parts, key=lambda name: float(parts[name].max()))
    when = run.t[int(np.argmax(parts[hottest]))] / 60
    yield f"The {hottest} gets warmest: {parts[hottest].max():.1f} degC after {when:.0f} min."


def _movement(run: Trajectory, axis: str) -> Iterator[str]:
    unit_text = axis_unit(axis)
    path = in_difference_unit(run.tcp[axis], unit_text)
    peak = int(np.argmax(np.abs(path)))
    shares = {n: in_difference_unit(v, unit_text)[peak] for (a, n), v in run.contributions.items() if a == axis}
    main = max(shares, key=lambda name: abs(shares[name]))
    yield (
        f"The tool centre point moves by {path[peak]:+.1f} {unit_text} along {axis} at {run.t[peak] / 60:.0f} min "
        f"({shares[main]:+.1f} of it: {main}) and stands at {path[-1]:+.1f} {unit_text} in the end."
    )


def _heat(run: Trajectory) -> Iterator[str]:
    taken = max(run.energy.absorbed, key=lambda name: run.energy.absorbed[name])
    yield (
        f"{run.energy.in_ / 1e3:.0f} kJ came in, {run.energy.out / 1e3:.0f} kJ went out again; "
        f"the {taken} still holds {run.energy.absorbed[taken] / 1e3:.0f} kJ of the rest."
    )
