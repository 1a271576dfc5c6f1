"""What every column of recordings is to a machine: surroundings, an input, a temperature, a displacement, or nothing.

Units tell most of it: what turns, moves, conducts current or gives power drives heat; names tell surroundings, and how
a column moves tells a set point. What is said by the user goes before all of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from network.analysis.drafting.channel_names import axis_in, is_counter, is_set_point, nearness
from network.analysis.drafting.recorded_course import true_readings
from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.entry_path import axis_of
from network.platform.quantities.units import Unit, unit
from network.platform.refusal import Complaints, Spot, likely
from network.recordings.recording import Recording

FEWEST = 12
"""Readings: a time constant, a level and a beginning, with independent ones left to judge them by."""
LARGEST = 2e-3
"""m: no heat moves a tool farther, a longer way is an axis's."""
DRIVING = ("rpm", "m/min", "W", "A", "V", "1")
"""A unit of every kind of input that makes heat."""


@dataclass(frozen=True)
class Wishes:
    """What the user says of columns."""

    inputs: tuple[str, ...] = ()
    sensors: tuple[str, ...] = ()
    ambient: str = ""


@dataclass(frozen=True)
class Roles:
    """ambient: the column or constant that is the surroundings, '' where there is none; inputs: what makes heat; held:
    temperatures that drive; temperatures; displacements: names with their axes; unused: names with the reason why;
    leader: one of the held that is so because nothing else is recorded that drives; is_by_behaviour: the surroundings
    were told by how they move; sensors: what the user says is one."""

    ambient: str
    inputs: tuple[str, ...]
    held: tuple[str, ...]
    temperatures: tuple[str, ...]
    displacements: Mapping[str, str]
    unused: Mapping[str, str] = field(default_factory=dict)
    leader: str = ""
    is_by_behaviour: bool = False
    sensors: tuple[str, ...] = ()


def assign_roles(runs: Sequence[Recording], wishes: Wishes) -> Roles:
    """Raises Refused where there is no temperature, or a wish names what is not there."""
    units = _units_of(runs)
    _check_wishes(runs, wishes, units)
    role = {name: _wish(name, unit(text), wishes) or _guess(runs, name, unit(text)) for name, text in units.items()}
    warm = [n for n, r in role.items() if r == "temperature"]
    ambient = wishes.ambient or _find_ambient(runs, [n for n in warm if n not in wishes.sensors])
    temperatures = tuple(name for name in warm if name != ambient and _moves(pool_readings(runs, name)))
    _check_temperatures(runs, units, temperatures, ambient)
    known = ("temperature", "input", "held", "displacement", "ambient")
    unused = {name: r for name, r in role.items() if r not in known and name != ambient}
    return Roles(
        ambient, tuple(n for n, r in role.items() if r == "input"), tuple(n for n, r in role.items() if r == "held"),
        temperatures, _axes([n for n, r in role.items() if r == "displacement"], unused), unused,
        sensors=wishes.sensors,
    )  # fmt: skip


def _units_of(runs: Sequence[Recording]) -> dict[str, str]:
    """Columns and constants of all runs. Raises Refused where two runs differ in what one measures."""
    units, complaints = dict[str, str](), Complaints()
    for run in runs:
        told = {name: column.unit for name, column in run.columns.items()}
        for name, text in (told | {name: signal.unit for name, signal in run.constants.items()}).items():
            known = units.setdefault(name, text)
            if unit(known).dimension != unit(text).dimension:
                wrong = f"{name} is in {text} here, and in {known} in another recording"
                complaints.refuse(Spot(run.file), wrong, "give it one kind of unit, or another name")
    complaints.raise_if_any()
    return units


def _check_wishes(runs: Sequence[Recording], wishes: Wishes, units: Mapping[str, str]) -> None:
    complaints = Complaints()
    named = {
        "--input": wishes.inputs,
        "--sensor": wishes.sensors,
        "--ambient": (wishes.ambient,) * bool(wishes.ambient),
    }
    for option, names in named.items():
        for name in names:
            if name not in units:
                complaints.refuse(Spot(f"{option} {name}"), "there is no such column", likely(name, units))
            elif option == "--ambient" and not unit(units[name]).is_temperature:
                complaints.refuse(Spot(f"{option} {name}"), f"is in {units[name]}", "name a temperature")
            elif option != "--sensor" and any(name not in {*run.columns, *run.constants} for run in runs):
                lacking = next(run.file for run in runs if name not in {*run.columns, *run.constants})
                right = "name what all of them have, or leave that recording out"
                complaints.refuse(Spot(f"{option} {name}"), f"{lacking} has no such column", right)
    named_twice = [name for name in {*wishes.inputs} if name in (*wishes.sensors, wishes.ambient)]
    for name in sorted(named_twice):
        complaints.refuse(Spot(f"--input {name}"), "is named as something else as well", "keep one of them")
    complaints.raise_if_any()


def _wish(name: str, of: Unit, wishes: Wishes) -> str:
    """What the user says a column is."""
    if name == wishes.ambient:
        return "ambient"
    if name in wishes.inputs:
        return "held" if of.is_temperature else "input"
    if name not in wishes.sensors:
        return ""
    is_length = of.dimension == unit("m").dimension
    return (
        "temperature" if of.is_temperature else "displacement" if is_length else f"no sensor of a draft is in {of.text}"
    )


def _guess(runs: Sequence[Recording], name: str, of: Unit) -> str:
    """temperature, input, held or displacement; any other answer is the reason why it is nothing."""
    if _bad_name(name):
        return f"{_bad_name(name)}: rename it in a mapping"
    if of.is_temperature:
        return _guess_temperature(runs, name)
    if of.dimension == unit("m").dimension:
        return _guess_length(runs, name)
    if of.dimension == unit("1/min").dimension:
        return f"{of.text} may be a speed: map it to rpm if it is one"
    if of.dimension not in {unit(text).dimension for text in DRIVING}:
        return f"nothing is known of heat that would follow from it in {of.text}"
    if of.dimension == unit("1").dimension and is_counter(name):
        return "it counts samples"
    return "input" if _in_all(runs, name) else "not every recording has a value of it"


def _bad_name(name: str) -> str:
    """Why a sensor or input cannot be called so; '' where it can."""
    if axis_of(name) is not None:
        return "its name means a displacement of the tool"
    strange = any(sign in name for sign in ",[") or name != " ".join(name.split())
    return "its name has signs that a machine file cannot bear" if strange else ""


def _in_all(runs: Sequence[Recording], name: str) -> bool:
    """Whether every run has a value of it."""
    return all(name in run.constants or _count([run], name) > 0 for run in runs)


def _guess_temperature(runs: Sequence[Recording], name: str) -> str:
    if all(name in run.constants for run in runs) or (nearness(name) is not None and _count(runs, name) >= FEWEST):
        return "temperature"
    values = pool_readings(runs, name)
    if is_set_point(name) or (_steps_like_a_set_point(values) and _in_all(runs, name)):
        return "held" if _in_all(runs, name) and _moves(values) else "a set point is no temperature of a part"
    if len(values) < FEWEST:
        return _tell_lack(runs, name)
    return "temperature" if _moves(values) else "it never moves"


def _moves(values: Array) -> bool:
    return len(values) >= FEWEST and bool(np.ptp(values) > 0)


def _tell_lack(runs: Sequence[Recording], name: str) -> str:
    count = _count(runs, name)
    return "it never moves" if count >= FEWEST else f"it has {count} readings"


def _count(runs: Sequence[Recording], name: str) -> int:
    """Readings, also of a channel that stands still."""
    return sum(int(np.isfinite(run.columns[name].values).sum()) for run in runs if name in run.columns)


def _guess_length(runs: Sequence[Recording], name: str) -> str:
    values = pool_readings(runs, name)
    if not _moves(values):
        return _tell_lack(runs, name)
    ends = np.quantile(values, (0.05, 0.95))
    way = f"it goes over {1e3 * np.ptp(ends):.3g} mm, which is an axis's way and no thermal displacement"
    return "displacement" if np.ptp(ends) <= LARGEST else way


def _steps_like_a_set_point(values: Array) -> bool:
    """Few jumps, each a good part of all that it goes over and more than the step of any reading."""
    jumps = np.abs(np.diff(values))
    jumps = jumps[jumps > 0]
    if not len(jumps) or len(jumps) > len(values) / FEWEST:
        return False
    steps = [10.0**-k for k in range(9)]
    printed = next((s for s in steps if np.allclose(values / s, np.rint(values / s), atol=1e-6, rtol=0)), 0.0)
    return bool(np.median(jumps) >= np.ptp(values) / 4 and np.min(jumps) > 2.5 * printed)


def pool_readings(runs: Sequence[Recording], name: str) -> Array:
    """The finite readings of a channel in all runs."""
    rows = [true_readings(run, name) for run in runs if name in run.columns]
    values = np.concatenate(rows) if rows else np.empty(0)
    return np.asarray(values[np.isfinite(values)])


def _find_ambient(runs: Sequence[Recording], warm: Sequence[str]) -> str:
    """By its name, from outdoors to the room; what is measured goes before a constant of the mappings, and the only
    temperature there is, is none."""
    measured = [n for n in warm if any(n in run.columns for run in runs)]
    named = [n for n in measured if nearness(n) is not None and _in_all(runs, n)]
    constant = [n for n in warm if all(n in run.constants for run in runs)]
    open_to = named if len(named) < len(measured) else []
    ranked = sorted(open_to or constant, key=lambda n: (9 if nearness(n) is None else nearness(n), len(n)))
    return ranked[0] if ranked else ""


def _check_temperatures(
    runs: Sequence[Recording], units: Mapping[str, str], temperatures: Sequence[str], ambient: str
) -> None:
    if temperatures:
        return
    complaints = Complaints()
    warm = [name for name, text in units.items() if unit(text).is_temperature and name != ambient]
    wrong = f"no temperature of a part is recorded that moves (columns: {', '.join(units)})"
    if ambient and not warm:
        wrong = f"the only temperature is {ambient}, taken as the surroundings"
    right = f"--sensor {ambient} makes it a part" if ambient else "a draft needs one column in degC at least"
    complaints.refuse(Spot(runs[0].file), wrong, right)
    complaints.raise_if_any()


def _axes(names: Sequence[str], unused: dict[str, str]) -> dict[str, str]:
    """An axis for every displacement: that of its name, else the first that is free, z before x and y."""
    axes = dict[str, str]()
    for name in sorted(names, key=lambda n: not axis_in(n)):
        wanted = [axis_in(name)] if axis_in(name) else ["z", "x", "y"]
        free = [axis for axis in wanted if axis not in axes.values()]
        if free:
            axes[name] = free[0]
        else:
            unused[name] = f"another column measures {' or '.join(wanted)}; one probe is drafted for an axis"
    return axes
