from __future__ import annotations

from network.catalogue.declaration.fields import param
from network.catalogue.mechanisms.friction import Jointed, Sliding


class GuideFriction(Sliding, Jointed, kind="guide_friction"):
    """Friction of a guideway: q = F |v|, v the feed, F = μ N the force of Coulomb friction: it is `power_per_feed`.

    60 N, a few carriages with their wipers, are 1 W/(m/min). Viscous drag of a slideway, which grows with v², is left
    out. To be told from screw_friction only by the place.
    """

    power_per_feed = param("W/(m/min)", 0, 1e5, "heat for each unit of feed", typical=4)
    sentence = "a guideway rubs and heats {into} with {power_per_feed} of feed"
