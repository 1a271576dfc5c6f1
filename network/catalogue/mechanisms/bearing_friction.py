from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from network.catalogue.declaration.declare import Advice, Array
from network.catalogue.declaration.fields import param
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.places import Place
from network.catalogue.mechanisms.base import raise_to_power
from network.catalogue.mechanisms.friction import Friction, Jointed, turning
from network.catalogue.mechanisms.mechanism import Inputs
from network.platform.quantities.units import show

LEAST = 160.0
"""(ν n)^(2/3) in (mm²/s · 1/min)^(2/3) below which the lubricant's torque falls no further: ν n = 2024."""


class BearingFriction(Friction, Jointed, kind="bearing_friction"):
    """Friction of a bearing: q = 2π/60 · |n| · M, with M constant or after Palmgren.

    Palmgren: M = M₀ + M₁, M₀ = 1e-7 f₀ max((ν n)^(2/3), 160) d_m³ and M₁ = f₁ P d_m, in N mm with ν in mm²/s at running
    temperature, n in 1/min, d_m in mm, P in N. As published (Harris, Rolling Bearing Analysis; unverified) the branches
    change at ν n = 2000 with a step of 0.8 %; here where they meet. The partition between the rings is `into`, one half
    each is the usual assumption; viscous_friction and preload_friction say what a constant M leaves out. Source: SKF,
    power loss N_R = 1.05e-4 M n (W, N mm, 1/min); eq. 10 of the heat-quantity method (M printed in N m is in N mm).
    """

    torque = param("N m", 0, 1e5, "friction torque", default=None, typical=0.3)
    lubrication_factor = param("1", 0, 50, "f₀: bearing and lubrication", default=None, typical=2)
    viscosity = param("mm^2/s", 0, 10_000, "viscosity of the lubricant, running", default=None, typical=20)
    mean_diameter = param("mm", 0, 5000, "mean diameter of the bearing", positive=True, default=None, typical=80)
    load_factor = param("1", 0, 0.1, "f₁: bearing and load", default=0)
    load = param("N", 0, 1e7, "load that makes friction", default=0)
    one_of = (("torque",), ("lubrication_factor", "viscosity", "mean_diameter"))
    strength = "torque"
    sentence = "a bearing rubs with {moment_told} and heats {into}"

    @property
    def is_constant(self) -> bool:
        return self.torque is not None

    @property
    def moment_told(self) -> str:
        if self.is_constant:
            return show(float(self.torque), "N m")
        f, d, v = float(self.lubrication_factor), show(float(self.mean_diameter), "mm"), float(self.viscosity)
        return f"f₀ = {f:.4g} at {d} in a lubricant of {show(v, 'mm^2/s')}"

    @classmethod
    def list_joints(cls, machine: MachineLike) -> Iterator[tuple[Place, Place]]:
        """Where one of two parts turns, that one first; any where it is not known what turns."""
        turns = {*turning(machine)}
        for a, b in super().list_joints(machine):
            if not turns or (a.node in turns) != (b.node in turns):
                yield (b, a) if b.node in turns else (a, b)

    def faults(self) -> Iterator[Advice]:
        for name in ("load_factor", "load"):
            if self.is_constant and self.__dict__[name] != 0:
                right = "drop it, or give lubrication_factor, viscosity and mean_diameter"
                yield name, f"{name} says nothing beside a constant torque", right

    def moment(self, u: Inputs, *T: Array) -> Array:
        if self.is_constant:
            return self.torque
        stirred = find_palmgren_torque(self.lubrication_factor, self.viscosity, u[self.input], self.mean_diameter)
        M: Array = stirred + self.load_factor * self.load * self.mean_diameter
        return M


def find_palmgren_torque(f0: Array, viscosity: Array, speed: Array, mean_diameter: Array) -> Array:
    """M₀ [N m] of a lubricant of so many m²/s at a speed in rad/s."""
    wetness = raise_to_power(viscosity * 1e6 * np.abs(speed) * 60 / (2 * np.pi), np.array(2 / 3))
    stirred = np.where(np.real(wetness) > LEAST, wetness, LEAST)
    return np.asarray(1e-7 * f0 * stirred * (mean_diameter * 1e3) ** 3 * 1e-3)
