"""A command that is stopped, by Ctrl-C, with its terminal or by the system, ends within two seconds, whatever it is at,
or within the time that it has to tell the best so far; a second stop ends it at once.

An exception alone does not do: one raised while memory is tidied up is lost, and pools wait for their processes. So a
thread hears of the signal, ends what the command started, and ends the command where it does not end by itself.
"""

from __future__ import annotations

import os
import signal
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any

GRACE = 1.0
"""s in which a command may tidy up by itself."""
STATUS = 130
SENTENCE = "lptn: stopped; nothing half-written was left"
ENDING = "lptn: stopped; the best so far is being written, stop again to end at once"
_UNDO: list[Callable[[], object]] = []
_SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
_told = threading.Event()
_owner = [0]
_time_to_tell = [0.0]


@contextmanager
def on_stop(undo: Callable[[], object]) -> Iterator[None]:
    """While it lasts, `undo` is called when the command is stopped, from another thread and perhaps twice."""
    _UNDO.append(undo)
    try:
        yield
    finally:
        _UNDO.remove(undo)


@contextmanager
def time_to_tell(seconds: float) -> Iterator[None]:
    """While it lasts, a command that is stopped may go on for as long as that, on this process alone."""
    _time_to_tell.append(seconds)
    try:
        yield
    finally:
        _time_to_tell.pop()


@contextmanager
def uninterrupted() -> Iterator[None]:
    """What takes milliseconds and must not be left half done: a stop that comes meanwhile is raised at its end."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    heard: list[tuple[int, FrameType | None]] = []
    before: dict[int, Any] = {}
    try:
        for number in _SIGNALS:
            if callable(handler := signal.getsignal(number)):
                before[number] = handler
                signal.signal(number, lambda *stop: heard.append(stop))
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for number, frame in heard[:1]:
            before[number](number, frame)


@contextmanager
def stoppable() -> Iterator[None]:
    """Whatever ends what is inside once it was asked to stop, ends it as KeyboardInterrupt."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    asked = threading.Event()
    _told.clear()
    with _hear_signals(asked):
        try:
            yield
        except BaseException:
            if asked.is_set():
                raise KeyboardInterrupt from None
            raise


@contextmanager
def _hear_signals(asked: threading.Event) -> Iterator[None]:
    """The signals raise KeyboardInterrupt here and wake a thread; one that is ignored from the start stays so."""
    ear, mouth = socket.socketpair()
    mouth.setblocking(False)
    before = {s: signal.getsignal(s) for s in _SIGNALS if signal.getsignal(s) not in (signal.SIG_IGN, None)}
    woken = signal.set_wakeup_fd(mouth.fileno(), warn_on_full_buffer=False)
    _owner[0] = os.getpid()
    for number in before:
        signal.signal(number, _interrupt)
    threading.Thread(target=_listen, args=(ear, asked), daemon=True).start()
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(woken)
        mouth.close()


def _interrupt(number: int, frame: FrameType | None) -> None:
    if os.getpid() != _owner[0]:
        os._exit(STATUS)  # forked a moment ago
    sys.unraisablehook = _quiet
    raise KeyboardInterrupt


def _quiet(lost: sys.UnraisableHookArgs) -> None:
    """Where a stop is lost: it ends without it."""
    if lost.exc_type is not KeyboardInterrupt:
        sys.__unraisablehook__(lost)


def _listen(ear: socket.socket, asked: threading.Event) -> None:
    with ear:
        while heard := ear.recv(1):
            if heard[0] in _SIGNALS:
                asked.set()
                _end(ear)


def _end(ear: socket.socket) -> None:
    _undo()
    if _time_to_tell[-1]:
        _past_the_buffer(ENDING)
        _wait_for_another(ear, _time_to_tell[-1])
    threading.Event().wait(GRACE)
    _undo()
    tell_stopped(_past_the_buffer)
    os._exit(STATUS)


def _wait_for_another(ear: socket.socket, seconds: float) -> None:
    """Until the command is stopped again, or has ended, or the time is up."""
    ear.settimeout(seconds)
    with suppress(TimeoutError):
        while (heard := ear.recv(1)) and heard[0] not in _SIGNALS:
            pass


def _undo() -> None:
    """Ends the processes that this one started, and calls what is to be done."""
    if "multiprocessing" in sys.modules:
        from multiprocessing import active_children

        with suppress(Exception):
            for process in active_children():
                process.kill()
    for undo in reversed(_UNDO):
        with suppress(Exception):
            undo()


def tell_stopped(tell: Callable[[str], object]) -> None:
    """One line, once."""
    if not _told.is_set():
        _told.set()
        tell(SENTENCE)


def _past_the_buffer(sentence: str) -> None:
    """To standard error, whose buffer may be held by what does not end; a bar has hidden the cursor there."""
    shown = "\r\x1b[2K\x1b[?25h" if sys.stderr.isatty() else ""
    with suppress(OSError):
        os.write(2, f"{shown}{sentence}\n".encode())


def _leave_it_to_the_parent() -> None:
    """A forked worker is ended by the process that forked it, and is deaf to Ctrl-C."""
    if any(signal.getsignal(number) is _interrupt for number in _SIGNALS):
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        for number in _SIGNALS[1:]:
            signal.signal(number, signal.SIG_DFL)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_it_to_the_parent)
