"""Commands that the computer lets down: a full disk, a folder that may be written to no longer, another run into the
same folder, a worker that is killed, a clock that is set back. What lay in the folder or the new result lies there
afterwards, whole, the reason is told in a sentence, and the same command works as soon as the computer does.

    python -m torture.faults --count 60          (as root on Linux: disks are small file systems in memory)
"""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from torture.deeds import DEEDS, Bench, attempt_all, finish, held, start

BACK = """
import random, time
_now, _back = time.time, random.Random(0)
time.time = lambda: _now() - _back.uniform(0, 7200)
"""
"""A clock that is set back again and again."""


@contextmanager
def small_disk(where: Path, size: int) -> Iterator[None]:
    """A file system of so many bytes in place of a folder's content, which is copied onto it."""
    inside = shutil.copytree(where / "out", where / "kept")
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "none", where / "out"], check=True)
    try:
        shutil.copytree(inside, where / "out", dirs_exist_ok=True)
        yield
    finally:
        after = where / "after"
        shutil.copytree(where / "out", after)
        subprocess.run(["umount", where / "out"], check=True)
        shutil.rmtree(where / "out")
        shutil.move(after, where / "out")
        shutil.rmtree(inside)


def fill_disk(command: str, chance: random.Random, bench: Bench) -> str:
    """Room for the old result, and for a part of the new one."""
    where = bench.again(command)
    size = sum(-(-path.stat().st_size // 4096) * 4096 for path in (where / "out").iterdir())
    with small_disk(where, size + 65536 + int(chance.uniform(0, 1.2) * size)):
        code, told = finish(bench.begin(command, DEEDS[command][1], where))
    return _check_sentence(code, told) or bench.judge(command, where, killed=False)


def close_folder(command: str, chance: random.Random, bench: Bench) -> str:
    """At some instant the folder's file system is mounted to be read only."""
    where = bench.again(command)
    with small_disk(where, 1 << 26):
        running, seconds = bench.begin(command, DEEDS[command][1], where), bench.seconds(command, bench.begin is start)
        time.sleep(chance.uniform(0, 1.0) * seconds)
        closed = subprocess.run(["mount", "-o", "remount,ro", where / "out"], capture_output=True, check=False)
        code, told = finish(running)
        if not closed.returncode:
            subprocess.run(["mount", "-o", "remount,rw", where / "out"], check=True)
    return _check_sentence(code, told) or bench.judge(command, where, killed=True)


def run_two(command: str, chance: random.Random, bench: Bench) -> str:
    """The same command twice at once into one folder."""
    where = bench.again(command)
    both = [bench.begin(command, words, where) for words in DEEDS[command]]
    ends = [finish(each) for each in both]
    wrong = [told for code, told in ends if code]
    return f"one of two: {wrong[0][-200:]}" if wrong else _judge_two(command, where, bench)


def _judge_two(command: str, where: Path, bench: Bench) -> str:
    """Whichever came last stands, beside files of the other that it does not have."""
    found, (first, second) = held(where / "out"), bench.results(command)
    whole = any(result.items() <= found.items() for result in (first, second))
    return "" if whole and not [*(where / "out").glob(".*")] else f"mixed: {sorted(found)}"


def kill_worker(command: str, chance: random.Random, bench: Bench) -> str:
    """One of the processes that `--jobs 2` starts is killed."""
    where = bench.again(command)
    running = start(command, DEEDS[command][1], where)
    time.sleep(chance.uniform(0.3, 0.9) * bench.seconds(command))
    while running.poll() is None and not (found := _workers(running.pid)):
        time.sleep(0.02)
    if running.poll() is None:
        os.kill(chance.choice(found), signal.SIGKILL)
    code, told = finish(running)
    return _check_sentence(code, told) or bench.judge(command, where, killed=False)


def _workers(parent: int) -> list[int]:
    """Its children, but for the one that Python itself keeps to tidy up after them."""
    listed = Path(f"/proc/{parent}/task/{parent}/children")
    with suppress(OSError):
        return [child for child in map(int, listed.read_text().split()) if b"tracker" not in _line_of(child)]
    return []


def _line_of(process: int) -> bytes:
    with suppress(OSError):
        return Path(f"/proc/{process}/cmdline").read_bytes()
    return b""


def set_clock_back(command: str, chance: random.Random, bench: Bench) -> str:
    where = bench.again(command)
    code, told = finish(start(command, DEEDS[command][1], where, BACK))
    return (f"clock: status {code}: {told[-200:]}" if code else "") or bench.judge(command, where, killed=False)


def _check_sentence(code: int, told: str) -> str:
    if "Traceback" in told:
        return f"traceback: {told.strip().splitlines()[-1]}"
    return f"silent: status {code}" if code and not told.strip() else ""


FAULTS: dict[str, tuple[Callable[[str, random.Random, Bench], str], tuple[str, ...]]] = {
    "full disk": (fill_disk, tuple(DEEDS)),
    "read only": (close_folder, tuple(DEEDS)),
    "two at once": (run_two, tuple(DEEDS)),
    "worker killed": (kill_worker, ("diagnose",)),
    "clock set back": (set_clock_back, tuple(DEEDS)),
}


def can_mount(folder: Path) -> bool:
    where = folder / "mount"
    where.mkdir()
    tried = subprocess.run(["mount", "-t", "tmpfs", "none", where], capture_output=True, check=False)
    return not tried.returncode and not subprocess.run(["umount", where], check=False).returncode


def main() -> int:
    with tempfile.TemporaryDirectory(prefix="torture-") as folder:
        bench, names = Bench(Path(folder), forked=True), [*FAULTS]
        if not can_mount(Path(folder)):
            print("file systems cannot be mounted here: full disk and read only are left out", file=sys.stderr)
            names = names[2:]
        return attempt_all("torture.faults", __doc__, 60, lambda chance: _let_down(chance.choice(names), chance, bench))


def _let_down(name: str, chance: random.Random, bench: Bench) -> tuple[str, str]:
    do, commands = FAULTS[name]
    command = chance.choice(commands)
    return f"{name}: {command}", do(command, chance, bench)


if __name__ == "__main__":
    sys.exit(main())
