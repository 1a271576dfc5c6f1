"""The paper's specimen: its table 2, and the profiles of an insulated bar against the analytic series."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import log

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.paper.table import Cell, PaperTable
from network.engine.simulation import simulate
from network.engine.trajectory import Trajectory
from network.machine.machine import Machine
from network.platform.package_data import find_shipped
from network.recordings.scenario import Scenario

TABLE_2 = {
    180: (69.60, 69.75, 69.17), 360: (139.39, 139.61, 138.33),
    540: (209.22, 209.47, 207.51), 720: (279.06, 279.33, 276.68),
}  # fmt: skip
"""kJ → FEM heated at the end, FEM heated in the middle, eq. 5 [µm], as printed."""
PLACES = {"end": None, "middle": "middle"}
"""Where it is heated → level of specimen_bar.yaml."""
METHODS = ("temperature", "heat")
HOURS = (1, 5, 10, 15, 20)
TERMS = 400


def bar(place: str, method: str = "temperature", lumps: int | None = None) -> Machine:
    """The specimen heated at a place, its growth computed from temperature or from heat."""
    counts = [] if lumps is None else [lumps]
    file = find_shipped("machines", "specimen_bar.yaml")
    return Machine.load(file, level=PLACES[place], lumps=counts, sets=[f"tcp.z.bar grows.method={method}"])


@cache
def heating() -> Scenario:
    return Scenario.load(find_shipped("scenarios", "heat_20_hours.yaml"))


def table_2() -> PaperTable:
    """Growth over heat absorbed; the four of ours are from two machines and two ways of computing it."""
    runs = {(place, method): simulate(bar(place, method), heating()) for place in PLACES for method in METHODS}
    grown = {key: run.tcp["z"] * 1e6 for key, run in runs.items()}
    heat = _heat_brought(runs["end", "temperature"])
    columns = {
        "E [kJ]": ".0f", "FEM end": ".2f", "FEM middle": ".2f", "eq. 5": ".2f",
        **{f"{place}, {'T' if method == 'temperature' else 'E'}": ".2f" for place, method in runs},
        "FEM end off [%]": "+.2f", "FEM middle off [%]": "+.2f", "eq. 5 off [%]": "+.3f",
    }  # fmt: skip
    rows = []
    for kilojoules, printed in TABLE_2.items():
        at = int(np.argmin(np.abs(heat - kilojoules * 1e3)))
        ours = [float(values[at]) for values in grown.values()]
        off = [100 * (theirs / own - 1) for theirs, own in zip(printed, (ours[0], ours[2], ours[0]), strict=True)]
        rows.append([heat[at] / 1e3, *printed, *ours, *off])
    title = "Table 2: growth of the specimen [µm]; FEM and eq. 5 as printed, ours from temperatures (T) and heat (E)"
    return PaperTable("table 2", title, columns, rows, (*_agreement(grown, heat), _fem_offset(rows)))


def _heat_brought(run: Trajectory) -> Array:
    """∫ of the heater's power over time [J], from the scenario alone."""
    power = run.inputs["heater"]
    steps = np.diff(run.t) * (power[1:] + power[:-1]) / 2
    return np.concatenate([[0.0], np.cumsum(steps)])


def _agreement(grown: dict[tuple[str, str], Array], heat: Array) -> tuple[str, ...]:
    apart = {place: largest_gap(grown[place, "heat"], grown[place, "temperature"]) for place in PLACES}
    node = bar("end").nodes["bar"]
    by_eq_5 = (node.expansion or 0.0) * float(node.length) * heat / node.capacity * 1e6
    hand = max(largest_gap(values, by_eq_5) for values in grown.values())
    told = ", ".join(f"{gap:.0e} (heated at the {place})" for place, gap in apart.items())
    return (
        f"Largest relative deviation over {len(heat) - 1} samples, growth from heat flows against growth from "
        f"temperatures: {told}; of all four against eq. 5 with E = ∫P dt of the scenario: {hand:.0e}.",
        "Eq. 5 holds for any bar of constant properties, so the place cannot matter; the printed column is rounded "
        "otherwise.",
    )


def _fem_offset(rows: list[list[float]]) -> str:
    above = [100 * (fem / row[3] - 1) for row in rows for fem in row[1:3]]
    extent = f"{min(above):.1f} to {max(above):.1f} %"
    return f"The FEM lies {extent} above the paper's own eq. 5: that difference is the FEM's."


def largest_gap(values: Array, base: Array) -> float:
    """The largest relative difference after the start, where both are zero."""
    return float(np.abs(values[1:] / base[1:] - 1).max())


# -- profiles -------------------------------------------------------------------------------------------------------
def series(machine: Machine, place: str, power: float, t: float) -> Array:
    """Mean rise of every lump of the insulated bar at t [K].

    Heat Q enters at ξ = 1, ξ the distance from the cold end over the length (Carslaw & Jaeger, Conduction of Heat in
    Solids, 3.8 eq. 3): T = Q t/(ρ c S L) + Q L/(k S) [(3 ξ² − 1)/6 − (2/π²) Σ (−1)ⁿ/n² e^(−n²π²Fo) cos nπξ], here
    integrated over each lump. A bar heated in the middle is two of half the length with half the heat.
    """
    node, halves = machine.nodes["bar"], 1 if place == "end" else 2
    length, Q = float(node.length) / halves, power / halves
    k_S = float(node.bar_conductance) * float(node.length) / node.lumps
    edges = np.linspace(0, 1, node.lumps + 1)
    xi = np.sort(1 - edges) if halves == 1 else edges[: node.lumps // 2 + 1] * 2
    n = np.arange(1, TERMS)
    fourier = k_S * t / (node.capacity / halves * length)
    decay = (-1.0) ** n / n**2 * np.exp(-((n * np.pi) ** 2) * fourier)
    integral = (xi**3 - xi) / 6 - 2 / np.pi**2 * (decay * np.sin(np.outer(xi, n) * np.pi) / (n * np.pi)).sum(axis=1)
    rise = Q * t / (node.capacity / halves) + Q * length / k_S * np.diff(integral) / np.diff(xi)
    return np.asarray(rise[::-1] if halves == 1 else np.concatenate([rise, rise[::-1]]))


def profiles(place: str, hours: float, lumps: int | None = None) -> tuple[Array, Array]:
    """Temperatures of the lumps after so many hours [°C]: of the network, and of the series."""
    machine, schedule = bar(place, lumps=lumps), heating().schedule
    t = schedule.t[schedule.t <= hours * 3600 + 1e-6]
    run = simulate(machine, replace(schedule, t=t))
    rise = series(machine, place, float(run.inputs["heater"][-1]), float(t[-1]))
    return run.T_end[run.network.parts["bar"]], float(run.parts["bar"][0]) + rise


def profile_table() -> PaperTable:
    """The warmest and the coldest lump, and the largest deviation over the bar, at two numbers of lumps."""
    few = bar("end").nodes["bar"].lumps
    many = 4 * few
    rows: list[list[Cell]] = []
    coarse, orders = [], []
    for place in PLACES:
        for hours in HOURS:
            (ours, exact), (finer, finer_exact) = profiles(place, hours), profiles(place, hours, many)
            off, finer_off = (float(np.abs(a - b).max()) for a, b in ((ours, exact), (finer, finer_exact)))
            ends = [float(values) for values in (ours.max(), exact.max(), ours.min(), exact.min())]
            rows.append([place, hours, *ends, off, finer_off])
            coarse.append(off)
            orders += [log(off / finer_off, 4)] if off > 1e-6 else []
    columns = {
        "heated at": "", "time [h]": ".0f", "warmest [°C]": ".4f", "series, warmest": ".4f", "coldest [°C]": ".4f",
        "series, coldest": ".4f", f"off, {few} lumps [K]": ".1e", f"off, {many} lumps [K]": ".1e",
    }  # fmt: skip
    notes = (
        f"Largest deviation of any lump with {few} lumps: {max(coarse):.1e} K; with four times as many it falls with "
        f"order {min(orders):.2f} or better (where it is above rounding).",
    )
    title = "Profiles of the insulated bar, lumps against the series of Carslaw & Jaeger"
    return PaperTable("profiles", title, columns, rows, notes)
