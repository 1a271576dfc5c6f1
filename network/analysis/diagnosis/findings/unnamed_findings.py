"""What has no name, and what heat over time is lacking where it is, or where a name is a part of the truth."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from network.analysis.diagnosis.findings.finding import UNKNOWN, Finding, Quantity
from network.analysis.diagnosis.findings.findings import windows_of
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.latent_heat.lacking_heat import trace_lacking
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.latent_heat.mismatch import Mismatch, locate_mismatch
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.ranking import belief_in_nothing
from network.catalogue.declaration.entry_path import axis_of
from network.catalogue.declaration.patch import Patch
from network.catalogue.suspects.ambient_drift import AmbientDrift
from network.engine.trajectory import axis_unit
from network.machine.checks import places_of
from network.machine.machine import Machine
from network.platform.quantities.number_format import format_amount
from network.platform.quantities.units import unit
from network.platform.wording import join_names, sentence

if TYPE_CHECKING:
    from network.analysis.diagnosis.search_record import Search


def find_unknown(search: Search, alone: bool = False) -> Finding:
    """What no kind explains: its place, its shape and its size; alone: with nothing of what was found beside it."""
    about = search.null if alone or not search.best.found else search.best
    mismatch = search.mismatch if about is search.null else locate_mismatch(about, search.is_hurried)
    top = mismatch.places[0]
    if top.is_room:
        return _find_room(search, about, mismatch)
    whole = trace_lacking(about, top)
    course = whole or mismatch.trace(top)
    name, size = size_of_unknown(about.machine, course)
    what = f"an unknown {name} of {format_amount(size.value, size.unit)} (rms)"
    read = list_read(about.machine, top.at.channels)
    where = f"{' and '.join(top.at.seats)}{f' (it reads {join_names(read)})' if read else ''}"
    said = f"{sentence(what)} at {where} that no kind of the catalogue explains{_tell_beside(alone, whole)}."
    windows = windows_of([whole] if whole else mismatch.places)
    return Finding(
        UNKNOWN, "sensors" if top.is_offset else "sources", top.at.nodes or tuple(read), top.at.channels,
        min(top.probability, SETTINGS.most_sure), {name: size}, said, Patch({}), top.gain, search.threshold,
        windows, course=course, share=top.probability, nothing=belief_in_nothing(top.gain),
    ).doubted("what was found may be a part of it" if alone or whole else "")  # fmt: skip


def _tell_beside(alone: bool, whole: UnknownHeat | None) -> str:
    """What it has to do with what was found."""
    if alone:
        return "; what was found hardly lowers it"
    return "; what was found there may be a part of it" if whole else ""


def list_read(machine: Machine, channels: Iterable[str]) -> list[str]:
    """The parts that some channels read, each once; none of a displacement."""
    sensors = (machine.sensors[name] for name in channels if name in machine.sensors)
    return [*dict.fromkeys(place.node for sensor in sensors for _, place in places_of(sensor))]


def _find_room(search: Search, about: Hypothesis, mismatch: Mismatch) -> Finding:
    """Surroundings that are not what is stated, otherwise in each run: no number of the file can tell the next one."""
    top, course = mismatch.places[0], mismatch.trace(mismatch.places[0])
    name, size = size_of_unknown(about.machine, course)
    low, high = (format_amount(float(end([end(T) for T in course.heat])), "K", 2) for end in (np.min, np.max))
    said = (
        f"{sentence(str(top.at))} does not stay at what is given for it: it would have to lie between {low} and {high} "
        "beside that, otherwise in each run. A thermometer there would tell."
    )
    return Finding(
        AmbientDrift.kind, "nodes", top.at.nodes, (), min(top.probability, SETTINGS.barred), {name: size}, said,
        Patch({}), top.gain, search.threshold, windows_of(mismatch.places), course=course,
        doubts=("its course is another one in each run, so that no run that was not seen can test it",),
        share=top.probability, nothing=belief_in_nothing(top.gain),
    )  # fmt: skip


def size_of_unknown(machine: Machine, unknown: UnknownHeat) -> tuple[str, Quantity]:
    """Its rms as a heat [W], as a temperature of surroundings [K], or at a channel as an offset in that channel's
    unit."""
    std = float(np.sqrt(np.mean(np.concatenate(unknown.std) ** 2)))
    if not unknown.is_offset:
        return unknown.quantity, Quantity(unknown.rms, std, unknown.unit)
    sensor = machine.sensors.get(unknown.at.channel)
    text = sensor.unit if sensor else axis_unit(axis_of(unknown.at.channel) or unknown.at.channel)
    return "offset", Quantity(unknown.rms, std, "K" if unit(text).is_temperature else text)


def trace_first(search: Search) -> tuple[UnknownHeat, ...]:
    """Where unknown heat would explain most, with the course of the most probable one where something is missing."""
    places = search.located[:8]
    first = next((u for u in places if not u.is_offset), None)
    if first is None or search.null.chi <= SETTINGS.noise:
        return places
    return tuple(search.mismatch.trace(u) if u is first else u for u in places)
