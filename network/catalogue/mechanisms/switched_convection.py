from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param, place
from network.catalogue.mechanisms.base import SurfaceLink
from network.catalogue.mechanisms.mechanism import Inputs, Relay, beyond


class SwitchedConvection(SurfaceLink, Relay, kind="switched_convection"):
    """A fan or a film of coolant that a temperature switches: Q = G (T_a − T_b) while it is on, else 0.

    It goes on above set + h and off below set − h, `delay` later each time; what always flows is a convection beside
    it. One mass C under constant heat q without other losses runs a saw-tooth between the two without delay: it warms
    for 2hC/q, then cools for τ ln ((set + h − T_∞)/(set − h − T_∞)), τ = C/G, T_∞ = T_b + q/G; where T_∞ lies above
    set − h the fan stays on. Source: Newton's law of cooling with a constant coefficient in each mode.
    """

    conductance = param("W/K", 0, 1e6, "conductance h A while it is on", typical=20)
    watches = place("the place whose temperature switches it")
    set = param("degC", -50, 300, "set point", typical=30)
    hysteresis = param("K", 0, 50, "half width of the hysteresis", positive=True, typical=1)
    delay = param("s", 0, 7200, "time between crossing and switching", default=0)
    strength = "conductance"
    shapes = ("set", "hysteresis")
    sentence = "{between[0]} loses {conductance} to {between[1]}, on and off around {set} ± {hysteresis} at {watches}"

    def heat_flow(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> Array:
        Q: Array = self.conductance * (T_a - T_b)
        return Q

    def slopes(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> tuple[Array, ...]:
        return self.conductance, -self.conductance, np.zeros_like(own[0])

    def guard(self, mode: Array, u: Inputs, *own: Array) -> Array:
        return beyond(mode, own[0], self.set, self.hysteresis)

    def pause(self) -> Array:
        return self.delay
