"""The kinds that the rooms declare, by section of a machine file. Filled as classes with a `kind` are defined."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_REGISTRY: dict[str, dict[str, type[Any]]] = {}


def enter(cls: type[Any]) -> None:
    _REGISTRY.setdefault(cls.section, {})[cls.kind] = cls


def list_kinds(section: str) -> Mapping[str, type[Any]]:
    """The kinds of one section of a machine file, sorted by name. The rooms must be loaded (see discovery)."""
    return dict(sorted(_REGISTRY.get(section, {}).items()))


def sections() -> tuple[str, ...]:
    """The sections that have kinds."""
    return tuple(_REGISTRY)


def section_of(kind: str) -> str | None:
    """Where a kind belongs."""
    return next((section for section, kinds in _REGISTRY.items() if kind in kinds), None)
