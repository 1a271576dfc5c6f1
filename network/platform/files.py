"""Files written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from network.platform.refusal import Spot, refuse


def replace_file(path: Path, write: Callable[[Path], object]) -> None:
    """Lets `write` fill a file beside `path` and puts it in its place; a link is followed, nothing but a plain file is
    replaced. Raises Refused where it cannot be written."""
    target = path.resolve()
    if target.exists() and not target.is_file():
        raise refuse(Spot(str(path)), "is not a plain file", "give the name of a file to write")
    part = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        write(part)
        os.replace(part, target)
    except OSError as error:
        wrong = f"cannot be written: {error.strerror}"
        raise refuse(Spot(str(path)), wrong, "give a folder that exists and that you may write to") from None
    finally:
        part.unlink(missing_ok=True)
