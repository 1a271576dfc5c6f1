"""Whether what coarse lumps lack is as large as what is left: then nothing else can be told from that.

With e(n) [σ] what a bar of n lumps has more with 2 n (lump_refinement), bars lack 4/3 Σ e together at most, with what
relays out of step make of it; of N rows at misfit χ √(N (χ² − 1)) is left beyond their noise.
"""

from __future__ import annotations

import numpy as np

from network.analysis.diagnosis.hypotheses.few_runs import on_few_runs
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.lumps.lump_refinement import TO_THE_LIMIT, leave_each
from network.analysis.sweep.finer_lumps import bars_of
from network.platform.refusal import Failed


def lacks_what_is_left(h: Hypothesis, jobs: int = 1) -> bool:
    """Of a hypothesis without findings, on the runs that it tells worst, at its numbers; no where a run breaks down."""
    try:
        few, counts = on_few_runs(h), bars_of(h.machine)
        lack = TO_THE_LIMIT * sum(leave_each(few, counts, [*counts], jobs).values())
    except (Failed, np.linalg.LinAlgError):
        return False
    return lack > 0.0 and lack**2 >= len(few.fit.left) * (few.chi**2 - 1)
