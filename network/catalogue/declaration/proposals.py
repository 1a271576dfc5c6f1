"""Names of what a proposal brings: such as are not taken."""

from __future__ import annotations

from collections.abc import Container
from itertools import count


def fresh(name: str, taken: Container[str]) -> str:
    """The name, with a number behind it if it is taken."""
    return name if name not in taken else next(n for i in count(2) if (n := f"{name} {i}") not in taken)
