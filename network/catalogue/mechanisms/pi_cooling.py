from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param, place
from network.catalogue.mechanisms.base import Source
from network.catalogue.mechanisms.mechanism import Inputs, State


class PiCooling(Source, kind="pi_cooling"):
    """A chiller under PI control: q = −G (e + z), e = T − set, and its integral z [K] grows by dz/dt = e/t_i.

    Without a `limit` it is linear and heats as well as it cools. One mass C answers to a constant heat q as a second
    order: e = q/(C ω) e^(−σt) sin ωt, σ = G/(2C), ω² = G/(C t_i) − σ²; it returns to the set point, where a cooler with
    hysteresis never rests. With a limit P it gives 0 to P, and z follows what is given, so that it does not wind up:
    dz/dt = (given/G − z)/t_i. Source: automatic reset, Åström & Murray, Feedback Systems, ch. 10 (unverified).
    """

    watches = place("the place whose temperature it controls")
    set = param("degC", -50, 300, "set point", typical=22)
    gain = param("W/K", 0, 1e6, "power for each kelvin above the set point", typical=50)
    reset_time = param("s", 0, 36_000, "time t_i in which the integral repeats it", positive=True, typical=300)
    limit = param("W", 0, 1e7, "power of which it is capable; default without limit", default=None, typical=1000)
    states = {"reset": State("K", "excess that the controller has integrated")}
    strength = "gain"
    shapes = ("set", "reset_time")
    sentence = "a chiller takes {gain} above {set} at {watches} out of {into}, with a reset time of {reset_time}"

    def is_affine(self) -> bool:
        return self.limit is None

    def _compute_heat(self, *own: Array) -> Array:
        """What the chiller gives, over its gain [K]."""
        asked: Array = own[0] - self.set + own[1]
        if self.limit is None:
            return asked
        most = self.limit / np.where(np.real(self.gain) > 0, self.gain, 1e-9)
        return np.where(np.real(asked) > np.real(most), most, np.where(np.real(asked) > 0, asked, 0.0))

    def heat(self, u: Inputs, *own: Array) -> Array:
        q: Array = -self.gain * self._compute_heat(*own)
        return q

    def rate(self, u: Inputs, *own: Array) -> tuple[Array, ...]:
        return ((self._compute_heat(*own) - own[1]) / self.reset_time,)
