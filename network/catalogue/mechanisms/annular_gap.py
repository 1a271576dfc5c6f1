from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import channel, param
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.fluids import FLUIDS
from network.catalogue.mechanisms.base import Link, raise_to_power
from network.catalogue.mechanisms.friction import turning
from network.catalogue.mechanisms.mechanism import Inputs

AIR = FLUIDS["air"]


class AnnularGap(Link, kind="annular_gap"):
    """Rotor and stator over the air between them: Q = (Nu/2) (k/δ) A (T_a − T_b), Ta = (|ω| R δ/ν) √(δ/R).

    Nu = 2 below Ta = 41, where heat is conducted; 0.202 Ta^0.63 Pr^0.27 with Taylor vortices, 0.386 Ta^0.5 Pr^0.27 when
    turbulent (measured by Taylor and Gazley; as in Staton & Cavagnino, IEEE Trans. Ind. Electron. 55 (2008) 3509). As
    published the last two change at Ta = 100 with a step of 5 % and the first at 41 with one of 4 %; here where they
    meet, Ta = 44 and 146. h = Nu k/δ holds for each wall, so two of them in a row make the 1/2. For smooth walls, δ
    small beside R, Ta to 1e4, no axial flow. Not looked for by a diagnosis: rotor and stator are joined over bearings
    as well, and a conduction between them stands for it.
    """

    area = param("m^2", 0, 1000, "area of the gap, 2π R times its length", typical=0.05)
    diameter = param("mm", 0, 5000, "diameter of the rotor", positive=True, typical=100)
    gap = param("mm", 0, 100, "width of the gap", positive=True, typical=0.5)
    input = channel("speed", "rpm")
    affine = False
    strength = "area"
    searched = False
    sentence = "{between[0]} and {between[1]} exchange heat over an air gap of {gap} around {diameter}, {area}"

    def taylor(self, T: Array, u: Inputs) -> Array:
        radius = self.diameter / 2
        Re = np.abs(u[self.input]) * radius * self.gap / AIR.viscosity(T)
        return np.asarray(Re * (self.gap / radius) ** 0.5)

    def heat_flow(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> Array:
        T = (T_a + T_b) / 2
        Nu = gap_nusselt(self.taylor(T, u), AIR.prandtl(T))
        return np.asarray(Nu / 2 * AIR.conductivity(T) / self.gap * self.area * (T_a - T_b))

    def remarks(self, u: Mapping[str, Array]) -> Iterator[str]:
        largest = float(np.max(self.taylor(np.array(20.0), u)))
        if largest > 1e4:
            yield f"Ta = {largest:.2g} at 20 degC, and its correlation holds to 1e4"

    @classmethod
    def candidates(cls, machine: MachineLike) -> Iterator[tuple[str, str]]:
        """Between what turns and what stands."""
        turns = {*turning(machine)}
        return (pair for pair in super().candidates(machine) if (pair[0] in turns) != (pair[1] in turns))


def gap_nusselt(Ta: Array, Pr: Array) -> Array:
    """h δ/k at each wall."""
    vortices, turbulent = (c * raise_to_power(Ta, np.array(p)) for c, p in ((0.202, 0.63), (0.386, 0.5)))
    moved = np.where(np.real(vortices) < np.real(turbulent), vortices, turbulent) * Pr**0.27
    return np.where(np.real(moved) > 2, moved, 2.0)
