"""Numbers whose entry decides in which unit they come."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from typing import Any

from network.catalogue.declaration.field import word_of
from network.catalogue.declaration.number_fields import ParamField
from network.platform.quantities.units import BadNumber, Number, split_number, spread_parts, unit
from network.platform.yaml.tree import Tree


class ManyUnitsField(ParamField):
    """A number whose entry decides in which unit it comes, like K/% or K/W; it is kept and written in that one."""

    @abstractmethod
    def takes(self, unit_text: str) -> bool:
        """Whether numbers may come in that unit."""

    def parse(self, tree: Tree) -> Number:
        text = word_of(tree, f"a number{self.example}")
        given = _unit_in(text)
        own = self.in_unit(given) if given not in ("", self.unit) and self.takes(given) else self
        return replace(ParamField.parse(own, tree), unit=given if own is not self else "")

    def write(self, value: Any) -> Any:
        given = value.unit if isinstance(value, Number) else ""
        return ParamField.write(self.in_unit(given) if given else self, value)


def _unit_in(text: str) -> str:
    """The unit of '0.03 K/% ± 20 %' or 'unknown 0..1 K/%'; nothing where none can be read."""
    given = spread_parts(text.removeprefix("unknown").rpartition("..")[2])[0].strip()
    try:
        return unit(split_number(given)[1]).text
    except BadNumber:
        return ""
