"""Where something that is not explained can sit: in a part, between two parts that a link joins, or in a channel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

Kind: TypeAlias = Literal["node", "link", "channel"]


@dataclass(frozen=True, slots=True)
class Location:
    """nodes: the part, or the two parts in the direction of the heat; channel: a sensor's name, where it is one."""

    nodes: tuple[str, ...] = ()
    channel: str = ""

    @property
    def kind(self) -> Kind:
        return "channel" if self.channel else "node" if len(self.nodes) == 1 else "link"

    @property
    def channels(self) -> tuple[str, ...]:
        return (self.channel,) if self.channel else ()

    @property
    def seats(self) -> tuple[str, ...]:
        """The parts or the channel, each by its name."""
        return self.nodes or self.channels

    def __str__(self) -> str:
        return " to ".join(self.seats)
