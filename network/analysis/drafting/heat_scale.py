"""Heat capacities, conductances and powers from lags and gains, which tell their ratios only.

A fit gives τ = C/ΣG, shares w = G/ΣG and gains g = P/ΣG. A recorded power in W makes ΣG = P/g of it; any other input is
given a usual heat at its largest value, and all heats, conductances and capacities of what hangs together may be off by
the same factor. What follows a part is seen in that part's own fit: of its heat it takes G (1 − w), of its heat
capacity it is w C. How large it is, is not told, so it is given half of both, and no
larger heat capacity than the other.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from network.analysis.drafting.identification import Identified
from network.analysis.drafting.lag_bench import ALWAYS, AROUND, OTHER
from network.analysis.drafting.part_models import PartModel
from network.catalogue.mechanisms.bearing_friction import BearingFriction
from network.catalogue.mechanisms.guide_friction import GuideFriction
from network.catalogue.mechanisms.heat_source import HeatSource
from network.catalogue.typical_values import USUAL_LOSS
from network.platform.quantities.units import unit

POWER = unit("W").dimension
MOST, LEAST = 0.5, 0.1
"""Of a part's conductance and heat capacity: the most that one which follows it takes, and the least that is left."""


@dataclass(frozen=True)
class Sizes:
    """One part. capacity [J/K]; behind: heat capacity of a part behind it and conductance to that [J/K, W/K], or None;
    around: conductance to the surroundings [W/K]; to_parent: to the part it follows, None without; to_held: to
    temperatures that are held, by name; heats: by input and ALWAYS, at its largest value [W]; is_known: whether a power
    in W told them."""

    capacity: float
    behind: tuple[float, float] | None
    around: float
    to_parent: float | None
    to_held: Mapping[str, float]
    heats: Mapping[str, float]
    is_known: bool


def size_parts(found: Identified) -> tuple[Sizes, ...]:
    """Of every part."""
    whole, known = list[float](), list[bool]()
    for model in found.models:
        own = _from_powers(found, model)
        known.append(own is not None or (model.parent is not None and known[model.parent]))
        whole.append(own or _from_usual(found, model, whole))
    return tuple(_sizes(found, k, whole, is_known) for k, is_known in enumerate(known))


def _from_powers(found: Identified, model: PartModel) -> float | None:
    """ΣG by the recorded power that heats it most, which parts that follow no other share alike; parts that follow one
    have no share in a power that heats such a part."""
    told = list[float]()
    for name, gain in model.fit.weights.items():
        if name in found.largest and _kind(found, name) == POWER:
            heated = [m for m in found.models if name in m.fit.weights]
            roots = [m for m in heated if m.parent is None] or heated
            if model in roots:
                told.append(1 / len(roots) / abs(gain))
    return min(told, default=None)


def _from_usual(found: Identified, model: PartModel, before: Sequence[float]) -> float:
    fit = model.fit
    if model.parent is not None:
        parent = found.models[model.parent].fit
        share = min(max(fit.weights.get(OTHER, 1.0), 1e-3), 1.0)
        capacity = before[model.parent] * parent.tau
        by_heat = MOST * before[model.parent] / (share * max(1 - share, 1e-3))
        return min(capacity / fit.tau, MOST * capacity / share / fit.tau, by_heat)
    heats = (*found.roles.inputs, ALWAYS)
    rises = {name: abs(_heat(found, name, g)) for name, g in fit.weights.items() if name in heats}
    if not rises or max(rises.values()) == 0:
        return USUAL_LOSS / len(found.models)
    name = max(rises, key=lambda n: rises[n])
    return usual_heat(found.units.get(name, "W"), found.largest.get(name, 1.0)) / rises[name]


def _kind(found: Identified, name: str) -> str:
    return unit(found.units[name]).dimension


def usual_heat(unit_text: str, largest: float) -> float:
    """What such an input usually gives at that value [W]."""
    dimension = unit(unit_text).dimension
    if dimension == unit("rpm").dimension:
        return BearingFriction.params()["torque"].proposal() * largest
    if dimension == unit("m/min").dimension:
        return GuideFriction.params()["power_per_feed"].proposal() * largest
    return HeatSource.params()["power"].proposal()


def _sizes(found: Identified, k: int, every: Sequence[float], is_known: bool) -> Sizes:
    model, whole = found.models[k], every[k]
    fit, weights = model.fit, model.fit.weights
    after = [(m.fit, every[j]) for j, m in enumerate(found.models) if m.parent == k]
    taken = sum(other.weights.get(OTHER, 0.0) * (1 - other.weights.get(OTHER, 0.0)) * G for other, G in after)
    held_by = sum(other.weights.get(OTHER, 0.0) * other.tau * G for other, G in after)
    around = max(weights.get(AROUND, 0.0) * whole - taken, LEAST * whole)
    capacity, behind = fit.tau * whole, None
    if fit.lags and fit.lags.is_late:
        capacity = fit.lags.long * whole
    elif fit.lags:
        capacity = fit.lags.own * whole
        behind = fit.lags.behind * whole, fit.lags.behind * whole / fit.lags.zero
    heats = {
        name: _heat(found, name, g * whole) for name, g in weights.items() if name in (*found.roles.inputs, ALWAYS)
    }
    held = {name: weights[name] * whole for name in found.roles.held if name in weights}
    to_parent = weights[OTHER] * whole if OTHER in weights else None
    return Sizes(max(capacity - held_by, LEAST * capacity), behind, around, to_parent, held, heats, is_known)


def _heat(found: Identified, name: str, per_unit: float) -> float:
    """At the largest value of an input."""
    return per_unit * found.largest.get(name, 1.0) ** (2 if found.goes_squared(name) else 1)
