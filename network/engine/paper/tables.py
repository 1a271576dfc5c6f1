"""The heat-quantity paper's tables with ours beside them; every number of ours is computed from the shipped files.

Source: "Utilization of heat quantity to model thermal errors of machine tool spindle". Where the paper prints something
else than it means (eq. 10, 15, 25), the tables say so; what its method cannot give is named, not fitted.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from network.engine.paper.bar import profile_table, table_2
from network.engine.paper.bending_model import bending_profiles, bending_run
from network.engine.paper.fits import fit_table
from network.engine.paper.table import Cell, PaperTable

RESIDUALS = {("δz", 6000): 2.2, ("δz", 8000): 21.8, ("δy", 6000): 4.7, ("δy", 8000): 6.0}
"""Residuals of the four fits in %, as printed."""
CLAIMED = 91.3


def accuracy() -> float:
    """100 % less the mean of the printed residuals."""
    return 100 - sum(RESIDUALS.values()) / len(RESIDUALS)


def accuracy_table() -> PaperTable:
    rows: list[list[Cell]] = [[axis, rpm, residual] for (axis, rpm), residual in RESIDUALS.items()]
    note = (
        f"100 % less their mean is {accuracy():.3f} %; the paper says {CLAIMED} %. That is arithmetic on its four "
        "numbers: the readings are not published, so nothing here could reproduce it."
    )
    columns = {"fit": "", "rpm": ".0f", "residual [%]": ".1f"}
    return PaperTable("accuracy", "Average fitting accuracy: the printed residuals", columns, rows, (note,))


def paper_tables() -> tuple[PaperTable, ...]:
    """All tables, computed now."""
    return (table_2(), profile_table(), fit_table(), bending_profiles(), bending_run(), accuracy_table())


def tell_paper() -> Iterator[str]:
    """Lines of all tables."""
    yield "Utilization of heat quantity to model thermal errors of machine tool spindle: the paper's numbers and ours."
    for table in paper_tables():
        yield ""
        yield from table.lines()


def paper_json() -> dict[str, Any]:
    return {table.name: table.as_dict() for table in paper_tables()} | {"accuracy_percent": accuracy()}
