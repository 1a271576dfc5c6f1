"""What a proposal is made of: names that are not taken, the entries of a patch, where a number of it stands."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping
from itertools import count
from typing import Any


def fresh(name: str, taken: Container[str]) -> str:
    """The name, with a number behind it if it is taken."""
    return name if name not in taken else next(n for i in count(2) if (n := f"{name} {i}") not in taken)


def bodies(patch: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """(path, entry) for everything a patch gives, like ('links.skin', {…}); what it removes is left out."""
    for section, named in patch.items():
        by_axis = {f"{section}.{axis}": entries for axis, entries in named.items()} if section == "tcp" else {}
        for path, entries in (by_axis or {section: named}).items():
            for name, body in entries.items():
                if isinstance(body, Mapping):
                    yield f"{path}.{name}", body
                    yield from ((f"{path}.{name}.effects.{i}", e) for i, e in enumerate(body.get("effects", ())))
