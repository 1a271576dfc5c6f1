"""Which of two searches is told, one on readings set right and one without that."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from network.analysis.diagnosis import search


def states(*told: float) -> Iterator[Any]:
    """States of a search, each as good as its number."""
    return iter(told)


@pytest.mark.parametrize(
    ("right", "other", "told"),
    [
        ((5.0, 6.0, 9.0), (4.0, 7.0, 8.0), [6.0, 9.0]),
        ((5.0, 6.0, 9.0), (4.0, 7.0, 20.0), [6.0, 9.0, 20.0]),
        ((5.0, 6.0, 9.0), (10.0, 11.0), [10.0, 11.0]),
        ((5.0,), (4.0,), []),
    ],
)
def test_lumps_alone_that_explain_more_come_before_readings_set_right(
    right: Any, other: Any, told: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And else the search on these is told to its end, before the other one, which has to beat it."""
    monkeypatch.setattr(search, "_is_told_better", lambda other, now: other > now)
    first, *rest = right
    assert [*search._weigh_fault(first, states(*rest), states(*other))] == told
