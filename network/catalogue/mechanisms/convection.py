from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from network.catalogue.convection_correlations import FILMS, ORIENTATIONS, SHAPES, coefficient, rayleigh
from network.catalogue.declaration.declare import Advice, Array
from network.catalogue.declaration.fields import param, word
from network.catalogue.fluids import FLUIDS
from network.catalogue.mechanisms.base import SurfaceLink
from network.catalogue.mechanisms.mechanism import Inputs
from network.platform.quantities.units import Number, show
from network.platform.wording import name_of

WARM = 10.0
"""K: the excess at which the range of a correlation is checked beforehand."""


class Convection(SurfaceLink, kind="convection"):
    """Heat to a fluid: Q = h A (T_a − T_b), h constant, or by a correlation for a still fluid around a geometry.

    Newton's law of cooling; the surface is named first. Instead of h its shape, orientation and length: `geometry:
    plate, orientation: up, length: 40 mm`, or in one word (plate_facing_up). The correlations, their sources and ranges
    stand in convection_correlations. Constant h holds for steady forced flow; natural_convection and forced_convection
    say what it leaves out; plate_flow, pipe_flow, rotating_cylinder and rotating_disc are films of what moves.
    """

    conductance = param("W/K", 0, 1e6, "conductance h A", typical=5, default=None)
    coefficient = param("W/(m^2 K)", 0, 1e5, "heat transfer coefficient", typical=8, default=None)
    area = param("m^2", 0, 1000, "area", typical=1, default=None)
    geometry = word("the shape of the surface", *FILMS, *SHAPES, default=None)
    length = param("m", 0, 100, "height, diameter, or area over perimeter", positive=True, typical=0.5, default=None)
    orientation = word("how a plate or a cylinder lies; up: facing up", *ORIENTATIONS, default=None)
    fluid = word("the fluid around a geometry", *FLUIDS, default="air")
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
        around = "" if self.fluid == "air" else f" in {name_of(self.fluid)}"
        return f"as a {name_of(self.shape)}{around} {over}"

    @property
    def shape(self) -> str:
        """The film that geometry and orientation name."""
        return SHAPES[self.geometry][self.orientation] if self.geometry in SHAPES else self.geometry

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
        return np.asarray(coefficient(self.shape, T_a, T_b, self.length, FLUIDS[self.fluid]) * self.area)

    def faults(self) -> Iterator[Advice]:
        ways = SHAPES.get(self.geometry or "", {})
        if ways and self.orientation not in ways:
            yield "geometry", f"does not say how the {self.geometry} lies", f"give `orientation: {'` or `'.join(ways)}`"
        if self.orientation is not None and not ways:
            yield "orientation", "says nothing without a plate or a cylinder", "write `geometry: plate`, or drop it"
        if self.fluid != "air" and self.geometry is None:
            yield "fluid", "says nothing without a geometry", "give geometry, length and area, or drop it"

    def doubts(self) -> Iterator[Advice]:
        if self.geometry is None:
            return
        at = np.array(20 + WARM), np.array(20.0)
        film, Ra = FILMS[self.shape], float(rayleigh(*at, self.length, FLUIDS[self.fluid]))
        if not film.low <= Ra <= film.high:
            right = f"the correlation for {self.shape} holds for Ra {film.low:.0e} to {film.high:.0e}"
            yield "length", f"gives Ra = {Ra:.1e} at {WARM:.0f} K excess, outside the correlation", right
