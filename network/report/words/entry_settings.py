"""What an entry says of itself besides its places: every key that was given, as numbers and words in short."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from network.catalogue.declaration.declare import Declared
from network.catalogue.declaration.field import Field
from network.catalogue.declaration.number_fields import ParamField

SEATS = ("of", "into", "between", "through")
"""Keys of the places where an entry acts; those that it reads elsewhere are among its settings."""


def settings_of(entry: Declared, besides: tuple[str, ...] = ()) -> str:
    """All keys that differ from what holds without them, but seats and what stands in a column of its own."""
    return ", ".join(_settings(entry, besides))


def _settings(entry: Declared, besides: tuple[str, ...]) -> Iterator[str]:
    for attribute, field in entry.fields.items():
        value = entry.__dict__.get(attribute)
        if value is not None and field.key not in (*SEATS, *besides) and value != field.initial:
            yield f"{field.key} {_tell(field, value)}"


def _tell(field: Field, value: Any) -> str:
    if isinstance(field, ParamField):
        return field.tell(value)
    written = field.write(value)
    return str(written).replace("-", "−") if isinstance(written, int) else str(written)
