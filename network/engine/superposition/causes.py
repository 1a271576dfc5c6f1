"""What drives the rises of a network: where it starts, the temperatures that are held, and every heat source."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from network.engine.network import Network


@dataclass(frozen=True)
class Cause:
    """One of them. held: which of the held nodes, by its place among them; source: a group of sources (heats, then
    relays) and its column; neither: where the run starts."""

    name: str
    held: int | None = None
    source: tuple[int, int] | None = None

    @property
    def is_start(self) -> bool:
        return self.held is None and self.source is None


def list_causes(network: Network) -> tuple[Cause, ...]:
    """The start, then held nodes and heat sources in the order of the file. Their names all differ."""
    sources = sorted(_sources(network), key=lambda cause: list(network.machine.sources).index(cause.name))
    taken = {cause.name for cause in sources}
    held = [Cause(_name_apart(name, taken, "held"), held=k) for k, name in enumerate(_held_nodes(network))]
    taken |= {cause.name for cause in held}
    return (Cause(_name_apart("start", taken, "of the run")), *held, *sources)


def _sources(network: Network) -> Iterator[Cause]:
    for g, group in enumerate((*network.heats, *network.relays)):
        if group.is_heat:
            for column, entry in enumerate(group.entry.tolist()):
                yield Cause(network.mechanisms[entry].partition(".")[2], source=(g, column))


def _held_nodes(network: Network) -> Iterator[str]:
    for i in network.bound.tolist():
        yield next(name for name, part in network.parts.items() if part.start <= i < part.stop)


def _name_apart(name: str, taken: set[str], otherwise: str) -> str:
    return f"{name} ({otherwise})" if name in taken else name


def mean_start(network: Network, T_start: np.ndarray) -> float:
    """The temperature of the whole machine at the start, by heat capacity [°C]: what rises are counted from."""
    own = network.free[~network.is_state[network.free]]
    return float(np.average(T_start[own], weights=network.capacity[own])) if len(own) else network.machine.reference
