"""What the runs that a model predicted leave to the next ones."""

from __future__ import annotations

from dataclasses import dataclass, field

from network.catalogue.declaration.declare import Array
from network.engine.response.measured_run import JointPlan
from network.engine.response.output_jacobian import Slopes


@dataclass(eq=False)
class WarmStart:
    """Run by run. guess: the course that the search for a bent one begins from; middle: mean temperatures of one beside
    relays, about which bent laws are straight; slopes: of the channels, where they
    stay the same at all instants and θ; joint: the last plan of all runs, with what their channels owe to all but the
    states; is_seen_same: whether the slopes of channels held at all instants at other numbers than the file's, too;
    is_apart: whether bent laws did not settle in all runs at once."""

    guess: dict[int, tuple[Array, Array]] = field(default_factory=dict)
    middle: dict[int, Array] = field(default_factory=dict)
    slopes: dict[int, Slopes] = field(default_factory=dict)
    joint: tuple[JointPlan, dict[int, Array]] | None = None
    is_seen_same: bool = False
    is_apart: bool = False

    def beside(self, joint: JointPlan) -> dict[int, Array]:
        """By run, what its channels owe to all but the states, as it is found."""
        if self.joint is None or self.joint[0] is not joint:
            self.joint = joint, {}
        return self.joint[1]
