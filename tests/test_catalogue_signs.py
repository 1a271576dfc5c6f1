"""Which way things go: more of a thing does more of what it does, whatever the kind; nothing here is named.

All of it is generated from the declarations: what a kind's strength is, which sources and links there are, what has a
direction. So a new kind is tested by being there.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from catalogue import (
    FLOWS,
    LAWS,
    Draw,
    arguments,
    drawn,
    each_flow,
    entry_in,
    evaluated,
    machine,
    names,
    patch_of,
    surroundings,
)

from network import Recording, Refused, simulate
from network.catalogue.declaration.declare import Effect
from network.catalogue.expansions.base import Expansion
from network.catalogue.mechanisms.base import Link, Source, Stream
from network.catalogue.mechanisms.mechanism import Relay
from network.recordings.inputs import Schedule, Start, constant

LADDER = np.array([0.0, 0.25, 0.5, 1.0, 2.0])
STRONG = [cls for cls in LAWS if cls.strength in cls.params()]
DIRECTED = [cls for cls in LAWS if issubclass(cls, Expansion) and "direction" in cls.fields]
LINKS = [cls for cls in FLOWS if issubclass(cls, Link)]
SOURCES = [cls for cls in FLOWS if issubclass(cls, Source) and not issubclass(cls, Relay) and not cls.states]
ROUNDING = 1e-12


def ladder(entry: Any, seed: int) -> np.ndarray:
    """What an entry gives at a rising strength, in the same surroundings."""
    name = type(entry).strength
    field = type(entry).params()[name]
    full = float(np.clip(field.proposal(), field.low, field.high / LADDER[-1]))
    u, x = surroundings(seed), arguments(entry, seed)
    return np.array([given_by(entry.replaced(**{name: np.array(s * full)}), u, *x) for s in LADDER])


def given_by(entry: Any, u: Any, *x: Any) -> float:
    """Heat, movement or reading; of a stream whose strength is its delay, the delay."""
    if isinstance(entry, Stream) and type(entry).strength == "delay":
        return entry.transport()[0]
    return float(evaluated(entry, u, *x))


@pytest.mark.parametrize("cls", STRONG, ids=names)
def test_more_of_it_does_more_and_never_turns_round(cls: type[Effect]) -> None:
    """From nothing to twice the typical strength what it gives only rises or only falls."""
    moved = 0
    for seed, entry in enumerate(drawn(cls, 12)):
        steps = np.diff(ladder(entry, seed))
        size = np.abs(steps).max()
        assert np.isfinite(steps).all()
        assert (steps >= -ROUNDING * size).all() or (steps <= ROUNDING * size).all(), (entry, steps)
        moved += size > 0
    assert moved or issubclass(cls, Relay) or cls.section == "effects"


@pytest.mark.parametrize("cls", LINKS, ids=names)
def test_the_more_one_end_is_the_warmer_one_the_more_it_gives(cls: type[Link]) -> None:
    for seed, entry in enumerate(drawn(cls, 12)):
        u, (T, _, *own) = surroundings(seed), arguments(entry, seed)
        flows = [float(entry.heat_flow(T + half, T - half, u, *own)) for half in (-1.0, -0.1, 0.0, 0.1, 1.0)]
        assert (np.diff(flows) >= 0).all() and flows[2] == 0, entry


@pytest.mark.parametrize("cls", DIRECTED, ids=names)
def test_a_mirrored_side_moves_the_other_way(cls: type[Expansion]) -> None:
    for seed, entry in enumerate(drawn(cls, 8)):
        u, x = surroundings(seed), arguments(entry, seed)
        there, back = (float(evaluated(entry.replaced(direction=sign * entry.direction), u, *x)) for sign in (1, -1))
        assert there == -back and np.isfinite(there)
        if x:  # at the reference, where nothing is read, it has not moved
            still = [np.zeros_like(reading) for reading in x]
            assert float(evaluated(entry, u, *still)) == 0, entry


def run_with(cls: type[Effect], body: dict[str, Any]) -> tuple[float, float]:
    """Mean temperature of the parts that it heats over ten minutes from 22 °C, and the heat it brought [J]."""
    found = machine().patched(patch_of(cls, body))
    u = surroundings(1)
    inputs = {name: constant(name, wanted or "1", float(u[name])) for name, wanted in found.inputs.items()}
    run = simulate(found, Schedule("test", "test", np.linspace(0, 600, 11), inputs, Start(others=22.0)))
    T = sum(share * float(run.parts[place.node].mean()) for place, share in entry_in(cls, found).into)
    return T, run.energy.by_mechanism["sources.it"]


@pytest.mark.parametrize("cls", SOURCES, ids=names)
def test_what_brings_more_heat_ends_warmer_and_what_takes_more_colder(cls: type[Source]) -> None:
    """By a run of the whole machine at half and at all of a typical strength: more friction is hotter."""
    field, compared = cls.params()[cls.strength], 0
    for seed in range(60):
        body = {key: value for key, value in Draw(cls, seed).body().items() if key != "while"}
        try:
            strengths = (field.write(share * field.proposal()) for share in (0.5, 1))
            less, more = (run_with(cls, body | {field.key: strength}) for strength in strengths)
        except Refused:
            continue
        warmer, brought = more[0] - less[0], more[1] - less[1]
        if abs(brought) > 1e-9 * abs(more[1]):
            assert np.sign(warmer) == np.sign(brought), body
            compared += 1
        if compared == 2:
            return
    assert compared, "no body was drawn that gives heat at these inputs"


@each_flow
def test_a_kind_that_can_only_be_there_or_not_is_switched_or_has_a_strength(cls: type[Effect]) -> None:
    assert cls.strength in cls.params()


def test_time_that_runs_backwards_is_refused(tmp_path: Path) -> None:
    rows = [f"{10 * k},{20 + k}" for k in range(50)]
    file = tmp_path / "r.csv"
    file.write_text("\n".join(["time [s],T [degC]", *rows]) + "\n")
    assert len(Recording.load(file).t) == 50
    file.write_text("\n".join(["time [s],T [degC]", *reversed(rows)]) + "\n")
    with pytest.raises(Refused, match="in the order of time"):
        Recording.load(file)
