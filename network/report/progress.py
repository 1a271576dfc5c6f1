"""A progress bar on standard error for whatever takes longer than a moment; nothing where nobody looks."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.progress import Progress

PATIENCE = 0.3
"""s: how long it stays silent."""
NEARLY = 0.999
"""Share at which it stays, for the time of what is done stands still."""
_OPEN: list[Bar] = []


@contextmanager
def share_bar(what: str) -> Iterator[Bar]:
    """Yields the bar, to be told the share of the work that is done, 0 to 1. Inside another it is that other one, at
    its beginning again, and goes on where it was after that."""
    if _OPEN:
        outer, was = _OPEN[-1], (_OPEN[-1].what, _OPEN[-1].share)
        outer.now(what, 0.0)
        try:
            yield outer
        finally:
            outer.now(*was)
        return
    bar = Bar(what)
    _OPEN.append(bar)
    try:
        yield bar
    finally:
        _OPEN.remove(bar)
        bar.close()


class Bar:
    """What is under way, the share that is done, and the time that has passed, which goes on by itself."""

    def __init__(self, what: str) -> None:
        self.what, self.share = what, 0.0
        self._lock, self._closed = threading.Lock(), False
        self._rich: Progress | None = None
        self._timer = threading.Timer(PATIENCE, self._show)
        self._timer.daemon = True
        if sys.stderr.isatty():
            import rich.progress  # beside numpy it would take its time

            assert rich.progress
            self._timer.start()

    def __call__(self, share: float) -> None:
        """Never falls back."""
        self.now(self.what, max(self.share, share))

    def now(self, what: str, share: float | None = None) -> None:
        """Says what is under way from now on."""
        self.what, self.share = what, self.share if share is None else share
        if self._rich is not None:
            self._rich.update(self._task, description=self.what, completed=min(self.share, NEARLY))

    def over(self, sources: Sequence[Any]) -> Callable[[float], None]:
        """A function that is told the simulated time [s] of the source under way."""
        return _Along(self, [_span(source) for source in sources]).tell

    def _show(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

        columns = TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn()
        with self._lock:
            if self._closed:
                return
            progress = Progress(*columns, console=Console(stderr=True), transient=True, redirect_stdout=False)
            self._task = progress.add_task(self.what, total=1.0)
            progress.update(self._task, completed=min(self.share, NEARLY))
            progress.start()
            self._rich = progress

    def close(self) -> None:
        self._timer.cancel()
        with self._lock:
            self._closed = True
            if self._rich is not None:
                self._rich.stop()


class _Along:
    """Sums the progress over several sources: a simulated time that falls back means the next one."""

    def __init__(self, bar: Bar, spans: Sequence[tuple[float, float]]) -> None:
        self.bar, self.spans, self.current, self.latest = bar, spans, 0, -float("inf")

    def tell(self, t: float) -> None:
        if t < self.latest:
            self.current = min(self.current + 1, len(self.spans) - 1)
        self.latest = t
        first, last = self.spans[self.current]
        self.bar((self.current + (t - first) / max(last - first, 1e-9)) / len(self.spans))


def _span(source: Any) -> tuple[float, float]:
    t = source.schedule.t if hasattr(source, "duration") else source.t
    return float(t[0]), float(t[-1])
