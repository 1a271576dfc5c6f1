"""The demonstration: the main job on a shipped machine, told in sentences; every number is computed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from textwrap import wrap

import numpy as np

from network.analysis.comparison.compare import compare
from network.analysis.sweep.sweep import sweep
from network.catalogue.declaration.entry_path import axis_of
from network.cli.demo_missing_physics import tell_missing
from network.engine.simulation import simulate
from network.engine.trajectory import Trajectory, axis_unit
from network.machine.machine import Machine
from network.platform.folders import folder
from network.platform.package_data import find_shipped
from network.platform.publication import publication
from network.platform.quantities.number_format import pretty
from network.platform.quantities.unit_values import in_difference_unit
from network.recordings.csv_table import write_csv
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario
from network.report.figures.canvas import save
from network.report.figures.sweep_figure import levels_figure
from network.report.files.pictures import draw_comparison, draw_run
from network.report.files.result_files import RUN, write_run
from network.report.words.sweep_words import tell_tolerance

ROUGHER_LEVELS = ("paper", "1", "2", "4", "8", "16")
GOOD_ENOUGH = "2 um"
TRUTH = ("links.coolant jacket.conductance=20 W/K", "sources.front friction.torque=290 N mm")
"""How the machine of the made recording differs from the file."""


def tell_demo(output: str | Path) -> Iterator[str]:
    """Lines of the story; the results are in the folder when the last one is told."""
    where = folder(output)
    machine_file = find_shipped("machines", "gantry_spindle.yaml")
    machine, scenario = Machine.load(machine_file), Scenario.load(find_shipped("scenarios", "warm_up_and_stop.yaml"))
    yield from _simulation(machine, scenario, where)
    yield from _simplification(machine, scenario, where)
    yield from _heat_quantity()
    yield from _recording(machine_file, scenario, where)
    yield from _chapter("5  What is missing?")
    yield from tell_missing(where)


def _chapter(title: str) -> Iterator[str]:
    yield from ("", title, "-" * len(title))


def _simulation(machine: Machine, scenario: Scenario, where: Path) -> Iterator[str]:
    parts = sum(node.is_part for node in machine.nodes.values())
    yield from _chapter("1  A machine in YAML, a speed schedule, the tool centre point")
    yield f"{machine.name}: {parts} parts, {len(machine.links)} links, {len(machine.sources)} heat sources"
    yield f"  in {machine.file}, through '{scenario.name}' ({scenario.duration / 3600:g} h)."
    run = simulate(machine, scenario)
    closes = f"the energy account closes to {abs(run.energy.closure):.0e}"
    yield f"Solved in {run.solve_seconds * 1e3:.1f} ms; {run.why}; {closes}."
    yield from _temperatures(run)
    for axis in run.tcp:
        yield from _movement(run, axis)
    yield from _heat(run)
    with publication(where, RUN) as draft:
        made = [*write_run(run, draft), *draw_run(run, draft)]
    yield from _tell_files([where / path.name for path in made])


def _simplification(machine: Machine, scenario: Scenario, where: Path) -> Iterator[str]:
    yield from _chapter("2  How simple may it be?")
    found = sweep(machine, scenario, levels=ROUGHER_LEVELS, tolerance=GOOD_ENOUGH)
    yield "From the paper's closed form to sixteen lumps in every bar:"
    yield from str(found).splitlines()[1 : 2 + len(ROUGHER_LEVELS)]
    yield tell_tolerance(found)
    save(levels_figure(found), where / "levels.png")
    yield from _tell_files([where / "levels.png"])


def _heat_quantity() -> Iterator[str]:
    yield from _chapter("3  Heat quantity: growth does not ask where the heat went in")
    sentences, hours = [], Scenario.load(find_shipped("scenarios", "heat_20_hours.yaml"))
    for level, how in (("heat", "at its end"), ("middle", "in its middle")):
        run = simulate(Machine.load(find_shipped("machines", "specimen_bar.yaml"), level=level), hours)
        spread, grown = float(np.ptp(run.T_end[run.network.parts["bar"]])), float(run.tcp["z"][-1]) * 1e6
        sentences.append(f"heated {how} it grows by {grown:.2f} µm while its temperatures differ by {spread:.1f} K")
    growth = "; ".join(sentences)
    yield from _wrap(
        f"720 kJ go into a steel bar of 1 m: {growth}. The first is integrated from heat flows, the second "
        "read from temperatures; the paper's eq. 5 says 276.68 µm. `lptn paper` prints all its tables with ours beside."
    )


def _recording(machine_file: Path, scenario: Scenario, where: Path) -> Iterator[str]:
    yield from _chapter("4  A recording beside it")
    truth = Machine.load(machine_file, sets=TRUTH)
    made = simulate(truth, scenario, noise_seed=1)
    columns = {name: (unit_text, values) for name, unit_text, values in made.columns_in_si() if not axis_of(name)}
    write_csv(where / "recording.csv", made.t, columns)
    compared = compare(Machine.load(machine_file), [Recording.load(where / "recording.csv")])
    yield from _wrap(
        f"No real recording travels with lptn, so one is made: the same machine with {' and '.join(TRUTH)}, and every "
        "sensor's noise. What the file as written leaves of it:"
    )
    yield from str(compared).splitlines()[1:]
    yield from _tell_files(draw_comparison(compared, where))


def _wrap(text: str) -> list[str]:
    return wrap(text, 110)


def _tell_files(paths: list[Path]) -> Iterator[str]:
    yield "Look at"
    yield from (f"  {path}: {_MEANING[path.name]}" for path in paths if path.name in _MEANING)


_MEANING = {
    "results.csv": "every channel over time, in a recording's format",
    "parts.csv": "temperature and heat of every part, contribution of every entry, over time",
    "summary.json": "extremes, energy account, method",
    "run.png": "temperatures and displacement over the speed schedule",
    "contributions.png": "which part moves the tool centre point, and when",
    "sources.png": "which heat source moves it, and when",
    "network.png": "the machine as a network, with the mean heat flows",
    "levels.png": "the simplification levels over time, their error and cost",
    "recording.png": "measured over simulated, residuals in units of noise",
}


def _temperatures(run: Trajectory) -> Iterator[str]:
    parts = {name: T for name, T in run.parts.items() if run.machine.nodes[name].is_part}
    hottest = max(parts, key=lambda name: float(parts[name].max()))
    when = run.t[int(np.argmax(parts[hottest]))] / 60
    yield f"The {hottest} gets warmest: {parts[hottest].max():.1f} °C after {when:.0f} min."


def _movement(run: Trajectory, axis: str) -> Iterator[str]:
    unit_text = axis_unit(axis)
    shown, path = pretty(unit_text), in_difference_unit(run.tcp[axis], unit_text)
    peak = int(np.argmax(np.abs(path)))
    shares = {n: in_difference_unit(v, unit_text)[peak] for (a, n), v in run.contributions.items() if a == axis}
    main = max(shares, key=lambda name: abs(shares[name]))
    yield (
        f"The tool centre point moves by {path[peak]:+.1f} {shown} along {axis} at {run.t[peak] / 60:.0f} min "
        f"({shares[main]:+.1f} of it: {main}) and stands at {path[-1]:+.1f} {shown} in the end."
    )


def _heat(run: Trajectory) -> Iterator[str]:
    taken = max(run.energy.absorbed, key=lambda name: run.energy.absorbed[name])
    yield (
        f"{run.energy.in_ / 1e3:.0f} kJ came in, {run.energy.out / 1e3:.0f} kJ went out again; "
        f"the {taken} still holds {run.energy.absorbed[taken] / 1e3:.0f} kJ of the rest."
    )
