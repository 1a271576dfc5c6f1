"""Files written whole or not at all."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from network.platform.publication import cannot_be_written, is_draft, publication
from network.platform.refusal import Spot, refuse


def replace_file(path: Path, write: Callable[[Path], object]) -> None:
    """Lets `write` fill a file beside `path` and puts it in its place; a link is followed, nothing but a plain file is
    replaced. Into a draft, which is published as a whole, it is written as it is. Raises Refused where it cannot be
    written."""
    target = path.resolve()
    if target.exists() and not target.is_file():
        raise refuse(Spot(str(path)), "is not a plain file", "give the name of a file to write")
    try:
        if is_draft(target.parent):
            write(target)
            return
        target.parent.stat()
        with publication(target.parent) as draft:
            write(draft / target.name)
    except OSError as error:
        raise cannot_be_written(path, error) from None


def write_text(path: Path, text: str) -> None:
    """Puts a whole text in place of the file, or leaves the file as it was. Raises Refused."""
    replace_file(path, lambda beside: beside.write_text(text, encoding="utf-8", newline="\n"))
