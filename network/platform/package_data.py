"""Machines and scenarios that come with lptn: beside the package in a clone, inside it when installed."""

from __future__ import annotations

import os
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path

from network.platform.refusal import Failed

FOLDERS = ("machines", "scenarios")
RESULTS = "results.csv"
"""The recording in a folder of results."""
NEAR = 0.8
"""Likeness from which a name is taken for a slip: one letter in five."""
_PACKAGE = Path(__file__).parents[1]


def find_shipped(folder: str, name: str) -> Path:
    """Path of a shipped file: find_shipped('machines', 'gantry_spindle.yaml')."""
    found = _find(folder, name)
    if found is not None:
        return found
    raise Failed(f"{folder}/{name} did not come with this installation; install lptn again")


def hint(path: Path) -> str:
    """What to add where a file is not there: one of its name comes with lptn, or one beside it is called nearly so."""
    found = next((p for folder in FOLDERS if (p := _find(folder, path.name))), None)
    if found:
        return f" (one of that name comes with lptn: {found})"
    if os.path.isfile(path / RESULTS):
        return f" (did you mean {path / RESULTS}?)"
    beside = [other.name for other in path.parent.iterdir() if other != path] if os.path.isdir(path.parent) else []
    near = get_close_matches(path.name, beside, n=1, cutoff=NEAR)
    return f" (did you mean {path.parent / near[0]}?)" if near else ""


def is_shipped(file: str, named: Sequence[str]) -> bool:
    """Whether a file came with lptn and is not the user's to change: inside the installation, or in a clone without
    being among the names that were given."""
    home = Path(file).resolve().parent.parent
    return Path(file).parent.name in FOLDERS and (home == _PACKAGE or (home == _PACKAGE.parent and file not in named))


def _find(folder: str, name: str) -> Path | None:
    paths = (home / folder / name for home in (_PACKAGE.parent, _PACKAGE))
    return next((path for path in paths if os.path.isfile(path)), None)
