"""Heat that nothing in the machine accounts for, in words: when, where, how much, whether in bursts."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from network.analysis.comparison.amounts import amount
from network.analysis.diagnosis.findings.finding import UNKNOWN
from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.entry_path import axis_of, displacement
from network.engine.trajectory import axis_unit
from network.platform.quantities.text_table import digits
from network.report.figures.lines import clock
from network.report.words.recording_names import name_recording

if TYPE_CHECKING:
    from network.analysis.diagnosis.findings.result import Diagnosis
    from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat

CLEAR = 2.0
"""Standard deviations from which unknown heat counts."""
HOURS = 6 * 3600.0
"""s: shorter recordings are told in minutes."""
FEWEST, FULLEST = 3, 0.75
"""Bursts are at least so many, and fill at most this share of the time."""
BOTH = 0.25
"""Share of the squared heat of the other sign from which both signs are told."""


THROUGHOUT = "Throughout"
COUNTS = 0.02
"""Probability from which a place is told."""
POINTS = 0.25
"""Probability of the best place from which the map of unknown heat points anywhere."""


@dataclass(frozen=True)
class Course:
    """What stands out of an unknown heat. first, last: when [s]; mean: between them; low, high: its ends; bursts: how
    many there are, each of about `level`; 0 where it is no matter of bursts."""

    first: float
    last: float
    mean: float
    low: float
    high: float
    bursts: int
    level: float
    is_one_way: bool


def course(t: Array, heat: Array, std: Array) -> Course | None:
    """Of one recording; None where nothing stands out."""
    clear = np.abs(heat) > CLEAR * std
    if not clear.any():
        return None
    weight = np.where(clear, heat, 0.0)
    sign = 1.0 if np.sum(weight * np.abs(weight)) > 0 else -1.0
    other = float(np.sum(np.minimum(sign * weight, 0) ** 2) / np.sum(weight**2))
    first, last = np.flatnonzero(clear)[[0, -1]]
    inside = slice(first, last + 1)
    bursts, level = _bursts(sign * heat[inside])
    return Course(
        float(t[first]), float(t[last]), float(np.mean(heat[inside])), float(heat[inside].min()),
        float(heat[inside].max()), bursts, sign * level, other < BOTH,
    )  # fmt: skip


def _bursts(heat: Array) -> tuple[int, float]:
    """How many stretches lie above half of the top, and what they reach; (0, 0) for one stretch or nearly always."""
    on = heat > np.quantile(heat, 0.9) / 2
    count = int(np.sum(np.diff(np.concatenate([[False], on]).astype(int)) == 1))
    if count < FEWEST or float(on.mean()) > FULLEST:
        return 0, 0.0
    return count, float(np.median(heat[on]))


def heat_words(d: Diagnosis, u: UnknownHeat) -> str:
    """The sentence about a place, on the recording where most is unaccounted for; nothing where nothing stands out."""
    at = max(range(len(u.t)), key=lambda i: float(np.sum(u.heat[i] ** 2)))
    seen = course(u.t[at], u.heat[at], u.std[at])
    if seen is None:
        return ""
    name = name_recording(d, d.fits.train_before.recordings[at])
    return f"{when(seen.first, seen.last, u.t[at], name)} {_what(d, u, seen)}{_in_bursts(d, u, seen)}."


def when(first: float, last: float, t: Array, of: str) -> str:
    """The time between two instants of a recording, which has the times t."""
    if last - first > 0.95 * float(t[-1] - t[0]):
        return f"{THROUGHOUT} {of}"
    name, length = ("min", 60.0) if float(t[-1] - t[0]) < HOURS else clock(t)
    if first == last:
        return f"At {first / length:.3g} {name} of {of}"
    return f"Between {first / length:.3g} and {last / length:.3g} {name} of {of}"


def _what(d: Diagnosis, u: UnknownHeat, seen: Course) -> str:
    """Who gets how much more or less than the model has it."""
    if not seen.is_one_way:
        low, high = _size(d, u, seen.low), _size(d, u, seen.high)
        if u.is_offset:
            return f"{u.at} reads up to {low} lower and up to {high} higher than the model"
        if u.is_room:
            return f"{u.at} would have to be up to {low} colder and up to {high} warmer than is given, by turns"
        who = f"{u.at} gets" if u.at.kind == "node" else f"from {u.at} flow"
        return f"{who} up to {low} less and up to {high} more heat than in the model, by turns"
    size = f"on average {_size(d, u, seen.mean)}"
    less = seen.mean < 0
    if u.at.kind == "node":
        return f"{u.at} gets {size} {'less' if less else 'more'} heat than the model gives it"
    if u.is_room:
        return f"{u.at} would have to be {size} {'colder' if less else 'warmer'} than is given"
    if u.at.kind == "link":
        return f"{size} {'less' if less else 'more'} flow from {u.at} than in the model"
    return f"{u.at} reads {size} {'lower' if less else 'higher'} than the model"


def _in_bursts(d: Diagnosis, u: UnknownHeat, seen: Course) -> str:
    return f", in {seen.bursts} bursts of about {_size(d, u, seen.level)}" if seen.bursts and seen.is_one_way else ""


def _size(d: Diagnosis, u: UnknownHeat, value: float) -> str:
    return amount(value, unit_of(d, u), 2)


def unit_of(d: Diagnosis, u: UnknownHeat) -> str:
    """W, K of surroundings, or the unit of the channel (of an axis)."""
    if not u.is_offset:
        return u.unit
    channel = u.at.channel
    sensor = d.machine.sensors.get(channel)
    return sensor.unit if sensor else axis_unit(axis_of(channel) or channel)


def suspects_of(d: Diagnosis, most: int = 3) -> tuple[UnknownHeat, ...]:
    """The places to tell about: where something was found; where that has no name, or no place, the most probable."""
    seats = seats_in(d)
    ranked = sorted(d.located, key=lambda u: (not is_found_at(u, seats), -u.probability))
    found = [u for u in ranked if is_found_at(u, seats)]
    if found and is_named(d):
        return tuple(found[:most])
    counting = [u for u in ranked if is_found_at(u, seats) or u.probability > COUNTS]
    return tuple((counting or ranked)[:most])


def is_named(d: Diagnosis) -> bool:
    """Whether everything that was found has a name."""
    return bool(d.findings) and all(f.kind != UNKNOWN for f in d.findings)


def is_found_at(u: UnknownHeat, seats: Container[str]) -> bool:
    """Whether a finding sits at its part or channel; a link counts for neither of its ends."""
    return len(u.at.seats) == 1 and u.at.seats[0] in seats


def seats_in(d: Diagnosis) -> set[str]:
    """Parts and channels of the findings; for an axis, the channels that read it."""
    seats = {seat for f in d.findings for seat in f.channels or f.places}
    on_axes = {name: displacement(sensor.axis) for name, sensor in d.machine.sensors.items() if sensor.axis}
    return seats | {name for name, axis in on_axes.items() if axis in seats}


def where_words(d: Diagnosis) -> str:
    """Places with their probabilities, as far as they count."""
    named = [f"{_unknown(u)} ({digits(100 * u.probability, 2)} %)" for u in d.located[:4] if u.probability > COUNTS]
    if not named or d.located[0].probability < POINTS:
        return ""
    told = f"If one unknown were all that is missing, it would be {', or '.join(named)}"
    agrees = {*d.located[0].at.seats} & seats_in(d)
    return f"{told}." if agrees else f"{told}; what was found explains the recordings better."


def _unknown(u: UnknownHeat) -> str:
    what = {"node": "heat in", "link": "heat from", "channel": "an offset of", "surroundings": "another temperature of"}
    return f"{what[u.at.kind]} {u.at}"
