"""Concealed heat over time beside the course that a diagnosis tells of what it does not know."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import PurePath
from typing import Any

import numpy as np

WORDS = ("heat", "offset", "values")
"""Keys under which a course may stand, beside `t` [s] and `file`."""
FEWEST = 8
"""Instants that a correlation is told of."""


def correlation(truth: Mapping[str, Any] | None, told: Mapping[str, Any]) -> float | None:
    """Of the concealed course and the told one at its instants; None where either does not tell one, or nothing
    changes in the concealed one, as of a fan that stands in that run."""
    if not truth:
        return None
    for course in courses(told):
        if "file" not in course or PurePath(course["file"]).stem == PurePath(truth["file"]).stem:
            return compared(truth, course)
    return None


def courses(told: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """Those of the findings, then those of the places where something is missing, the likeliest first."""
    for each in (*(told.get("findings") or ()), *((told.get("located") or {}).get("nodes") or ())):
        course = each.get("course")
        yield from [course] if isinstance(course, Mapping) else course or ()


def compared(truth: Mapping[str, Any], course: Mapping[str, Any]) -> float | None:
    values = next((course[word] for word in WORDS if word in course), None)
    if values is None or len(values) != len(course["t"]):
        return None
    t, y = (np.asarray(each, dtype=float) for each in (course["t"], values))
    real = np.asarray(truth["t"], dtype=float)
    x = np.interp(t, real, np.asarray(truth["heat"], dtype=float))
    kept = np.isfinite(y) & (t >= real[0]) & (t <= real[-1])
    x, y = x[kept], y[kept]
    if len(x) < FEWEST or not np.ptp(x) > 0:
        return None
    return float(np.corrcoef(x, y)[0, 1]) if np.ptp(y) > 0 else 0.0
