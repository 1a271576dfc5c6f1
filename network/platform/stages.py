"""Long work tells the share that is done, and in words what is under way and what it has, to whoever shows that."""

from __future__ import annotations

from collections.abc import Callable

Told = Callable[[float], None]


def say(tell: Told, what: str) -> None:
    """What is under way from now on; nothing where the listener only takes shares."""
    now = getattr(tell, "now", None)
    if now is not None:
        now(what)


class Stage:
    """A stretch of longer work, told as a part of it."""

    def __init__(self, tell: Told, first: float, last: float) -> None:
        self.tell, self.first, self.last = tell, first, last

    def __call__(self, share: float) -> None:
        self.tell(self.first + (self.last - self.first) * share)

    def now(self, what: str) -> None:
        say(self.tell, what)
