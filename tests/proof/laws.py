"""Constitutive laws of the truth, written otherwise than a catalogue of fits would write them."""

from __future__ import annotations

import math
from functools import cache

RPM = 2 * math.pi / 60
"""rad/s of one revolution a minute."""


def vogel(T: float, cold: float, steepness: float) -> float:
    """Torque of a bearing over that at `cold` [°C], by Vogel's viscosity: (ν/ν_cold)^(2/3), ln ν = A + B/(T + 118 °C).

    B = 900 K for `steepness` 1: near 0.033 1/K at 20 °C and 0.023 1/K at 50 °C, a mineral oil of some 32 mm²/s.
    """
    return math.exp(2 / 3 * steepness * 900.0 * (1 / (T + 118.0) - 1 / (cold + 118.0)))


def crossflow(reynolds: float) -> float:
    """Nusselt number of a cylinder in air across it, Pr 0.71, by Churchill and Bernstein; 0.3 at rest."""
    pr = 0.71
    laminar = 0.62 * math.sqrt(reynolds) * pr ** (1 / 3) / (1 + (0.4 / pr) ** (2 / 3)) ** 0.25
    nusselt: float = 0.3 + laminar * (1 + (reynolds / 282_000) ** 0.625) ** 0.8
    return nusselt


def blown(share: float, gain: float) -> float:
    """Film over that at rest: 1 + gain · (Nu − 0.3)/(Nu_top − 0.3), Re 2·10⁵ at the top speed; `share` of it."""
    return 1 + gain * (crossflow(2e5 * abs(share)) - 0.3) / (crossflow(2e5) - 0.3)


@cache
def drag(reynolds: float) -> float:
    """Friction coefficient of a turning cylinder, 1/√C = −0.6 + 4.07 log₁₀(Re √C) (Theodorsen and Regier)."""
    root = 0.05
    for _ in range(60):
        root = 1 / (-0.6 + 4.07 * math.log10(reynolds * root))
    return root * root


def air_drag(share: float, power: float) -> float:
    """Heat [W] of a rotor's air friction, C n³ over C at the top speed, where Re is 3·10⁵; `share` of that speed."""
    share = abs(share)
    return power * share**3 * drag(3e5 * share) / drag(3e5) if share > 0.01 else 0.0


def motor_loss(share: float, copper: float, iron: float) -> float:
    """Heat [W] of a motor, copper only while it turns, iron with the power 1.5 of speed."""
    return (copper if share else 0.0) + iron * math.pow(abs(share), 1.5)
