from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, cast

from network.catalogue.declaration.declare import Array, typical_body
from network.catalogue.declaration.field import REQUIRED
from network.catalogue.declaration.fields import word
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.many_units import ManyUnitsField
from network.catalogue.declaration.proposals import Runs
from network.catalogue.mechanisms.mechanism import Inputs
from network.catalogue.sensors.base import SensorEffect
from network.catalogue.typical_values import list_full_inputs
from network.platform.quantities.units import unit

KELVIN = unit("K").dimension


class ShareField(ManyUnitsField):
    """Kelvin per unit of an input: K/%, K/W, K/(m/min); K alone for an input without a unit."""

    def takes(self, unit_text: str) -> bool:
        over, _, under = unit_text.partition("/")
        return unit(over.strip()).dimension == KELVIN and (not under or bool(unit(input_unit(unit_text))))

    @property
    def example(self) -> str:
        return ", in K per unit of the input, like 0.03 K/%"

    @property
    def sample(self) -> Any:
        return "0.03 K/%"


def input_unit(unit_text: str) -> str:
    """What stands under the line: 'm/min' of 'K/(m/min)'."""
    return unit_text.partition("/")[2].strip().removeprefix("(").removesuffix(")") or "1"


class SensorCrosstalk(SensorEffect, kind="sensor_crosstalk"):
    """An input shifts the reading at once: reading = truth + share · u, u the value of the input.

    A heater's current in the wires of its own or the next sensor, a drive's field in a thermocouple, a supply that sags
    under load. No heat and no delay, which tells it from a source near the sensor. `share` comes in kelvin per unit of
    the input, K/% or K/W; linear, so valid where the input stays within what was recorded. Source: common impedance
    and inductive coupling (Ott, Electromagnetic Compatibility Engineering, ch. 2; unverified).
    """

    quantities = ("temperature",)
    driver = word("the name of the input that shifts it", key="with")
    share = cast(Array, ShareField("K/%", -100, 100, "what it reads too much per unit of the input", REQUIRED,
                                   typical=0.03))  # fmt: skip
    strength = "share"
    is_steady = False
    sentence = "{channel} reads {share} of {driver} too much"

    def needs(self) -> Mapping[str, str]:
        return {self.driver: input_unit(getattr(self.field_of("share"), "unit", "K/%"))}

    def reading(self, truth: Array, state: Array, u: Inputs) -> Array:
        return truth + self.share * u[self.driver]

    def truth(self, reading: Array, u: Inputs) -> Array:
        return reading - self.share * u[self.driver]

    @classmethod
    def proposes(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        return cls.proposes_on(machine, Runs())

    @classmethod
    def proposes_on(cls, machine: MachineLike, runs: Runs) -> Iterator[Mapping[str, Any]]:
        """On every channel that measures a temperature, by every input that is none: a kelvin at its full value, more
        or less. Along an input that never changes it is a constant error."""
        full = {name: most for name, most in list_full_inputs(machine).items() if name not in runs.steady}
        for name, sensor in machine.sensors.items():
            taken = {e.to_plain().get("with") for e in sensor.effects if e.kind == cls.kind}
            for driver, (value, unit_text) in full.items() if sensor.place is not None else ():
                for sign in (1, -1) if driver not in taken else ():
                    under = f"({unit_text})" if "/" in unit_text or " " in unit_text else unit_text
                    share = f"{sign / value:.3g} K/{under}" if under != "1" else f"{sign / value:.3g} K"
                    yield {"sensors": {name: cls.put_on(sensor, typical_body(cls, share=share, **{"with": driver}))}}
