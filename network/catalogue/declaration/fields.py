"""The fields an entry can declare: numbers with units, places, shares, words, flags. Each reads and writes its YAML."""

from __future__ import annotations

import re
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from network.catalogue.declaration.entry_reading import Nested, read_kind
from network.catalogue.declaration.field import REQUIRED, Field, word_of
from network.catalogue.declaration.input_field import ANY, InputField, channel, merge_inputs
from network.catalogue.declaration.number_fields import Amount, AmountField, ParamField
from network.catalogue.declaration.places import Place, PlaceField, PlacesField, SharesField, parse_place
from network.catalogue.declaration.positions import AlongField
from network.platform.quantities.units import BadNumber
from network.platform.refusal import likely, short
from network.platform.yaml.tree import Tree

__all__ = [
    "ANY", "REQUIRED", "AlongField", "Amount", "AmountField", "Field", "FlagField", "InputField", "Nested",
    "ParamField", "Place", "PlaceField", "PlacesField", "SharesField", "WholeField", "WordField", "along",
    "amount", "channel", "flag", "merge_inputs", "nested", "param", "parse_place", "place", "places", "read_kind",
    "shares", "whole", "word", "word_of",
]  # fmt: skip


class WordField(Field):
    """One word; with `options` only these."""

    def __init__(self, meaning: str, default: Any, options: tuple[str, ...], key: str) -> None:
        super().__init__(meaning, default, key)
        self.options = options

    def parse(self, tree: Tree) -> str:
        text = word_of(tree, self.meaning)
        if self.options and text not in self.options:
            raise BadNumber(f"is '{short(text)}'", likely(text, self.options))
        return text

    @property
    def sample(self) -> Any:
        return self.options[0] if self.options else self.default if isinstance(self.default, str) else "name"

    def schema(self) -> dict[str, Any]:
        return {"enum": list(self.options)} if self.options else {"type": "string"}

    def structure(self, value: Any) -> object:
        return value


class FlagField(Field):
    def parse(self, tree: Tree) -> bool:
        text = word_of(tree, "true or false")
        if text not in ("true", "false"):
            raise BadNumber(f"is '{short(text)}'", "write true or false")
        return text == "true"

    def write(self, value: Any) -> Any:
        return bool(value)

    @property
    def sample(self) -> Any:
        return True

    def schema(self) -> dict[str, Any]:
        return {"type": "boolean"}


class WholeField(Field):
    """A whole number within bounds, or one of the allowed ones."""

    def __init__(self, meaning: str, low: int, high: int, default: Any, allowed: tuple[int, ...]) -> None:
        super().__init__(meaning, default)
        self.low, self.high, self.allowed = low, high, allowed

    def parse(self, tree: Tree) -> int:
        text = word_of(tree, self.wanted)
        value = int(text) if re.fullmatch("[+-]?(0|[1-9][0-9]{0,17})", text) else None
        if value is None or not self.low <= value <= self.high or (self.allowed and value not in self.allowed):
            raise BadNumber(f"is '{short(text)}'", f"give {self.wanted}")
        return value

    @property
    def wanted(self) -> str:
        if self.allowed:
            return " or ".join(map(str, self.allowed))
        return f"a whole number from {self.low} to {self.high}"

    def write(self, value: Any) -> Any:
        return int(value)

    @property
    def sample(self) -> Any:
        return self.allowed[0] if self.allowed else self.low

    def schema(self) -> dict[str, Any]:
        if self.allowed:
            return {"enum": list(self.allowed)}
        return {"type": "integer", "minimum": self.low, "maximum": self.high}


def param(
    unit_text: str, low: float, high: float, meaning: str, *, default: Any = REQUIRED, positive: bool = False,
    typical: float | None = None, any_power_of: str = "",
) -> NDArray[np.float64]:  # fmt: skip
    """A number with a unit; bounds, default and typical value in that unit. `positive`: zero is refused too."""
    return cast(
        NDArray[np.float64], ParamField(unit_text, low, high, meaning, default, positive, typical, any_power_of)
    )


def instant(
    low: float, high: float, meaning: str, *, default: Any = REQUIRED, positive: bool = False, typical: float
) -> NDArray[np.float64]:
    """A time, in minutes, that says when something jumps: a run has no slope by it."""
    told = ("min", low, high, meaning, default, positive, typical)
    return cast(NDArray[np.float64], ParamField(*told, is_instant=True))


def along(meaning: str, *, default: Any = REQUIRED) -> Any:
    """A point along a part: a share of its length, a length, or where an input says (see positions)."""
    return AlongField(meaning, default)


def amount(meaning: str, *, default: Any = REQUIRED) -> Amount:
    return cast(Amount, AmountField(meaning, default))


def place(meaning: str, *, default: Any = REQUIRED) -> Place:
    return cast(Place, PlaceField(meaning, default))


def places(meaning: str, count: int | None = 2, *, default: Any = REQUIRED) -> tuple[Place, ...]:
    return cast("tuple[Place, ...]", PlacesField(meaning, count, default))


def shares(meaning: str) -> tuple[tuple[Place, float], ...]:
    return cast("tuple[tuple[Place, float], ...]", SharesField(meaning))


def word(meaning: str, *options: str, default: Any = REQUIRED, key: str = "") -> str:
    return cast(str, WordField(meaning, default, options, key))


def flag(meaning: str, *, default: Any = False) -> bool:
    return cast(bool, FlagField(meaning, default))


def whole(meaning: str, low: int, high: int, *, default: Any = REQUIRED, allowed: tuple[int, ...] = ()) -> int:
    return cast(int, WholeField(meaning, low, high, default, allowed))


def nested(meaning: str, of: Any, *, many: bool = False, required: bool = False) -> Any:
    return Nested(meaning, of, many, required)
