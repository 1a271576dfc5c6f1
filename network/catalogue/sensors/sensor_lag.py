from __future__ import annotations

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param
from network.catalogue.mechanisms.mechanism import Inputs
from network.catalogue.sensors.base import SensorEffect


class SensorLag(SensorEffect, kind="sensor_lag"):
    """A slow sensor: lag · dz/dt = truth − z, the reading is z. It starts at the truth.

    A first-order instrument (Doebelin, Measurement Systems): lag = heat capacity of the sensor / conductance to what it
    measures, so 63 % of a step after one lag. Some 1 to 10 s for a glued thermocouple, minutes for one loose in a bore.
    It changes its own channel only; a mass that takes part in the machine is a hidden_mass.
    """

    lag = param("s", 0, 36_000, "time constant of the sensor", positive=True, typical=120)
    has_state = True
    strength = "lag"
    sentence = "{channel} follows the truth with a lag of {lag}"

    def rate(self, truth: Array, state: Array) -> Array:
        return (truth - state) / self.lag

    def reading(self, truth: Array, state: Array, u: Inputs) -> Array:
        return state
