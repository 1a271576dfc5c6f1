"""The sentence of a finding; parts that need more lumps together, and all of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from network.analysis.comparison.amounts import joined
from network.analysis.diagnosis.result import sentence

if TYPE_CHECKING:
    from network.analysis.diagnosis.result import Finding


def sentence_of(finding: Finding) -> str:
    """As it was found; where its patch does nothing but cut parts more finely, every part of the patch."""
    nodes: Mapping[str, Any] = finding.patch.get("nodes", {})
    only_lumps = len(finding.patch) == 1 and not finding.parameters and all("lumps" in body for body in nodes.values())
    return f"{sentence('; '.join(_cuts(nodes)))}." if nodes and only_lumps else finding.sentence


def _cuts(nodes: Mapping[str, Any]) -> Iterator[str]:
    counts = {name: int(body["lumps"]) for name, body in nodes.items()}
    for count in dict.fromkeys(counts.values()):
        names = [name for name, own in counts.items() if own == count]
        if len(names) == 1:
            yield f"{names[0]} needs {count} lumps along its length"
        else:
            yield f"{joined(names)} need {count} lumps each along their length"
