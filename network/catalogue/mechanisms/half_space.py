from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param, place
from network.catalogue.mechanisms.base import Source
from network.catalogue.mechanisms.mechanism import Inputs, State

FASTEST, SLOWEST, LAYERS = 1.0, 1 / (1000 * 86400.0), 14
"""1/s, 1/s: rates of the first and the last layer, and how many there are, each as much slower than the one before."""
STEP = np.log(FASTEST / SLOWEST) / (LAYERS - 1)
RATES = (FASTEST * np.exp(-STEP * np.arange(LAYERS))).tolist()
WEIGHTS = [STEP / np.pi * rate**0.5 for rate in RATES]
TAIL = 2 / np.pi * (SLOWEST * np.exp(-STEP / 2)) ** 0.5
"""√(1/s): of √s what the layers slower than the last would give, which have not begun to warm."""


class HalfSpace(Source, kind="half_space"):
    """A floor so deep that heat never reaches its bottom: Q = k (S √(s/a) + 4 R) (T − T_deep) at the frequency s.

    k conductivity, a diffusivity, S the area of the footprint, R = √(S/π). The first term is the semi-infinite body
    under its surface (Carslaw & Jaeger, Conduction of Heat in Solids, 2.5), the second what a warm disc loses for good
    (ibid., 8.2); their sum is exact early and late, in between unverified. √s = (1/π) ∫ s/(s + x) dx/√x becomes a
    Foster network of 14 layers, each four times as slow as the one before: after a step of the temperature the heat
    flow is within 0.6 % of its passing part from 10 s to 10 days, and what is lost for good is told too large by some
    3 % √(S/m²) of it. A run begins with the floor at the temperature of what stands on it, as after days of rest. Not
    looked for by a diagnosis, for each has its 14 layers: over hours hidden_mass stands for what the ground takes up,
    and foundation, a floor that keeps its temperature, for what is lost for good.
    """

    surface = place("the place that stands on it")
    area = param("m^2", 0, 1e4, "area of the footprint", positive=True, typical=2)
    conductivity = param("W/(m K)", 0, 500, "conductivity: 1.4 of concrete, 0.5 to 2 of soil", typical=1.4)
    diffusivity = param("mm^2/s", 0, 500, "diffusivity: 0.7 of concrete, 0.2 to 0.8 of soil", positive=True,
                        typical=0.7)  # fmt: skip
    temperature = param("degC", -50, 100, "temperature far below", typical=15)
    states = {f"layer{i}": State("K", f"temperature of layer {i} of {LAYERS}, counted from 0 degC")
              for i in range(1, LAYERS + 1)}  # fmt: skip
    strength = "conductivity"
    searched = False
    shapes = ("diffusivity", "temperature")
    sentence = "{into} stands with {area} on ground of {conductivity} and {diffusivity}, {temperature} far below"

    def heat(self, u: Inputs, *own: Array) -> Array:
        T, *layers = own
        penetrance = self.area / self.diffusivity**0.5
        lasting = (4 * (self.area / np.pi) ** 0.5 + penetrance * TAIL) * (T - self.temperature)
        passing = sum((weight * (T - z) for weight, z in zip(WEIGHTS, layers, strict=True)), start=np.zeros(()))
        return np.asarray(-self.conductivity * (lasting + penetrance * passing))

    def rate(self, u: Inputs, *own: Array) -> tuple[Array, ...]:
        return tuple(rate * (own[0] - z) for rate, z in zip(RATES, own[1:], strict=True))

    def begin(self, u: Inputs, *T: Array) -> tuple[Array, ...]:
        return (T[0],) * LAYERS
