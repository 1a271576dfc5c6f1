"""The built-in materials as a page: numbers, units, sources, and how a file adds its own."""

from __future__ import annotations

from collections.abc import Iterable

from network.catalogue.materials import BUILT_IN, SOURCES, Material
from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import table
from network.platform.wording import name_of

PER_METRE = "um/(m K)"
EXAMPLE = "{density: 7100 kg/m^3, specific_heat: 515 J/(kg K), conductivity: 36 W/(m K), expansion: 1.25e-5 1/K}"


def material_page(names: Iterable[str] = BUILT_IN) -> str:
    """Those materials, one below the other."""
    units = {name: field.unit for name, field in Material.params().items()} | {"expansion": PER_METRE}
    header = ["material", *(f"{name_of(name)} [{pretty(unit)}]" for name, unit in units.items()), "source"]
    rows = [[name, *(_tell(name, key, unit) for key, unit in units.items()), SOURCES[name]] for name in names]
    return "\n".join([
        "materials: solids and fluids that a bar or mass may name; values at 20 °C",
        *table(header, rows, header[1:-1]),
        "", "Your own, or other numbers under the same name, stand in the machine file:",
        "  materials:", f"    nodular_iron: {EXAMPLE}",
    ])  # fmt: skip


def _tell(material: str, key: str, unit: str) -> str:
    value = float(BUILT_IN[material].__dict__[key]) * (1e6 if unit == PER_METRE else 1)
    return f"{value:.4g}"
