"""Many hypotheses fitted at once, in as many processes as are wanted; the result does not depend on their number."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import Any, TypeVar

from network.calibration.threads import on_one_thread

Item = TypeVar("Item")
_WORK: list[tuple[Callable[[Any], Any], Sequence[Any]]] = []


def spread(
    work: Callable[[Any], Item], items: Sequence[Any], jobs: int, tell: Callable[[float], None] | None
) -> list[Item]:
    """work(item) for every item, in their order; `tell` is told the share that is done."""
    say = tell or (lambda share: None)
    if jobs < 2 or len(items) < 2 or "fork" not in multiprocessing.get_all_start_methods():
        done = []
        for i, item in enumerate(items):
            done.append(work(item))
            say((i + 1) / len(items))
        return done
    _WORK.append((work, items))
    try:
        with ProcessPoolExecutor(min(jobs, len(items)), multiprocessing.get_context("fork")) as pool:
            futures = [pool.submit(_one, i) for i in range(len(items))]
            for i, _ in enumerate(as_completed(futures)):
                say((i + 1) / len(items))
            return [future.result() for future in futures]
    finally:
        _WORK.pop()


@on_one_thread
def _one(i: int) -> Any:
    work, items = _WORK[-1]
    return work(items[i])
