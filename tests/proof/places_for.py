"""Where effects could be concealed in a machine, found from what it is made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations
from typing import Any

from numpy.random import Generator

from proof.layout import Layout, split


def sites_of(rng: Generator, layout: Layout) -> Mapping[str, tuple[Any, ...]]:
    """Sites by the name of the effect; those with none are left out."""
    still = [name for name in layout.parts if name != "shaft"]
    warm = [split(place)[0] for place in layout.sensors.values() if not place.startswith("tcp.")]
    sensed = [name for name in still if name in warm]
    thermometers = [name for name, place in layout.sensors.items() if split(place)[0] in sensed]
    axes = sorted({growth.axis for growth in layout.growths.values()})
    skins = [n for n, j in layout.joints.items() if j.kind == "convection" and j.b == "ambient" and split(j.a)[0] in still]
    sites: dict[str, tuple[Any, ...]] = {
        "source": tuple(shuffled(rng, still)[:6]),
        "path": tuple(shuffled(rng, pairs_apart(layout, still))[:8]),
        "fan": tuple(skins[:8]),
        "windage": ("shaft",),
        "viscous": ("front friction", "rear friction"),
        "tank": tuple(name for name, T in layout.held.items() if T is not None),
        "cooler": tuple(sensed),
        "mass": tuple(sensed),
        "floor": tuple(still),
        "tilt": tuple((axis, *pair) for axis in axes for pair in shuffled(rng, list(combinations(sensed, 2)))[:3]),
        "spin": tuple(axes),
        "lag": tuple(thermometers),
        "loose": tuple(thermometers),
        "wash": tuple(shuffled(rng, still)[:6]),
        "run-in": tuple(sensed),
    }
    return {name: where for name, where in sites.items() if where}


def usual_sites(rng: Generator, layout: Layout) -> Layout:
    """The machine with the sites that every machine has, beside its own."""
    joints, axes = layout.joints, [growth.axis for growth in layout.growths.values()]
    plain = [name for name, joint in joints.items() if joint.kind == "conduction"]
    thermometers = [name for name, place in layout.sensors.items() if split(place)[0] in layout.parts]
    sites: dict[str, tuple[Any, ...]] = {
        "forgotten": tuple((name, joints[name]) for name in plain if is_spare(layout, name)),
        "growth": tuple(pair for pair in layout.growths.items() if axes.count(pair[1].axis) > 1),
        "link": tuple(plain),
        "swap": tuple(shuffled(rng, list(combinations(thermometers, 2)))[:6]),
        "clock": ("schedule",),
        "room": ("ambient",),
    }
    return replace(layout, sites={name: where for name, where in sites.items() if where} | dict(layout.sites))


def is_spare(layout: Layout, name: str) -> bool:
    """Whether both ends of a joint stay joined to something without it."""
    rest = [joint for other, joint in layout.joints.items() if other != name]
    ends = {split(end)[0] for joint in rest for end in (joint.a, joint.b)}
    return {split(layout.joints[name].a)[0], split(layout.joints[name].b)[0]} <= ends


def shuffled(rng: Generator, items: list[Any]) -> list[Any]:
    return [items[int(i)] for i in rng.permutation(len(items))]


def pairs_apart(layout: Layout, names: list[str]) -> list[tuple[str, str]]:
    """Pairs of parts that nothing joins."""
    joined = {frozenset((split(joint.a)[0], split(joint.b)[0])) for joint in layout.joints.values()}
    return [pair for pair in combinations(names, 2) if frozenset(pair) not in joined]
