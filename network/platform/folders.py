"""Folders that results go into: made if need be, refused where they cannot be had."""

from __future__ import annotations

import os
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from network.platform.refusal import Spot, refuse


def folder(path: str | Path) -> Path:
    """The folder, made if need be. Raises Refused where a file is in the way or it may not be written."""
    path = Path(path)
    in_the_way = next((p for p in (path, *path.parents) if os.path.exists(p) and not os.path.isdir(p)), None)
    if in_the_way is not None:
        raise refuse(Spot(str(path)), f"cannot be a folder, {in_the_way} is a file", "give another -o")
    try:
        path.mkdir(parents=True, exist_ok=True)
    except PermissionError:
        raise refuse(Spot(str(path)), "may not be made", "give another -o") from None
    except OSError:
        raise refuse(Spot(str(path)), "no folder can be made there", "give another -o") from None
    if not os.access(path, os.W_OK):
        raise refuse(Spot(str(path)), "may not be written to", "give another -o")
    return path


def not_there(path: Path) -> list[Path]:
    """The folders that would have to be made, the innermost first."""
    return [p for p in (path, *path.parents) if not os.path.exists(p)]


def remove_empty(folders: Iterable[Path]) -> None:
    for each in folders:
        with suppress(OSError):
            each.rmdir()


def check_folder(path: str | Path) -> Path:
    """A folder that can be made and written to, before anything is computed; it is not left there. Raises Refused."""
    path = Path(path)
    new = not_there(path)
    try:
        return folder(path)
    finally:
        remove_empty(new)
