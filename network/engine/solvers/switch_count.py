"""How often relays may switch before nobody can have meant it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from network.engine.solvers.plan import Plan
from network.platform.refusal import Failed

MOST_SWITCHES = 100_000
"""Of a run: some minute of computing."""
MOST_UNSEEN = 10_000
"""Between two instants of output: a relay that switches every ten seconds of a day. More are a jump in time."""


def check_count(plan: Plan, switches: Sequence[tuple[float, int, int]], most: int = MOST_SWITCHES) -> None:
    """Raises Failed where relays switch without end."""
    if len(switches) > most:
        t = switches[-1][0]
        raise Failed(f"a relay switched {most} times by {t:.4g} s; give it a wider hysteresis or a delay")
    if len(switches) > MOST_UNSEEN:
        since, now = switches[-MOST_UNSEEN - 1][0], switches[-1][0]
        k = int(np.searchsorted(plan.t, since, side="right"))
        if k < len(plan.t) and not plan.t[k] <= now:
            before = float(plan.t[max(k - 1, 0)])
            raise Failed(
                f"a relay switches more than {MOST_UNSEEN} times between {before:.10g} s and {plan.t[k]:.10g} s, two "
                "instants of the run with nothing in between; look for a jump in time, or give it a wider hysteresis"
            )
