from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self

from network.catalogue.declaration.fields import Place, param, place
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.suspects.base import Suspect


class AmbientDrift(Suspect, kind="ambient_drift"):
    """Surroundings drift from what is recorded or stated of them: T = T_given + rate · t, t the time of the run.

    Where the room is a constant of the file, or its thermometer hangs far from the machine. Valid over a shift; a day
    goes up and down, for which a node's `drifts:` has a swing, too. It acts on all that is linked to the surroundings
    alike, in proportion to the conductance, which tells it from a source in one part. In a file it is written
    `drifts: {rate: 0.3 K/h}` at the held node. Linear in its number, so a fit finds it by slopes.
    """

    host = place("the node of the surroundings")
    rate = param("K/h", -50, 50, "how fast they warm beside what is given", typical=0.3)
    strength = "rate"
    sentence = "{host} drifts by {rate} from what is recorded or stated"

    def patch(self, machine: MachineLike) -> Mapping[str, Any]:
        node = machine.nodes[self.host.node]
        return {"nodes": {self.host.node: {**node.to_plain(), "drifts": self.write_numbers("rate")}}}

    @classmethod
    def suspected(cls, machine: MachineLike) -> Iterator[Self]:
        """Every held node that does not drift yet, either way."""
        typical = cls.params()["rate"].proposal()
        for name, node in machine.nodes.items():
            if node.is_held and "drifts" not in node.to_plain():
                yield from (cls(host=Place(name), rate=sign * typical) for sign in (1, -1))
