from __future__ import annotations

from network.declare import Array
from network.fields import param
from network.mechanisms.friction import Friction


class BearingFriction(Friction, kind="bearing_friction"):
    """Friction of a bearing of constant torque: q = 2π/60 · |n| · M.

    The partition between the rings is `into`; one half each is the usual assumption. Constant torque holds for small
    changes of speed, load and temperature; see viscous_friction and preload_friction for what it leaves out.
    Source: SKF, rolling bearings, power loss N_R = 1.05e-4 M n (W, N mm, 1/min); the same as eq. 10 of the
    heat-quantity method, 1.047e-4 n M (where M is printed in N m: it is N mm).
    """

    torque = param("N m", 0, 1e5, "friction torque", typical=0.3)
    strength = "torque"
    looks_like = ("seal_friction", "motor_loss", "viscous_friction", "windage")
    sentence = "a bearing rubs with {torque} and heats {into}"

    def moment(self, *T: Array) -> Array:
        return self.torque
