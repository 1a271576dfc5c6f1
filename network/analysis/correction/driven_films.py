"""Conductances that an input drives: a fan, a spindle that stirs the air, a gate. Straight about the point in
temperatures, a table in the input: the heat that they let pass more than at the mean input goes by g(u) (T_a − T_b)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.mechanisms.mechanism import Inputs
from network.engine.balance import flow_heat
from network.engine.entry_groups import Flows
from network.engine.network import Network


@dataclass(frozen=True, eq=False)
class DrivenFilms:
    """The elementary flows of one class that read one input. input: its name; flows: the class; differences: T_a − T_b
    of each as a row over all lumps (E, N); spread: what a watt of each does to every lump (E, N)."""

    input: str
    flows: Flows

    @property
    def differences(self) -> Array:
        rows = np.zeros((len(self.flows.a), self.flows.size))
        np.add.at(rows, (np.arange(len(rows)), self.flows.a), 1.0)
        np.add.at(rows, (np.arange(len(rows)), self.flows.b), -1.0)
        return rows

    @property
    def spread(self) -> Array:
        return self.flows.spread

    def conductances(self, point: Array, u: Inputs) -> Array:
        """Of every flow at many values of the input (V, 1): (V, E) [W/K]; half of what its slopes by both ends are,
        for a law that bends."""
        many = np.tile(point, (len(u[self.input]), 1))
        by_a, by_b, *_ = self.flows.slopes(many, u)
        return np.asarray(self.flows.w * (by_a - by_b) / 2 * np.ones((len(many), 1)))

    def heat(self, point: Array, u: Inputs) -> Array:
        """Into every lump with all temperatures at the point: (V, N) [W]."""
        return np.asarray(flow_heat(self.flows, np.tile(point, (len(u[self.input]), 1)), u) @ self.spread)


def list_films(network: Network) -> Iterator[DrivenFilms]:
    """Those that read one input; what reads several stays at its mean."""
    for flows in network.flows:
        read = [*flows.law.needs()]
        if len(read) == 1 and flows.relay is None and not flows.reads:
            yield DrivenFilms(read[0], flows)
