"""A measured channel: what it measures, how noisy it is, what it does to the truth."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self, cast

from network.catalogue.declaration.declare import Advice, Declared, list_kinds
from network.catalogue.declaration.entry_path import axis_of
from network.catalogue.declaration.fields import (
    ANY,
    Amount,
    AmountField,
    Field,
    Place,
    channel,
    nested,
    parse_place,
    word,
    word_of,
)
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.places import PATTERN
from network.catalogue.expansions.base import ANGULAR_AXES, AXES
from network.catalogue.sensors.base import SensorEffect
from network.platform.quantities.units import BadNumber, Unit, difference, unit
from network.platform.refusal import short
from network.platform.yaml.tree import Tree

NOISE_UNITS = {"temperature": "K", "displacement": "um", "angle": "urad"}
LEAST_NOISE = 1e-6
"""In these units: what the best instruments of a laboratory resolve, a microkelvin, a picometre, a picoradian."""
MOST_NOISE = {"temperature": 140.0, "displacement": 1e5, "angle": 1e6}
"""In these units: 1σ of a reading that says nothing: even over the 480 K that a part may have, a tenth of a metre, a
radian."""


class NoiseField(AmountField):
    """1σ of one sample: a difference, above zero."""

    def _amount(self, text: str, number: float, given: Unit) -> Amount:
        if not number > 0:
            raise BadNumber(f"'{short(text)}' is not above zero", f"give {self.meaning}")
        if given.is_temperature:
            return Amount(difference(given).to_si(number), "K")
        return Amount(given.to_si(number), given.text)

    @property
    def sample(self) -> Any:
        return "0.05 K"


class MeasuresField(Field):
    """A place, or tcp.<axis>."""

    def parse(self, tree: Tree) -> Place | str:
        text = word_of(tree, self.meaning)
        return text if axis_of(text) is not None else parse_place(text)

    @property
    def sample(self) -> Any:
        return "a"

    def schema(self) -> dict[str, Any]:
        return {"type": "string", "pattern": PATTERN}


class Sensor(Declared):
    """A channel of a recording. `zero: start` reads what changed since the start (a probe that was zeroed).

    `while: pump` lets its readings count only while that input is not zero: a thermometer in a pipe that stands, a
    display that freezes at standstill. What is simulated is the truth at all times.
    """

    section = "sensors"
    measures: Any = MeasuresField("a place, or tcp.x … tcp.c")
    noise: Amount = cast(Amount, NoiseField("1σ of one sample, like 0.05 K or 0.25 um"))
    zero = word("where the channel reads zero: at the reference, or at the start", "start", default=None)
    gate = channel(None, ANY, "an input: its readings count only while that is not zero", key="while")
    effects: tuple[SensorEffect, ...] = nested(
        "what the sensor does to the truth", lambda: list_kinds("effects"), many=True
    )

    def needs(self) -> Mapping[str, str]:
        """The input channel that says when its readings count."""
        return {} if self.gate is None else {self.gate: ANY}

    seen: Place | str | None = None
    """What it reads instead of what it `measures`."""

    @property
    def exchanged(self) -> str:
        """The sensor whose place it says to read instead of its own; nothing where it reads its own."""
        return next((effect.exchanges for effect in self.effects if effect.exchanges), "")

    def resolve(self, machine: MachineLike) -> Self:
        """With what it really reads, where it is exchanged with another or another with it, and the numbers that its
        effects take from other channels."""
        whom = self.exchanged or machine.exchanged_by.get(self.name, "")
        partner = machine.sensors.get(whom) if whom else None
        pairs = ((effect, self.find_followed(machine, effect)) for effect in self.effects)
        effects = tuple(effect if other is None else effect.take(other) for effect, other in pairs)
        return self.replaced(seen=None if partner is None else partner.measures, effects=effects)

    @staticmethod
    def find_followed(machine: MachineLike, effect: SensorEffect) -> Any:
        """The effect whose numbers one takes; None where it has its own, or there is none."""
        if not effect.follows or effect.follows not in machine.sensors:
            return None
        own = (other for other in machine.sensors[effect.follows].effects if not other.follows)
        return next((other for other in own if other.kind == effect.kind), None)

    @property
    def place(self) -> Place | None:
        reads = self.seen or self.measures
        return reads if isinstance(reads, Place) else None

    @property
    def axis(self) -> str | None:
        return None if self.place else axis_of(str(self.seen or self.measures))

    @property
    def quantity(self) -> str:
        if isinstance(self.measures, Place):
            return "temperature"
        return "angle" if axis_of(str(self.measures)) in ANGULAR_AXES else "displacement"

    @property
    def unit(self) -> str:
        """The unit its channel is shown in."""
        return {"temperature": "degC", "displacement": "um", "angle": "urad"}[self.quantity]

    @property
    def noise_unit(self) -> str:
        return NOISE_UNITS[self.quantity]

    @property
    def sigma(self) -> float:
        """1σ of one sample, in SI."""
        return self.noise.value

    def faults(self) -> Iterator[Advice]:
        yield from self._faults_of_noise()
        if self.zero and self.place:
            yield "zero", "a temperature is not zeroed at the start", "drop `zero`, it is for displacements"
        if self.axis is not None and self.axis not in AXES:
            yield "measures", f"there is no axis '{short(self.axis)}'", "the axes are " + ", ".join(AXES)
        yield from self._faults_of_effects()

    def _faults_of_noise(self) -> Iterator[Advice]:
        given, most = unit(self.noise_unit), MOST_NOISE[self.quantity]
        if unit(self.noise.unit).dimension != given.dimension:
            wrong = f"noise '{self.noise}' is not the noise of a {self.quantity}"
            yield "noise", wrong, f"give it in {self.noise_unit}, as in 0.05 {self.noise_unit}"
        elif not LEAST_NOISE <= self.sigma / given.scale <= most:
            wrong = f"noise '{self.noise}' is no noise that a {self.quantity} is measured with"
            yield "noise", wrong, f"give 1σ of one sample, from {LEAST_NOISE:g} to {most:g} {self.noise_unit}"

    def _faults_of_effects(self) -> Iterator[Advice]:
        before = ""
        for effect in self.effects:
            if self.quantity not in effect.quantities:
                wrong = f"{effect.kind} does not act on what measures {self.measures}"
                yield "effects", wrong, "it acts on " + " or ".join(f"a {name}" for name in effect.quantities)
            if before and effect.has_state:
                yield "effects", f"{effect.kind} stands behind {before}", f"list {effect.kind} first"
            before = before or ("" if effect.is_steady else effect.kind)
