"""Keys fixed before anyone answers: their SHA-256 is published with the cases, a salt inside keeps them shut."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from numpy.random import Generator


class Broken(Exception):
    """A key that is not the one that was published."""


def sealed(key: Mapping[str, Any], rng: Generator) -> str:
    """The key as text, with a salt of 128 bits."""
    return json.dumps({**key, "salt": rng.bytes(16).hex()}, indent=1) + "\n"


def seal_of(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def opened(folder: Path, case: str) -> dict[str, Any]:
    """The key of a case, if it is the one whose seal stands in cases.json; else raises Broken."""
    text = (folder / "keys" / f"{case}.json").read_text(encoding="utf-8")
    published = json.loads((folder / "cases.json").read_text(encoding="utf-8"))["cases"][case]["sha256"]
    if seal_of(text) != published:
        raise Broken(f"the key of {case} is not the one that was sealed")
    key: dict[str, Any] = json.loads(text)
    return key
