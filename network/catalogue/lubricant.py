"""The lubricant of a bearing, as an entry names it: `oil: {grade: 32}`."""

from __future__ import annotations

from collections.abc import Iterator

from network.catalogue.declaration.declare import Advice, Declared
from network.catalogue.declaration.fields import param, whole
from network.catalogue.fluids import ISO_VG, Oil, oil_of_grade


class Lubricant(Declared):
    """A mineral oil, or the base oil of a grease, by its ISO VG grade (ISO 3448), over temperature by Walther's law.

    log log (ν + 0.7) = A − B log T, ν in mm²/s, T in kelvin (ASTM D341), through the grade at 40 °C and `at_100`, by
    default that of a mineral oil with a viscosity index of 95 to 100. See catalogue.fluids.
    """

    section = "oil"
    grade = whole("ISO VG grade", min(ISO_VG), max(ISO_VG), allowed=tuple(ISO_VG))
    at_100 = param("mm^2/s", 1, 1000, "viscosity at 100 degC; default usual for the grade", default=None, typical=5.4)

    @property
    def oil(self) -> Oil:
        return oil_of_grade(self.grade, None if self.at_100 is None else float(self.at_100))

    def faults(self) -> Iterator[Advice]:
        if self.uncertain():
            yield "at_100", "at_100 has a spread, and the oil is not calibrated", "give the number without ±"
        if self.at_100 is not None and not float(self.at_100) < self.grade * 1e-6:
            yield "at_100", "is at 100 degC as viscous as at 40 degC, or more", f"give less than {self.grade} mm^2/s"
