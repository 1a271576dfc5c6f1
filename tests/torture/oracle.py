"""What a command may do with any input: refuse it in the form of the contract and write nothing, fail in one sentence
and write nothing, or accept it and leave files that are finite, whole and read again."""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import signal
import sys
import time
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

import numpy as np

from network import Machine, Recording, Refused
from network.cli.commands import run
from torture.mutants import PIPED

QUICK, SLOW, AT_ONCE = 5.0, 60.0, 2.0
"""s of a processor that `check` may take, and any other command; and either to refuse."""
CLOSES = 1e-4
"""Gap of an energy account from which something is wrong: rosenbrock and solve_ivp keep 1e-7 of the temperatures, and
an account is made of differences of these."""
SAID = re.compile(r"[^\n]+?: .+; .+|warning: .+|lptn: .+")
USAGE = re.compile(r"(Usage|Try|Error|Written)\b.*|")


@dataclass(frozen=True)
class Outcome:
    """kind: refused, failed, accepted, or fault; why: of a fault, in words, its first one alike for faults that are."""

    kind: str
    why: str = ""
    seconds: float = 0.0


class Hangs(BaseException):
    """Taken for nothing else on its way up."""


def judge(words: Sequence[str], where: Path) -> Outcome:
    """Runs `lptn words…` in a folder of its inputs, in this process."""
    before, began = _listing(where), time.process_time()
    limit = QUICK if words[0] == "check" else SLOW
    out, err = io.StringIO(), io.StringIO()
    try:
        with _within(limit), contextlib.chdir(where), _streams(_piped(where), out, err):
            code = _status(words)
    except Hangs:
        return Outcome("fault", f"hangs: longer than {limit:g} s of the processor", limit)
    except BaseException as error:
        at = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{Path(at.filename).name} {at.name}"
        return Outcome("fault", f"traceback: {type(error).__name__} in {place}: {error}"[:300])
    seconds = time.process_time() - began
    new = _listing(where) - before
    if code:
        kind, why = ("refused" if code == 2 else "failed"), _check_words(err.getvalue(), code)
        why = why or (f"leftover: {sorted(new)} of what was not accepted" if new else "")
        why = why or (f"slow: refused after more than {AT_ONCE:g} s" if code == 2 and seconds > AT_ONCE else "")
    else:
        kind, why = "accepted", _check_files(where, new)
    return Outcome("fault", why, seconds) if why else Outcome(kind, "", seconds)


def _status(words: Sequence[str]) -> int:
    try:
        run(list(words))
    except SystemExit as end:
        return int(end.code or 0)
    return 0


def _piped(where: Path) -> io.StringIO:
    return io.StringIO((where / PIPED).read_text("utf-8") if (where / PIPED).exists() else "", newline="")


@contextlib.contextmanager
def _streams(given: io.StringIO, out: io.StringIO, err: io.StringIO) -> Iterator[None]:
    before = sys.stdin
    sys.stdin = given
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            yield
    finally:
        sys.stdin = before


@contextlib.contextmanager
def _within(seconds: float) -> Iterator[None]:
    def over(number: int, frame: FrameType | None) -> None:
        raise Hangs

    before = signal.signal(signal.SIGVTALRM, over)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def _listing(where: Path) -> set[str]:
    return {str(path.relative_to(where)) for path in where.rglob("*")}


def _check_words(told: str, code: int) -> str:
    lines = [line for line in told.splitlines() if not USAGE.fullmatch(line)]
    odd = [line for line in lines if not SAID.fullmatch(line)]
    if odd:
        return f"form: not of the contract's form: {odd[0][:200]}"
    if "Traceback" in told or (not lines and "Error" not in told):
        return "form: nothing was said"
    return ""


def _check_files(where: Path, new: set[str]) -> str:
    hidden = [name for name in new if any(part.startswith(".") for part in Path(name).parts)]
    if hidden:
        return f"leftover: {hidden}"
    for name in sorted(new):
        path = where / name
        try:
            if name.endswith(".csv") and path.name in ("results.csv", "bands.csv") and (why := _check_table(path)):
                return why
            if name.endswith(".json") and (why := _check_json(path)):
                return why
            if path.name in ("machine.calibrated.yaml", "machine.diagnosed.yaml"):
                Machine.load(path)
        except Refused as refused:
            return f"again: {path.name} is not read again: {refused}"[:300]
    return ""


def _check_table(path: Path) -> str:
    columns = Recording.load(path).columns
    odd = [name for name, column in columns.items() if not np.isfinite(column.values).all()]
    return f"finite: {path.name} holds {odd[0]} that is not finite" if odd else ""


def _check_json(path: Path) -> str:
    """Where the account is not finite it is null."""
    told = json.loads(path.read_text(encoding="utf-8"))
    energy = told.get("energy") if isinstance(told, dict) else None
    if isinstance(energy, dict) and not abs(np.nan if energy["closure"] is None else energy["closure"]) <= CLOSES:
        return f"energy: the account of {path.name} does not close ({energy['closure']})"
    return ""


def remove(where: Path, words: Sequence[str] = ()) -> None:
    """Everything in a folder."""
    for path in sorted(where.rglob("*"), reverse=True):
        path.rmdir() if path.is_dir() and not path.is_symlink() else os.unlink(path)
