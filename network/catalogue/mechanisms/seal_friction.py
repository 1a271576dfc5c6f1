from __future__ import annotations

from collections.abc import Iterator

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.mechanisms.friction import Friction, turning
from network.catalogue.mechanisms.mechanism import Inputs


class SealFriction(Friction, kind="seal_friction"):
    """Friction of a lip or gap seal of constant torque: q = 2π/60 · |n| · M.

    The equation is a bearing's; it is a kind of its own because it stands at the shaft's end, has no preload, and
    keeps its torque as it warms. M = μ F' π d²/2 for a lip of line load F' on a shaft of diameter d (unverified).
    """

    torque = param("N m", 0, 1e3, "friction torque of the seal", typical=0.05)
    strength = "torque"
    sentence = "a seal rubs with {torque} and heats {into}"

    def moment(self, u: Inputs, *T: Array) -> Array:
        return self.torque

    @classmethod
    def hosts(cls, machine: MachineLike) -> Iterator[str]:
        return turning(machine)
