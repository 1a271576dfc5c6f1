"""What can drive a simulation: a scenario, a recording, or a mapping of a foreign recording, told apart by content."""

from __future__ import annotations

from pathlib import Path

from network.platform.refusal import Spot, refuse
from network.platform.yaml import document
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario


def load_source(path: str | Path) -> Scenario | Recording:
    """The scenario or recording in a file. Raises Refused."""
    path = Path(path)
    if path.suffix.lower() not in (".yaml", ".yml"):
        return Recording.load(path)
    keys = document.load(path, "a scenario or a recording's mapping").items
    if "recording" in keys:
        return Recording.load(path)
    if "scenario" in keys:
        return Scenario.load(path)
    if "machine" in keys or "nodes" in keys:
        raise refuse(
            Spot(str(path), 1), "is a machine file", "give a scenario or a recording here; the machine stands first"
        )
    right = "begin with `scenario: name`, or with `recording: name`"
    raise refuse(Spot(str(path), 1), "is neither a scenario nor a mapping", right)


def load_recording(path: str | Path) -> Recording:
    """The recording in a file; a scenario is refused. Raises Refused."""
    source = load_source(path)
    if isinstance(source, Scenario):
        raise refuse(Spot(str(path), 1), "is a scenario", "give a recording: a CSV, or a mapping that names one")
    return source
