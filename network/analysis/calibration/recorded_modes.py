"""When relays were on, read off recordings of what they watch.

Where the readings do not bend the way that a relay drives (hysteresis_swing), they do not show it, and it is simulated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from network.analysis.calibration.hysteresis_swing import FEWEST, Swing, find_switchings
from network.catalogue.mechanisms.mechanism import Relay
from network.engine.response.followed_relays import MODE, list_readers
from network.machine.machine import Machine
from network.recordings.recording import Recording
from network.recordings.relay_mode import RelayMode

CLEAR = 4.0
"""Half width of a hysteresis in 1σ of its readings from which these show it: one reading in 10⁴ goes that far."""


def read_modes(machine: Machine, recordings: Sequence[Recording]) -> tuple[Recording, ...]:
    """Recordings that tell when the relays of a machine were on; as they are, without modes, where one of them does not
    show it for every relay."""
    relays = {path.name: entry for path, entry in machine.by_path.items() if isinstance(entry, Relay)}
    told = [_read_relay(machine, relay, name, recordings) for name, relay in relays.items()]
    runs = [{mode.name: mode for mode in run if mode is not None} for run in zip(*told, strict=True)]
    if not told or any(len(modes) < len(told) for modes in runs):
        return forget_modes(recordings)
    return tuple(replace(r, modes=modes) for r, modes in zip(recordings, runs, strict=True))


def forget_modes(recordings: Sequence[Recording]) -> tuple[Recording, ...]:
    """Recordings in which relays switch by what they watch."""
    return tuple(replace(r, modes={}) if r.modes else r for r in recordings)


def _read_relay(
    machine: Machine, relay: Relay, name: str, recordings: Sequence[Recording]
) -> list[RelayMode | None]:  # fmt: skip
    """The modes of one relay in every run: off all along, too, where the readings of what it watches stay clearly short
    of the level at which it goes on, and are as frequent as to show how it switches in others."""
    modes = [read_mode(machine, relay, name, r) for r in recordings]
    steps = [float(np.diff(mode.t[1:]).min(initial=np.inf)) for mode in modes if mode is not None]
    told = zip(modes, recordings, strict=True)
    return [mode or _read_idle(machine, relay, name, r, min(steps, default=0.0)) for mode, r in told]


def _read_idle(machine: Machine, relay: Relay, name: str, recording: Recording, fastest: float) -> RelayMode | None:
    """fastest: the shortest time that it is on or off in other runs [s]."""
    seen = _find_swing(machine, relay, recording)
    if seen is None or FEWEST * float(np.median(np.diff(seen.swing.t))) > fastest:
        return None
    is_short = seen.swing.x.max() + CLEAR * seen.sigma < seen.swing.on
    return RelayMode(MODE + name, recording.t[:1], np.zeros(0), 0.0) if is_short else None


def clear_of(sigma: float) -> float:
    """Width of a hysteresis from which readings of a noise σ show it."""
    return 2 * CLEAR * sigma


def read_mode(machine: Machine, relay: Relay, name: str, recording: Recording) -> RelayMode | None:
    """When one relay was on; None where the readings of what it watches do not show it."""
    seen = _find_swing(machine, relay, recording)
    swing = None if seen is None else seen.swing.centred()
    if seen is None or swing is None or swing.on - swing.off < clear_of(seen.sigma):
        return None
    found = find_switchings(swing)
    if not found:  # one that never seems to switch may be hidden by readings too rare, or of something else
        return None
    t = np.array([recording.t[0], *(bend.t for bend in found)])
    return RelayMode(MODE + name, t, np.array([bend.spread for bend in found]), float(not found[0].goes_on))


class _Seen(NamedTuple):
    """Readings of what a relay watches, between its levels, and their noise."""

    swing: Swing
    sigma: float


def _find_swing(machine: Machine, relay: Relay, recording: Recording) -> _Seen | None:
    """None where nothing reads it, or its levels are not known."""
    levels, body = relay.levels(), relay.follow("")
    sensor = next((n for n in list_readers(machine, relay) if n in recording.columns), None)
    if levels is None or sensor is None or body is None or not body.keys() >= {*relay.uncertain()}:
        return None  # numbers of its own that are not known, like a set point, only show where it is simulated
    sign = np.sign(levels[1] - levels[2])
    values = recording.columns[sensor].values
    kept = np.isfinite(values)
    if kept.sum() < FEWEST:
        return None
    swing = Swing(recording.t[kept], sign * values[kept], sign * levels[1], sign * levels[2])
    return _Seen(swing, machine.sensors[sensor].sigma)
