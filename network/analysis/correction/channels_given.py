"""What a user says of the control: its channels."""

from __future__ import annotations

from network.analysis.correction.correction import list_sensors
from network.machine.machine import Machine
from network.platform.refusal import Complaints, Spot, likely


def read_channels(machine: Machine, text: str | None) -> list[str] | None:
    """'speed,T_housing' → its names, each an input or a temperature sensor of the machine; None for all. Raises
    Refused."""
    if text is None:
        return None
    known, complaints = [*machine.drives, *list_sensors(machine)], Complaints()
    names = [name.strip() for name in text.split(",") if name.strip()]
    for name in names:
        if name not in known:
            complaints.refuse(Spot("--inputs"), f"'{name}' is no input and no plain sensor of it", likely(name, known))
    complaints.raise_if_any()
    return names
