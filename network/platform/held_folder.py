"""Folders of a process that are known to be abandoned once it is gone, however it ended.

A held folder is locked as long as its process lives: the system lets go of the lock with the process, so that no clock
and no process number has to be believed. Nothing tells a folder that is held from an abandoned one where folders
cannot be locked (Windows, some network drives): there, what a killed process leaves has to be removed by hand.
"""

from __future__ import annotations

import os
import re
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from secrets import token_hex

from network.platform.stopping import on_stop, uninterrupted

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

OURS = re.compile(r"\.?lptn-([a-z]+)-[0-9a-f]{16}")
PATIENCE = 10.0
"""s that one process waits for another that sorts a folder, which takes milliseconds."""


def new_name(kind: str) -> str:
    """A name for a held folder, one that no other program gives; the file manager does not show it."""
    return f".lptn-{kind}-{token_hex(8)}"


def kind_of(path: Path) -> str:
    """Which kind of held folder bears this name; empty for a name that is not ours."""
    found = OURS.fullmatch(path.name)
    return found[1] if found else ""


def hold(path: Path) -> int | None:
    """Locks a folder until this process ends or what is returned is closed; None where another holds it, where it is
    another user's, or where folders cannot be locked."""
    if fcntl is None:
        return None
    with suppress(OSError):
        handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
        try:
            if os.fstat(handle).st_uid == os.getuid():
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return handle
        except OSError:
            pass
        os.close(handle)
    return None


def let_go(handle: int | None) -> None:
    if handle is not None:
        os.close(handle)


@contextmanager
def sorting(where: Path) -> Iterator[None]:
    """While it lasts, no other process sorts this folder; one that takes too long is not waited for. Raises
    FileNotFoundError where the folder is gone."""
    handle = os.open(where, os.O_RDONLY) if fcntl is not None and os.access(where, os.R_OK) else None
    try:
        if handle is not None:
            _wait_for(handle)
        yield
    finally:
        let_go(handle)


def _wait_for(handle: int) -> None:
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            time.sleep(0.01)
        except OSError:  # such folders cannot be locked
            return
        else:
            return


def abandoned(where: Path, kinds: tuple[str, ...]) -> Iterator[Path]:
    """Held folders of these kinds whose process is gone, each locked meanwhile. To be called while sorting."""
    found = sorted(where.iterdir()) if os.access(where, os.R_OK) else []
    for path in found:
        if kind_of(path.with_suffix("")) in kinds and (handle := hold(path)) is not None:
            try:
                yield path
            finally:
                os.close(handle)


def make_held(path: Path) -> int | None:
    """A new folder, held before it has a name that others know as ours: nobody takes it for an abandoned one, also
    where the folder around it is so slow that sorting it was not waited for."""
    unknown = path.with_name(f"{path.name}.new")
    with uninterrupted():
        unknown.mkdir(mode=0o700)
        handle = hold(unknown)
        os.rename(unknown, path)
    return handle


@contextmanager
def passing_folder(where: Path, kind: str) -> Iterator[Path]:
    """A folder that is there while it lasts; those of its kind whose process is gone are removed first."""
    path = where / new_name(kind)
    handle = None

    def remove() -> None:
        shutil.rmtree(path, ignore_errors=True)

    try:
        with on_stop(remove):
            with sorting(where):
                for old in abandoned(where, (kind,)):
                    shutil.rmtree(old, ignore_errors=True)
                handle = make_held(path)
            yield path
    finally:
        with uninterrupted():
            remove()
        let_go(handle)
