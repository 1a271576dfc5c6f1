from __future__ import annotations

from network.declare import Array
from network.fields import param
from network.sensors.base import SensorEffect


class SensorLag(SensorEffect, kind="sensor_lag"):
    """A slow sensor: lag · dz/dt = truth − z, the reading is z. It starts at the truth.

    First-order lag of a sensor with its mounting; 1 to 10 s for a glued thermocouple, minutes for one in a bore.
    Source: Doebelin, Measurement Systems, first-order instruments; unverified edition.
    """

    lag = param("s", 0, 36_000, "time constant of the sensor", positive=True, typical=120)
    has_state = True
    strength = "lag"
    looks_like = ("hidden_mass",)
    sentence = "{channel} follows the truth with a lag of {lag}"

    def rate(self, truth: Array, state: Array) -> Array:
        return (truth - state) / self.lag

    def reading(self, truth: Array, state: Array) -> Array:
        return state
