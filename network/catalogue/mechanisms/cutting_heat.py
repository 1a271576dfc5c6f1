from __future__ import annotations

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import channel, param
from network.catalogue.mechanisms.base import Source
from network.catalogue.mechanisms.mechanism import Inputs


class CuttingHeat(Source, kind="cutting_heat"):
    """The part of the cutting power that stays in the machine: q = share · P_cut.

    Nearly all of the cutting power becomes heat; 75 to 80 % of it leaves with the chips and the coolant, some 10 % goes
    into the workpiece and some 10 % into the tool (Krar, Technology of Machine Tools). Chips that lie on the table make
    the share larger, flooding makes it smaller. The input is the mechanical power at the tool, not the motor's.
    """

    share = param("1", 0, 1, "share of the cutting power", typical=0.1)
    input = channel("cutting_power", "W")
    strength = "share"
    sentence = "{share} of the cutting power heats {into}"

    def heat(self, u: Inputs, *T: Array) -> Array:
        q: Array = self.share * u[self.input]
        return q
