"""Opens the rooms: imports every file in them, so that its kinds are registered."""

from __future__ import annotations

import pkgutil
from functools import lru_cache
from importlib import import_module

from network.catalogue.declaration.declare import Declared, list_kinds

ROOMS = ("mechanisms", "expansions", "sensors", "suspects")


@lru_cache(maxsize=1)
def open_rooms() -> None:
    for room in ROOMS:
        package = import_module(f"network.catalogue.{room}")
        for module in pkgutil.iter_modules(package.__path__):
            import_module(f"network.catalogue.{room}.{module.name}")


def kinds(section: str) -> dict[str, type[Declared]]:
    """Every kind of one section (links, sources, tcp, sensors, suspects), by name."""
    open_rooms()
    return dict(list_kinds(section))
