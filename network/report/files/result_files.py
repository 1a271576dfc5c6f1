"""Files that a command leaves behind: written whole or not at all."""

from __future__ import annotations

import csv
import io
import json
import os
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from itertools import chain
from pathlib import Path
from typing import Any

from network.engine.superposition.superposition import Superposition
from network.engine.trajectory import Trajectory
from network.platform.files import replace_file
from network.platform.refusal import Refused, Spot, refuse
from network.platform.stopping import on_stop
from network.recordings.csv_table import write_csv
from network.report.words.source_words import summarise_superposition

DRAWN = 60.0
"""s: how long after the rest of a result its pictures may be drawn."""


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


@contextmanager
def results_in(path: str | Path) -> Iterator[None]:
    """Around the work whose results go into a folder: one that cannot be had is refused first; however the work
    ends, nothing half-written stays in the folder, and none that was made stays empty."""
    where, new = check_folder(path), not_there(Path(path))
    before = {*_half_written(where)}

    def take_away() -> None:
        for each in {*_half_written(where)} - before:
            shutil.rmtree(each) if each.is_dir() else each.unlink()
        remove_empty(new)

    try:
        with on_stop(take_away):
            yield
    finally:
        take_away()


def _half_written(where: Path) -> Iterator[Path]:
    for pattern in (".diagnosis.*", ".calibration.*", ".*.part"):
        yield from where.glob(pattern)


def write_text(path: Path, text: str) -> None:
    """Puts a whole text in place of the file, or leaves the file as it was. Raises Refused."""
    replace_file(path, lambda beside: beside.write_text(text, encoding="utf-8", newline="\n"))


def put_in_place(made: Sequence[Path], where: Path) -> None:
    """Moves files made beside into a folder, or none of them. Raises Refused where a folder has one of their names."""
    for path in made:
        if (where / path.name).is_dir():
            raise refuse(Spot(str(where / path.name)), "is a folder", "give another -o")
    for path in made:
        os.replace(path, where / path.name)


@contextmanager
def replacing(where: Path, result: str, pictures: Sequence[str]) -> Iterator[None]:
    """Around the writing of a result: pictures of the one that lay there, by the patterns of their names, go with it.
    What came into the folder after it is not touched."""
    before = where / result
    made = before.stat().st_mtime if before.is_file() else 0.0
    old = {p: p.stat().st_mtime for pattern in pictures for p in where.glob(pattern) if p.is_file()}
    yield
    for path, when in old.items():
        if path.stat().st_mtime == when <= made + DRAWN:
            path.unlink()


def as_json(value: Mapping[str, Any]) -> str:
    """JSON text; NaN becomes null."""
    return json.dumps(_finite(value), indent=1, ensure_ascii=False) + "\n"


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _finite(child) for key, child in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(child) for child in value]
    return None if isinstance(value, float) and value != value else value


def write_table(path: Path, header: Iterable[object], rows: Iterable[Iterable[object]]) -> None:
    """A table as CSV, 7 digits; nothing for None."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(str, header))
    writer.writerows([f"{cell:.7g}" if isinstance(cell, float) else cell for cell in row] for row in rows)
    write_text(path, text.getvalue())


def run_summary(run: Trajectory, shares: Superposition | None) -> dict[str, Any]:
    """What summary.json holds; `from`: where the movement comes from."""
    return run.summary() | ({} if shares is None else {"from": summarise_superposition(shares)})


def write_run(run: Trajectory, where: Path, shares: Superposition | None = None) -> list[Path]:
    """results.csv (a recording's format), parts.csv (what every part has and does, and where the movement comes from),
    and summary.json."""
    results, parts, summary = (where / name for name in ("results.csv", "parts.csv", "summary.json"))
    written: list[Path] = []
    try:
        more = shares.columns() if shares is not None else ()
        for path, columns in ((results, run.columns()), (parts, chain(run.part_columns(), more))):
            write_csv(path, run.t, {name: (unit_text, values) for name, unit_text, values in columns})
            written.append(path)
        write_text(summary, as_json(run_summary(run, shares)))
    except Refused:
        for path in written:
            path.unlink(missing_ok=True)
        raise
    return [results, parts, summary]
