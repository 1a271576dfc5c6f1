"""A machine heated until it is as warm as machines are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from proof.assembly import assemble
from proof.layout import Joint, Layout


def warmed(layout: Layout, rise: float) -> Layout:
    """The same machine with its heats such that its warmest part settles so much [K] over the reference."""
    build = assemble(layout, layout.nominal())
    build.held["ambient"] = layout.reference
    system, rpm = build.freeze(), 0.75 * layout.top_speed
    feed = 8.0 if layout.feeds else 0.0
    bent = 6.0 * sum((build.dense(build.at(j.a)) * area_of(j) for j in layout.joints.values()), np.zeros_like(system.C))
    L = system.conductance(rpm, (False,) * len(system.relays)) + np.diag(np.asarray(bent))
    heat = sum((loss.into * loss.power(rpm) for loss in system.losses), np.zeros_like(system.C))
    heat = heat + sum((loss.into * loss.power(feed) for loss in system.fed), np.zeros_like(system.C))
    for cooler in layout.coolers.values():
        L = L + np.diag(500.0 * build.dense(build.at(cooler.at)))
    factor = rise / max(float(np.linalg.solve(L, heat).max()), 1e-3)
    heats = {
        name: heat if name == "pump" else replace(heat, numbers=scaled(heat.numbers, factor))
        for name, heat in layout.heats.items()
    }
    return replace(layout, heats=heats)


def area_of(joint: Joint) -> float:
    """Area [m²] over which a joint that is no straight line gives heat off, roughly; 0 for those that are."""
    return {"radiation": joint.conductance, "natural_convection": joint.more.get("area", 0.0)}.get(joint.kind, 0.0)


def scaled(numbers: Mapping[str, float], factor: float) -> dict[str, float]:
    return {name: float(f"{value * factor:.3g}") for name, value in numbers.items()}
