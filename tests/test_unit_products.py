"""Units read from the table alone are those that pint reads from it, whatever prefix and product."""

from __future__ import annotations

from fractions import Fraction
from itertools import product

import pytest

from network.platform.quantities import unit_names, unit_table
from network.platform.quantities.unit_names import BadNumber
from network.platform.quantities.unit_products import _table, read_product

NAMES, PREFIXES, _ = _table()
PRODUCTS = ("W/K", "kJ/(kg K)", "W/(m^2 K)", "N mm", "W m^-1 K^-1", "J/(kg K)", "kg/m^3", "1/K", "1e3 W",
            "1 / min", "W/m K", "W/m/K",
            "um/(m K)", "m^2.5", "rev/min", "l/min", "percent/K", "W/K^2", "meters", "Kelvin", "cm^2", "N  mm ",
            "m^12 m^9", "W//K", "ubar", "mmin", "kWh", "Ws", "", "W K^", "°C", "K/%", "m³", "N·m", "m**2")  # fmt: skip


def by_pint(text: str, monkeypatch: pytest.MonkeyPatch) -> tuple[Fraction, str] | str:
    with monkeypatch.context() as alone:
        alone.setattr(unit_names, "read_product", lambda text: None)
        found = read(text)
        if isinstance(found, tuple):
            return found
        unit_table.registry.cache_clear()  # odd names before it can leave pint's registry unable to read plain ones
        unit_table.find_spelling.cache_clear()
        return read(text)


def read(text: str) -> tuple[Fraction, str] | str:
    try:
        return unit_names._factor_and_dimension(text)
    except BadNumber as bad:
        return str(bad)


def test_every_name_with_every_prefix_is_as_pint_reads_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """But for kgram, which pint cannot read where kilogram is a unit of its own."""
    texts = [prefix + name for prefix, name in product(("", *PREFIXES), NAMES) if prefix + name != "kgram"]
    wrong = [text for text in texts if read(text) != by_pint(text, monkeypatch)]
    assert not wrong
    assert sum(read_product(text) is not None for text in texts) > 0.5 * len(texts)


@pytest.mark.parametrize("text", PRODUCTS)
def test_products_are_as_pint_reads_them(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert read(text) == by_pint(text, monkeypatch)
