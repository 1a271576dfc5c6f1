"""Where something that is not explained can sit: in a part, between two parts that a link joins, in a channel, or in
surroundings of which no course is given."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

Kind: TypeAlias = Literal["node", "link", "channel", "surroundings"]


@dataclass(frozen=True, slots=True)
class Location:
    """nodes: the part, the two parts in the direction of the heat, or the node of the surroundings, which is held;
    channel: a sensor's name, where it is one."""

    nodes: tuple[str, ...] = ()
    channel: str = ""
    is_held: bool = False

    @property
    def kind(self) -> Kind:
        if self.channel or self.is_held:
            return "channel" if self.channel else "surroundings"
        return "node" if len(self.nodes) == 1 else "link"

    @property
    def channels(self) -> tuple[str, ...]:
        return (self.channel,) if self.channel else ()

    @property
    def seats(self) -> tuple[str, ...]:
        """The parts or the channel, each by its name."""
        return self.nodes or self.channels

    def __str__(self) -> str:
        return " to ".join(self.seats)
