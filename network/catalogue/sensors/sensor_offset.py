from __future__ import annotations

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param
from network.catalogue.mechanisms.mechanism import Inputs
from network.catalogue.sensors.base import SensorEffect


class SensorOffset(SensorEffect, kind="sensor_offset"):
    """A constant error of a temperature channel: reading = truth + offset.

    Calibration error of a thermocouple or thermistor, ± 0.1 to 1 K; an offset that all channels share is one of the
    reference and cannot be seen.
    """

    quantities = ("temperature",)
    offset = param("K", -100, 100, "what it reads too much", typical=0.3)
    strength = "offset"
    sentence = "{channel} reads {offset} too much"

    def reading(self, truth: Array, state: Array, u: Inputs) -> Array:
        return truth + self.offset
