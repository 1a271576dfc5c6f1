"""What the runs that a model predicted leave to the next ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from network.catalogue.declaration.declare import Array
from network.engine.response.joint_course import JointPlan
from network.engine.response.measured_run import Resampled, Run
from network.engine.response.output_jacobian import Slopes
from network.engine.solvers.plan import Plan


@dataclass(eq=False)
class WarmStart:
    """Run by run. guess: the course that the search for a bent one begins from; plans: with what they depend on;
    slopes: of the channels, where they stay the same at all instants and θ; resampled: the cells of the intervals
    between the last edges; joint: the last plan of all runs; is_seen_same: whether the slopes of channels held at all
    instants at other numbers than the file's, too."""

    guess: dict[int, tuple[Array, Array]] = field(default_factory=dict)
    plans: dict[int, tuple[object, Plan]] = field(default_factory=dict)
    slopes: dict[int, Slopes] = field(default_factory=dict)
    resampled: dict[int, Resampled] = field(default_factory=dict)
    joint: list[JointPlan] = field(default_factory=list)
    is_seen_same: bool = False

    def resampling(self, i: int, run: Run, edges: Array) -> Resampled:
        """Of a run over the intervals between some edges."""
        if i not in self.resampled or self.resampled[i].edges is not edges:
            self.resampled[i] = Resampled(run, edges)
        return self.resampled[i]

    def join(self, runs: Sequence[Run]) -> JointPlan:
        """All runs, whose plans are known, as one; as before where these are the same."""
        plans = [self.plans[i][1] for i in range(len(runs))]
        if not self.joint or any(a is not b for a, b in zip(self.joint[0].parts, plans, strict=True)):
            resampled = (self.resampling(i, run, plans[i].edges) for i, run in enumerate(runs))
            self.joint = [JointPlan(tuple(plans), tuple(resampled))]
        return self.joint[0]
