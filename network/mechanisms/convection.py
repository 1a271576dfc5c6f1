from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from network.declare import Advice, Array
from network.fields import param, word
from network.films import FILMS, coefficient, rayleigh
from network.mechanisms.base import Inputs, SurfaceLink

WARM = 10.0
"""K: the excess at which the range of a correlation is checked beforehand."""


class Convection(SurfaceLink, kind="convection"):
    """Heat to a fluid: Q = h A (T_a − T_b), h constant, or by a correlation for still air around a geometry.

    Source: Newton's law of cooling; the correlations and their ranges stand in network.films. Constant h holds for
    forced flow; see natural_convection and forced_convection for what it leaves out.
    """

    conductance = param("W/K", 0, 1e6, "conductance h A", typical=5, default=None)
    coefficient = param("W/(m^2 K)", 0, 1e5, "heat transfer coefficient", typical=8, default=None)
    area = param("m^2", 0, 1000, "area", typical=1, default=None)
    geometry = word("the shape of the surface", *FILMS, default=None)
    length = param("m", 0, 100, "height, diameter, or area over perimeter", positive=True, typical=0.5, default=None)
    one_of = (("conductance",), ("coefficient", "area"), ("geometry", "length", "area"))
    strength = "conductance"
    looks_like = ("natural_convection", "radiation", "conduction")
    sentence = "{between[0]} exchanges heat with {between[1]} by convection at {conductance}"

    def is_affine(self) -> bool:
        return self.geometry is None

    def heat_flow(self, T_a: Array, T_b: Array, u: Inputs) -> Array:
        return self._conductance(T_a, T_b) * (T_a - T_b)

    def _conductance(self, T_a: Array, T_b: Array) -> Array:
        if self.conductance is not None:
            return self.conductance
        if self.coefficient is not None:
            return self.coefficient * self.area
        return coefficient(self.geometry, T_a, T_b, self.length) * self.area

    def doubts(self) -> Iterator[Advice]:
        if self.geometry is None:
            return
        film, Ra = FILMS[self.geometry], float(rayleigh(np.array(20 + WARM), np.array(20.0), self.length))
        if not film.low <= Ra <= film.high:
            right = f"the correlation for {self.geometry} holds for Ra {film.low:.0e} to {film.high:.0e}"
            yield "length", f"gives Ra = {Ra:.1e} at {WARM:.0f} K excess, outside the correlation", right
