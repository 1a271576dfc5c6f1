"""When relays were on, read off recordings of what they watch.

Where the readings do not bend the way that a relay drives (hysteresis_swing), they do not show it, and it is simulated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

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
    told = [_read_run(machine, recording) for recording in recordings]
    if not all(told):
        return forget_modes(recordings)
    return tuple(replace(r, modes=modes) for r, modes in zip(recordings, told, strict=True))


def forget_modes(recordings: Sequence[Recording]) -> tuple[Recording, ...]:
    """Recordings in which relays switch by what they watch."""
    return tuple(replace(r, modes={}) if r.modes else r for r in recordings)


def _read_run(machine: Machine, recording: Recording) -> Mapping[str, RelayMode]:
    """Modes of all relays in a run; nothing where one cannot be read."""
    relays = {path.name: entry for path, entry in machine.by_path.items() if isinstance(entry, Relay)}
    told = [read_mode(machine, relay, name, recording) for name, relay in relays.items()]
    known = {mode.name: mode for mode in told if mode is not None}
    return known if len(known) == len(told) else {}


def clear_of(sigma: float) -> float:
    """Width of a hysteresis from which readings of a noise σ show it."""
    return 2 * CLEAR * sigma


def read_mode(machine: Machine, relay: Relay, name: str, recording: Recording) -> RelayMode | None:
    """When one relay was on; None where the readings of what it watches do not show it."""
    levels = relay.levels()
    sensor = next((n for n in list_readers(machine, relay) if n in recording.columns), None)
    body = relay.follow("")
    if levels is None or sensor is None or body is None or not body.keys() >= {*relay.uncertain()}:
        return None  # numbers of its own that are not known, like a set point, only show where it is simulated
    sign = np.sign(levels[1] - levels[2])
    values = recording.columns[sensor].values
    kept = np.isfinite(values)
    if kept.sum() < FEWEST:
        return None
    swing = Swing(recording.t[kept], sign * values[kept], sign * levels[1], sign * levels[2]).centred()
    if swing is None or swing.on - swing.off < clear_of(machine.sensors[sensor].sigma):
        return None
    found = find_switchings(swing)
    if not found:  # one that never seems to switch may be hidden by readings too rare, or of something else
        return None
    t = np.array([recording.t[0], *(bend.t for bend in found)])
    return RelayMode(MODE + name, t, np.array([bend.spread for bend in found]), float(swing.x[0] > swing.on))
