"""The contract every equation of the catalogue keeps: derivatives, arrays, signs, limits. Loops over the registry."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import TypeAlias

import numpy as np
import pytest
from catalogue import FLOWS, arguments, drawn, each_law, evaluated, names, own_arguments, surroundings

from network.catalogue.declaration.declare import Array, Effect
from network.catalogue.mechanisms.base import Link, Source, Stream
from network.catalogue.mechanisms.friction import Friction, Sliding
from network.catalogue.mechanisms.mechanism import Inputs, Mechanism, Relay
from network.catalogue.sensors.base import SensorEffect
from network.platform.quantities.units import unit

STEP = 1e-30
Args: TypeAlias = tuple[Array, ...]


def central(f: Callable[[float], Array], x: float, step: float) -> Array:
    """Fourth-order central difference."""
    return (8 * (f(x + step) - f(x - step)) - (f(x + 2 * step) - f(x - 2 * step))) / (12 * step)


@each_law
def test_slopes_are_the_derivatives(cls: type[Effect]) -> None:
    for seed, entry in enumerate(drawn(cls, 6)):
        if isinstance(entry, SensorEffect):
            continue
        u, x = surroundings(seed), arguments(entry, seed)
        slopes = entry.slopes(*x[:2], u, *x[2:]) if isinstance(entry, Link | Stream) else entry.slopes(u, *x)
        assert len(slopes) == len(x)
        for i, slope in enumerate(slopes):

            def along_x(v: float, entry: Effect = entry, u: Inputs = u, x: Args = x, i: int = i) -> Array:
                return evaluated(entry, u, *x[:i], np.array(v), *x[i + 1 :])

            step = 1e-3 * max(1.0, abs(float(x[i])))
            along = central(along_x, float(x[i]), step)
            scale = abs(evaluated(entry, u, *x)) / max(1.0, abs(float(x[i])))
            assert np.asarray(slope) == pytest.approx(along, rel=1e-6, abs=float(1e-7 * scale) + 1e-15)


@each_law
def test_a_complex_step_in_a_parameter_is_the_derivative(cls: type[Effect]) -> None:
    for seed, entry in enumerate(drawn(cls, 6)):
        u, x = surroundings(seed), arguments(entry, seed)
        for name, field in cls.params().items():
            value = getattr(entry, name)
            if value is None:
                continue

            def along_name(v: float, entry: Effect = entry, u: Inputs = u, x: Args = x, name: str = name) -> Array:
                return evaluated(entry.replaced(**{name: v}), u, *x)

            step = 1e-4 * max(abs(value), 1e-3 * (field.high - field.low) if value == 0 else 0.0)
            along = central(along_name, value, step)
            stepped = np.imag(evaluated(entry.replaced(**{name: value + STEP * 1j}), u, *x)) / STEP
            scale = abs(evaluated(entry, u, *x)) / max(abs(value), step)
            assert stepped == pytest.approx(along, rel=1e-6, abs=float(1e-7 * scale) + 1e-15), f"{cls.kind}.{name}"


@each_law
def test_a_complex_step_is_finite_at_rest_and_at_equal_temperatures(cls: type[Effect]) -> None:
    u = {**surroundings(1), "speed": np.array(0.0), "feed": np.array(0.0)}
    for entry in drawn(cls, 3):
        x = tuple(np.zeros_like(v) + 22.0 for v in arguments(entry, 1))
        for name in cls.params():
            if (value := getattr(entry, name)) is not None:
                assert np.isfinite(evaluated(entry.replaced(**{name: value + STEP * 1j}), u, *x)).all(), name


@each_law
def test_arrays_give_what_one_by_one_gives(cls: type[Effect]) -> None:
    if issubclass(cls, SensorEffect) and cls.looks_back:
        return
    factors = (1.0, 0.9, 1.07)
    for seed, entry in enumerate(drawn(cls, 3)):
        numbers = [n for n in (*cls.params(), *cls.derived) if getattr(entry, n) is not None]
        several = [entry.replaced(**{n: getattr(entry, n) * factor for n in numbers}) for factor in factors]
        stacked = type(entry).stack(several)
        xs = [arguments(entry, 10 * seed + k) for k in range(len(factors))]
        columns = tuple(np.array(column) for column in zip(*xs, strict=True))
        for instants in (1, 4):
            us = [surroundings(k) for k in range(instants)]
            u = {key: np.array([[v[key]] for v in us]) for key in us[0]}
            wide = tuple(np.ones((instants, 1)) * column for column in columns)
            together = evaluated(stacked, u, *wide) * np.ones((instants, len(factors)))
            apart = [[evaluated(e, v, *x) for e, x in zip(several, xs, strict=True)] for v in us]
            assert together == pytest.approx(np.array(apart, float), rel=1e-13)


@each_law
def test_affine_means_affine(cls: type[Effect]) -> None:
    """Second differences in random directions vanish if and only if the entry says it is affine."""
    if not issubclass(cls, Mechanism):
        return
    for seed, entry in enumerate(drawn(cls, 6)):
        rng, u, x = np.random.default_rng(seed), surroundings(seed), arguments(entry, seed)
        bends = []
        for _ in range(8):
            first, second = rng.uniform(-30, 30, (2, len(x)))
            steps = (0 * first, first, second, first + second)
            values = [evaluated(entry, u, *(v + d for v, d in zip(x, step, strict=True))) for step in steps]
            scale = max(float(np.abs(v).max()) for v in values) or 1.0
            bends.append(abs(float(values[0] - values[1] - values[2] + values[3])) / scale)
        assert (max(bends) < 1e-12) == entry.is_affine(), bends


@pytest.mark.parametrize("cls", [c for c in FLOWS if c.states], ids=names)
def test_states_have_a_unit_a_beginning_and_a_rate(cls: type[Mechanism]) -> None:
    for state in cls.states.values():
        assert unit(state.unit).scale == 1, "one of SI"
        assert len(state.meaning) > 3
    for seed, entry in enumerate(drawn(cls, 6)):
        u, own = surroundings(seed), own_arguments(entry, seed)
        assert len(entry.rate(u, *own)) == len(entry.begin(u, *own[: len(cls.places_read())])) == len(cls.states)
        for name, value in ((n, getattr(entry, n)) for n in cls.params()):
            if value is not None:
                stepped = entry.replaced(**{name: value + STEP * 1j}).rate(u, *own)
                assert np.isfinite(stepped).all(), name


@pytest.mark.parametrize("cls", [c for c in FLOWS if c.states], ids=names)
def test_rates_of_an_affine_entry_are_affine(cls: type[Mechanism]) -> None:
    for seed, entry in enumerate(drawn(cls, 6)):
        rng, u, own = np.random.default_rng(seed), surroundings(seed), own_arguments(entry, seed)
        first, second = rng.uniform(-1, 1, (2, len(own)))
        steps = (0 * first, first, second, first + second)
        a, b, c, d = (np.array(entry.rate(u, *(v + s for v, s in zip(own, step, strict=True)))) for step in steps)
        assert not entry.is_affine() or a - b - c + d == pytest.approx(np.zeros(len(a)), abs=1e-12 * np.abs(a).max())


@pytest.mark.parametrize("cls", [c for c in FLOWS if c.states or issubclass(c, Relay)], ids=names)
def test_rates_and_guards_of_many_are_those_of_each(cls: type[Mechanism]) -> None:
    entry = next(drawn(cls, 1))
    several = [entry, entry.replaced(**{n: 1.07 * getattr(entry, n) for n in cls.params() if getattr(entry, n)})]
    stacked, u = type(entry).stack(several), surroundings(3)
    wide = tuple(np.full(2, float(x)) for x in own_arguments(entry, 3))
    for i, one in enumerate(several):
        own = tuple(x[i] for x in wide)
        assert [float(r[i]) for r in stacked.rate(u, *wide)] == [float(r) for r in one.rate(u, *own)]
        if isinstance(one, Relay) and isinstance(stacked, Relay):
            for mode in (0.0, 1.0):
                assert stacked.guard(np.full(2, mode), u, *wide)[i] == one.guard(np.array(mode), u, *own)


@pytest.mark.parametrize("cls", [c for c in FLOWS if issubclass(c, Relay)], ids=names)
def test_a_relay_never_wants_to_leave_both_modes(cls: type[Relay]) -> None:
    for seed, entry in enumerate(drawn(cls, 6)):
        u, own = surroundings(seed), own_arguments(entry, seed)
        assert min(float(entry.guard(np.array(mode), u, *own)) for mode in (0.0, 1.0)) < 0
        assert float(entry.pause()) >= 0


@pytest.mark.parametrize("cls", [c for c in FLOWS if issubclass(c, Link)], ids=names)
def test_heat_flows_from_hot_to_cold(cls: type[Link]) -> None:
    """One way at least, like through a heat pipe, and never back."""
    for seed, entry in enumerate(drawn(cls, 6)):
        u, (T_a, T_b, *own) = surroundings(seed), arguments(entry, seed)
        there = evaluated(entry, u, T_a, T_b, *own) * (T_a - T_b)
        back = evaluated(entry, u, T_b, T_a, *own) * (T_b - T_a)
        assert min(there, back) >= 0 < max(there, back)
        assert evaluated(entry, u, T_a, T_a, *own) == 0


@each_law
def test_the_direction_of_rotation_does_not_matter(cls: type[Effect]) -> None:
    if issubclass(cls, SensorEffect):
        return
    for seed, entry in enumerate(drawn(cls, 4)):
        u, x = surroundings(seed), arguments(entry, seed)
        back = {**u, "speed": -u["speed"], "feed": -u["feed"]}
        assert np.array_equal(evaluated(entry, u, *x), evaluated(entry, back, *x))


@pytest.mark.parametrize("cls", [c for c in FLOWS if issubclass(c, Friction | Sliding)], ids=names)
def test_nothing_rubs_at_rest_and_friction_never_cools(cls: type[Source]) -> None:
    for seed, entry in enumerate(drawn(cls, 4)):
        for k in range(5):
            u, x = surroundings(seed), arguments(entry, 20 * seed + k)
            rest = {**u, "speed": np.array(0.0), "feed": np.array(0.0)}
            assert evaluated(entry, rest, *x) == 0
            assert evaluated(entry, u, *x) >= 0


@pytest.mark.parametrize("cls", [c for c in FLOWS if issubclass(c, Source)], ids=names)
def test_between_edges_a_source_changes_only_if_it_says_so(cls: type[Source]) -> None:
    day = 86_400.0
    for seed, entry in enumerate(drawn(cls, 3)):
        u, x = surroundings(seed), arguments(entry, seed)
        edges = np.concatenate([[0.0], entry.edges(2 * day), [2 * day]])
        assert np.all(np.diff(edges) > 0)
        for left, right in pairwise(edges[:200]):
            times = left + (right - left) * np.array([1e-9, 0.3, 0.7, 1 - 1e-9])
            heat = [float(evaluated(entry, {**u, "time": np.array(t)}, *x)) for t in times]
            assert entry.follows_time or max(heat) == min(heat)
