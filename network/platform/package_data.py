"""Machines and scenarios that come with lptn: beside the package in a clone, inside it when installed."""

from __future__ import annotations

from pathlib import Path

from network.platform.refusal import Failed

_PACKAGE = Path(__file__).parents[1]


def find_shipped(folder: str, name: str) -> Path:
    """Path of a shipped file: find_shipped('machines', 'gantry_spindle.yaml')."""
    found = _find(folder, name)
    if found is not None:
        return found
    raise Failed(f"{folder}/{name} did not come with this installation; install lptn again")


def hint(path: Path) -> str:
    """What to add where a file is not there, and one of its name comes with lptn."""
    found = next((p for folder in ("machines", "scenarios") if (p := _find(folder, path.name))), None)
    return f" (one of that name comes with lptn: {found})" if found else ""


def _find(folder: str, name: str) -> Path | None:
    paths = (home / folder / name for home in (_PACKAGE.parent, _PACKAGE))
    return next((path for path in paths if path.is_file()), None)
