"""The gantry mill of the heat-quantity method as the truth of the flagship: a motorised spindle, a head and a beam.

Steel and shop are those of the publication (7850 kg/m³, 477 J/(kg K), 1.13e-5 1/K; 21.4 to 21.8 °C); sizes, losses and
joints are typical of such a mill. The spindle stretches along z, the beam along y.
"""

from __future__ import annotations

from proof.layout import Growth, Heat, Joint, Layout, Material, Part, bearing

FLAGSHIP = Layout(
    name="flagship",
    title="Gantry mill of the heat-quantity method, its coolant taken as constant",
    reference=21.6,
    top_speed=10_000.0,
    materials={
        "spindle_steel": Material(7850, 477, 50.66, 1.13e-5),
        "core_sheet": Material(7650, 460, 24, 1.2e-5),
        "beam_iron": Material(7200, 500, 48, 1.08e-5),
    },
    parts={
        "shaft": Part("spindle_steel", 0.70, 52e-4, 3600.0, turns=True),
        "stator": Part("core_sheet", 0.20, 130e-4),
        "housing": Part("spindle_steel", 0.62, 330e-4),
        "head": Part("beam_iron", 0.50, 720e-4),
        "beam": Part("beam_iron", 3.00, 980e-4),
    },
    held={"ambient": None, "coolant": 21.0},
    joints={
        "front bearings": Joint("shaft@0.1..0.22", "housing@0.05..0.2", 30.0),
        "rear bearing": Joint("shaft@0.82..0.88", "housing@0.85..0.93", 11.0),
        "air gap": Joint("shaft@0.38..0.64", "stator", 7.0),
        "stator seat": Joint("stator", "housing@0.36..0.66", 95.0),
        "coolant jacket": Joint("housing@0.03..0.75", "coolant", 80.0, "convection"),
        "flange": Joint("housing@0.5..0.75", "head@0..0.55", 45.0),
        "guideway": Joint("head@0.7..1", "beam@0.3..0.5", 16.0),
        "nose skin": Joint("shaft@0..0.1", "ambient", 1.5, "convection"),
        "housing skin": Joint("housing@0..0.4", "ambient", 3.0, "convection"),
        "head skin": Joint("head", "ambient", 11.0, "convection"),
        "beam skin": Joint("beam", "ambient", 46.0, "convection"),
    },
    heats={
        "front friction": bearing("shaft@0.1..0.22", "housing@0.05..0.2", 0.16),
        "rear friction": bearing("shaft@0.82..0.88", "housing@0.85..0.93", 0.06),
        "motor loss": Heat("motor_loss", {"stator": 1.0}, {"copper": 80.0, "iron": 330.0}),
    },
    growths={
        "housing grows": Growth("z", "housing@0..0.65", 0.403, 1),
        "nose grows": Growth("z", "shaft@0..0.16", 0.112, 1),
        "beam grows": Growth("y", "beam@0..0.4", 1.200, -1),
        "head grows": Growth("y", "head@0.3..0.7", 0.200, -1),
    },
    sensors={
        "T_stator": "stator@0.4..0.6",
        "T_housing": "housing@0.2..0.5",
        "T_head": "head@0.4..0.6",
        "T_beam": "beam@0.3..0.5",
        "dz": "tcp.z",
        "dy": "tcp.y",
    },
    sites={},
)
