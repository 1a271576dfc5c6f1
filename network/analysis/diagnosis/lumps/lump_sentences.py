"""Parts that need more lumps in a sentence, several of them together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from network.platform.wording import join_names, sentence


def cuts_only(patch: Mapping[str, Any]) -> bool:
    """Whether a patch does nothing but cut parts more finely."""
    nodes: Mapping[str, Any] = patch.get("nodes", {})
    return bool(nodes) and len(patch) == 1 and all("lumps" in body for body in nodes.values())


def lump_sentence(nodes: Mapping[str, Any]) -> str:
    """Which parts need how many lumps."""
    return f"{sentence('; '.join(_cuts(nodes)))}."


def _cuts(nodes: Mapping[str, Any]) -> Iterator[str]:
    counts = {name: int(body["lumps"]) for name, body in nodes.items()}
    for count in dict.fromkeys(counts.values()):
        names = [name for name, own in counts.items() if own == count]
        if len(names) == 1:
            yield f"{names[0]} needs {count} lumps along its length"
        else:
            yield f"{join_names(names)} need {count} lumps each along their length"
