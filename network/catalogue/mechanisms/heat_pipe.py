from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param
from network.catalogue.mechanisms.base import Link, magnitude
from network.catalogue.mechanisms.mechanism import Inputs

STEEPEST = 600.0
"""Exponent beyond which it is open, or closed, to the last digit."""


class HeatPipe(Link, kind="heat_pipe"):
    """A heat pipe, which carries so much and no more: Q = s G ΔT/(1 + s G |ΔT|/Q_max), ΔT = T_a − T_b.

    For small differences a conductance s G, for large ones it nears Q_max, the capillary limit; in between a smooth
    transition, which no pipe follows to the per cent. s is the share that is at work: `back` of it where b is the
    warmer end (1 with a wick in any position, 0 where gravity brings the liquid back and a lies below: a thermosiphon,
    a diode of heat), and with `opens` 1/(1 + e^(−4 (T − opens)/within)) of it, T the warmer end's: gas that leaves the
    condenser as the vapour's pressure rises, or a fluid that thaws; the form is made to be smooth, its width to be
    measured. What the wall conducts is a conduction beside it. Ends count as isothermal, and the vapour follows at
    once. Source: Faghri, Heat Pipe Science and Technology; Reay & Kew, Heat Pipes (both unverified).
    Looks like a conduction while G |ΔT| stays below a tenth of Q_max. Not looked for by a diagnosis: it is built in on
    purpose and known, and what carries less than the file says shows at conduction.
    """

    conductance = param("W/K", 0, 1e5, "conductance at small differences", typical=10)
    limit = param("W", 0, 1e5, "the most heat it carries", positive=True, typical=200)
    back = param("1", 0, 1, "share of the conductance while its second place is the warmer", default=1)
    opens = param("degC", -100, 500, "the warmer end's temperature at which half of it works", typical=30, default=None)
    within = param(
        "K", 0, 100, "how far the temperature rises while it opens, where `opens` is given", positive=True, default=5
    )
    affine = False
    strength = "conductance"
    searched = False
    shapes = ("limit",)
    sentence = "{between[0]} and {between[1]} are joined by a heat pipe of {conductance}, {limit} at the most"

    def heat_flow(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> Array:
        dT = T_a - T_b
        G = self.conductance * self._share(T_a, T_b)
        return np.asarray(G * dT / (1 + G * magnitude(dT) / self.limit))

    def _share(self, T_a: Array, T_b: Array) -> Array:
        """What of it is at work."""
        is_forward = np.real(T_a) >= np.real(T_b)
        share = np.where(is_forward, 1.0, self.back)
        if self.opens is None:
            return share
        warmer = np.where(is_forward, T_a, T_b)
        beyond = 4 * (warmer - self.opens) / self.within
        beyond = np.where(np.abs(np.real(beyond)) < STEEPEST, beyond, np.sign(np.real(beyond)) * STEEPEST)
        return np.asarray(share / (1 + np.exp(-beyond)))
