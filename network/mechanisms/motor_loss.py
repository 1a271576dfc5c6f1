from __future__ import annotations

import numpy as np

from network.declare import Array
from network.fields import param
from network.mechanisms.base import SPINDLE, Inputs, Source


class MotorLoss(Source, kind="motor_loss"):
    """Losses of a motor: q = copper (while |n| > 0) + iron (|n|/n_ref)^p.

    p is 1 (hysteresis) to 2 (eddy currents). Copper loss at constant current; it does not fall with temperature here
    (see copper_temperature). Source: Bertotti's separation of iron losses, W = k_h f + k_e f² at constant induction;
    Bertotti, IEEE Trans. Magn. 24 (1988) 621; unverified.
    """

    copper = param("W", 0, 1e6, "copper loss while running", typical=100)
    iron = param("W", 0, 1e6, "iron loss at the reference speed", typical=200)
    iron_exponent = param("1", 0.5, 3, "exponent of the iron loss over speed", default=1.5)
    reference_speed = param("rpm", 0, 300_000, "speed at which the iron loss is given", positive=True, typical=10_000)
    inputs = SPINDLE
    strength = "iron"
    looks_like = ("windage", "bearing_friction")
    sentence = "the motor heats {into} with {copper} copper and {iron} iron loss at {reference_speed}"

    def heat(self, u: Inputs, *T: Array) -> Array:
        n = np.abs(u["speed"])
        return self.copper * (n > 0) + self.iron * (n / self.reference_speed) ** self.iron_exponent
