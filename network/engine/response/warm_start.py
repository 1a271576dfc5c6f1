"""What the runs that a model predicted leave to the next ones."""

from __future__ import annotations

from dataclasses import dataclass, field

from network.catalogue.declaration.declare import Array
from network.engine.response.output_jacobian import Slopes
from network.engine.response.prediction import Resampled, Run
from network.engine.solvers.plan import Plan


@dataclass(eq=False)
class WarmStart:
    """Run by run. guess: the course that the search for a bent one begins from; plans: with what they depend on;
    slopes: of the channels, where they stay the same at all instants and θ; resampled: the cells of the intervals
    between the last edges."""

    guess: dict[int, tuple[Array, Array]] = field(default_factory=dict)
    plans: dict[int, tuple[object, Plan]] = field(default_factory=dict)
    slopes: dict[int, Slopes] = field(default_factory=dict)
    resampled: dict[int, Resampled] = field(default_factory=dict)

    def resampling(self, i: int, run: Run, edges: Array) -> Resampled:
        """Of a run over the intervals between some edges."""
        if i not in self.resampled or self.resampled[i].edges is not edges:
            self.resampled[i] = Resampled(run, edges)
        return self.resampled[i]
