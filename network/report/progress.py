"""A progress bar on standard error for whatever takes longer than two seconds; nothing where nobody looks."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.progress import Progress

PATIENCE = 1.0
"""s: how long it stays silent."""


@contextmanager
def bar(what: str, sources: Sequence[Any]) -> Iterator[Callable[[float], None]]:
    """Yields a function that is told the simulated time [s] of the source under way."""
    teller = _Bar(what, [_span(source) for source in sources])
    try:
        yield teller.tell
    finally:
        teller.close()


@contextmanager
def share_bar(what: str) -> Iterator[Callable[[float], None]]:
    """Yields a function that is told the share of the work that is done, 0 to 1."""
    teller = _Bar(what, [(0.0, 1.0)])
    try:
        yield teller.tell
    finally:
        teller.close()


def _span(source: Any) -> tuple[float, float]:
    t = source.schedule.t if hasattr(source, "duration") else source.t
    return float(t[0]), float(t[-1])


class _Bar:
    """Sums the progress over several sources: a simulated time that falls back means the next one."""

    def __init__(self, what: str, spans: list[tuple[float, float]]) -> None:
        self.what, self.spans, self.current, self.latest = what, spans, 0, -float("inf")
        self.began: float = time.perf_counter()
        self.rich: Progress | None = None

    def tell(self, t: float) -> None:
        if t < self.latest:
            self.current = min(self.current + 1, len(self.spans) - 1)
        self.latest = t
        if sys.stderr.isatty() and time.perf_counter() - self.began > PATIENCE:
            self._show(t)

    def _show(self, t: float) -> None:
        if self.rich is None:
            self.rich = self._started()
        first, last = self.spans[self.current]
        self.rich.update(self.task, completed=self.current + (t - first) / max(last - first, 1e-9))

    def _started(self) -> Progress:
        from rich.console import Console
        from rich.progress import Progress

        progress = Progress(console=Console(stderr=True), transient=True)
        progress.start()
        self.task = progress.add_task(self.what, total=float(len(self.spans)))
        return progress

    def close(self) -> None:
        if self.rich is not None:
            self.rich.stop()
