from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from network.catalogue.convection_correlations import FILMS, coefficient, rayleigh
from network.catalogue.declaration.declare import Advice, Array
from network.catalogue.declaration.fields import param, word
from network.catalogue.mechanisms.base import Inputs, SurfaceLink
from network.platform.quantities.units import Number, show

WARM = 10.0
"""K: the excess at which the range of a correlation is checked beforehand."""


class Convection(SurfaceLink, kind="convection"):
    """Heat to a fluid: Q = h A (T_a − T_b), h constant, or by a correlation for still air around a geometry.

    Newton's law of cooling; the surface is named first. The correlations, their sources and ranges stand in
    convection_correlations. Constant h holds for steady forced flow; natural_convection and forced_convection say what
    it leaves out.
    """

    conductance = param("W/K", 0, 1e6, "conductance h A", typical=5, default=None)
    coefficient = param("W/(m^2 K)", 0, 1e5, "heat transfer coefficient", typical=8, default=None)
    area = param("m^2", 0, 1000, "area", typical=1, default=None)
    geometry = word("the shape of the surface", *FILMS, default=None)
    length = param("m", 0, 100, "height, diameter, or area over perimeter", positive=True, typical=0.5, default=None)
    one_of = (("conductance",), ("coefficient", "area"), ("geometry", "length", "area"))
    strength = "conductance"
    sentence = "{between[0]} exchanges heat with {between[1]} by convection, {film}"

    @property
    def total(self) -> Number | None:
        """h A with its uncertainty; None for a correlation."""
        if self.geometry is not None:
            return None
        if self.conductance is not None:
            return self._number("conductance")
        h, A = self._number("coefficient"), self._number("area")
        wide = h if h.prior != "known" else A
        by = (A if wide is h else h).value
        spread = float(np.hypot(h.spread, A.spread))
        return replace(wide, value=wide.value * by, spread=spread, low=wide.low * by, high=wide.high * by)

    def _number(self, name: str) -> Number:
        return self.numbers.get(name, Number(float(self.__dict__[name])))

    @property
    def film(self) -> str:
        if self.conductance is not None:
            return show(float(self.conductance), "W/K")
        over = f"over {show(float(self.area), 'm^2')}"
        if self.coefficient is not None:
            return f"{show(float(self.coefficient), 'W/(m^2 K)')} {over}"
        return f"as a {self.geometry.replace('_', ' ')} {over}"

    def is_affine(self) -> bool:
        return self.geometry is None

    def heat_flow(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> Array:
        Q: Array = self._conductance(T_a, T_b) * (T_a - T_b)
        return Q

    def _conductance(self, T_a: Array, T_b: Array) -> Array:
        if self.conductance is not None:
            return self.conductance
        if self.coefficient is not None:
            return np.asarray(self.coefficient * self.area)
        return np.asarray(coefficient(self.geometry, T_a, T_b, self.length) * self.area)

    def doubts(self) -> Iterator[Advice]:
        if self.geometry is None:
            return
        film, Ra = FILMS[self.geometry], float(rayleigh(np.array(20 + WARM), np.array(20.0), self.length))
        if not film.low <= Ra <= film.high:
            right = f"the correlation for {self.geometry} holds for Ra {film.low:.0e} to {film.high:.0e}"
            yield "length", f"gives Ra = {Ra:.1e} at {WARM:.0f} K excess, outside the correlation", right
