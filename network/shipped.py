"""Machines and scenarios that come with lptn: beside the package in a clone, inside it when installed."""

from __future__ import annotations

from pathlib import Path

from network.refusal import Failed

_PACKAGE = Path(__file__).parent


def shipped(folder: str, name: str) -> Path:
    """Path of a shipped file: shipped('machines', 'gantry_spindle.yaml')."""
    for home in (_PACKAGE.parent, _PACKAGE):
        if (home / folder / name).is_file():
            return home / folder / name
    raise Failed(f"{folder}/{name} did not come with this installation; install lptn again")
