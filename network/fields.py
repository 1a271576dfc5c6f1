"""The fields an entry can have: numbers with units, places, shares, words, flags. Each reads and writes its YAML."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from network.refusal import Complaints, likely
from network.units import BadNumber, Number, parse_number, show, split_number, unit
from network.yamlfile import Branch, Items, Leaf, Tree

if TYPE_CHECKING:
    from network.declare import Declared

REQUIRED: Final = object()
"""Default of a field that must be given: what only the user can know has no default."""

SHARE_SLACK = 1e-6


@dataclass(frozen=True)
class Place:
    """A part, or a range of it as fractions of its length. A point has start == stop."""

    node: str
    start: float = 0.0
    stop: float = 1.0

    def __str__(self) -> str:
        if (self.start, self.stop) == (0.0, 1.0):
            return self.node
        if self.start == self.stop:
            return f"{self.node}@{self.start:g}"
        return f"{self.node}@{self.start:g}..{self.stop:g}"

    @property
    def share(self) -> float:
        """The part of the length that the range covers."""
        return self.stop - self.start


def parse_place(text: str) -> Place:
    """`node`, `node@0.3`, `node@0.2..0.8`."""
    node, at, where = text.strip().partition("@")
    if not node:
        raise BadNumber(f"'{text}' names no node", "write node, node@0.3 or node@0.2..0.8")
    if not at:
        return Place(node)
    low, dots, high = where.partition("..")
    start = _fraction(low, text)
    stop = _fraction(high, text) if dots else start
    if dots and not start < stop:
        raise BadNumber(f"'{text}' runs backwards", "write the smaller fraction first, as in node@0.2..0.8")
    return Place(node, start, stop)


def _fraction(text: str, whole: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise BadNumber(f"'{whole}' is not a place", "write node, node@0.3 or node@0.2..0.8") from None
    if not 0 <= value <= 1:
        raise BadNumber(f"'{whole}' lies outside the part", "fractions go from 0 to 1")
    return value


class Field(ABC):
    """One key of an entry."""

    attribute: str

    def __init__(self, meaning: str, default: Any = REQUIRED, key: str = "") -> None:
        self.meaning, self.default, self._key = meaning, default, key

    def __set_name__(self, owner: type, name: str) -> None:
        self.attribute = name

    @property
    def key(self) -> str:
        return self._key or self.attribute

    @property
    def example(self) -> str:
        """How it could be written, for the message about a missing key."""
        return ""

    @property
    def initial(self) -> Any:
        """The value where nothing is given; None where it must be given."""
        return None if self.default is REQUIRED else self.default

    @abstractmethod
    def parse(self, tree: Tree) -> Any:
        """The value. Raises BadNumber with what is wrong and what would be right."""

    def write(self, value: Any) -> Any:
        return str(value)

    def tell(self, value: Any) -> Any:
        """How the value reads in a sentence."""
        return str(value)

    def structure(self, value: Any) -> object:
        """What of the value must agree for two entries to be evaluated in one call."""
        return None


def word_of(tree: Tree, meaning: str) -> str:
    if not isinstance(tree, Leaf) or tree.is_null:
        raise BadNumber("is not a single value", f"give {meaning}")
    return tree.text.strip()


class ParamField(Field):
    """A number with a unit, bounds and a meaning. Inside it is SI, absolute temperatures °C."""

    def __init__(
        self, unit_text: str, low: float, high: float, meaning: str, default: Any, positive: bool, typical: float | None,
        any_power_of: str,
    ) -> None:  # fmt: skip
        super().__init__(meaning, default)
        self.unit, self.positive, self.any_power_of = unit_text, positive, any_power_of
        self._low, self._high, self._typical = low, high, typical

    @property
    def example(self) -> str:
        return f", in {self.unit}" if self.unit != "1" else ""

    @property
    def initial(self) -> Any:
        return self._si(self.default) if isinstance(self.default, int | float) else None

    def _si(self, number: float) -> float:
        given = unit(self.unit)
        return number * given.scale + (0.0 if self.unit == "K" else given.offset)

    @property
    def low(self) -> float:
        return self._si(self._low)

    @property
    def high(self) -> float:
        return self._si(self._high)

    @property
    def may_be_negative(self) -> bool:
        return self._low < 0 or self.unit == "degC"

    def parse(self, tree: Tree) -> Number:
        text = word_of(tree, f"a number{self.example}")
        number = parse_number(text, self._wanted(text), self.may_be_negative, (self.low, self.high))
        ends = (number.low, number.high) if number.prior == "unknown" else (number.value,)
        for value in ends:
            self._check_bounds(value, text)
        return number

    def _wanted(self, text: str) -> str:
        """The unit asked for; some coefficients come per any power of one dimension (W/(m² K^1.25), W/(m² K^1.33))."""
        if not self.any_power_of:
            return self.unit
        given = text.removeprefix("unknown").rpartition("..")[2].split("±")[0].strip()
        try:
            of = unit(split_number(given)[1]).dimension
        except BadNumber:
            return self.unit
        same = _without(of, self.any_power_of) == _without(unit(self.unit).dimension, self.any_power_of)
        return split_number(given)[1] if same and self.any_power_of in of else self.unit

    def _check_bounds(self, value: float, text: str) -> None:
        slack = 1e-12 * max(abs(self.low), abs(self.high))
        if self.positive and value <= 0:
            raise BadNumber(f"'{text}' is not above zero", f"give {self.meaning} above zero, in {self.unit}")
        if not self.low - slack <= value <= self.high + slack:
            allowed = f"{show(self.low, self.unit)} to {show(self.high, self.unit)}"
            side = "below" if value < self.low else "above"
            raise BadNumber(f"'{text}' is {side} what is possible", f"{self.meaning} goes from {allowed}")

    def proposal(self) -> float:
        """A typical value in SI: where a search for it may start."""
        if self._typical is not None:
            return self._si(self._typical)
        if self.may_be_negative:
            return (self.low + self.high) / 2
        return math.sqrt(max(self.low, self.high * 1e-6) * self.high)

    def write(self, value: Any) -> Any:
        number = value if isinstance(value, Number) else Number(float(value))
        if number.prior == "unknown":
            low, high = (show(v, self.unit, 17) for v in (number.low, number.high))
            return f"unknown {low.split(' ')[0]}..{high}"
        text = _plain_number(show(number.value, self.unit, 17))
        if number.prior == "log":
            return f"{text} ± {number.spread * 100:.12g} %"
        if number.prior == "normal":
            return f"{text} ± {show(number.spread, 'K' if self.unit == 'degC' else self.unit, 12)}"
        return text

    def tell(self, value: Any) -> str:
        return show(float(value), self.unit)


def _plain_number(text: str) -> str:
    """The shortest decimal that reads back as the same number: 0.10000000000000001 → 0.1."""
    number, _, unit_text = text.partition(" ")
    shortest = repr(float(number))
    shortest = shortest.removesuffix(".0")
    return f"{shortest} {unit_text}".strip()


def _without(dimension: str, name: str) -> str:
    """A dimension less one of its bases: '[mass] [temperature]^-1 [time]^-3' → '[mass] [time]^-3'."""
    return " ".join(term for term in dimension.split() if not term.startswith(name))


@dataclass(frozen=True)
class Amount:
    """A number in a unit of the user's own choice, kept with that unit; `value` is SI."""

    value: float
    unit: str

    def __str__(self) -> str:
        return _plain_number(show(self.value, self.unit, 17))


class AmountField(Field):
    """A number whose unit is decided elsewhere, like the value of an input channel."""

    def parse(self, tree: Tree) -> Amount:
        number, unit_text = split_number(word_of(tree, self.meaning))
        value = unit(unit_text).to_si(number)
        if value == 0:
            raise BadNumber("is zero", f"give {self.meaning} other than zero")
        return Amount(value, unit_text or "1")

    def structure(self, value: Any) -> object:
        return value is not None


class PlaceField(Field):
    def parse(self, tree: Tree) -> Place:
        return parse_place(word_of(tree, self.meaning))


class Path(tuple[Place, ...]):
    """Places in order, as a sentence names them."""

    def __str__(self) -> str:
        return ", ".join(map(str, self))


class PlacesField(Field):
    """A list of places; `count` fixes how many."""

    def __init__(self, meaning: str, count: int | None, default: Any) -> None:
        super().__init__(meaning, default)
        self.count = count

    def parse(self, tree: Tree) -> tuple[Place, ...]:
        wanted = f"{self.count} places" if self.count else "at least two places"
        if not isinstance(tree, Items):
            raise BadNumber("is not a list", f"give {wanted}, as in [a, b]")
        if len(tree.entries) != (self.count or max(2, len(tree.entries))):
            raise BadNumber(f"has {len(tree.entries)} places", f"give {wanted}, as in [a, b]")
        return tuple(parse_place(word_of(child, "a place")) for child in tree.entries)

    def write(self, value: Any) -> Any:
        return [str(place) for place in value]

    def tell(self, value: Any) -> Path:
        return Path(value)

    def structure(self, value: Any) -> object:
        return len(value) if value is not None else None


class SharesField(Field):
    """Places with shares that add up to 1."""

    def parse(self, tree: Tree) -> tuple[tuple[Place, float], ...]:
        if not isinstance(tree, Branch) or not tree.items:
            raise BadNumber("is not a mapping of places to shares", "write `{node: 1}` or `{a: 0.5, b: 0.5}`")
        shares = tuple((parse_place(place), self._share(place, child)) for place, child in tree.items.items())
        total = sum(share for _, share in shares)
        if abs(total - 1) > SHARE_SLACK:
            raise BadNumber(f"has shares that add up to {total:.6g}", "make them add up to 1")
        return shares

    @staticmethod
    def _share(place: str, tree: Tree) -> float:
        number = parse_number(word_of(tree, "a share"), "1", False, (0, 1))
        if number.prior != "known" or not 0 <= number.value <= 1:
            raise BadNumber(f"has a share '{word_of(tree, 'a share')}' for {place}", "shares go from 0 to 1, without ±")
        return number.value

    def write(self, value: Any) -> Any:
        return {str(place): float(share) for place, share in value}

    def tell(self, value: Any) -> str:
        return " and ".join(str(place) for place, _ in value)


class WordField(Field):
    """One word; with `options` only these."""

    def __init__(self, meaning: str, default: Any, options: tuple[str, ...], key: str) -> None:
        super().__init__(meaning, default, key)
        self.options = options

    def parse(self, tree: Tree) -> str:
        text = word_of(tree, self.meaning)
        if self.options and text not in self.options:
            raise BadNumber(f"is '{text}'", likely(text, self.options))
        return text

    def structure(self, value: Any) -> object:
        return value


class FlagField(Field):
    def parse(self, tree: Tree) -> bool:
        text = word_of(tree, "true or false")
        if text not in ("true", "false"):
            raise BadNumber(f"is '{text}'", "write true or false")
        return text == "true"

    def write(self, value: Any) -> Any:
        return bool(value)


class WholeField(Field):
    """A whole number within bounds, or one of the allowed ones."""

    def __init__(self, meaning: str, low: int, high: int, default: Any, allowed: tuple[int, ...]) -> None:
        super().__init__(meaning, default)
        self.low, self.high, self.allowed = low, high, allowed

    def parse(self, tree: Tree) -> int:
        text = word_of(tree, self.meaning)
        wanted = " or ".join(map(str, self.allowed)) if self.allowed else f"a whole number from {self.low} to {self.high}"
        if not text.lstrip("+-").isdigit() or (text.lstrip("+-").startswith("0") and text.lstrip("+-") != "0"):
            raise BadNumber(f"is '{text}'", f"give {wanted}")
        value = int(text)
        if not self.low <= value <= self.high or (self.allowed and value not in self.allowed):
            raise BadNumber(f"is {text}", f"give {wanted}")
        return value

    def write(self, value: Any) -> Any:
        return int(value)


class Nested(Field):
    """An entry of its own kind inside an entry, or a list of entries chosen by their `kind`."""

    def __init__(self, meaning: str, of: Any, many: bool) -> None:
        super().__init__(meaning, () if many else None)
        self._of, self.many = of, many

    def parse(self, tree: Tree) -> Any:
        raise NotImplementedError("nested entries are read with parse_entry")

    def parse_entry(self, where: str, tree: Tree, complaints: Complaints) -> Declared | tuple[Declared, ...] | None:
        if not self.many:
            return cast("type[Declared]", self._of()).read(where, tree, complaints)
        if not isinstance(tree, Items):
            raise BadNumber("is not a list", "write [{kind: …, …}, …]")
        read = (read_kind(self._of(), f"{where}[{i}]", child, complaints) for i, child in enumerate(tree.entries))
        return tuple(entry for entry in read if entry is not None)

    def write(self, value: Any) -> Any:
        return [entry.to_plain() for entry in value] if self.many else value.to_plain()

    def structure(self, value: Any) -> object:
        return tuple(e.structure() for e in value) if self.many else value is not None


Entry = TypeVar("Entry", bound="Declared")


def read_kind(kinds: dict[str, type[Entry]], where: str, tree: Tree, complaints: Complaints) -> Entry | None:
    """The entry of the class that its `kind` names."""
    if not isinstance(tree, Branch):
        complaints.refuse(tree.spot, f"{where} is not a mapping", "write `{kind: …, …}`")
        return None
    child = tree.items.get("kind")
    if not isinstance(child, Leaf):
        complaints.refuse(tree.spot, f"{where} has no kind", "give one of: " + ", ".join(kinds))
        return None
    if child.text not in kinds:
        complaints.refuse(child.spot, f"{where} has an unknown kind '{child.text}'", likely(child.text, kinds))
        return None
    return kinds[child.text].read(where.partition(".")[2] if "." in where else where, tree, complaints)


def param(
    unit_text: str, low: float, high: float, meaning: str, *, default: Any = REQUIRED, positive: bool = False,
    typical: float | None = None, any_power_of: str = "",
) -> NDArray[np.float64]:  # fmt: skip
    """A number with a unit; bounds, default and typical value in that unit. `positive`: zero is refused too."""
    return cast(
        NDArray[np.float64], ParamField(unit_text, low, high, meaning, default, positive, typical, any_power_of)
    )


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


def nested(meaning: str, of: Any, *, many: bool = False) -> Any:
    return Nested(meaning, of, many)
