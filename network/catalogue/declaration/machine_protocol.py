"""What the catalogue asks of a machine, as a shape: entries are read before there is a machine, and know it by this.

Only what lies below the catalogue is named here, so that nothing is imported upwards.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from network.catalogue.declaration.entry_path import EntryPath
from network.catalogue.declaration.field import Field
from network.catalogue.declaration.places import Place


class EntryLike(Protocol):
    """Any entry of a file."""

    @property
    def name(self) -> str: ...
    @property
    def kind(self) -> str: ...
    @property
    def section(self) -> str: ...
    @property
    def fields(self) -> Mapping[str, Field]: ...
    def to_plain(self) -> dict[str, Any]: ...


class NodeLike(EntryLike, Protocol):
    """A part, a massless junction, or a node of held temperature."""

    @property
    def is_held(self) -> bool: ...
    @property
    def is_bar(self) -> bool: ...
    @property
    def is_part(self) -> bool: ...
    @property
    def is_massless(self) -> bool: ...
    @property
    def capacity(self) -> float: ...
    @property
    def expansion(self) -> float | None: ...
    @property
    def length(self) -> NDArray[np.float64]: ...
    @property
    def lumps(self) -> int: ...
    @property
    def rotates(self) -> bool: ...
    @property
    def temperature(self) -> Any: ...


class LinkLike(EntryLike, Protocol):
    """A link or a stream."""

    @property
    def places(self) -> tuple[Place, ...]: ...
    @classmethod
    def readings(cls) -> tuple[str, ...]: ...
    def slopes(
        self, T_a: NDArray[np.float64], T_b: NDArray[np.float64], u: Mapping[str, NDArray[np.float64]],
        *own: NDArray[np.float64],
    ) -> tuple[NDArray[np.float64], ...]: ...  # fmt: skip


class EffectLike(EntryLike, Protocol):
    """What a sensor does to the truth."""

    is_steady: ClassVar[bool]

    @property
    def follows(self) -> str: ...


class SensorLike(EntryLike, Protocol):
    """A channel."""

    @property
    def place(self) -> Place | None: ...
    @property
    def measures(self) -> Any: ...
    @property
    def quantity(self) -> str: ...
    @property
    def effects(self) -> Sequence[EffectLike]: ...


class MachineLike(Protocol):
    """reference [°C]; the entries of each section by name, of `tcp` by axis and name; exchanged_by: sensor → the first
    one that says to be exchanged with it; inputs: channel → its unit;
    joined_parts: pairs of parts that a link joins; entries: all, with their paths."""

    @property
    def reference(self) -> float: ...
    @property
    def nodes(self) -> Mapping[str, NodeLike]: ...
    @property
    def links(self) -> Mapping[str, LinkLike]: ...
    @property
    def sources(self) -> Mapping[str, EntryLike]: ...
    @property
    def tcp(self) -> Mapping[str, Mapping[str, EntryLike]]: ...
    @property
    def sensors(self) -> Mapping[str, SensorLike]: ...
    @property
    def exchanged_by(self) -> Mapping[str, str]: ...
    @property
    def inputs(self) -> Mapping[str, str]: ...
    def material(self, name: str) -> EntryLike | None: ...
    def list_joined_parts(self) -> Iterator[tuple[str, str]]: ...
    def entries(self) -> Iterator[tuple[EntryPath, EntryLike]]: ...
    @property
    def by_path(self) -> Mapping[EntryPath, EntryLike]: ...
