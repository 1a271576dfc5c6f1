"""Machines that nobody drew: parts from 3 to 40 joined at random, heated until they are as warm as machines are.

What they hold beside joints and still air is drawn as well: radiation, buoyancy, a fan on the spindle, a coolant loop
with a pump and a chiller of its own, seats that keep no heat, axes that heat as they move.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.random import Generator

from proof.layout import Cooler, Growth, Heat, Joint, Layout, Material, Part, Stream, bearing
from proof.places_for import sites_of
from proof.warming import warmed

MATERIALS = {
    "spindle_steel": Material(7820, 472, 43, 1.15e-5),
    "winding_sheet": Material(7650, 458, 22, 1.2e-5),
    "frame_iron": Material(7200, 502, 47, 1.08e-5),
}
NAMES = (
    "bed", "headstock", "column", "table", "saddle", "ram", "slide", "bridge", "carriage", "crossbeam", "turret",
    "tailstock", "gearbox", "base", "pedestal", "cabinet", "pallet", "rotary table", "workhead", "guide block",
    "screw bearing", "nut housing", "rail", "magazine", "arm", "yoke", "foot", "cover", "bracket", "lower frame",
    "upper frame", "left wall", "right wall", "rear wall", "drive housing", "counterweight", "steady rest",
)  # fmt: skip
FEATURES = ("radiation", "buoyancy", "fan", "loop", "seat", "feed")
BENT = ("radiation", "buoyancy")
"""Features with which a machine is no longer linear."""
WARM = (7.0, 22.0)
"""K over the reference that the warmest part reaches at three quarters of the top speed."""


@dataclass
class Sketch:
    """A machine while it is drawn."""

    rng: Generator
    parts: dict[str, Part] = field(default_factory=dict)
    joints: dict[str, Joint] = field(default_factory=dict)
    heats: dict[str, Heat] = field(default_factory=dict)
    vessels: dict[str, float] = field(default_factory=dict)
    seats: list[str] = field(default_factory=list)
    streams: dict[str, Stream] = field(default_factory=dict)
    coolers: dict[str, Cooler] = field(default_factory=dict)
    held: dict[str, float | None] = field(default_factory=lambda: {"ambient": None})

    def near(self, value: float, spread: float = 0.4) -> float:
        return float(f"{value * np.exp(self.rng.uniform(-spread, spread)):.3g}")

    def range_of(self, name: str) -> str:
        """A stretch of a part, a fifth of it at the least, or all of it."""
        if self.rng.random() < 0.4:
            return name
        a = float(self.rng.uniform(0, 0.7))
        return f"{name}@{a:.2g}..{min(1.0, a + float(self.rng.uniform(0.2, 0.5))):.2g}"


def scattered(rng: Generator, parts: int, features: tuple[str, ...]) -> Layout:
    """A machine of so many parts that has some of the FEATURES."""
    sketch, reference = Sketch(rng), float(rng.choice([20.0, 21.0, 22.0]))
    draw_spindle(sketch)
    names = [NAMES[i] for i in rng.permutation(len(NAMES))] + [f"module {i}" for i in range(parts)]
    for name in names:
        if len(sketch.parts) < parts:
            draw_part(sketch, name)
    draw_loops(sketch)
    draw_skins(sketch, features)
    if "loop" in features:
        draw_coolant(sketch, reference)
    if "seat" in features:
        draw_seat(sketch)
    draw_heats(sketch, "feed" in features)
    layout = finish(sketch, reference, f"scattered-{parts}{''.join(f'+{name}' for name in features)}")
    return replace(warmed(layout, float(rng.uniform(*WARM))), sites=sites_of(rng, layout))


def draw_spindle(sketch: Sketch) -> None:
    """A shaft in a housing; most have a motor of their own."""
    near = sketch.near
    sketch.parts["shaft"] = Part("spindle_steel", near(0.55, 0.3), near(50e-4), near(3500.0), turns=True)
    sketch.parts["housing"] = Part("frame_iron", near(0.55, 0.3), near(300e-4))
    sketch.joints["front bearing"] = Joint("shaft@0.1..0.25", "housing@0.05..0.25", near(38))
    sketch.joints["rear bearing"] = Joint("shaft@0.75..0.88", "housing@0.75..0.9", near(20))
    sketch.heats["front friction"] = bearing("shaft@0.1..0.25", "housing@0.05..0.25", near(0.5))
    sketch.heats["rear friction"] = bearing("shaft@0.75..0.88", "housing@0.75..0.9", near(0.25))


def draw_part(sketch: Sketch, name: str) -> None:
    """A part that sits on one of those that are there, the motor first."""
    rng, near = sketch.rng, sketch.near
    if "motor" not in sketch.parts and len(sketch.parts) == 2 and rng.random() < 0.7:
        sketch.parts["motor"] = Part("winding_sheet", near(0.24, 0.2), near(160e-4))
        sketch.joints["motor seat"] = Joint("motor", "housing@0.6..0.95", near(35))
        sketch.joints["motor coupling"] = Joint("motor", "shaft@0.9..1", near(5))
        return
    able = [other for other in sketch.parts if other not in ("shaft", "motor")]
    on = able[int(rng.integers(len(able)))]
    sketch.parts[name] = Part("frame_iron", near(0.8, 0.6), near(480e-4, 0.6))
    sketch.joints[f"{on} to {name}"] = Joint(sketch.range_of(on), sketch.range_of(name), near(40, 0.7))


def draw_loops(sketch: Sketch) -> None:
    """Now and then parts meet a second time."""
    able = [name for name in sketch.parts if name not in ("shaft", "motor")]
    for a, b in zip(able, able[2:], strict=False):
        if sketch.rng.random() < 0.15 and not joined(sketch.joints, a, b):
            sketch.joints[f"{a} on {b}"] = Joint(sketch.range_of(a), sketch.range_of(b), sketch.near(20, 0.6))


def joined(joints: dict[str, Joint], a: str, b: str) -> bool:
    return any({joint.a.partition("@")[0], joint.b.partition("@")[0]} == {a, b} for joint in joints.values())


def draw_skins(sketch: Sketch, features: tuple[str, ...]) -> None:
    """Still air around nearly every part; some skins radiate, some follow buoyancy, that of the shaft its speed."""
    rng = sketch.rng
    for name, part in sketch.parts.items():
        if name == "shaft":
            skin = Joint("shaft@0..0.12", "ambient", sketch.near(3), "convection")
            fan = replace(skin, kind="forced_convection", more={"gain": sketch.near(3)})
            sketch.joints["nose skin"] = fan if "fan" in features else skin
            continue
        surface = 4 * np.sqrt(part.area) * part.length
        if rng.random() < 0.12 and name != "housing":
            continue
        still = Joint(name, "ambient", float(f"{7 * surface * np.exp(rng.uniform(-0.5, 0.5)):.3g}"), "convection")
        sketch.joints[f"{name} skin"] = still
        if "buoyancy" in features and rng.random() < 0.4:
            coefficient = float(f"{still.conductance / surface / 1.8:.3g}")
            law = {"area": float(f"{surface:.3g}")}
            sketch.joints[f"{name} skin"] = Joint(name, "ambient", coefficient, "natural_convection", law)
        if "radiation" in features and rng.random() < 0.5:
            area = float(f"{surface * rng.uniform(0.5, 0.95):.3g}")
            sketch.joints[f"{name} radiates"] = Joint(name, "ambient", area, "radiation")


def draw_coolant(sketch: Sketch, reference: float) -> None:
    """A tank with a chiller that switches, and a pump that sends its coolant through a jacket; or plain cold water."""
    rng, near = sketch.rng, sketch.near
    if rng.random() < 0.5:
        sketch.held["water"] = round(reference - float(rng.uniform(0.5, 2)), 1)
        sketch.joints["water jacket"] = Joint("housing@0.1..0.8", "water", near(40), "convection")
        return
    sketch.vessels |= {"tank": near(90e3), "jacket": near(6e3)}
    sketch.joints["coolant jacket"] = Joint("housing@0.1..0.8", "jacket", near(45), "convection")
    sketch.joints["tank skin"] = Joint("tank", "ambient", near(5), "convection")
    sketch.streams["coolant loop"] = Stream(("tank", "jacket", "tank"), near(420))
    set_at, half = reference + float(rng.uniform(-0.6, 0.4)), float(rng.uniform(0.4, 0.9))
    sketch.coolers["chiller"] = Cooler("tank", near(1100), round(set_at, 1), round(half, 2))
    sketch.heats["pump"] = Heat("heat_source", {"tank": 1.0}, {"power": near(80)})


def draw_seat(sketch: Sketch) -> None:
    """A joint goes through a flange that keeps no heat; a film or another part meets it there."""
    fixed = ("front bearing", "rear bearing", "motor coupling")
    able = [name for name, joint in sketch.joints.items() if joint.kind == "conduction" and name not in fixed]
    if not able:
        return
    name = able[int(sketch.rng.integers(len(able)))]
    joint = sketch.joints.pop(name)
    sketch.seats.append("flange")
    sketch.joints[f"{name} upper"] = Joint(joint.a, "flange", sketch.near(2 * joint.conductance, 0.2))
    sketch.joints[f"{name} lower"] = Joint("flange", joint.b, sketch.near(2 * joint.conductance, 0.2))
    sketch.joints["flange skin"] = Joint("flange", "ambient", sketch.near(3), "convection")


def draw_heats(sketch: Sketch, feeds: bool) -> None:
    """The motor, a pump or a cabinet that is always on, and screws or guides under the axes."""
    rng, near = sketch.rng, sketch.near
    into = "motor" if "motor" in sketch.parts else "housing@0.3..0.7"
    sketch.heats["motor loss"] = Heat("motor_loss", {into: 1.0}, {"copper": near(70), "iron": near(190)})
    others = [name for name in sketch.parts if name not in ("shaft", "housing", "motor")]
    if others and rng.random() < 0.5:
        at = others[int(rng.integers(len(others)))]
        sketch.heats["drive cabinet"] = Heat("heat_source", {at: 1.0}, {"power": near(60)})
    for i, at in enumerate(rng.permutation(others)[: 1 + len(others) // 8] if feeds else ()):
        kind = ("screw_friction", "guide_friction")[i % 2]
        sketch.heats[f"axis {i + 1} friction"] = Heat(kind, {str(at): 1.0}, {"power_per_feed": near(9)})


def finish(sketch: Sketch, reference: float, name: str) -> Layout:
    """Sensors on most parts that stand still, and one or two axes that they move."""
    sensors, rng = sensed(sketch), sketch.rng
    growths = dict(grown(sketch, ("z",) if rng.random() < 0.4 else ("z", "x")))
    axes = dict.fromkeys(growth.axis for growth in growths.values())
    return Layout(
        name=name.partition("+")[0], title=f"Machine tool of {len(sketch.parts)} parts", reference=reference,
        top_speed=float(rng.choice([4000.0, 6000.0, 8000.0, 12_000.0])), materials=MATERIALS, parts=sketch.parts,
        held=sketch.held, joints=sketch.joints, heats=sketch.heats, growths=growths,
        sensors={**sensors, **{f"d{axis}": f"tcp.{axis}" for axis in axes}}, sites={}, zeroed=bool(rng.random() < 0.3),
        vessels=sketch.vessels, seats=tuple(sketch.seats), streams=sketch.streams, coolers=sketch.coolers,
    )  # fmt: skip


def sensed(sketch: Sketch) -> dict[str, str]:
    """Two sensors at the least, a dozen at the most."""
    rng = sketch.rng
    able = [name for name in sketch.parts if name != "shaft"]
    share = rng.uniform(0.5, 0.95)
    chosen = [name for i, name in enumerate(able) if i < 2 or rng.random() < share][:12]
    starts = {name: float(rng.uniform(0.05, 0.7)) for name in chosen}
    sensors = {f"T_{name.replace(' ', '_')}": f"{name}@{a:.2g}..{a + 0.15:.2g}" for name, a in starts.items()}
    return sensors | ({"T_tank": "tank"} if "tank" in sketch.vessels and rng.random() < 0.6 else {})


def grown(sketch: Sketch, axes: tuple[str, ...]) -> Iterator[tuple[str, Growth]]:
    """Two to four parts move each axis, the spindle's z among them."""
    rng = sketch.rng
    able = [name for name in sketch.parts if name not in ("shaft", "motor")]
    for axis in axes:
        some = [str(name) for name in rng.permutation(able)[: int(rng.integers(2, 5))]]
        for name in (*some, *(("shaft",) if axis == "z" and rng.random() < 0.6 else ())):
            a = float(rng.uniform(0, 0.4))
            b = a + float(rng.uniform(0.3, 0.6))
            length = round((b - a) * sketch.parts[name].length, 3)
            growth = Growth(axis, f"{name}@{a:.2g}..{b:.2g}", length, int(rng.choice([-1, 1])))
            yield f"{name} grows along {axis}", growth
