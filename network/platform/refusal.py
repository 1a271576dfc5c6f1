"""Refusals: what is wrong with an input, where, and what would be right."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches

FEWEST = 3
"""Letters that may stand for the one word that begins with them."""
MOST_LISTED = 40
"""Known words that a message lists."""


@dataclass(frozen=True, order=True)
class Spot:
    """A place in a file; line 0 means the file (or option) as a whole."""

    file: str
    line: int = 0

    def __str__(self) -> str:
        return f"{self.file}:{self.line}" if self.line else self.file


@dataclass(frozen=True, order=True)
class Refusal:
    """One sentence to the user: `file:line: what is wrong; what would be right`."""

    spot: Spot
    wrong: str
    right: str

    def __str__(self) -> str:
        return " ".join(f"{self.spot}: {self.wrong}; {self.right}".split("\n"))


class Refused(Exception):
    """An input that cannot be used, with every refusal found in it. The command line exits with 2."""

    def __init__(self, refusals: Iterable[Refusal]) -> None:
        self.refusals = tuple(sorted(set(refusals)))
        super().__init__("\n".join(map(str, self.refusals)))

    def __reduce__(self) -> tuple[type[Refused], tuple[tuple[Refusal, ...]]]:
        """So that it comes whole out of another process."""
        return type(self), (self.refusals,)


class Failed(Exception):
    """A computation that could not be carried through. The command line exits with 1."""


class UnknownName(KeyError):
    """A name that is none of those there are; says which they are."""

    def __str__(self) -> str:
        return str(self.args[0])


@dataclass
class Complaints:
    """Collects the refusals of one input, so that all are told at once; warnings do not stop anything."""

    refusals: list[Refusal] = field(default_factory=list)
    warnings: list[Refusal] = field(default_factory=list)

    def refuse(self, spot: Spot, wrong: str, right: str) -> None:
        self.refusals.append(Refusal(spot, wrong, right))

    def warn(self, spot: Spot, wrong: str, right: str) -> None:
        self.warnings.append(Refusal(spot, wrong, right))

    def absorb(self, refused: Refused) -> None:
        self.refusals.extend(refused.refusals)

    def raise_if_any(self) -> None:
        if self.refusals:
            raise Refused(self.refusals)


def refuse(spot: Spot, wrong: str, right: str) -> Refused:
    """The exception for a single refusal, to be raised by the caller."""
    return Refused([Refusal(spot, wrong, right)])


def likely(word: str, known: Iterable[str]) -> str:
    """'did you mean …' with the nearest known word, or the list of what is known."""
    words = list(known)
    if not words:
        return "none is defined"
    lowered = {w.lower(): w for w in reversed(words)}
    begun = [known for known in words if len(word) >= FEWEST and known.lower().startswith(word.lower())]
    near = begun if len(begun) == 1 else get_close_matches(word[:100], words, n=1)
    near = near or get_close_matches(word[:100].lower(), lowered, n=1)
    if near:
        return f"did you mean '{near[0] if near[0] in words else lowered[near[0]]}'?"
    return f"known are: {list_first(words)}"


def list_first(words: Sequence[str]) -> str:
    """The first of them, and how many more there are: as many as a message can bear."""
    more = f" and {len(words) - MOST_LISTED} more" if len(words) > MOST_LISTED else ""
    return ", ".join(words[:MOST_LISTED]) + more


def short(text: str, most: int = 60) -> str:
    """What was read, on one line and not longer than a message can bear."""
    line = " ".join(text.split())
    return line if len(line) <= most else line[: most - 1] + "…"
