"""Commands stopped at random instants, from the first import to the last file: what lay in the folder before or the new
result lies there afterwards, whole; nothing hidden stays where the command could tidy up; no process stays; the same
command then works.

    python -m torture.stops --count 500
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from torture.deeds import DEEDS, Bench, start

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
    parser = argparse.ArgumentParser(prog="torture.stops", description=__doc__)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    chance, told = random.Random(given.seed), Counter[str]()
    with tempfile.TemporaryDirectory(prefix="torture-") as folder:
        bench = Bench(Path(folder))
        for _ in range(given.count):
            command, number = chance.choice([*DEEDS]), chance.choice(SIGNALS)
            why = stop_once(command, number, chance.uniform(0, 1.1), bench)
            told[f"{command} {number.name}: {why or 'held'}"] += 1
            if why:
                print(f"{command} {number.name}: {why}", file=sys.stderr, flush=True)
    print("\n".join(f"{count:5} {what}" for what, count in sorted(told.items())))
    return int(any(not what.endswith("held") for what in told))


if __name__ == "__main__":
    sys.exit(main())
