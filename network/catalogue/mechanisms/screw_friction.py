from __future__ import annotations

from network.catalogue.declaration.fields import param
from network.catalogue.mechanisms.friction import Sliding


class ScrewFriction(Sliding, kind="screw_friction"):
    """Friction of a ball screw's nut and bearings: q = p |v|, v the feed, p = 2π M/lead for a friction torque M.

    Constant torque: no influence of speed, load or temperature. Source: Tian & He 2004, q = 0.12 π n M in kJ/h with n
    in 1/min and M in N m, which is 2π/60 n M in W, as quoted in eq. 1 of Machines 11 (2023) 408.
    """

    power_per_feed = param("W/(m/min)", 0, 1e5, "heat for each unit of feed", typical=12)
    sentence = "a screw rubs and heats {into} with {power_per_feed} of feed"
