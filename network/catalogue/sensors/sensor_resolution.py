from __future__ import annotations

from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import whole
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.mechanisms.mechanism import Inputs
from network.catalogue.sensors.base import SensorEffect


class SensorResolution(SensorEffect, kind="sensor_resolution"):
    """A thermometer that reads in steps of 1 K/n: reading = round(n · truth)/n.

    A logger that writes one decimal has n = 10, a converter of 12 bit over 256 K has 16. Where the truth wanders over
    several steps the error is like noise of 1 K/(n √12), white where it crosses a step from sample to sample (Widrow &
    Kollár, Quantization Noise, ch. 4; unverified); at rest it is constant, up to half a step. Slopes are those of the
    truth: a reading that stands still does not say that the number behind it does nothing. n is no number that a fit
    could turn, and a diagnosis does not look for it: declare the noise no smaller than the step says.
    """

    quantities = ("temperature",)
    steps = whole("steps in a kelvin, 10 for 0.1 K", 1, 100_000)
    strength = "steps"
    is_steady = False
    searched = False
    sentence = "{channel} reads in steps of a kelvin over {steps}"

    def reading(self, truth: Array, state: Array, u: Inputs) -> Array:
        seen = np.real(truth)
        return np.asarray(truth + (np.round(self.steps * seen) / self.steps - seen))

    def truth(self, reading: Array, u: Inputs) -> Array:
        """The middle of what would read so."""
        return reading

    @classmethod
    def typical_on(cls, machine: MachineLike) -> dict[str, Any]:
        return {"kind": cls.kind, "steps": 10}
