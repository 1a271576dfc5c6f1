"""Commands stopped at random instants, from the first import to the last file: what lay in the folder before or the new
result lies there afterwards, whole; nothing hidden stays where the command could tidy up; no process stays; the same
command then works.

    python -m torture.stops --count 500
"""

from __future__ import annotations

import os
import random
import signal
import sys
import tempfile
import time
from pathlib import Path

from torture.deeds import DEEDS, Bench, read_count, start, tally

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
GONE = 10.0
"""s within which what a command has started ends with it."""


def stop_once(command: str, number: signal.Signals, share: float, bench: Bench) -> str:
    """What went wrong; empty where nothing did. share: of the time that the command takes, when it is stopped."""
    where, seconds = bench.again(command), bench.seconds(command)
    running = start(command, DEEDS[command][1], where)
    time.sleep(share * seconds)
    running.send_signal(number)
    told = running.communicate()[1].decode("utf-8", "replace")
    if "Traceback" in told:
        return f"traceback: {told.strip().splitlines()[-1]}"
    if not _group_ends(running.pid):
        return "orphans: processes that it started live on"
    return bench.judge(command, where, killed=number == signal.SIGKILL)


def _group_ends(group: int) -> bool:
    until = time.monotonic() + GONE
    while time.monotonic() < until:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False


def main() -> int:
    count, chance = read_count("torture.stops", __doc__, 500)
    with tempfile.TemporaryDirectory(prefix="torture-") as folder:
        bench = Bench(Path(folder))
        return tally(_stop_any(chance, bench) for _ in range(count))


def _stop_any(chance: random.Random, bench: Bench) -> tuple[str, str]:
    command, number = chance.choice([*DEEDS]), chance.choice(SIGNALS)
    return f"{command} {number.name}", stop_once(command, number, chance.uniform(0, 1.1), bench)


if __name__ == "__main__":
    sys.exit(main())
