"""A result of several files put into a folder at once: the old result is there or the new one, never a mixture.

It is made in a draft, a hidden folder beside it, whose files then take the place of the old ones. Whatever fails
meanwhile, the old files are put back. Where the process is killed between the first file and the last, the next
publication in the folder brings it to its end; what other killed processes left is removed then, too. Publications by
several processes at once take turns, and the last one stands.
"""

from __future__ import annotations

import os
import shutil
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from network.platform.folders import folder, not_there, remove_empty
from network.platform.held_folder import abandoned, kind_of, let_go, make_held, new_name, sorting
from network.platform.refusal import Refused, Spot, refuse
from network.platform.stopping import GRACE, on_stop, uninterrupted

DRAFT, READY = "draft", "ready"
"""Kinds of held folders: one that is being made, and one whose files are on their way to their places."""
NEW, OLD, STALE = "new", "old", "stale"
"""In them: the files of the result, those whose place they take, and those of the old result that only go."""
ATTEMPTS = 20
"""Of beginning in a folder that another process has just removed because it was empty."""


@dataclass(frozen=True)
class Kind:
    """What a result is known by in its folder: a file that is always among its files, and patterns of the names of
    those that it may lack. Of the result before, what the new one lacks goes, but for files changed since."""

    mark: str = ""
    patterns: Sequence[str] = ()

    def list_of(self, where: Path) -> Iterator[str]:
        """Names of the files that came into the folder together with the mark of the result that is there. All files
        of a publication have one time of change."""
        mark = where / self.mark
        if self.mark and mark.is_file():
            paths = (path for pattern in self.patterns for path in where.glob(pattern) if path.is_file())
            yield from (path.name for path in paths if path.stat().st_mtime_ns == mark.stat().st_mtime_ns)


@contextmanager
def publication(where: str | Path, kind: Kind = Kind()) -> Iterator[Path]:
    """A folder to write files into; they stand in `where`, which is made if need be, when the block has ended, and
    nothing is changed there when it has raised. A link that has the name of a file is replaced, not followed.

    Raises Refused where the folder cannot be had or written to, or something other than a file has one of their names.
    """
    where = Path(where)
    new, draft = not_there(where), _Draft(where, kind)

    def tidy_up() -> None:
        draft.remove()
        remove_empty(new)

    try:
        with on_stop(tidy_up), _told_by_place(where):
            draft.begin()
            yield draft.path / NEW
            with uninterrupted():
                draft.publish()
                tidy_up()
    finally:
        with uninterrupted():
            tidy_up()
        let_go(draft.handle)


def is_draft(path: Path) -> bool:
    """Whether files written into this folder are published with it."""
    return path.name == NEW and kind_of(path.parent) == DRAFT


def cannot_be_written(path: Path, error: OSError) -> Refused:
    """The refusal of a file, told by the place where it was going to stand."""
    place = path.parents[2] / path.name if is_draft(path.parent) else path
    right = "give a folder that exists, that has room and that you may write to"
    return refuse(Spot(str(place)), f"cannot be written: {error.strerror}", right)


@contextmanager
def _told_by_place(where: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise cannot_be_written(Path(error.filename) if isinstance(error.filename, str) else where, error) from None


class _Draft:
    """A result on its way."""

    def __init__(self, where: Path, kind: Kind) -> None:
        self.where, self.kind, self.handle = where, kind, None
        self.path, self.ready = where / new_name(DRAFT), where / new_name(READY)
        self.moving, self.settled = threading.Lock(), True

    handle: int | None

    def begin(self) -> None:
        for _ in range(ATTEMPTS):
            folder(self.where)
            with suppress(FileNotFoundError), sorting(self.where):
                _finish_abandoned(self.where)
                self.handle = make_held(self.path)
                for name in (NEW, OLD, STALE):
                    (self.path / name).mkdir()
                return
        raise refuse(Spot(str(self.where)), "is removed again and again by something else", "give another -o")

    def publish(self) -> None:
        with self.moving, sorting(self.where):
            names = [path.name for path in (self.path / NEW).iterdir()]
            self._check(names)
            self._keep(names)
            self.settled = False
            try:
                self.path.rename(self.ready)
                _put(self.ready, self.where)
            except BaseException:
                self._put_back(names)
                self.settled = True
                raise
            self.settled = True

    def _check(self, names: Sequence[str]) -> None:
        for place in (self.where / name for name in names):
            if os.path.lexists(place) and not (place.is_file() or place.is_symlink()):
                what = "is a folder" if place.is_dir() else "is not a plain file"
                raise refuse(Spot(str(place)), what, "give another -o")

    def _keep(self, names: Sequence[str]) -> None:
        """The old files once more in the draft, and one time for all the new ones."""
        _stamp([self.path / NEW / name for name in names])
        for name in names:
            if os.path.lexists(self.where / name):
                _double(self.where / name, self.path / OLD / name)
        for name in {*self.kind.list_of(self.where)} - {*names}:
            _double(self.where / name, self.path / STALE / name)

    def _put_back(self, names: Sequence[str]) -> None:
        """Whatever has been done so far: what was there is there again, and nothing else."""
        for name in names if self.ready.exists() else ():
            if os.path.lexists(self.ready / OLD / name):
                os.replace(self.ready / OLD / name, self.where / name)
            elif not (self.ready / NEW / name).exists():
                (self.where / name).unlink(missing_ok=True)
        for path in (self.ready / STALE).glob("*"):
            os.replace(path, self.where / path.name)

    def remove(self) -> None:
        """Removes the draft, but not while its files are on their way: what is left of it then is brought to its end
        by the next publication."""
        if self.moving.acquire(timeout=GRACE):
            try:
                shutil.rmtree(self.path, ignore_errors=True)
                if self.settled:
                    shutil.rmtree(self.ready, ignore_errors=True)
            finally:
                self.moving.release()


def _stamp(paths: Sequence[Path]) -> None:
    if paths:
        when = max(path.stat().st_mtime_ns for path in paths)
        for path in paths:
            os.utime(path, ns=(when, when))


def _double(path: Path, to: Path) -> None:
    """Another name of the same file, or a copy where a file system knows one name only."""
    try:
        os.link(path, to, follow_symlinks=False)
    except (OSError, NotImplementedError):
        shutil.copy2(path, to, follow_symlinks=False)


def _put(ready: Path, where: Path) -> None:
    for path in (ready / NEW).iterdir():
        os.replace(path, where / path.name)
    for path in (ready / STALE).iterdir():
        (where / path.name).unlink(missing_ok=True)


def _finish_abandoned(where: Path) -> None:
    """Of processes that are gone: what was on its way comes to its place, drafts go."""
    for path in abandoned(where, (DRAFT, READY)):
        if kind_of(path) == READY:
            with suppress(OSError):
                _put(path, where)
        shutil.rmtree(path, ignore_errors=True)
