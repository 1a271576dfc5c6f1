"""Where a recording is parted: pieces that each are a run of their own, with a start of its own."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from network.platform.quantities.text_table import span
from network.platform.refusal import Complaints
from network.recordings.columns import Column, Samples
from network.recordings.gap_bridging import hinders
from network.recordings.hygiene.glue import find_glued
from network.recordings.time_order import LEAST, Step, find_steps


@dataclass(frozen=True)
class Cut:
    """Another run begins with sample `index`; why: a sentence's part."""

    index: int
    why: str


def find_cuts(samples: Samples, complaints: Complaints) -> tuple[Cut, ...]:
    """Cuts where the clock goes back to another run, and at gaps through which the inputs cannot be drawn."""
    steps = find_steps(samples, complaints)
    if complaints.refusals:
        return ()
    cuts = list[Cut]()
    for step in steps:
        why = step.sentence if step.is_back else _why_gap(samples, step, steps, cuts)
        if why:
            cuts.append(Cut(step.index, why))
    glued = [cut for part in extents(len(samples.t), cuts) for cut in _glued(samples, part)]
    return tuple(sorted([*cuts, *glued], key=lambda cut: cut.index))


def _glued(samples: Samples, part: slice) -> Iterator[Cut]:
    columns = [column.keep(part) for column in samples.columns.values()]
    for index, names in find_glued(samples.t[part], columns):
        when = f"{float(samples.t[part][index]):.10g} s"
        jump = f"{len(names)} temperatures jump at once ({', '.join(names[:MOST])}{', …' if len(names) > MOST else ''})"
        yield Cut(part.start + index, f"at {when} {jump} as none does by itself, and no input does")


def _why_gap(samples: Samples, step: Step, steps: Sequence[Step], cuts: Sequence[Cut]) -> str:
    end = next((s.index for s in steps if s.is_back and s.index > step.index), len(samples.t))
    begin = cuts[-1].index if cuts else 0
    columns = [column.keep(slice(end)) for column in samples.columns.values()]
    hindrance = hinders(samples.t[:end], columns, step.index, begin)
    return f"{step.sentence}, and {hindrance}" if hindrance else ""


def extents(count: int, cuts: Sequence[Cut]) -> tuple[slice, ...]:
    """The samples of each piece that has enough of them to be a run."""
    edges = [0, *(cut.index for cut in cuts), count]
    parts = [slice(a, b) for a, b in pairwise(edges)]
    return tuple(part for part in parts if part.stop - part.start >= LEAST) if cuts else (slice(0, count),)


def tell_cuts(file: str, t: np.ndarray, cuts: Sequence[Cut]) -> tuple[str, ...]:
    """One sentence on a recording that is parted."""
    if not cuts:
        return ()
    lengths = [span(float(t[part][-1] - t[part][0])) for part in extents(len(t), cuts)]
    more = [f"and {len(cuts) - MOST} more times"] if len(cuts) > MOST else []
    why = "; ".join([*(cut.why for cut in cuts[:MOST]), *more])
    many = "runs" if len(lengths) != 1 else "run"
    runs = f"{len(lengths)} {many} ({', '.join(lengths[:MOST])}{', …' if len(lengths) > MOST else ''})"
    lone = len(cuts) + 1 - len(lengths)
    told = f"{file} is parted into {runs}, each with a start of its own: {why}"
    alone = "1 sample that stands alone is" if lone == 1 else f"{lone} samples that stand alone are"
    return (told, f"{file}: {alone} left out") if lone else (told,)


MOST = 5
"""Cuts that a sentence tells."""


def piece_column(column: Column, part: slice, zeroed: bool) -> Column:
    """A part of it; zeroed: less its first value there."""
    values = column.values[part]
    known = values[np.isfinite(values)]
    return replace(column, values=values - known[0] if zeroed and len(known) else values)
