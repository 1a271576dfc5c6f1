"""How results print themselves: what they say is asked for here, and given by a room that they know nothing of."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol


class Printer(Protocol):
    """Whoever puts results into words."""

    def tell(self, what: Any) -> str:
        """As a person reads it in a terminal."""

    def summarise(self, what: Any) -> dict[str, Any]:
        """As a machine reads it: the contents of a JSON file."""


_FOUND: list[Callable[[], Printer]] = []


def use_printer(find: Callable[[], Printer]) -> None:
    """From now on this one prints; it is not looked for before something is printed."""
    _FOUND[:] = [find]


def tell(what: Any) -> str:
    return _FOUND[0]().tell(what)


def summarise(what: Any) -> dict[str, Any]:
    return _FOUND[0]().summarise(what)
