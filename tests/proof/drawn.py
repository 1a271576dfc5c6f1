"""Cheap innocents: small machines whose true numbers are drawn from just the priors that their file states.

One lump for each part, white noise, speed edges on samples, every run from the reference. Nothing is wrong but the
numbers, so intervals of 95 % have to hold the truth in 95 of 100 cases.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator

from proof.assembly import assemble
from proof.layout import Growth, Heat, Joint, Layout, Material, Part, bearing
from proof.observing import Recording, observe, record
from proof.programs import SAMPLE, Program, ladder
from proof.system import Array
from proof.written import machine_text

IRON = Material(7200, 500, 48, 1.08e-5)
STEEL = Material(7850, 477, 50, 1.13e-5)
FINE_STEP = 2.5
"""s: steps of the truth, which leave some 10 µK."""


@dataclass(frozen=True)
class Drawn:
    """A machine file, the true values of its uncertain numbers in SI by their path in it, and recordings."""

    machine: str
    true: dict[str, float]
    recordings: tuple[Recording, ...]

    @property
    def arrays(self) -> tuple[dict[str, Array], ...]:
        return tuple(dict(recording.columns) for recording in self.recordings)


def drawn_machine(rng: Generator, runs: int = 2, hours: float = 3.0) -> Drawn:
    """A machine of 3 or 4 parts and 8 to 12 uncertain numbers, with recordings of what it really did."""
    layout = shape(rng)
    true = {path: value * float(np.exp(s * rng.standard_normal())) for path, value, s in layout.uncertain()}
    speeds, air = np.array([2000.0, 3500, 5000, 6500]), 22 + rng.uniform(-0.6, 0.6, runs)
    programs = [snapped(ladder(rng, hours * 3600, speeds, float(mean))) for mean in air]
    build = assemble(layout, true)
    recordings = []
    for program in programs:
        times = program.times()
        shown = observe(build, program, {}, times, FINE_STEP)
        recordings.append(record(rng, program, times, shown, layout.channels()))
    return Drawn(machine_text(layout, layout.nominal()), true, tuple(recordings))


def snapped(program: Program) -> Program:
    """The same program with every edge on a sample, and air that stands still at what a file can tell."""
    edges = tuple(SAMPLE * round(edge / SAMPLE) for edge in program.edges)
    return replace(program, edges=edges, mean=round(program.mean, 2), waves=())


def shape(rng: Generator) -> Layout:
    """A shaft in a housing on one or two further parts, with nominal values as a drawing would give them."""

    def near(value: float) -> float:
        return float(f"{value * np.exp(rng.uniform(-0.4, 0.4)):.3g}")

    parts = {
        "shaft": Part("steel", near(0.5), near(45e-4), turns=True),
        "housing": Part("steel", near(0.5), near(180e-4)),
        "slide": Part("iron", near(0.6), near(450e-4)),
    }
    joints = {
        "bearing": Joint("shaft@0.1..0.3", "housing@0.1..0.3", near(35)),
        "bolts": Joint("housing", "slide@0..0.5", near(50)),
        "housing skin": Joint("housing", "ambient", near(6), "convection"),
        "slide skin": Joint("slide", "ambient", near(9), "convection"),
        "shaft skin": Joint("shaft@0..0.1", "ambient", near(2), "convection"),
    }
    if rng.random() < 0.5:
        parts["frame"] = Part("iron", near(1.5), near(700e-4))
        joints["ways"] = Joint("slide", "frame@0.3..0.6", near(40))
        joints["frame skin"] = Joint("frame", "ambient", near(20), "convection")
    heats = {
        "friction": bearing("shaft@0.1..0.3", "housing@0.1..0.3", near(0.3)),
        "motor loss": Heat("motor_loss", {"housing": 1.0}, {"copper": near(60), "iron": near(150)}),
    }
    if rng.random() < 0.4:
        heats["pump"] = Heat("heat_source", {"slide": 1.0}, {"power": near(60)})
    return layout_of(parts, joints, heats)


def layout_of(parts: dict[str, Part], joints: dict[str, Joint], heats: dict[str, Heat]) -> Layout:
    """A sensor on every part but now and then the shaft, and one axis that housing and slide move."""
    growths = {
        "housing grows": Growth("z", "housing@0..0.6", round(0.6 * parts["housing"].length, 4), -1),
        "slide grows": Growth("z", "slide@0..0.5", round(0.5 * parts["slide"].length, 4), 1),
    }
    sensors = {f"T_{name}": name for name in parts if name != "shaft"} | {"dz": "tcp.z"}
    materials = {"steel": STEEL, "iron": IRON}
    held = {"ambient": None}
    title = "Spindle on a slide"
    return Layout("drawn", title, 22.0, 6500.0, materials, parts, held, joints, heats, growths, sensors, {})
