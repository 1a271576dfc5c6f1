"""Commands stopped at random instants, from the first import to the last file: what lay in the folder before or the new
result lies there afterwards, whole; nothing hidden stays where the command could tidy up; no process stays; the same
command then works.

    python -m torture.stops --count 500 --log ../.torture/stops.jsonl

One in eight is a process of its own, stopped from its first import on; the others are copies of one that has loaded
everything (`diagnose` always a process of its own), so that more of the stops meet what is computed and written.
"""

from __future__ import annotations

import os
import random
import signal
import sys
import tempfile
import time
from pathlib import Path

from torture.deeds import DEEDS, Bench, attempt_all, begin, start

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
FRESH = 0.12
"""Of the stops, how many are of a process of their own."""
OFTEN = {"simulate": 5, "sweep": 5, "compare": 5, "calibrate": 4, "iso230": 4, "export": 5, "diagnose": 0.5}
"""How often each command is stopped: those seldom that take long."""
GONE = 10.0
"""s within which what a command has started ends with it."""


def stop_once(command: str, number: signal.Signals, share: float, fresh: bool, bench: Bench) -> str:
    """What went wrong; empty where nothing did. share: of the time that the command takes, when it is stopped."""
    where, seconds = bench.again(command), bench.seconds(command, fresh)
    running = (start if fresh else begin)(command, DEEDS[command][1], where)
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
    with tempfile.TemporaryDirectory(prefix="torture-") as folder:
        bench = Bench(Path(folder), forked=True)
        return attempt_all("torture.stops", __doc__, 500, lambda chance: _stop_any(chance, bench))


def _stop_any(chance: random.Random, bench: Bench) -> tuple[str, str]:
    command, number = chance.choices([*OFTEN], [*OFTEN.values()])[0], chance.choice(SIGNALS)
    fresh = command == "diagnose" or chance.random() < FRESH
    return f"{command} {number.name}", stop_once(command, number, chance.uniform(0, 1.1), fresh, bench)


if __name__ == "__main__":
    sys.exit(main())
