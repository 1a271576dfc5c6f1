"""The paper's bending model (eq. 6–9), beside the first moment of the profile and the difference of the faces."""

from __future__ import annotations

from math import cos, sin

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.expansions.bending import Bending
from network.engine.assembly import build
from network.engine.paper.table import Cell, PaperTable
from network.engine.simulation import simulate
from network.machine.machine import Machine
from network.platform.package_data import find_shipped
from network.recordings.scenario import Scenario

BY = {"first moment": None, "faces": "faces", "eq. 9": "heat"}
"""How bending is computed → level of table_bending.yaml."""
PROFILE_LUMPS = 1000
"""So many that the outer lumps are the faces, to 0.1 %."""
RUN_LUMPS = 200
MINUTES = (10, 60, 120, 240)


def table_machine(by: str, lumps: int | None = None) -> Machine:
    counts = [] if lumps is None else [lumps]
    return Machine.load(find_shipped("machines", "table_bending.yaml"), level=BY[by], lumps=counts)


def bend_table(by: str, rise: Array) -> float:
    """Displacement [m] of the table for rises over the reference [K], one for each lump from foot to top."""
    machine = table_machine(by, len(rise))
    network, entry = build(machine), machine.tcp["z"]["table bends"]
    T = np.zeros(network.size)
    T[network.parts["table"]] = rise
    heat = network.heat_capacity * T
    readings = (
        network.heat_row(reading.place) @ heat if reading.how == "heat" else network.reading_row(reading) @ T
        for reading in entry.readings()
    )
    return float(entry.movement({}, *readings))


def eq_9(machine: Machine, heat: float) -> float:
    """Eq. 9 as printed [m]: (L/2)(1 − cos θ)/sin θ, θ = α E/(ρ c S H) with S across the length, ρ c S = C/L."""
    entry, node = machine.tcp["z"]["table bends"], machine.nodes["table"]
    assert isinstance(entry, Bending)
    length, height = float(entry.length), float(node.length)
    theta = (node.expansion or 0.0) * heat / (node.capacity / length * height)
    return length / 2 * (1 - cos(theta)) / sin(theta)


def bending_profiles() -> PaperTable:
    """Bending over that of a linear profile with the same warmest face and a cold foot."""
    machine = table_machine("first moment")
    y: Array = np.linspace(0.5, PROFILE_LUMPS - 0.5, PROFILE_LUMPS) / PROFILE_LUMPS
    linear = eq_9(machine, machine.nodes["table"].capacity / 2)
    shapes = {"linear, 1 K at the top": y, "skin of 10 % of the height, 1 K": np.where(y > 0.9, 1.0, 0.0)}
    rows: list[list[Cell]] = [[name, *(bend_table(by, rise) / linear for by in BY)] for name, rise in shapes.items()]
    note = (
        "Only the first moment is right for both: curvature follows 12/H³ ∫ΔT y dy. The faces take the skin for all of "
        "the height, and eq. 9 knows its heat, not where it is."
    )
    title = "Bending of the table, relative to that of the linear profile (α ΔT L²/(8 H))"
    return PaperTable("bending", title, {"profile": "", **dict.fromkeys(BY, ".2f")}, rows, (note,))


def bending_run() -> PaperTable:
    """The table under cutting heat: lift of its middle by the three."""
    scenario = Scenario.load(find_shipped("scenarios", "table_under_cutting.yaml"))
    runs = {by: simulate(table_machine(by, RUN_LUMPS), scenario) for by in BY}
    run = runs["eq. 9"]
    at = [int(np.argmin(np.abs(run.t - minutes * 60))) for minutes in MINUTES]
    heat, lifts = run.heat["table"] / 1e3, [other.tcp["z"] * 1e6 for other in runs.values()]
    rows = [[float(column[k]) for column in (run.t / 60, heat, *lifts)] for k in at]
    gap = max(abs(row[-1] / 1e6 / eq_9(run.machine, row[1] * 1e3) - 1) for row in rows)
    notes = (
        "Two hours of cutting, two hours of rest. The table bends only while heat flows into its face; eq. 9 keeps "
        "what it has.",
        f"Eq. 9 from heat flows, as (L/2) tan(θ/2), against eq. 9 as printed: {gap:.0e}, the digits that 1 − cos θ "
        "loses.",
    )
    columns = {"time [min]": ".0f", "E [kJ]": ".0f", **{f"{by} [µm]": ".2f" for by in BY}}
    return PaperTable("bending under cutting", "The table under cutting heat, lift of its middle", columns, rows, notes)
