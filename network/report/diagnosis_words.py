"""What a diagnosis says of itself in the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from network.diagnosis.verdict import Diagnosis


def tell_diagnosis(d: Diagnosis) -> str:
    """Verdict, findings, advice."""
    return "\n".join([d.verdict, *(f.sentence for f in d.findings), *d.notes])
