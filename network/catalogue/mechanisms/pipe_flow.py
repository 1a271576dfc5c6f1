from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import channel, param, word
from network.catalogue.fluids import FLUIDS
from network.catalogue.mechanisms.base import raise_to_power
from network.catalogue.mechanisms.film import MovingFilm
from network.catalogue.mechanisms.mechanism import Inputs

LAMINAR, TURBULENT = 2300.0, 4000.0


class PipeFlow(MovingFilm, kind="pipe_flow"):
    """A bore or a cooling jacket with a fluid flowing through: h = Nu k/D, Re = 4 V/(π D ν) with V the volume flow.

    To Re = 2300 Nu = 3.66 + 0.0668 Gz/(1 + 0.04 Gz^(2/3)), Gz = Re Pr D/L (Hausen); from 4000 Gnielinski: Nu =
    (f/8)(Re − 1000) Pr/(1 + 12.7 √(f/8) (Pr^(2/3) − 1)) (1 + (D/L)^(2/3)), f = (0.79 ln Re − 1.64)^−2; straight over Re
    in between (Gnielinski 1995, as in the VDI heat atlas; unverified). Pr 0.5 to 2000, Re to 5e6; properties at the
    fluid's temperature, which is named second; walls not far from it. `diameter` is the hydraulic one, 4 S/U, with
    `cross_section` S where that is not round. Give `flow`, or the input that records it. The stream itself, which
    carries the heat away, is an advection. A diagnosis looks for forced_convection in its stead.
    """

    diameter = param("mm", 0, 2000, "hydraulic diameter", positive=True, typical=12)
    length = param("m", 0, 1000, "length of the channel", positive=True, typical=2)
    flow = param("l/min", 0, 60_000, "volume flow", default=None, typical=8)
    cross_section = param("mm^2", 0, 1e6, "cross-section, if not round", positive=True, default=None, typical=100)
    measured_flow = channel(None, "l/min", "the input that records the flow", key="input")
    fluid = word("what flows", *FLUIDS, default="water")
    most = 5e6
    one_of = (("flow",), ("measured_flow",))
    sentence = "{fluid} flows through {between[0]} in a channel of {diameter}, {area} wet"

    def reynolds(self, T: Array, u: Inputs) -> Array:
        volume = self.flow if self.flow is not None else np.abs(u[self.measured_flow])
        section = self.cross_section if self.cross_section is not None else np.pi / 4 * self.diameter**2
        return np.asarray(volume / section * self.diameter / FLUIDS[self.fluid].viscosity(T))

    def coefficient(self, T_a: Array, T_b: Array, u: Inputs) -> Array:
        fluid = FLUIDS[self.fluid]
        Nu = pipe_nusselt(self.reynolds(T_b, u), fluid.prandtl(T_b), self.diameter / self.length)
        return np.asarray(Nu * fluid.conductivity(T_b) / self.diameter)


def pipe_nusselt(Re: Array, Pr: Array, slenderness: Array) -> Array:
    """Mean Nu of a pipe of that D/L, laminar, in transition and turbulent."""
    share = (Re - LAMINAR) / (TURBULENT - LAMINAR)
    between = (1 - share) * _laminar(np.array(LAMINAR), Pr, slenderness)
    between = between + share * _turbulent(np.array(TURBULENT), Pr, slenderness)
    fast = np.real(Re) > TURBULENT
    high = np.where(fast, _turbulent(np.where(fast, Re, TURBULENT), Pr, slenderness), between)
    return np.where(np.real(Re) > LAMINAR, high, _laminar(Re, Pr, slenderness))


def _laminar(Re: Array, Pr: Array, slenderness: Array) -> Array:
    Gz = Re * Pr * slenderness
    return np.asarray(3.66 + 0.0668 * Gz / (1 + 0.04 * raise_to_power(Gz, np.array(2 / 3))))


def _turbulent(Re: Array, Pr: Array, slenderness: Array) -> Array:
    eighth = (0.79 * np.log(Re) - 1.64) ** -2 / 8
    Nu = eighth * (Re - 1000) * Pr / (1 + 12.7 * eighth**0.5 * (Pr ** (2 / 3) - 1))
    return np.asarray(Nu * (1 + slenderness ** (2 / 3)))
