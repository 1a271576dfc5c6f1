"""Materials: what is built in, each with its source, and how a file adds its own.

Values at 20 °C, each with its source. Ranges between grades: ± 5 % for density and specific heat, ± 20 % for
conductivity of iron.
"""

from __future__ import annotations

from collections.abc import Iterator

from network.catalogue.declaration.declare import Advice, Declared
from network.catalogue.declaration.fields import param


class Material(Declared):
    """A solid's properties at 20 °C; with slopes k = k₂₀ (1 + a (T − 20 °C)) and c_p = c_20 (1 + b (T − 20 °C)).

    Steel loses some 0.04 % of its conductivity per kelvin and gains 0.05 % of its specific heat (Incropera & DeWitt,
    appendix A, 300 to 400 K; unverified). Between lumps k is that of their mean temperature, which is exact for a
    steady bar (Kirchhoff's transform). Both make a network non-linear: what is within 20 K of 20 °C does without.
    """

    section = "materials"
    density = param("kg/m^3", 1, 30_000, "density", positive=True, typical=7850)
    specific_heat = param("J/(kg K)", 1, 20_000, "specific heat capacity", positive=True, typical=480)
    conductivity = param("W/(m K)", 0, 5000, "thermal conductivity", positive=True, typical=50)
    expansion = param("1/K", -1e-4, 2e-3, "coefficient of linear expansion", typical=1.1e-5)
    conductivity_slope = param("1/K", -0.005, 0.005, "relative growth of the conductivity per kelvin", default=0)
    specific_heat_slope = param("1/K", -0.005, 0.005, "relative growth of the specific heat per kelvin", default=0)

    def doubts(self) -> Iterator[Advice]:
        if abs(float(self.expansion)) > 1e-4:
            yield "expansion", f"expands by {float(self.expansion):.3g} per kelvin", "metals have 1e-6 to 3e-5 1/K"


BOOK = "Incropera & DeWitt, appendix A"
SPECIMEN = "specimen of the heat-quantity paper, its table 1"
SHEETS = "typical of data sheets"
_TABLE = (  # density, specific heat, conductivity, expansion
    ("steel", 7850, 477, 50.66, 1.13e-5, SPECIMEN),
    ("stainless_steel", 7900, 477, 14.9, 1.66e-5, f"{BOOK} (AISI 304)"),
    ("cast_iron", 7200, 500, 48, 1.08e-5, f"{SHEETS} (GJL-300)"),
    ("mineral_casting", 2400, 800, 2.5, 1.3e-5, f"{SHEETS} (epoxy granite)"),
    ("granite", 2630, 775, 2.79, 7.0e-6, f"{BOOK}; expansion {SHEETS}"),
    ("aluminium", 2700, 900, 209, 2.34e-5, f"{SHEETS} (EN AW-6060)"),
    ("copper", 8933, 385, 401, 1.65e-5, BOOK),
    ("brass", 8530, 380, 110, 1.9e-5, BOOK),
    ("titanium", 4430, 560, 6.7, 8.6e-6, f"{SHEETS} (Ti-6Al-4V)"),
    ("invar", 8100, 515, 10.5, 1.3e-6, f"{SHEETS} (FeNi36)"),
    ("silicon_nitride", 3200, 700, 28, 3.0e-6, f"{SHEETS} (balls of bearings)"),
    ("alumina", 3900, 765, 36, 7.5e-6, BOOK),
    ("cfrp", 1550, 900, 5, 5e-7, f"{SHEETS} (quasi-isotropic, along the layers)"),
    ("glass", 2500, 720, 1.0, 9e-6, "EN 572-1 (soda-lime glass)"),
    ("water", 998, 4182, 0.6, 6.9e-5, f"{BOOK}; a third of the volume's expansion"),
    ("oil", 870, 1900, 0.13, 2.5e-4, f"{SHEETS} (mineral oil)"),
    ("air", 1.2, 1007, 0.026, 1.14e-3, BOOK),
)
BUILT_IN = {
    name: Material(name, density=density, specific_heat=heat, conductivity=conductivity, expansion=expansion)
    for name, density, heat, conductivity, expansion, _ in _TABLE
}
SOURCES = {row[0]: row[5] for row in _TABLE}
"""Where the numbers of a built-in material come from."""
