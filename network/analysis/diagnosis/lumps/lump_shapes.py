"""What lumps may get wrong in the channels: shapes that a test of further physics takes up, for they are in every run.

An error of lumps that is far within the noise of a reading adds up over thousands of them and comes back in runs that
were not seen; a name would be held for it. With n lumps in a bar and all others as they are let d be what the channels
have more with 2 n: 4/3 d is what is left to the limit of a continuous bar (lump_refinement.py), and counts as one more
number with a prior 1σ of one. Range: small errors, and bars whose profiles their lumps begin to resolve.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.lumps.lump_refinement import FINEST, TO_THE_LIMIT, means_of
from network.analysis.diagnosis.screening.screen import whiten
from network.analysis.sweep.finer_lumps import bars_of, cut_bars
from network.catalogue.declaration.declare import Array
from network.platform.parallel import run_all


def shapes_of_lumping(before: Hypothesis, current: Hypothesis, jobs: int = 1) -> Array:
    """Whitened (shapes, rows): what each bar of a hypothesis has more with twice its lumps, and what the one that
    stands in for it on coarser lumps gets wrong (before; the same one where there is none), at the numbers of that."""
    bars = bars_of(current.machine) if current.machine.lumps < FINEST else {}
    machines = [current.machine, *(cut_bars(current.machine, {name: 2 * n}) for name, n in bars.items())]
    here, *finer = run_all(partial(means_of, before), machines, jobs)
    if here is None:
        return np.empty((0, len(before.fit.left)))
    told = [TO_THE_LIMIT * (means - here) for means in finer if means is not None]
    return whiten(before.linearised, np.array([here - _stand_in(before), *told]))


def _stand_in(before: Hypothesis) -> Array:
    """Cells' means of all runs, with what coarser lumps are told to lack."""
    means = np.concatenate([p.cells for p in before.predictions])
    lacking = zip(before.case.lacking, before.fit.problem.data, strict=True) if before.case.lacking else ()
    lack = [each.at(data) for each, data in lacking]
    return np.asarray(means + np.concatenate(lack)) if lack else means
