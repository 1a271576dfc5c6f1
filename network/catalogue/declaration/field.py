"""What every field of an entry is: one key with a meaning, read from YAML and written back."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, Final, TypeVar

from network.platform.quantities.units import BadNumber
from network.platform.yaml.tree import Leaf, Tree

Value = TypeVar("Value")

REQUIRED: Final = object()
"""Default of a field that must be given: what only the user can know has no default."""


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

    @property
    def sample(self) -> Any:
        """A value as it could stand in a file."""
        return None if self.default is REQUIRED else self.default

    def schema(self) -> dict[str, Any]:
        """JSON Schema of the value as it stands in a file."""
        return {"type": ["string", "number"]}

    def tell(self, value: Any) -> Any:
        """How the value reads in a sentence."""
        return str(value)

    def structure(self, value: Any) -> object:
        """What of the value must agree for two entries to be evaluated in one call."""
        return None


def word_of(tree: Tree, meaning: str) -> str:
    """The text of a single value. Raises BadNumber where there is none."""
    if not isinstance(tree, Leaf):
        raise BadNumber("is not a single value", f"give {meaning}")
    if tree.is_null or not tree.text.strip():
        raise BadNumber("is empty", f"give {meaning}")
    return tree.text.strip()


def at_its_line(read: Callable[[Tree], Value], tree: Tree) -> Value:
    """What `read` makes of one value among several; its fault is told by its own line."""
    try:
        return read(tree)
    except BadNumber as error:
        raise BadNumber(error.wrong, error.right, error.spot or tree.spot) from None
