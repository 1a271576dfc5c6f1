"""What to run next: schedules that would tell apart what these recordings cannot."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from network.diagnosis.verdict import Experiment

if TYPE_CHECKING:
    from network.diagnosis.diagnosing import Search


def experiments(search: Search) -> Iterator[Experiment]:
    yield from ()
