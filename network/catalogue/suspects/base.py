"""Missing physics that takes more than one entry: a suspect proposes patches that add or change several at once.

A suspect has no YAML form. Its fields are the place it sits at and the numbers of its patch: each number stands in the
patch under the same key, once, so that what was fitted can be read back from the patched machine.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from typing import Any, Self

from network.catalogue.declaration.declare import Effect
from network.catalogue.declaration.entry_path import EntryPath, NumberPath
from network.catalogue.declaration.fields import Field, Place, PlaceField, parse_place
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.patch import Patch


class Suspect(Effect):
    """Several entries that belong together: `patch` makes them, `suspected` says where they could be missing."""

    section = "suspects"

    @abstractmethod
    def patch(self, machine: MachineLike) -> Mapping[str, Any]:
        """The patch that adds it to a machine."""

    @classmethod
    @abstractmethod
    def suspected(cls, machine: MachineLike) -> Iterator[Self]:
        """Where in this machine it could be missing, with typical numbers."""

    @classmethod
    def proposes(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        return (suspect.patch(machine) for suspect in cls.suspected(machine))

    @classmethod
    def typical(cls, **given: Any) -> Self:
        """One with typical numbers where none are given."""
        return cls(**{name: field.proposal() for name, field in cls.params().items()} | given)

    def write_numbers(self, *names: str) -> dict[str, Any]:
        """Some of its numbers as they stand in a patch."""
        return {self.fields[name].key: self.fields[name].write(self.__dict__[name]) for name in names}

    @classmethod
    def path_to(cls, parameter: str, patch: Mapping[str, Any]) -> NumberPath:
        key = cls.fields[parameter].key
        return next(NumberPath(path, key) for path, body in Patch(patch).entries() if key in body)

    @classmethod
    def told(cls, machine: MachineLike, patch: Mapping[str, Any]) -> str:
        return cls.from_patch(machine, patch).said()

    @classmethod
    def from_patch(cls, machine: MachineLike, patch: Mapping[str, Any]) -> Self:
        """The suspect that a patch holds, with the numbers of the machine the patch was laid over."""
        return cls(**{name: cls._read_back(field, machine.by_path, patch) for name, field in cls.fields.items()})

    @classmethod
    def _read_back(cls, field: Field, entries: Mapping[EntryPath, Any], patch: Mapping[str, Any]) -> Any:
        if isinstance(field, PlaceField):
            return cls.host_in(patch)
        number = cls.path_to(field.attribute, patch)
        entry = entries[number.entry]
        return entry.__dict__[next(name for name, own in entry.fields.items() if own.key == number.key)]

    @classmethod
    def host_in(cls, patch: Mapping[str, Any]) -> Place:
        """The place it sits at: where its first link begins, or the node it changes."""
        links: Mapping[str, Any] = patch.get("links", {})
        first = next((body["between"][0] for body in links.values() if "between" in body), None)
        return parse_place(first if first is not None else next(iter(patch["nodes"])))
