from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self

import numpy as np

from network.catalogue.declaration.declare import Advice, Array
from network.catalogue.declaration.fields import amount, channel, merge_inputs, param, word
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.proposals import Runs, fresh_entry
from network.catalogue.mechanisms.base import Source, raise_to_power
from network.catalogue.mechanisms.mechanism import Inputs
from network.catalogue.typical_values import SPEED, name_input, size_body


class HeatSource(Source, kind="heat_source"):
    """Constant heat, heat while the spindle turns, or heat that follows an input: q = P, or q = P · u/u_at.

    `with: always` gives P at all times, `with: running` while |n| > 0, `with: name` in proportion to that input
    channel, which gives P at the value `at`. With an `exponent` it goes with a power of the input's size,
    q = P |u/u_at|^p: 2 for a current (Joule's law, I² R) or a voltage. A negative P cools.
    """

    power = param("W", -1e6, 1e6, "heat", typical=100)
    driver = word("always, running, or the name of an input channel", default="always", key="with")
    at = amount("value of the input at which the heat is `power`, like 15 m/min", default=None)
    exponent = param("1", 0, 6, "power of the input's size that it goes with; default in proportion to the input",
                     default=None, typical=2)  # fmt: skip
    input = channel(None, "rpm", "the speed of what turns in `with: running`; default speed")
    derived = ("full",)
    full: float
    strength = "power"
    sentence = "{into} {exchanged} {when}"

    @property
    def exchanged(self) -> str:
        """What it gives or, where its power is negative, takes, in words."""
        tell = self.fields["power"].tell
        return (
            f"loses {tell(-self.power)} to a sink" if self.power < 0 else f"receives {tell(self.power)} from a source"
        )

    @property
    def when(self) -> str:
        """When it is on, in words."""
        if self.driver == "always":
            return "that is always on"
        if self.driver == "running":
            return "while the spindle turns"
        power = "" if self.exponent is None else f" to the power of {float(self.exponent):.2g}"
        return f"that follows {self.driver}{power}"

    @property
    def speed(self) -> str:
        """The input that tells whether what turns does so."""
        return self.input or SPEED

    def needs(self) -> Mapping[str, str]:
        own = {"always": (), "running": ((self.speed, "rpm"),)}
        follows = own.get(self.driver) if self.at is None else ((self.driver, self.at.unit),)
        return merge_inputs([*super().needs().items(), *(follows or ())])

    def resolve(self, machine: MachineLike) -> Self:
        return self.replaced(full=self.at.value if self.at is not None else None)

    def faults(self) -> Iterator[Advice]:
        follows = self.driver not in ("always", "running")
        if follows and self.at is None:
            right = f"give the value of {self.driver} that makes `power`"
            yield "driver", f"follows '{self.driver}' but lacks 'at'", right
        if not follows and self.at is not None:
            yield "at", f"has 'at' with `with: {self.driver}`", "drop `at`, or name the input in `with`"
        if not follows and self.exponent is not None:
            wrong = f"has 'exponent' with `with: {self.driver}`"
            yield "exponent", wrong, "drop `exponent`, or name the input in `with`"
        if self.driver != "running" and self.input is not None:
            yield "input", f"has 'input' with `with: {self.driver}`", "name the input in `with`"

    @property
    def may_cool(self) -> bool:
        return self.at is not None

    def heat(self, u: Inputs, *T: Array) -> Array:
        q: Array = self.power * self._share(u)
        return q

    def _share(self, u: Inputs) -> Array:
        """Of its power, at the inputs of an instant."""
        if self.driver == "always":
            return np.ones_like(u["time"])
        if self.driver == "running":
            return np.asarray(u[self.speed] != 0)
        share = np.asarray(u[self.driver] / self.full)
        return share if self.exponent is None else raise_to_power(np.abs(share), self.exponent)

    @classmethod
    def proposes_on(cls, machine: MachineLike, runs: Runs) -> Iterator[Mapping[str, Any]]:
        """Besides, into every part, heat in proportion to a recorded power that no source reads: all of it; and what
        goes with another recorded column, in proportion and with its square (a current's loss)."""
        yield from super().proposes_on(machine, runs)
        write = cls.fields["power"].write
        powers = ((n, {"with": n, "at": str(m), "power": write(m.value)}) for n, m in runs.powers.items())
        linear = ((n, {"with": n, "at": str(most)}) for n, most in runs.drivers.items())
        squared = ((f"{n} squared", {"with": n, "at": str(most), "exponent": 2}) for n, most in runs.drivers.items())
        for column, own in (*powers, *linear, *squared):
            for name in cls.hosts(machine):
                body = size_body(cls, machine, into={name: 1}, **own)
                yield {"sources": {fresh_entry(cls.kind, f"{column} {name}", machine.sources): body}}

    @classmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """Into every part: always, and while the spindle runs if the machine knows its speed."""
        speed = name_input(SPEED, machine)
        for driver in ("always", "running") if speed is not None else ("always",):
            own = {"input": speed} if driver == "running" and speed != SPEED else {}
            for name in cls.hosts(machine):
                body = size_body(cls, machine, into={name: 1}, **{"with": driver}, **own)
                yield {"sources": {fresh_entry(cls.kind, f"{driver} {name}", machine.sources): body}}
