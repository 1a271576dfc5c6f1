"""Places: a part, a point on it or a range of it; and the fields that name them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from network.catalogue.declaration.field import Field, at_its_line, word_of
from network.platform.quantities.units import NUMBER, BadNumber, parse_number
from network.platform.refusal import Spot, short
from network.platform.yaml.tree import Branch, Items, Tree

SHARE_SLACK = 1e-6
PATTERN = r"^[^@]+(@\s*[0-9.eE+-]+\s*)?$"
PLACE_HINT = "write node, node@0.3 or node@0.2..0.8"


@dataclass(frozen=True)
class Place:
    """A part, or a range of it as fractions of its length. A point has start == stop."""

    node: str
    start: float = 0.0
    stop: float = 1.0

    def __str__(self) -> str:
        if self.is_whole:
            return self.node
        if self.start == self.stop:
            return f"{self.node}@{self.start:g}"
        return f"{self.node}@{self.start:g}..{self.stop:g}"

    @property
    def is_whole(self) -> bool:
        return (self.start, self.stop) == (0.0, 1.0)

    @property
    def share(self) -> float:
        """The part of the length that the range covers."""
        return self.stop - self.start


def parse_place(text: str) -> Place:
    """`node`, `node@0.3`, `node@0.2..0.8`. Raises BadNumber."""
    node, at, where = (part.strip() for part in text.partition("@"))
    if not node:
        raise BadNumber(f"'{short(text)}' names no node", PLACE_HINT)
    if not at:
        return Place(node)
    low, dots, high = where.partition("..")
    start = _fraction(low.strip(), text)
    stop = _fraction(high.strip(), text) if dots else start
    if dots and not start < stop:
        raise BadNumber(f"'{short(text)}' runs backwards", "write the smaller fraction first, as in node@0.2..0.8")
    return Place(node, start, stop)


def _fraction(text: str, whole: str) -> float:
    if not re.fullmatch(NUMBER, text):
        raise BadNumber(f"'{short(whole)}' is not a place", PLACE_HINT)
    if re.match("[+-]?0[0-9]", text) or not 0 <= float(text) <= 1:
        raise BadNumber(f"'{short(whole)}' lies outside the part", "fractions go from 0 to 1")
    return float(text)


class PlaceField(Field):
    def parse(self, tree: Tree) -> Place:
        return parse_place(word_of(tree, self.meaning))

    @property
    def sample(self) -> Any:
        return "a"

    def schema(self) -> dict[str, Any]:
        return {"type": "string", "pattern": PATTERN}


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
        return tuple(at_its_line(self._place, child) for child in tree.entries)

    @staticmethod
    def _place(tree: Tree) -> Place:
        return parse_place(word_of(tree, "a place"))

    def write(self, value: Any) -> Any:
        return [str(place) for place in value]

    @property
    def sample(self) -> Any:
        return ["a", "b"]

    def schema(self) -> dict[str, Any]:
        most = {"maxItems": self.count} if self.count else {}
        return {"type": "array", "items": {"type": "string", "pattern": PATTERN}, "minItems": self.count or 2, **most}

    def tell(self, value: Any) -> Path:
        return Path(value)

    def structure(self, value: Any) -> object:
        return len(value) if value is not None else None


class SharesField(Field):
    """Places with shares that add up to 1."""

    def parse(self, tree: Tree) -> tuple[tuple[Place, float], ...]:
        if not isinstance(tree, Branch) or not tree.items:
            raise BadNumber("is not a mapping of places to shares", "write `{node: 1}` or `{a: 0.5, b: 0.5}`")
        shares = tuple(self._share(place, child, tree.key_spot(place)) for place, child in tree.items.items())
        total = sum(share for _, share in shares)
        if not abs(total - 1) <= SHARE_SLACK:
            raise BadNumber(f"has shares that add up to {total:.6g}", "make them add up to 1")
        return shares

    @staticmethod
    def _share(place: str, tree: Tree, spot: Spot) -> tuple[Place, float]:
        try:
            text = word_of(tree, "a share from 0 to 1")
            number = parse_number(text, "1", True, (0, 1))
            if number.prior != "known" or not 0 <= number.value <= 1:
                raise BadNumber(f"'{short(text)}' is not a share", "shares go from 0 to 1, without ±")
            return parse_place(place), number.value
        except BadNumber as error:
            raise BadNumber(f"{short(place)}: {error.wrong}", error.right, spot) from None

    def write(self, value: Any) -> Any:
        return {str(place): float(share) for place, share in value}

    @property
    def sample(self) -> Any:
        return {"a": 1}

    def schema(self) -> dict[str, Any]:
        share = {"type": ["number", "string"], "minimum": 0, "maximum": 1}
        names = {"propertyNames": {"pattern": PATTERN}, "minProperties": 1}
        return {"type": "object", "additionalProperties": share, **names}

    def tell(self, value: Any) -> str:
        return " and ".join(str(place) for place, _ in value)
