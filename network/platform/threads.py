"""BLAS on one thread, from the entry points on: two threads slow the small products of a network down many times.

A command and its processes hold it there from their beginning; a public function holds it while it runs. So it is with
the search for unused objects, which are rare and looked for among all entries of many machines each time.
"""

from __future__ import annotations

import gc
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, wraps
from typing import TYPE_CHECKING, ParamSpec, TypeVar

from network.platform.freed_memory import keep_freed_memory

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
R = TypeVar("R")
RARELY = (20_000, 20, 20)
"""Objects made between two searches for unused ones, and how many of these go by before older ones are looked at, too:
gc has 700, 10, 10, which takes a third of the time that laying candidates over a machine takes."""


def begin_on_one_thread() -> None:
    """For a program and its processes, before numpy is there; what the environment says comes first."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    keep_freed_memory()
    gc.set_threshold(*RARELY)


def on_one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """The function with BLAS held to one thread while it runs, and with memory at hand."""

    @wraps(function)
    def run_on_one_thread(*args: P.args, **kwargs: P.kwargs) -> R:
        keep_freed_memory()
        with _controller().limit(limits=1), _rare_collection():
            return function(*args, **kwargs)

    return run_on_one_thread


@contextmanager
def _rare_collection() -> Iterator[None]:
    before = gc.get_threshold()
    gc.set_threshold(*RARELY)
    try:
        yield
    finally:
        gc.set_threshold(*before)


@cache
def _controller() -> ThreadpoolController:
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
