"""A mutant made smaller as long as it shows the same fault: lines taken out of its files, options out of its words."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace

from torture.mutants import Mutant
from torture.oracle import Outcome

MOST, LONGEST = 150, 60.0
"""Attempts, and s of the processor, after which the smallest so far will do."""


def minimise(made: Mutant, outcome: Outcome, attempt: Callable[[Mutant], Outcome]) -> Mutant:
    """The smallest found; what makes faults alike is how they begin."""
    left, until = MOST, time.process_time() + LONGEST
    shrunk = True
    while shrunk and left > 0:
        shrunk = False
        for smaller in _smaller(made):
            left -= 1
            if left <= 0 or time.process_time() > until:
                left = 0
                break
            if _alike(attempt(smaller), outcome):
                made, shrunk = smaller, True
                break
    return made


def _alike(one: Outcome, other: Outcome) -> bool:
    return one.kind == "fault" and one.why[:60] == other.why[:60]


def _smaller(made: Mutant) -> Iterator[Mutant]:
    for at in range(len(made.words) - 1, 2, -1):
        yield replace(made, words=made.words[:at] + made.words[at + 1 :])
    for name, text in made.files.items():
        lines = text.split("\n")
        size = len(lines) // 2
        while size:
            for first in range(0, len(lines), size):
                yield replace(made, files={**made.files, name: "\n".join(lines[:first] + lines[first + size :])})
            size //= 4
